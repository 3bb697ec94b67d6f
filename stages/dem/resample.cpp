// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/dem/resample.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace cornice::dem {
namespace {

constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();
/// Parts of a pixel within which an edge counts as lying on a centre.
constexpr double kRounding = 1e-6;
/// Side of what is resampled at once, in pixels of the finer grid: 16 MiB of heights.
constexpr double kBlockSide = 2048.0;
/// Of the places in a pixel, how many must have data for a mean.
constexpr double kMeanShare = 0.5;

/// Columns and rows of a file, in doubles: where a place falls between them.
struct Source {
  const RasterHead& head;
  int first_col = 0, first_row = 0, width = 0, height = 0;
  std::vector<float> values;

  float at(int col, int row) const {
    return values[static_cast<std::size_t>(row - first_row) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(col - first_col)];
  }
};

/// Part of the pixels [0, count) that [low, high] touches, one more on either side.
void clamp_range(double low, double high, int count, int& first, int& size) {
  first = static_cast<int>(std::clamp(std::floor(low) - 1.0, 0.0, count - 1.0));
  const int last = static_cast<int>(std::clamp(std::floor(high) + 1.0, 0.0, count - 1.0));
  size = last - first + 1;
}

float bilinear(const Source& source, double col, double row) {
  const int width = source.head.width, height = source.head.height;
  const auto pixel = [](double at, int count) {
    return static_cast<int>(std::clamp(std::floor(at), 0.0, count - 1.0));
  };
  if (std::isnan(source.at(pixel(col, width), pixel(row, height)))) return kNothing;
  const double x = std::floor(col - 0.5), y = std::floor(row - 0.5);
  const double u = col - 0.5 - x, v = row - 0.5 - y;
  double sum = 0.0, weight = 0.0;
  for (int j = 0; j < 2; ++j) {
    for (int i = 0; i < 2; ++i) {
      // Beyond the outermost centres their own height.
      const float z = source.at(pixel(x + i, width), pixel(y + j, height));
      const double w = (i == 0 ? 1.0 - u : u) * (j == 0 ? 1.0 - v : v);
      if (std::isnan(z)) continue;
      sum += w * static_cast<double>(z);
      weight += w;
    }
  }
  return weight > 0.0 ? static_cast<float>(sum / weight) : kNothing;
}

/// Mean of `samples` x `samples` places spread evenly over a pixel from (col, row) to as much as
/// `side` further, in pixels of the file; those beside the file do not count.
float mean(const Source& source, double col, double row, double side, int samples) {
  double sum = 0.0;
  int held = 0, inside = 0;
  for (int j = 0; j < samples; ++j) {
    const double y = row + side * (j + 0.5) / samples;
    if (y < 0.0 || y > source.head.height) continue;
    for (int i = 0; i < samples; ++i) {
      const double x = col + side * (i + 0.5) / samples;
      if (x < 0.0 || x > source.head.width) continue;
      ++inside;
      const float z = bilinear(source, x, y);
      if (std::isnan(z)) continue;
      sum += static_cast<double>(z);
      ++held;
    }
  }
  return held > 0 && held >= kMeanShare * inside ? static_cast<float>(sum / held) : kNothing;
}

void resample_block(RasterFile& file, const PixelRect& block, double step, float* to,
                    std::size_t stride) {
  const RasterHead& head = file.head();
  const auto col_of = [&](double east) { return (east - head.west) / head.step; };
  const auto row_of = [&](double north) { return (head.north - north) / head.step; };
  const auto edge = [&](std::int64_t index) { return static_cast<double>(index) * step; };
  Source source{head, 0, 0, 0, 0, {}};
  clamp_range(col_of(edge(block.col)), col_of(edge(block.end_col())), head.width, source.first_col,
              source.width);
  clamp_range(row_of(-edge(block.row)), row_of(-edge(block.end_row())), head.height,
              source.first_row, source.height);
  const auto width = static_cast<std::size_t>(source.width);
  source.values.resize(width * static_cast<std::size_t>(source.height));
  file.read(source.first_col, source.first_row, source.width, source.height, source.values.data(),
            width);
  const double side = step / head.step;
  const int samples = static_cast<int>(std::ceil(side - kRounding));
  for (std::int64_t row = 0; row < block.height; ++row) {
    const double top = row_of(-edge(block.row + row));
    float* line = to + static_cast<std::size_t>(row) * stride;
    for (std::int64_t col = 0; col < block.width; ++col) {
      const double left = col_of(edge(block.col + col));
      line[col] = samples > 1 ? mean(source, left, top, side, samples)
                              : bilinear(source, left + 0.5 * side, top + 0.5 * side);
    }
  }
}

}  // namespace

PixelRect resampled_rect(const RasterHead& head, double step) {
  const auto first_centre = [&](double from) {
    return static_cast<std::int64_t>(std::ceil(from / step - 0.5 - kRounding));
  };
  const double east = head.west + head.step * head.width;
  const double south = head.north - head.step * head.height;
  PixelRect rect;
  rect.col = first_centre(head.west);
  rect.row = first_centre(-head.north);
  rect.width = first_centre(east) - rect.col;
  rect.height = first_centre(-south) - rect.row;
  return rect;
}

void resample(RasterFile& file, const PixelRect& part, double step, float* to, std::size_t stride) {
  const double finer = std::min(1.0, file.head().step / step);
  const auto side = std::max<std::int64_t>(1, static_cast<std::int64_t>(kBlockSide * finer));
  for (std::int64_t row = 0; row < part.height; row += side) {
    for (std::int64_t col = 0; col < part.width; col += side) {
      const PixelRect block{part.col + col, part.row + row, std::min(side, part.width - col),
                            std::min(side, part.height - row)};
      resample_block(file, block, step, to + static_cast<std::size_t>(row) * stride + col, stride);
    }
  }
}

}  // namespace cornice::dem
