// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/perceived.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace cornice::test {
namespace {

using Channels = std::array<double, 3>;
constexpr int kReach = 4;
constexpr double kSigma = 1.2;

double linear(std::uint8_t value) {
  const double v = value / 255.0;
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

/// One pass of the blur along x (step 1) or y (step width), edges repeated.
std::vector<Channels> blurred(const std::vector<Channels>& in, int width, int height,
                              bool along_x) {
  std::array<double, 2 * kReach + 1> weights{};
  double sum = 0.0;
  for (int i = -kReach; i <= kReach; ++i)
    sum += weights[static_cast<std::size_t>(i + kReach)] =
        std::exp(-0.5 * i * i / (kSigma * kSigma));
  std::vector<Channels> out(in.size(), Channels{});
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int i = -kReach; i <= kReach; ++i) {
        const int px = std::clamp(along_x ? x + i : x, 0, width - 1);
        const int py = std::clamp(along_x ? y : y + i, 0, height - 1);
        const Channels& from = in[static_cast<std::size_t>(py * width + px)];
        for (std::size_t c = 0; c < 3; ++c)
          out[static_cast<std::size_t>(y * width + x)][c] +=
              weights[static_cast<std::size_t>(i + kReach)] / sum * from[c];
      }
  return out;
}

Channels lab(const Channels& rgb) {
  const double x = 0.4124 * rgb[0] + 0.3576 * rgb[1] + 0.1805 * rgb[2];
  const double y = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
  const double z = 0.0193 * rgb[0] + 0.1192 * rgb[1] + 0.9505 * rgb[2];
  const auto f = [](double t) {
    constexpr double kEdge = 6.0 / 29.0;
    return t > kEdge * kEdge * kEdge ? std::cbrt(t) : t / (3.0 * kEdge * kEdge) + 4.0 / 29.0;
  };
  const double fx = f(x / 0.95047), fy = f(y), fz = f(z / 1.08883);
  return {116.0 * fy - 16.0, 500.0 * (fx - fy), 200.0 * (fy - fz)};
}

std::vector<Channels> seen(const Picture& picture) {
  std::vector<Channels> light;
  for (const auto& pixel : picture.pixels)
    light.push_back({linear(pixel[0]), linear(pixel[1]), linear(pixel[2])});
  light = blurred(light, picture.width, picture.height, true);
  light = blurred(light, picture.width, picture.height, false);
  for (Channels& pixel : light) pixel = lab(pixel);
  return light;
}

}  // namespace

Perceived perceived_difference(const Picture& a, const Picture& b) {
  if (a.width != b.width || a.height != b.height || a.pixels.empty())
    throw std::runtime_error("sizes differ");
  const std::vector<Channels> one = seen(a), other = seen(b);
  std::vector<double> differences;
  double sum = 0.0;
  for (std::size_t i = 0; i < one.size(); ++i) {
    const double d =
        std::hypot(one[i][0] - other[i][0], one[i][1] - other[i][1], one[i][2] - other[i][2]);
    differences.push_back(d);
    sum += d;
  }
  const auto at = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() * 99 / 100);
  std::nth_element(differences.begin(), at, differences.end());
  return {sum / static_cast<double>(differences.size()), *at};
}

}  // namespace cornice::test
