# SPDX-License-Identifier: GPL-3.0-or-later
cornice_add_bench(io cornice_las LASzip::LASzip)
