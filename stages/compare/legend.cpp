// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/compare/legend.h"

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "stages/compare/svg.h"

namespace cornice::compare {
namespace {

constexpr int kTitlePx = 34, kLegendPx = 190, kMarginPx = 12, kBarPx = 26, kTallestBarPx = 360;
constexpr int kFontPx = 15, kTitleFontPx = 18;
constexpr int kLongestMapPx = 1400, kShortestMapPx = 500;

/// Where Debian, Ubuntu and Fedora keep DejaVu Sans; without it OpenImageIO looks for its own.
std::string font() {
  constexpr std::array<const char*, 3> kFiles{"/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
                                              "/usr/share/fonts/dejavu-sans-fonts/DejaVuSans.ttf",
                                              "/usr/share/fonts/dejavu/DejaVuSans.ttf"};
  for (const char* file : kFiles) {
    if (std::filesystem::exists(file)) return file;
  }
  return "";
}

class Canvas {
 public:
  Canvas(int width, int height) {
    picture_.width = width;
    picture_.height = height;
    picture_.pixels.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
                           {255, 255, 255});
  }
  Rgb& at(int x, int y) {
    return picture_.pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(picture_.width) +
                           static_cast<std::size_t>(x)];
  }
  void fill(int x, int y, int width, int height, Rgb colour) {
    for (int j = std::max(0, y); j < std::min(picture_.height, y + height); ++j) {
      for (int i = std::max(0, x); i < std::min(picture_.width, x + width); ++i) at(i, j) = colour;
    }
  }
  /// `y` is the text's middle.
  void text(int x, int y, const std::string& words, int size) {
    OIIO::ImageBuf image(OIIO::ImageSpec(picture_.width, picture_.height, 3, OIIO::TypeDesc::UINT8),
                         picture_.pixels.data());
    const std::array<float, 3> colour{0.15f, 0.15f, 0.15f};
    has_text_ = OIIO::ImageBufAlgo::render_text(image, x, y, words, size, font(), colour,
                                                OIIO::ImageBufAlgo::TextAlignX::Left,
                                                OIIO::ImageBufAlgo::TextAlignY::Center) &&
                has_text_;
  }
  const Picture& picture() const { return picture_; }
  bool has_text() const { return has_text_; }

 private:
  Picture picture_;
  bool has_text_ = true;
};

std::string metres(double value, bool plus) {
  char text[32];
  std::snprintf(text, sizeof text, plus ? "%+.3g m" : "%.3g m", value == 0.0 ? 0.0 : value);
  return text;
}

void draw_bar(Canvas& canvas, int x, int& y, double range_m, int height) {
  for (int row = 0; row < height; ++row) {
    const double value = range_m * (1.0 - 2.0 * (row + 0.5) / height);
    canvas.fill(x, y + row, kBarPx, 1, difference_colour(value, range_m));
  }
  for (int k = 0; k <= 4; ++k) {
    const int at = y + (height - 1) * k / 4;
    canvas.fill(x + kBarPx, at, 6, 1, {80, 80, 80});
    canvas.text(x + kBarPx + 10, at, metres(range_m * (1.0 - 0.5 * k), true), kFontPx);
  }
  canvas.text(x + kBarPx + 10, y + 22, "B above A", kFontPx);
  canvas.text(x + kBarPx + 10, y + height - 24, "B below A", kFontPx);
  y += height + 24;
}

void draw_scale(Canvas& canvas, int x, int y, double px_per_m) {
  const double length_m = tick_step(120.0 / px_per_m, 1);
  const double fitting_m = length_m * px_per_m > 150.0 ? 0.5 * length_m : length_m;
  const int width = static_cast<int>(std::lround(fitting_m * px_per_m));
  canvas.fill(x, y, width, 3, {40, 40, 40});
  canvas.fill(x, y - 5, 1, 13, {40, 40, 40});
  canvas.fill(x + width, y - 5, 1, 13, {40, 40, 40});
  canvas.text(x, y + 20, metres(fitting_m, false), kFontPx);
}

}  // namespace

Picture with_legend(const Picture& picture, const Legend& legend, bool& has_text) {
  const int height = std::max(picture.height, 300);
  Canvas canvas(picture.width + kLegendPx, height + kTitlePx + kMarginPx);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      canvas.at(x, y + kTitlePx) =
          picture.pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) +
                         static_cast<std::size_t>(x)];
    }
  }
  canvas.text(kMarginPx, kTitlePx / 2, legend.title, kTitleFontPx);
  const int x = picture.width + kMarginPx;
  int y = kTitlePx + kMarginPx;
  const int below = 30 * static_cast<int>(legend.keys.size()) + 60;
  if (legend.range_m > 0.0) {
    draw_bar(canvas, x, y, legend.range_m, std::clamp(height - below - 60, 120, kTallestBarPx));
  }
  for (const auto& [colour, words] : legend.keys) {
    canvas.fill(x, y, kBarPx, 18, colour);
    canvas.text(x + kBarPx + 10, y + 9, words, kFontPx);
    y += 28;
  }
  if (legend.px_per_m > 0.0) draw_scale(canvas, x, y + 16, legend.px_per_m);
  has_text = canvas.has_text() && has_text;
  return canvas.picture();
}

Picture difference_map(const Raster& difference, const Raster& relief, double range_m,
                       double& px_per_m) {
  const int longest = std::max(difference.width, difference.height);
  const int coarser = std::max(1, (longest + kLongestMapPx - 1) / kLongestMapPx);
  const int larger = coarser > 1 ? 1 : std::clamp(kShortestMapPx / longest, 1, 8);
  px_per_m = static_cast<double>(larger) / (coarser * difference.step);
  const Picture shade = hillshade(relief);
  Picture map{std::max(1, difference.width / coarser) * larger,
              std::max(1, difference.height / coarser) * larger,
              {}};
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      double sum = 0.0, light = 0.0;
      int count = 0;
      for (int k = 0; k < coarser * coarser; ++k) {
        const int col = std::min(x / larger * coarser + k % coarser, difference.width - 1);
        const int row = std::min(y / larger * coarser + k / coarser, difference.height - 1);
        const float value = difference.at(col, row);
        if (value == difference.no_data) continue;
        sum += static_cast<double>(value);
        light +=
            shade.pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(shade.width) +
                         static_cast<std::size_t>(col)][0] /
            255.0;
        ++count;
      }
      map.pixels.push_back(
          count == 0 ? Rgb{255, 255, 255}
                     : lit(difference_colour(sum / count, range_m), 0.55 + 0.55 * light / count));
    }
  }
  return map;
}

}  // namespace cornice::compare
