// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/pictures/relief.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "pipeline/pictures/colours.h"

namespace cornice::pictures {
namespace {

/// A disc of `radius_px`; what falls outside the picture is left out.
void dot_at(Picture& picture, double x, double y, double radius_px, Rgb colour) {
  const int reach = static_cast<int>(std::ceil(radius_px));
  const int cx = static_cast<int>(std::floor(x));
  const int cy = static_cast<int>(std::floor(y));
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      const int px = cx + dx;
      const int py = cy + dy;
      if (px < 0 || py < 0 || px >= picture.width || py >= picture.height) continue;
      if (dx * dx + dy * dy > radius_px * radius_px) continue;
      picture.pixels[static_cast<std::size_t>(py) * picture.width + px] = colour;
    }
  }
}

/// Number of pixels from one edge to another. Throws InputError where it is not whole.
int pixels_between(double from, double to, double step) {
  const double count = (to - from) / step;
  if (std::abs(count - std::round(count)) > 1e-3) {
    throw InputError("DEM", "the rasters do not lie on one grid");
  }
  return static_cast<int>(std::lround(count));
}

}  // namespace

Raster merged(const std::vector<Raster>& parts) {
  Raster all = parts.front();
  double east = -std::numeric_limits<double>::infinity();
  double south = -east;
  for (const Raster& part : parts) {
    if (part.step != all.step) throw InputError("DEM", "the rasters differ in step");
    all.west = std::min(all.west, part.west);
    all.north = std::max(all.north, part.north);
    east = std::max(east, part.west + part.width * part.step);
    south = std::min(south, part.north - part.height * part.step);
  }
  all.width = pixels_between(all.west, east, all.step);
  all.height = pixels_between(south, all.north, all.step);
  all.values.assign(static_cast<std::size_t>(all.width) * all.height, all.no_data);
  for (const Raster& part : parts) {
    const int left = pixels_between(all.west, part.west, all.step);
    const int top = pixels_between(part.north, all.north, all.step);
    for (int row = 0; row < part.height; ++row) {
      for (int col = 0; col < part.width; ++col) {
        const float value = part.at(col, row);
        if (value != part.no_data) all.at(left + col, top + row) = value;
      }
    }
  }
  return all;
}

Picture relief_picture(const Raster& raster) {
  float low = std::numeric_limits<float>::infinity();
  float high = -low;
  for (const float value : raster.values) {
    if (value == raster.no_data || !std::isfinite(value)) continue;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  Picture picture = hillshade(raster);
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    const float value = raster.values[i];
    if (value == raster.no_data || !std::isfinite(value)) continue;
    const double share = high > low ? static_cast<double>((value - low) / (high - low)) : 0.0;
    const float light = 0.35f + 0.75f * static_cast<float>(picture.pixels[i][0]) / 255.0f;
    picture.pixels[i] = shaded(height_colour(share), light);
  }
  return picture;
}

Picture with_margin(const Picture& picture, int margin_px) {
  Picture larger{picture.width + 2 * margin_px, picture.height + 2 * margin_px, {}};
  larger.pixels.assign(static_cast<std::size_t>(larger.width) * larger.height, Rgb{255, 255, 255});
  for (int y = 0; y < picture.height; ++y) {
    const auto from = picture.pixels.begin() + static_cast<std::ptrdiff_t>(y) * picture.width;
    const auto to = larger.pixels.begin() +
                    static_cast<std::ptrdiff_t>(y + margin_px) * larger.width + margin_px;
    std::copy(from, from + picture.width, to);
  }
  return larger;
}

void draw_trajectories(Picture& picture, const Raster& raster, const FlightLines& lines,
                       int margin_px) {
  const double radius_px = std::max(1.5, picture.width / 400.0);
  for (const FlightLine& line : lines.lines) {
    for (std::size_t i = 1; i < line.nodes.size(); ++i) {
      const Vec3d a = line.nodes[i - 1].position;
      const Vec3d b = line.nodes[i].position;
      const auto steps =
          static_cast<int>(std::ceil(std::hypot(b.x - a.x, b.y - a.y) / raster.step));
      for (int k = 0; k <= steps; ++k) {
        const double part = steps > 0 ? static_cast<double>(k) / steps : 0.0;
        const Vec3d p = a + (b - a) * part;
        dot_at(picture, margin_px + (p.x - raster.west) / raster.step,
               margin_px + (raster.north - p.y) / raster.step, radius_px, number_colour(line.id));
      }
    }
  }
}

}  // namespace cornice::pictures
