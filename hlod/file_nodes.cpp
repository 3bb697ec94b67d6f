// SPDX-License-Identifier: GPL-3.0-or-later
// The node table: one column after the other, as differences where neighbours are alike.
#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>

#include "core/base/error.h"
#include "hlod/codec_bytes.h"
#include "hlod/codec_fields.h"
#include "hlod/file_layout.h"

namespace cornice::hlod {
namespace {

std::uint32_t bits_of(std::int32_t value) { return static_cast<std::uint32_t>(value); }
std::int32_t from_bits(std::uint32_t value) { return static_cast<std::int32_t>(value); }

/// First corner of a node's cell, steps of its level.
LatticePoint corner_of(const CellKey& key, const Lattice& lattice) {
  const auto scaled = [&](std::int32_t index) {
    return from_bits(bits_of(index) << lattice.cell_bits);
  };
  return {scaled(key.i), scaled(key.j), scaled(key.k)};
}

/// Calls column(get, set) for every column in file order; get(node, previous) is what is stored,
/// set(node, previous, code) the inverse. Offsets and corners are known when a column is set.
struct Column {
  std::function<std::uint32_t(const Node&, const Node&)> get;
  std::function<void(Node&, const Node&, std::uint32_t)> set;
};

template <class Field>
Column difference_column(Field field) {
  return {
      [=](const Node& n, const Node& p) {
        return zigzag(bits_of(field(const_cast<Node&>(n))) - bits_of(field(const_cast<Node&>(p))));
      },
      [=](Node& n, const Node& p, std::uint32_t code) {
        field(n) = from_bits(bits_of(field(const_cast<Node&>(p))) + unzigzag(code));
      }};
}

template <class Field>
Column count_column(Field field) {
  return {[=](const Node& n, const Node&) { return field(const_cast<Node&>(n)); },
          [=](Node& n, const Node&, std::uint32_t code) { field(n) = code; }};
}

template <class Field>
Column float_column(Field field) {
  return {[=](const Node& n, const Node&) {
            return std::bit_cast<std::uint32_t>(field(const_cast<Node&>(n)));
          },
          [=](Node& n, const Node&, std::uint32_t code) { field(n) = std::bit_cast<float>(code); }};
}

Column lowest_column(std::int32_t LatticePoint::*axis, const Lattice& lattice) {
  return {[=](const Node& n, const Node&) {
            return zigzag(bits_of(n.lowest.*axis) - bits_of(corner_of(n.key, lattice).*axis));
          },
          [=](Node& n, const Node&, std::uint32_t code) {
            n.lowest.*axis = from_bits(bits_of(corner_of(n.key, lattice).*axis) + unzigzag(code));
          }};
}

Column extent_column(std::int32_t LatticePoint::*axis) {
  return {[=](const Node& n, const Node&) {
            return bits_of(n.highest.*axis) - bits_of(n.lowest.*axis);
          },
          [=](Node& n, const Node&, std::uint32_t code) {
            n.highest.*axis = from_bits(bits_of(n.lowest.*axis) + code);
          }};
}

std::vector<Column> columns(const Lattice& lattice) {
  std::vector<Column> list{
      difference_column([](Node& n) -> int& { return n.key.level; }),
      difference_column([](Node& n) -> std::int32_t& { return n.key.i; }),
      difference_column([](Node& n) -> std::int32_t& { return n.key.j; }),
      difference_column([](Node& n) -> std::int32_t& { return n.key.k; }),
      {[](const Node& n, const Node&) -> std::uint32_t { return n.part; },
       [](Node& n, const Node&, std::uint32_t code) { n.part = static_cast<std::uint16_t>(code); }},
  };
  for (std::int32_t LatticePoint::*axis : {&LatticePoint::x, &LatticePoint::y, &LatticePoint::z}) {
    list.push_back(lowest_column(axis, lattice));
    list.push_back(extent_column(axis));
  }
  list.push_back(float_column([](Node& n) -> float& { return n.error_m; }));
  list.push_back(float_column([](Node& n) -> float& { return n.step_error_m; }));
  list.push_back(count_column([](Node& n) -> std::uint32_t& { return n.triangles; }));
  list.push_back(count_column([](Node& n) -> std::uint32_t& { return n.vertices; }));
  list.push_back(count_column([](Node& n) -> std::uint32_t& { return n.parents; }));
  list.push_back(count_column([](Node& n) -> std::uint32_t& { return n.bytes; }));
  for (const int shift : {0, 32}) {
    list.push_back({[=](const Node& n, const Node&) {
                      return static_cast<std::uint32_t>(n.checksum >> shift);
                    },
                    [=](Node& n, const Node&, std::uint32_t code) {
                      n.checksum |= std::uint64_t{code} << shift;
                    }});
  }
  return list;
}

bool is_next(const Node& before, const Node& node) {
  if (before.key == node.key) return node.part == before.part + 1;
  return before.key < node.key && node.part == 0;
}

[[noreturn]] void refuse(const std::filesystem::path& path, const std::string& problem) {
  throw InputError(path.string(), problem + "; write it anew");
}

}  // namespace

std::string fault_of(const Node& n, const Header& header) {
  const Lattice& lattice = header.lattice;
  if (n.key.level < 0 || n.key.level > lattice.finest_level) return "lies on no level";
  // |coordinate| of cells and points, in steps of the finest level.
  const std::int64_t limit = std::int64_t{1} << 29;
  const int finer = lattice.finest_level - n.key.level;
  const auto far_off = [&](std::int64_t value, int shift) {
    return std::abs(value) > (limit >> shift);
  };
  for (const std::int32_t index : {n.key.i, n.key.j, n.key.k}) {
    if (far_off(index, finer + lattice.cell_bits) ||
        far_off(index + std::int64_t{1}, finer + lattice.cell_bits))
      return "lies outside of the lattice";
  }
  if (header.partition == Partition::kQuadtree && n.key.k != 0) return "is no column";
  for (std::int32_t LatticePoint::*axis : {&LatticePoint::x, &LatticePoint::y, &LatticePoint::z}) {
    if (n.lowest.*axis > n.highest.*axis) return "has an empty box";
    if (far_off(n.lowest.*axis, finer) || far_off(n.highest.*axis, finer)) {
      return "has a box outside of the lattice";
    }
  }
  if (!std::isfinite(n.error_m) || !std::isfinite(n.step_error_m) || n.step_error_m < 0.0f ||
      n.error_m < 0.0f) {
    return "has an error that is no number";
  }
  if (n.vertices > kCellVertexLimit || n.triangles > kCellTriangleLimit || n.parents > n.vertices ||
      (n.key.level == 0 && n.parents > 0)) {
    return "has impossible counts";
  }
  return n.bytes == 0 ? "has no bytes" : "";
}

std::vector<std::byte> pack_nodes(std::span<const Node> nodes, const Lattice& lattice) {
  BlockWriter block;
  std::vector<std::uint32_t> codes(nodes.size());
  for (const Column& column : columns(lattice)) {
    const Node origin;
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      codes[n] = column.get(nodes[n], n == 0 ? origin : nodes[n - 1]);
    }
    write_codes(block, codes, 32);
  }
  return block.take();
}

std::vector<Node> unpack_nodes(const std::filesystem::path& path, std::span<const std::byte> bytes,
                               const Head& head) {
  std::vector<Node> nodes(head.node_count);
  BlockReader block(bytes);
  std::vector<std::uint32_t> codes(nodes.size());
  for (const Column& column : columns(head.header.lattice)) {
    read_codes(block, codes, 32);
    const Node origin;
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      column.set(nodes[n], n == 0 ? origin : nodes[n - 1], codes[n]);
    }
  }
  if (!block.ok() || !block.at_end()) refuse(path, "has a node table that cannot be decoded");
  std::uint64_t offset = head_bytes(head.header);
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    nodes[n].offset = offset;
    offset += nodes[n].bytes;
    const std::string fault = fault_of(nodes[n], head.header);
    if (!fault.empty()) refuse(path, cell_name(nodes[n].key, nodes[n].part) + " " + fault);
    if (n == 0 ? nodes[n].part != 0 : !is_next(nodes[n - 1], nodes[n])) {
      refuse(path, cell_name(nodes[n].key, nodes[n].part) + " is out of order");
    }
  }
  if (offset != head.table_offset) refuse(path, "has blocks that do not fill their place");
  return nodes;
}

Box3d bounds_of(std::span<const Node> nodes, const Lattice& lattice) {
  Box3d box;
  for (const Node& node : nodes) {
    box.add(lattice.position(node.lowest, node.key.level));
    box.add(lattice.position(node.highest, node.key.level));
  }
  return nodes.empty() ? Box3d{lattice.origin, lattice.origin} : box;
}

std::vector<LevelStatistics> statistics_of(std::span<const Node> nodes, int finest_level) {
  std::vector<LevelStatistics> levels(static_cast<std::size_t>(finest_level) + 1);
  for (const Node& node : nodes) {
    LevelStatistics& level = levels[static_cast<std::size_t>(node.key.level)];
    level.triangles += node.triangles;
    level.vertices += node.vertices;
    level.bytes += node.bytes;
    if (node.part > 0) continue;
    ++level.cells;
    level.error_max_m = std::max(level.error_max_m, double{node.error_m});
    level.error_mean_m += double{node.error_m};
  }
  for (LevelStatistics& level : levels) {
    if (level.cells > 0) level.error_mean_m /= static_cast<double>(level.cells);
  }
  return levels;
}

}  // namespace cornice::hlod
