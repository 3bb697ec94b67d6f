// SPDX-License-Identifier: GPL-3.0-or-later
// Flight lines as GeoPackage (layers "lines", LineString ZM with M = GPS time, and "nodes") for GIS
// and as JSON for machines. docs/formats/flight_lines.md describes both.
#pragma once

#include <filesystem>

#include "core/points/flight_line.h"

namespace cornice {

/// Reads .json or .gpkg. Throws InputError where it is neither or lacks a field.
FlightLines read_flight_lines(const std::filesystem::path& path);

}  // namespace cornice
