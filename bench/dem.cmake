# SPDX-License-Identifier: GPL-3.0-or-later
cornice_add_bench(dem cornice_io)
# It measures the program.
add_dependencies(bench-dem cornice-dem)
