// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/dem/layers.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "core/base/parallel.h"

namespace cornice::dem {
namespace {

__extension__ using Wide = __int128;

constexpr double kSumUnits = 1 << 20;  ///< per metre
constexpr std::int64_t kOne = std::int64_t{1} << Layers::kFractionBits;
/// Coordinates so near to a row or column of centres are on it: those of a grid's own mesh, which
/// has them rounded to a 4096th of a pixel.
constexpr std::int64_t kSnap = kOne / 2048;
/// Triangles up to so many pixels have edge functions below 2^62.
constexpr std::int64_t kNarrow = 1024 * kOne;
constexpr float kFar = std::numeric_limits<float>::infinity();

std::int64_t floor_pixel(std::int64_t place) { return place >> Layers::kFractionBits; }
std::int64_t ceil_pixel(std::int64_t place) { return floor_pixel(place + kOne - 1); }

/// The line from `a` to `b`; positive on the inner side.
template <class Int>
struct Edge {
  Int over_col, over_row, here;
  bool owns_ties;  ///< whether a point on it, moved a little east and still less south, is inside

  Edge(const Layers::Place& a, const Layers::Place& b, std::int64_t col, std::int64_t row)
      : over_col(a.row - b.row),
        over_row(b.col - a.col),
        here(over_row * static_cast<Int>(row - a.row) + over_col * static_cast<Int>(col - a.col)),
        owns_ties(over_col > 0 || (over_col == 0 && over_row > 0)) {}
  Int at(std::int64_t cols, std::int64_t rows) const {
    return here + (over_col * static_cast<Int>(cols) + over_row * static_cast<Int>(rows)) *
                      static_cast<Int>(kOne);
  }
};

}  // namespace

Layers::Pixel::Pixel()
    : highest(-kFar), lowest(kFar), touched_highest(-kFar), touched_lowest(kFar) {}

void Layers::Pixel::meet(double height) {
  const auto z = static_cast<float>(height);
  highest = std::max(highest, z);
  lowest = std::min(lowest, z);
  sum += std::llround(height * kSumUnits);
  ++count;
}

void Layers::Pixel::touch(double height) {
  const auto z = static_cast<float>(height);
  touched_highest = std::max(touched_highest, z);
  touched_lowest = std::min(touched_lowest, z);
}

std::uint32_t Layers::Pixel::layers() const {
  return count > 0 ? count : touched_highest >= touched_lowest ? 1 : 0;
}

Layers::Layers(const RasterGrid& grid, const PixelRect& rect)
    : grid_(grid), rect_(rect), pixels_(rect.area()) {}

Layers::Place Layers::place_of(const Mesh& mesh, std::size_t vertex) const {
  const Vec3d p = mesh.origin + mesh.positions[vertex].cast<double>();
  const auto fixed = [](double pixels) {
    const std::int64_t place = std::llround((pixels - 0.5) * static_cast<double>(kOne));
    const std::int64_t centre = (place + kOne / 2) & ~(kOne - 1);
    return std::abs(place - centre) <= kSnap ? centre : place;
  };
  return {fixed((p.x - grid_.west) / grid_.step), fixed((grid_.north - p.y) / grid_.step), p.z};
}

/// Scans the pixels of `box`, which the triangle's own box touches.
template <class Int>
void Layers::scan(Place a, Place b, Place c, const PixelRect& box) {
  const auto doubled_area = [&] {
    return static_cast<Int>(b.col - a.col) * static_cast<Int>(c.row - a.row) -
           static_cast<Int>(b.row - a.row) * static_cast<Int>(c.col - a.col);
  };
  if (doubled_area() < 0) std::swap(b, c);
  const Int area = doubled_area();
  if (area == 0) return;  // upright: no centre is inside
  const std::int64_t col = box.col * kOne, row = box.row * kOne;
  const Edge<Int> ab(a, b, col, row), bc(b, c, col, row), ca(c, a, col, row);
  const auto scale = static_cast<double>(area);
  for (std::int64_t j = 0; j < box.height; ++j) {
    Pixel* line = pixels_.data() + (box.row + j - rect_.row) * rect_.width + (box.col - rect_.col);
    for (std::int64_t i = 0; i < box.width; ++i) {
      const Int w_c = ab.at(i, j), w_a = bc.at(i, j), w_b = ca.at(i, j);
      if (w_a < 0 || w_b < 0 || w_c < 0) continue;
      const double height = static_cast<double>(w_a) / scale * a.height +
                            static_cast<double>(w_b) / scale * b.height +
                            static_cast<double>(w_c) / scale * c.height;
      const bool is_inside =
          (w_a > 0 || bc.owns_ties) && (w_b > 0 || ca.owns_ties) && (w_c > 0 || ab.owns_ties);
      if (is_inside) {
        line[i].meet(height);
      } else {
        line[i].touch(height);
      }
    }
  }
}

void Layers::add_rows(const Mesh& mesh, const std::vector<Place>& places, const PixelRect& band) {
  for (const auto& triangle : mesh.triangles) {
    const Place &a = places[triangle[0]], &b = places[triangle[1]], &c = places[triangle[2]];
    const auto [north, south] = std::minmax({a.row, b.row, c.row});
    const std::int64_t first_row = ceil_pixel(north), last_row = floor_pixel(south);
    if (last_row < band.row || first_row >= band.end_row() || first_row > last_row) continue;
    const auto [west, east] = std::minmax({a.col, b.col, c.col});
    const std::int64_t first_col = ceil_pixel(west);
    const PixelRect own{first_col, first_row, floor_pixel(east) - first_col + 1,
                        last_row - first_row + 1};
    const PixelRect box = own.common(band);
    if (box.empty()) continue;
    if (east - west < kNarrow && south - north < kNarrow) {
      scan<std::int64_t>(a, b, c, box);
    } else {
      scan<Wide>(a, b, c, box);
    }
  }
}

void Layers::add(const Mesh& mesh, int threads) {
  constexpr std::size_t kGrain = 1 << 14;
  std::vector<Place> places(mesh.positions.size());
  parallel_for(places.size(), kGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) places[v] = place_of(mesh, v);
  });
  // Every thread goes through all triangles for rows of its own: no two write to one pixel.
  const std::int64_t bands = std::min<std::int64_t>(thread_count(threads), rect_.height);
  parallel_for(static_cast<std::size_t>(bands), 1, threads, [&](std::size_t begin, std::size_t) {
    const auto i = static_cast<std::int64_t>(begin);
    const std::int64_t first = rect_.height * i / bands, last = rect_.height * (i + 1) / bands;
    add_rows(mesh, places, {rect_.col, rect_.row + first, rect_.width, last - first});
  });
}

template <class Value>
std::vector<float> Layers::band_of(float nothing, Value value) const {
  std::vector<float> band;
  band.reserve(pixels_.size());
  for (const Pixel& p : pixels_) band.push_back(p.layers() == 0 ? nothing : value(p));
  return band;
}

std::vector<float> Layers::highest(float nothing) const {
  return band_of(nothing,
                 [](const Pixel& p) { return p.count > 0 ? p.highest : p.touched_highest; });
}

std::vector<float> Layers::lowest(float nothing) const {
  return band_of(nothing, [](const Pixel& p) { return p.count > 0 ? p.lowest : p.touched_lowest; });
}

std::vector<float> Layers::mean(float nothing) const {
  return band_of(nothing, [](const Pixel& p) {
    if (p.count == 0) return 0.5f * (p.touched_highest + p.touched_lowest);
    if (p.count == 1) return p.highest;
    return static_cast<float>(static_cast<double>(p.sum) / kSumUnits / p.count);
  });
}

std::vector<float> Layers::counts() const {
  return band_of(0.0f, [](const Pixel& p) { return static_cast<float>(p.layers()); });
}

std::uint64_t Layers::pixels_with(std::uint32_t layers) const {
  return static_cast<std::uint64_t>(std::count_if(
      pixels_.begin(), pixels_.end(), [&](const Pixel& p) { return p.layers() >= layers; }));
}

}  // namespace cornice::dem
