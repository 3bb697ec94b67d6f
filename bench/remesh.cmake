# SPDX-License-Identifier: GPL-3.0-or-later
cornice_add_bench(remesh cornice_remesh cornice_io)
