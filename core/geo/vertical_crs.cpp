// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geo/vertical_crs.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <ogr_spatialref.h>

#include <optional>

#include "core/base/error.h"
#include "core/geo/gdal_handles.h"

namespace cornice {

Crs with_vertical(const Crs& crs, const std::string& text) {
  const QuietGdal quiet;
  const char* limits[] = {"ALLOW_NETWORK_ACCESS=NO", "ALLOW_FILE_ACCESS=NO", nullptr};
  OGRSpatialReference vertical;
  if (vertical.SetFromUserInput(text.c_str(), limits) != OGRERR_NONE ||
      vertical.IsVertical() == 0 || vertical.IsCompound() != 0) {
    throw UsageError("--vertical-crs",
                     "'" + text + "' names no vertical system; give its code, EPSG:5728, or WKT");
  }
  OGRSpatialReference plan;
  plan.importFromWkt(crs.wkt.c_str());
  plan.StripVertical();
  const std::string name = std::string(plan.GetName() != nullptr ? plan.GetName() : "") + " + " +
                           (vertical.GetName() != nullptr ? vertical.GetName() : "");
  OGRSpatialReference whole;
  if (whole.SetCompoundCS(name.c_str(), &plan, &vertical) == OGRERR_NONE) {
    char* wkt = nullptr;
    whole.exportToWkt(&wkt);
    const std::optional<Crs> result = crs_from_wkt(wkt == nullptr ? "" : wkt);
    CPLFree(wkt);
    if (result && result->has_vertical) return *result;
  }
  throw UsageError("--vertical-crs", "'" + text + "' cannot be joined with " + crs.name);
}

}  // namespace cornice
