# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(dem_survey property/dem/survey_mesh_test.cpp
             LIBS cornice_dem cornice_mesh cornice_test_support)
