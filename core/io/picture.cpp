// SPDX-License-Identifier: GPL-3.0-or-later
// Hillshade: Horn 1981, "Hill shading and the reflectance map", Proceedings of the IEEE 69(1).
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/io/raster.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;

constexpr int kJpegQuality = 90;

std::string format_of(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (extension == ".png") return "png";
  if (extension == ".jpg" || extension == ".jpeg") return "jpeg";
  throw RunError(path.string(), "a picture is written as .png or .jpg");
}

/// Height differences per metre towards east and north at a pixel, Horn's weights. Neighbours
/// without data, and those beyond the edge, are taken as high as the pixel itself.
std::array<double, 2> slope_at(const Raster& raster, int col, int row) {
  const float centre = raster.at(col, row);
  const auto height = [&](int dx, int dy) {
    const int x = col + dx;
    const int y = row + dy;
    if (x < 0 || y < 0 || x >= raster.width || y >= raster.height) return centre;
    const float value = raster.at(x, y);
    return value == raster.no_data ? centre : value;
  };
  const auto difference = [](float a, float b) {
    return static_cast<double>(a) - static_cast<double>(b);
  };
  double east = 0.0;
  double north = 0.0;
  for (int i = -1; i <= 1; ++i) {
    const double weight = i == 0 ? 2.0 : 1.0;
    east += weight * difference(height(1, i), height(-1, i));
    north += weight * difference(height(i, -1), height(i, 1));
  }
  return {east / (8.0 * raster.step), north / (8.0 * raster.step)};
}

}  // namespace

void write_picture(const fs::path& path, const Picture& picture) {
  const std::string format = format_of(path);
  const bool sized = picture.width > 0 && picture.height > 0 &&
                     picture.pixels.size() == static_cast<std::size_t>(picture.width) *
                                                  static_cast<std::size_t>(picture.height);
  if (!sized) throw std::invalid_argument("a picture needs width * height pixels, at least one");
  const auto output = OIIO::ImageOutput::create(format);
  if (!output) throw RunError(path.string(), "cannot be written: " + OIIO::geterror());
  OIIO::ImageSpec spec(picture.width, picture.height, 3, OIIO::TypeDesc::UINT8);
  if (format == "jpeg") spec.attribute("Compression", "jpeg:" + std::to_string(kJpegQuality));
  const auto write_to = [&](const fs::path& name) {
    const bool written = output->open(name.string(), spec) &&
                         output->write_image(OIIO::TypeDesc::UINT8, picture.pixels.data()) &&
                         output->close();
    if (!written) throw RunError(path.string(), "cannot be written: " + output->geterror());
  };
  // Into memory where possible: OpenImageIO's writers do not tell of a full disk.
  std::vector<unsigned char> bytes;
  OIIO::Filesystem::IOVecOutput memory(bytes);
  if (output->supports("ioproxy") != 0 && output->set_ioproxy(&memory)) {
    write_to(path);
    write_file_atomically(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  } else {
    AtomicFile target(path);
    write_to(target.path());
    target.commit();
  }
}

Picture hillshade(const Raster& raster, double azimuth_deg, double altitude_deg,
                  std::array<std::uint8_t, 3> background) {
  constexpr double kRadians = std::numbers::pi / 180.0;
  const double azimuth = azimuth_deg * kRadians;
  const double altitude = altitude_deg * kRadians;
  const double light_east = std::sin(azimuth) * std::cos(altitude);
  const double light_north = std::cos(azimuth) * std::cos(altitude);
  const double light_up = std::sin(altitude);
  Picture picture;
  picture.width = raster.width;
  picture.height = raster.height;
  picture.pixels.assign(raster.values.size(), background);
  for (int row = 0; row < raster.height; ++row) {
    for (int col = 0; col < raster.width; ++col) {
      if (raster.at(col, row) == raster.no_data) continue;
      const auto [east, north] = slope_at(raster, col, row);
      const double length = std::sqrt(east * east + north * north + 1.0);
      const double shade = (light_up - light_east * east - light_north * north) / length;
      const auto grey = static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(shade, 0.0, 1.0)));
      const std::size_t at =
          static_cast<std::size_t>(row) * static_cast<std::size_t>(raster.width) +
          static_cast<std::size_t>(col);
      picture.pixels[at] = {grey, grey, grey};
    }
  }
  return picture;
}

}  // namespace cornice
