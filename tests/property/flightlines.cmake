# SPDX-License-Identifier: GPL-3.0-or-later
# Needs the score of bench/flightlines, a library that only exists where benchmarks are built.
if(CORNICE_BUILD_BENCH)
  cornice_test(flightlines_survey property/flightlines/survey_test.cpp LIBS
               cornice_flightlines_score)
endif()
