# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(hlod_file unit/hlod/codec_test.cpp unit/hlod/file_test.cpp
             LIBS cornice_hlod cornice_test_hlod_cells cornice_test_support)
cornice_test(hlod_select unit/hlod/morph_test.cpp unit/hlod/select_test.cpp
             LIBS cornice_hlod cornice_test_hlod_cells)
