// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/dem/pieces.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>

namespace cornice::dem {
namespace {

/// A pixel is between 2^11 and 2^12 quanta, a piece below 2^24: what a float holds exactly.
constexpr int kQuantumBits = 11;
/// Origins lie on whole metres, or on 16 pixels where those are less.
constexpr int kOriginBits = 4;

std::string part_name(const std::string& stem, std::int64_t row, std::int64_t col) {
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), "_r%02lld_c%02lld", static_cast<long long>(row),
                static_cast<long long>(col));
  return stem + text.data();
}

}  // namespace

std::string stem_of(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  const bool is_known = extension == ".tif" || extension == ".tiff" || extension == ".asc" ||
                        extension == ".txt" || extension == ".grd";
  return is_known ? path.stem().string() : path.filename().string();
}

std::vector<Piece> cut_into_pieces(const Survey& survey, std::int64_t most_pixels) {
  std::vector<Piece> pieces;
  for (std::size_t i = 0; i < survey.tiles().size(); ++i) {
    const Tile& tile = survey.tiles()[i];
    const PixelRect& rect = tile.rect;
    if (rect.empty()) continue;
    const std::string stem = stem_of(tile.path);
    const std::int64_t cols = (rect.width + most_pixels - 1) / most_pixels;
    const std::int64_t rows = (rect.height + most_pixels - 1) / most_pixels;
    for (std::int64_t row = 0; row < rows; ++row) {
      for (std::int64_t col = 0; col < cols; ++col) {
        const std::int64_t west = rect.width * col / cols, north = rect.height * row / rows;
        const PixelRect own{rect.col + west, rect.row + north, rect.width * (col + 1) / cols - west,
                            rect.height * (row + 1) / rows - north};
        pieces.push_back({i, own, cols * rows == 1 ? stem : part_name(stem, row + 1, col + 1)});
      }
    }
  }
  return pieces;
}

Lattice::Lattice(double step)
    : step_(step),
      quantum_(std::exp2(std::floor(std::log2(step)) - kQuantumBits)),
      origin_quantum_(std::max(
          quantum_, std::min(1.0, std::exp2(std::floor(std::log2(step)) + kOriginBits)))) {}

Vec3d Lattice::origin_of(const Survey& survey, const PixelRect& own) const {
  const auto down = [&](double x) { return std::floor(x / origin_quantum_) * origin_quantum_; };
  return {down(survey.east_of(own.col)), down(survey.north_of(own.end_row() - 1)), 0.0};
}

VertexPlaces Lattice::places_of(const Survey& survey, const PixelRect& own) const {
  const Vec3d origin = origin_of(survey, own);
  const auto place = [&](double x, double from) {
    return static_cast<float>(std::round(x / quantum_) * quantum_ - from);
  };
  VertexPlaces places;
  places.step = static_cast<float>(step_);
  for (std::int64_t col = 0; col <= own.width; ++col) {
    places.east.push_back(place(survey.east_of(own.col + col), origin.x));
  }
  for (std::int64_t row = 0; row <= own.height; ++row) {
    places.north.push_back(place(survey.north_of(own.row - 1 + row), origin.y));
  }
  return places;
}

}  // namespace cornice::dem
