// SPDX-License-Identifier: GPL-3.0-or-later
// The files of the stage (docs/formats/flight_lines.md) and its printed summary.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "stages/flightlines/survey_lines.h"

namespace cornice::flightlines {

/// Writes the GeoPackage: layers "lines" (LineString ZM, M = GPS time), "nodes" (PointZM), and the
/// tables "overlaps" and "invalid_pulses". Throws RunError where GDAL cannot write.
void write_geopackage(const std::filesystem::path& path, const SurveyLines& survey);

/// Writes the JSON file.
void write_json(const std::filesystem::path& path, const SurveyLines& survey);

/// One line of text a flight line, its accept test below it, and the overlaps.
std::vector<std::string> describe(const SurveyLines& survey);

/// Warnings: one for each line whose beams do not come from a path, and what else was given up.
std::vector<std::string> step_downs(const SurveyLines& survey);

}  // namespace cornice::flightlines
