# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(stitch property/stitch/stitch_test.cpp property/stitch/tiles.cpp
             LIBS cornice_stitch cornice_io cornice_mesh cornice_test_meshes
                  cornice_test_support)
