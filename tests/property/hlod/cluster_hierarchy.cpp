// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/property/hlod/cluster_hierarchy.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "core/base/random.h"

namespace cornice::test {
namespace {

using namespace hlod;

using Key = std::array<std::int32_t, 3>;
Key key_of(LatticePoint p) { return {p.x, p.y, p.z}; }
using Corners = std::array<LatticePoint, 3>;
using Level = std::map<CellKey, std::vector<Corners>>;

std::int32_t floor_div(std::int64_t a, std::int64_t b) {
  return static_cast<std::int32_t>(a / b - ((a % b != 0) && (a < 0) ? 1 : 0));
}

Level finest_cells(const Mesh& mesh, const Header& header) {
  const double step = header.lattice.step(header.lattice.finest_level);
  const auto rounded = [&](Vec3f p) {
    const auto one = [&](float x) { return static_cast<std::int32_t>(std::lround(x / step)); };
    return LatticePoint{one(p.x), one(p.y), one(p.z)};
  };
  Level cells;
  const std::int64_t side = std::int64_t{3} << header.lattice.cell_bits;
  for (const auto& t : mesh.triangles) {
    const Corners c{rounded(mesh.positions[t[0]]), rounded(mesh.positions[t[1]]),
                    rounded(mesh.positions[t[2]])};
    if (c[0] == c[1] || c[1] == c[2] || c[2] == c[0]) continue;
    const auto middle = [&](std::int32_t LatticePoint::*axis) {
      return floor_div(std::int64_t{c[0].*axis} + c[1].*axis + c[2].*axis, side);
    };
    const std::int32_t k = header.partition == Partition::kOctree ? middle(&LatticePoint::z) : 0;
    cells[{header.lattice.finest_level, middle(&LatticePoint::x), middle(&LatticePoint::y), k}]
        .push_back(c);
  }
  return cells;
}

/// P: vertices in one box of a shifted grid go to one of them, rounded to the coarser lattice.
class Clusters {
 public:
  Clusters(const Header& header, int level, std::uint64_t seed) {
    // Two points of a box and one step of rounding are at most s0 * 2^-(l+1) apart.
    width_ = static_cast<std::int32_t>(header.edge_share * (1 << header.lattice.cell_bits) / 2) - 2;
    CounterRandom random(seed, 7, static_cast<std::uint64_t>(level));
    for (std::int32_t& shift : shift_) {
      shift = static_cast<std::int32_t>(random.uniform(0.0, width_));
    }
  }
  LatticePoint parent(LatticePoint p) {
    const Key box{floor_div(p.x + shift_[0], width_), floor_div(p.y + shift_[1], width_),
                  floor_div(p.z + shift_[2], width_)};
    return chosen_.emplace(box, coarsened(p)).first->second;
  }

 private:
  std::int32_t width_;
  Key shift_{};
  std::map<Key, LatticePoint> chosen_;
};

CellMesh mesh_of(const CellKey& key, const std::vector<Corners>& triangles, Clusters* clusters) {
  CellMesh mesh;
  mesh.key = key;
  std::map<Key, std::uint16_t> numbers, parent_numbers;
  for (const Corners& t : triangles) {
    std::array<std::uint16_t, 3> corners{};
    for (std::size_t c = 0; c < 3; ++c) {
      const auto [entry, is_new] = numbers.emplace(key_of(t[c]), mesh.vertices.size());
      corners[c] = entry->second;
      if (!is_new) continue;
      mesh.vertices.push_back({t[c], {}, 0, 0, {}, {}});
      if (clusters == nullptr) continue;
      const LatticePoint parent = clusters->parent(t[c]);
      const auto [named, is_new_parent] =
          parent_numbers.emplace(key_of(parent), mesh.parents.size());
      if (is_new_parent) mesh.parents.push_back({parent, {}, 0, 0, {}, {}});
      mesh.parent_of.push_back(named->second);
    }
    mesh.triangles.push_back(corners);
  }
  return mesh;
}

}  // namespace

bench::Hierarchy cluster_hierarchy(const Mesh& mesh, const ClusterOptions& options) {
  bench::Hierarchy result;
  Header& header = result.header;
  header.lattice = {mesh.origin, options.root_side_m, options.finest_level, options.cell_bits};
  header.partition = options.partition;
  header.edge_share = options.edge_share;
  Level cells = finest_cells(mesh, header);
  double error_m = 0.0;
  for (int level = options.finest_level; level >= 0; --level) {
    Clusters clusters(header, level, options.seed);
    Level coarser;
    double step_m = 0.0;
    for (const auto& [key, triangles] : cells) {
      CellMesh cell = mesh_of(key, triangles, level > 0 ? &clusters : nullptr);
      result.nodes.push_back(make_node(cell, static_cast<float>(1.0001 * error_m), 0.0f));
      result.meshes.push_back(std::move(cell));
      if (level == 0) continue;
      for (const Corners& t : triangles) {
        Corners up;
        for (std::size_t c = 0; c < 3; ++c) {
          up[c] = clusters.parent(t[c]);
          const LatticePoint way = t[c] - refined(up[c]);
          step_m = std::max(step_m, norm(way.cast<double>()) * header.lattice.step(level));
        }
        if (up[0] == up[1] || up[1] == up[2] || up[2] == up[0]) continue;
        coarser[key.parent()].push_back(up);
      }
    }
    error_m += step_m;
    cells = std::move(coarser);
  }
  std::vector<std::size_t> order(result.nodes.size());
  for (std::size_t n = 0; n < order.size(); ++n) order[n] = n;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return result.nodes[a].key < result.nodes[b].key;
  });
  bench::Hierarchy sorted{header, {}, {}};
  for (const std::size_t n : order) {
    sorted.nodes.push_back(result.nodes[n]);
    sorted.meshes.push_back(std::move(result.meshes[n]));
  }
  return sorted;
}

}  // namespace cornice::test
