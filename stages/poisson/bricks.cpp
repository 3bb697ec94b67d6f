// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/poisson/bricks.h"

#include <bit>
#include <cassert>

namespace cornice {

BrickIndex::BrickIndex(std::span<const BrickKey> bricks) {
  assert(bricks.size() < (1u << 31) && "positions of bricks are 32 bits");
  if (bricks.empty()) return;
  slots_.assign(std::bit_ceil(2 * bricks.size()), kNone);
  mask_ = slots_.size() - 1;
  for (std::uint32_t i = 0; i < bricks.size(); ++i) {
    std::size_t slot = hash(bricks[i]) & mask_;
    while (slots_[slot] != kNone) {
      assert(bricks[slots_[slot]] != bricks[i] && "a key occurs once");
      slot = (slot + 1) & mask_;
    }
    slots_[slot] = i;
  }
}

}  // namespace cornice
