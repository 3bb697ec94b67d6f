# SPDX-License-Identifier: GPL-3.0-or-later
# survey: flight, scanner, tiles and truth over any Scene; the executable brings the scenes.
cornice_library(simulate_survey defects.cpp products.cpp returns.cpp scanner.cpp survey.cpp
                survey_block.cpp survey_options.cpp survey_tiles.cpp survey_truth.cpp trajectory.cpp
                truth.cpp truth_lines.cpp)
target_link_libraries(cornice_simulate_survey
                      PUBLIC cornice_base cornice_cli cornice_geo cornice_io cornice_las
                             cornice_points
                      PRIVATE GDAL::GDAL nlohmann_json::nlohmann_json TBB::tbb)
cornice_stage(simulate cornice_simulate_survey cornice_simulate_scene)
