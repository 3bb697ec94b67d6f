// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/build_region.h"

#include <cmath>

#include "core/base/error.h"

namespace cornice::hlod {
namespace {

/// Columns per region wanted, so that regions are of about one size.
constexpr int kColumnsPerRegion = 2;

std::int32_t columns_of(const Header& header, const Box3d& box, int level) {
  const double extent = box.max.x - header.lattice.origin.x;
  return static_cast<std::int32_t>(std::floor(extent / header.lattice.cell_side(level))) + 1;
}

/// The blocks that children of the columns and of those beside them lie in.
Columns finer(const Columns& columns, int side) {
  const auto block = [side](std::int32_t i) {
    return static_cast<std::int32_t>(std::floor((i + side / 2) / static_cast<double>(side)));
  };
  const Columns beside = columns.grown();
  return {block(2 * beside.first) * side - side / 2,
          (block(2 * beside.last - 1) + 1) * side - side / 2};
}

}  // namespace

bool Region::owns(const CellKey& cell) const {
  return cell.level >= level && owned.contains(cell.i >> (cell.level - level));
}

Region plan_region(const Header& header, const Box3d& box, int block_side, int index, int count) {
  const int finest = header.lattice.finest_level;
  Region region;
  while (region.level < finest &&
         columns_of(header, box, region.level) < kColumnsPerRegion * count) {
    ++region.level;
  }
  const std::int32_t columns = columns_of(header, box, region.level);
  if (columns < count) {
    throw UsageError("--region", "there are " + std::to_string(columns) +
                                     " columns of cells, fewer than " + std::to_string(count) +
                                     " regions; ask for fewer");
  }
  const auto begin = [&](int i) {
    return static_cast<std::int32_t>(std::int64_t{columns} * i / count);
  };
  region.owned = {begin(index), begin(index + 1)};
  region.needed.resize(static_cast<std::size_t>(finest) + 1);
  region.needed[static_cast<std::size_t>(region.level)] = region.owned;
  for (int level = region.level + 1; level <= finest; ++level) {
    region.needed[static_cast<std::size_t>(level)] =
        finer(region.needed[static_cast<std::size_t>(level) - 1], block_side);
  }
  return region;
}

}  // namespace cornice::hlod
