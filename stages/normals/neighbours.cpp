// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/normals/neighbours.h"

#include <algorithm>
#include <cassert>

namespace cornice::normals {

void NeighbourBlock::open_lane(std::uint32_t point, std::uint32_t size) {
  assert(!is_full());
  point_[lanes_] = point;
  size_[lanes_++] = size;
  rows_ = std::max<std::size_t>(rows_, size);
  if (dx_.size() < rows_ * kLanes) {
    for (auto* array : {&dx_, &dy_, &dz_}) array->resize(rows_ * kLanes);
    index_.resize(rows_ * kLanes);
  }
}

void NeighbourBlock::add(std::uint32_t point, const Neighbourhood& neighbours) {
  open_lane(point, neighbours.size);
  for (std::size_t c = 0, at = place(); c < neighbours.size; ++c, at += kLanes) {
    set(at, neighbours.index[c], neighbours.dx[c], neighbours.dy[c], neighbours.dz[c]);
  }
}

void NeighbourBlock::finish() {
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    for (std::size_t c = size_[lane]; c < rows_; ++c) {
      const std::size_t at = c * kLanes + lane;
      dx_[at] = dy_[at] = dz_[at] = 0.0f;
      index_[at] = point_[lane];
    }
  }
}

void NeighbourBlock::clear() {
  lanes_ = rows_ = 0;
  point_.fill(0);
  size_.fill(0);
}

}  // namespace cornice::normals
