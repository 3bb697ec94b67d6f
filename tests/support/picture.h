// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures read back and compared.
#pragma once

#include <filesystem>

#include "core/io/raster.h"

namespace cornice::test {

/// Three channels of 8 bits; a fourth is dropped. Throws std::runtime_error.
Picture read_png(const std::filesystem::path& path);

std::size_t count_of(const Picture& picture, std::array<std::uint8_t, 3> colour);

/// Of the largest difference of the three channels, pixel by pixel.
struct PictureDifference {
  double mean = 0.0;
  std::array<std::size_t, 256> counts{};
  double share_within(int limit) const;
};
/// Both of one size.
PictureDifference compare_pictures(const Picture& a, const Picture& b);

}  // namespace cornice::test
