# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(viewer_gpu unit/viewer_gpu/drape_texture_test.cpp unit/viewer_gpu/gpu_cells_test.cpp
             unit/viewer_gpu/morph_shader_test.cpp unit/viewer_gpu/overdraw_test.cpp
             LIBS cornice_test_support cornice_viewer_render GDAL::GDAL)
