// SPDX-License-Identifier: GPL-3.0-or-later
// Where the cursor is, in words.
#pragma once

#include <optional>
#include <string>

#include "core/geo/transform.h"
#include "terrain-viewer/app/pick.h"

namespace cornice::viewer {

class ReadOut {
 public:
  /// scene_crs: as Crs::text(), or empty.
  explicit ReadOut(const std::string& scene_crs);

  /// "E 2600055.00  N 1200050.00  H 1500.90 m   slope 12 deg", and where the reference system is
  /// known in a second line "46.950863 N  7.439329 E", WGS 84. "sky" for nothing.
  const std::string& text(const std::optional<UnderCursor>& under);

 private:
  std::string globe_line(Vec3d point) const;

  PlanTransform to_globe_;
  std::string text_ = "sky";
  std::optional<UnderCursor> shown_;  ///< what text_ is about
};

}  // namespace cornice::viewer
