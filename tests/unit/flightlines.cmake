# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(
  flightlines
  unit/flightlines/flight_line_test.cpp
  unit/flightlines/flown_line.cpp
  unit/flightlines/line_estimate_test.cpp
  unit/flightlines/line_split_test.cpp
  unit/flightlines/lines_output_test.cpp
  unit/flightlines/trajectory_test.cpp
  LIBS
  cornice_flightlines
  cornice_io
  cornice_test_support)
