// SPDX-License-Identifier: GPL-3.0-or-later
// Maps and views with what their colours mean beside them.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/io/raster.h"
#include "stages/compare/colours.h"

namespace cornice::compare {

/// What stands beside a picture.
struct Legend {
  std::string title;
  double range_m = 0.0;                           ///< above 0: a bar of difference colours
  std::vector<std::pair<Rgb, std::string>> keys;  ///< patches of colour with their meaning
  double px_per_m = 0.0;                          ///< above 0: a scale bar
};

/// The picture with its title above and legend to the right. `has_text` becomes false where this
/// machine has no font to write with; then there are colours alone.
Picture with_legend(const Picture& picture, const Legend& legend, bool& has_text);

/// Differences over shaded relief of the same grid, north up; white where there are none. Large
/// grids are drawn coarser, small ones with larger pixels; `px_per_m` gets the scale.
Picture difference_map(const Raster& difference, const Raster& relief, double range_m,
                       double& px_per_m);

}  // namespace cornice::compare
