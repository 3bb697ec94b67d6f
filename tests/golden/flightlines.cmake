# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(flightlines_real golden/flightlines/real_lines_test.cpp LIBS cornice_flightlines
             cornice_io GDAL::GDAL)
