// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "core/geo/crs.h"

namespace cornice {

/// `crs` with its heights in the vertical system that `text` names, "EPSG:5728" or WKT; a vertical
/// part that it had is replaced. Throws UsageError("--vertical-crs", ...) where PROJ does not know
/// the text, or it names no vertical system. `crs` must not be empty.
Crs with_vertical(const Crs& crs, const std::string& text);

}  // namespace cornice
