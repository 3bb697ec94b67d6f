# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(flightlines unit/flightlines/flown_line.cpp unit/flightlines/trajectory_test.cpp
             LIBS cornice_flightlines)
