// SPDX-License-Identifier: GPL-3.0-or-later
// What the GeoPackage and the JSON file both say, field by field.
#pragma once

#include "core/io/geopackage.h"
#include "stages/flightlines/survey_lines.h"

namespace cornice::flightlines {

/// Of a line: all but what needs its nodes, or is a list.
Fields line_fields(const LineEstimate& estimate);

Fields overlap_fields(const OverlapPair& pair);

}  // namespace cornice::flightlines
