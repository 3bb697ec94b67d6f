# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(info unit/info/counters_test.cpp unit/info/examine_test.cpp unit/info/wording_test.cpp
             LIBS cornice_info cornice_test_support GDAL::GDAL nlohmann_json::nlohmann_json)
