// SPDX-License-Identifier: GPL-3.0-or-later
// The functions of crs.h with a memory: tiles of a survey say the same system in the same bytes,
// and PROJ takes some 15 ms to look one up.
#pragma once

#include "core/geo/crs.h"

namespace cornice {

/// What crs_from_text, crs_from_wkt and crs_from_geotiff_keys return for the same arguments, or
/// throw. May be called from several threads.
Crs known_crs_from_text(const std::string& text);
std::optional<Crs> known_crs_from_wkt(const std::string& wkt);
std::optional<Crs> known_crs_from_geotiff_keys(const std::vector<unsigned char>& keys,
                                               const std::vector<unsigned char>& doubles,
                                               const std::string& ascii);

}  // namespace cornice
