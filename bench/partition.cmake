# SPDX-License-Identifier: GPL-3.0-or-later
cornice_add_bench(partition cornice_hlod cornice_io)
