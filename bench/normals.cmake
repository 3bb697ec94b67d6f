# SPDX-License-Identifier: GPL-3.0-or-later
cornice_add_bench(normals cornice_normals flann::flann)
