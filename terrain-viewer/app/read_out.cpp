// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/read_out.h"

#include <array>
#include <cmath>
#include <cstdio>

#include "core/geo/crs.h"

namespace cornice::viewer {

ReadOut::ReadOut(const std::string& scene_crs)
    : to_globe_(scene_crs.empty() ? Crs{} : crs_from_text(scene_crs), crs_from_text("EPSG:4326")) {}

std::string ReadOut::globe_line(Vec3d point) const {
  const auto place = to_globe_(point);
  if (!place) return {};
  std::array<char, 96> text{};
  // The sixth decimal is a decimetre.
  std::snprintf(text.data(), text.size(), "\n%.6f %s  %.6f %s", std::abs(place->y),
                place->y < 0.0 ? "S" : "N", std::abs(place->x), place->x < 0.0 ? "W" : "E");
  return text.data();
}

const std::string& ReadOut::text(const std::optional<UnderCursor>& under) {
  if (under == shown_) return text_;
  shown_ = under;
  if (!under) return text_ = "sky";
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), "E %.2f  N %.2f  H %.2f m", under->point.x,
                under->point.y, under->point.z);
  text_ = text.data();
  if (under->slope_deg) {
    std::snprintf(text.data(), text.size(), "   slope %.0f deg", *under->slope_deg);
    text_ += text.data();
  }
  return text_ += globe_line(under->point);
}

}  // namespace cornice::viewer
