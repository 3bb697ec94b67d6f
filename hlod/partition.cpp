// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/partition.h"

#include <cassert>

namespace cornice::hlod {
namespace {

constexpr std::int32_t floor_divided(std::int64_t value, std::int64_t divisor) {
  const std::int64_t quotient = value / divisor;
  return static_cast<std::int32_t>(quotient - (value % divisor < 0 ? 1 : 0));
}

}  // namespace

CellKey cell_of_triangle(LatticePoint a, LatticePoint b, LatticePoint c, int level, int cell_bits,
                         Partition partition) {
  // The barycentre is a third of the sum, so a cell of sums is three times as wide.
  const std::int64_t side = std::int64_t{3} << cell_bits;
  const auto cell = [side](std::int64_t p, std::int64_t q, std::int64_t r) {
    return floor_divided(p + q + r, side);
  };
  return {level, cell(a.x, b.x, c.x), cell(a.y, b.y, c.y),
          partition == Partition::kQuadtree ? 0 : cell(a.z, b.z, c.z)};
}

CellKey block_of_cell(const CellKey& cell, int side, Partition partition) {
  assert(side >= 2 && side % 2 == 0 && "a block is shifted by half its side");
  const auto block = [side](std::int32_t i) {
    return floor_divided(std::int64_t{i} + side / 2, side);
  };
  return {cell.level, block(cell.i), block(cell.j),
          partition == Partition::kQuadtree ? 0 : block(cell.k)};
}

}  // namespace cornice::hlod
