// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/go_to.h"

#include <utility>

#include "core/geo/crs.h"
#include "core/geo/transform.h"

namespace cornice::viewer {
namespace {

constexpr int kLv95 = 2056, kLambert93 = 2154, kWgs84 = 4326;

/// The system that numbers of their size are of; 0 where they could be of any.
int system_of(double easting, double northing) {
  const auto within = [](double value, double low, double high) {
    return value >= low && value <= high;
  };
  if (within(easting, 2.4e6, 2.9e6) && within(northing, 1.0e6, 1.4e6)) return kLv95;
  if (within(easting, 0.0, 1.3e6) && within(northing, 6.0e6, 7.2e6)) return kLambert93;
  return 0;
}

PlaceFound problem(std::string text) { return {std::nullopt, false, std::move(text)}; }

}  // namespace

PlaceFound find_place(const std::string& text, const std::string& scene_crs) {
  const auto asked = parse_place(text);
  if (!asked) return problem("\"" + text + "\" is no place: 2643500 1158000, or 46.5N 8.1E");
  const Crs crs = scene_crs.empty() ? Crs{} : crs_from_text(scene_crs);
  Vec3d place{asked->first, asked->second, asked->z.value_or(0.0)};
  int system = system_of(place.x, place.y);
  if (asked->is_globe) {
    system = kWgs84;
    std::swap(place.x, place.y);
    if (crs.empty()) return problem("latitude and longitude need a layer with a reference system");
  }
  if (system != 0 && !crs.empty() && crs.horizontal_epsg != system) {
    const auto here = transformed(place, crs_from_text("EPSG:" + std::to_string(system)), crs);
    if (!here) return problem("\"" + text + "\" lies outside of the layer's reference system");
    place = *here;
  }
  return {place, asked->z.has_value(), ""};
}

Camera camera_over(const PlaceFound& found, const Camera& like, const Ground& ground,
                   double height_m) {
  Vec3d at = *found.place;
  if (!found.has_height) at.z = ground(at.x, at.y).value_or(height_m);
  return looking_at(like, at + Vec3d{0.0, -400.0, 300.0}, at);
}

}  // namespace cornice::viewer
