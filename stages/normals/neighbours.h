// SPDX-License-Identifier: GPL-3.0-or-later
// Neighbourhoods: what makes one, one of them, and sixteen side by side.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace cornice::normals {

/// How many neighbours make a neighbourhood, the point itself included: all within radius_m, but
/// the nearest `least` where those are fewer, and only the nearest `most` where they are more.
struct NeighbourRule {
  std::uint32_t least = 16;
  std::uint32_t most = 16;
  float radius_m = 0.0f;
};

/// Neighbours of one point, itself included, in ascending order of index; among points at exactly
/// the same distance the lower index is nearer. The arrays have `size` entries and are valid until
/// the next search.
struct Neighbourhood {
  std::uint32_t size = 0;
  const std::uint32_t* index = nullptr;
  const float* dx = nullptr;  ///< neighbour - point, metres
  const float* dy = nullptr;
  const float* dz = nullptr;
  float reach_sq = 0.0f;  ///< square of the distance to the farthest neighbour
};

/// Neighbourhoods that are worked on side by side, one in each lane of a vector register.
constexpr std::size_t kLanes = 16;

/// Up to kLanes neighbourhoods. Neighbour c of lane l is entry c * kLanes + l; lanes with fewer
/// neighbours than there are rows are filled up with the point itself.
class NeighbourBlock {
 public:
  void add(std::uint32_t point, const Neighbourhood& neighbours);
  /// Room for the neighbourhood of one more point: entry c goes to place() + c * kLanes.
  void open_lane(std::uint32_t point, std::uint32_t size);
  void clear();
  bool is_full() const { return lanes_ == kLanes; }
  std::size_t lanes() const { return lanes_; }
  std::size_t rows() const { return rows_; }
  std::uint32_t point(std::size_t lane) const { return point_[lane]; }
  const std::array<std::uint32_t, kLanes>& sizes() const { return size_; }
  /// Of the lane opened last.
  std::size_t place() const { return lanes_ - 1; }
  const float* dx() const { return dx_.data(); }
  const float* dy() const { return dy_.data(); }
  const float* dz() const { return dz_.data(); }
  const std::uint32_t* index() const { return index_.data(); }
  void set(std::size_t at, std::uint32_t index, float dx, float dy, float dz) {
    dx_[at] = dx, dy_[at] = dy, dz_[at] = dz, index_[at] = index;
  }
  /// Fills up; to be called once after the last add().
  void finish();

 private:
  std::size_t lanes_ = 0, rows_ = 0;
  std::array<std::uint32_t, kLanes> point_{}, size_{};
  std::vector<float> dx_, dy_, dz_;
  std::vector<std::uint32_t> index_;
};

}  // namespace cornice::normals
