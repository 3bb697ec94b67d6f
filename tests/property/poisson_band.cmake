# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(poisson_band property/poisson_band/band_test.cpp property/poisson_band/file_test.cpp
             property/poisson_band/seams.cpp property/poisson_extract/fields.cpp
             LIBS cornice_poisson_extract cornice_mesh cornice_test_support)
