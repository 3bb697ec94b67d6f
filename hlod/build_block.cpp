// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/build_block.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>

#include "hlod/octahedral.h"
#include "hlod/octahedral_lanes.h"
#include "hlod/partition.h"

namespace cornice::hlod {
namespace {

/// Rounding moves a point by up to half a step along each axis.
constexpr float kRoundingSteps = 0.867f;

/// Calls act(other) for each cell that the bits name, seen from `cell`.
template <class Act>
void for_each_sharer(std::uint32_t bits, const CellKey& cell, const Act& act) {
  for (int place = 0; bits != 0; ++place, bits >>= 1) {
    if ((bits & 1) == 0) continue;
    act(CellKey{cell.level, cell.i + place % 3 - 1, cell.j + place / 3 % 3 - 1,
                cell.k + place / 9 - 1});
  }
}

}  // namespace

BlockResult BlockBuilder::run(const std::vector<const BuildCell*>& cells) {
  cells_ = &cells;
  BlockResult result;
  assemble();
  result.counts.triangles_in = mesh_.triangles.size();
  for (const std::uint8_t locked : mesh_.locked) result.counts.locked_vertices += locked;
  simplify();
  unify();
  average();
  make_parents(result);
  for (const BuildCell& parent : result.parents) {
    result.counts.triangles_out += parent.triangles.size();
  }
  finish_cells(result);
  return result;
}

void BlockBuilder::reserve() {
  std::size_t vertices = 0, triangles = 0, shared = 0;
  to_begins_.assign(1, 0);
  for (const BuildCell* cell : *cells_) {
    vertices += cell->vertices.size();
    triangles += cell->triangles.size();
    to_begins_.push_back(vertices);
    for (const std::uint32_t bits : cell->sharers) shared += bits != 0;
  }
  table_.reset(shared);
  to_.resize(vertices);
  mesh_.triangles.clear();
  mesh_.triangles.reserve(triangles);
  resize_vertices(vertices);
}

void BlockBuilder::resize_vertices(std::size_t count) {
  points_.resize(count);
  data_.resize(count);
  mesh_.locked.resize(count);
  shared_.resize(count);
}

void BlockBuilder::assemble() {
  const std::vector<const BuildCell*>& cells = *cells_;
  reserve();
  parent_keys_.clear();
  parent_cell_.clear();
  for (const BuildCell* cell : cells) parent_keys_.push_back(cell->key.parent());
  std::sort(parent_keys_.begin(), parent_keys_.end());
  parent_keys_.erase(std::unique(parent_keys_.begin(), parent_keys_.end()), parent_keys_.end());
  for (const BuildCell* cell : cells) {
    const auto found =
        std::lower_bound(parent_keys_.begin(), parent_keys_.end(), cell->key.parent());
    parent_cell_.push_back(static_cast<std::uint32_t>(found - parent_keys_.begin()));
  }
  begins_.assign(1, 0);
  std::uint32_t count = 0;
  for (std::size_t c = 0; c < cells.size(); ++c) count = add_cell(c, count);
  resize_vertices(count);
  base_ = count == 0 ? LatticePoint{} : data_.front().position;
  mesh_.positions.resize(count);
  fine_.resize(count);
  for (std::size_t v = 0; v < count; ++v) {
    mesh_.positions[v] = (data_[v].position - base_).cast<float>();
    // Half steps of fine rest, exact in floats as the whole ones are.
    const Vec3f fine = 0.5f * (points_[v] - refined(base_)).cast<float>();
    fine_[v] = Float4{fine.x, fine.y, fine.z, 0};
  }
  mesh_.further.clear();
  if (options_.attribute_weight == 0) return;
  const float scale = static_cast<float>(options_.attribute_weight) *
                      static_cast<float>(1 << header_.lattice.cell_bits);
  for (const CellVertex& v : data_) {
    const bool textured = (header_.attributes & kHasTexture) != 0;
    const auto byte = [&](std::size_t k) { return static_cast<float>(v.colour[k]) / 255.0f; };
    const auto whole = [&](std::size_t k) { return static_cast<float>(v.texture[k]) / 65535.0f; };
    mesh_.further.push_back(textured
                                ? std::array{scale * whole(0), scale * whole(1), 0.0f}
                                : std::array{scale * byte(0), scale * byte(1), scale * byte(2)});
  }
}

/// Adds a cell's vertices behind the first `count` of the block's, and its triangles. How many
/// vertices there are then.
std::uint32_t BlockBuilder::add_cell(std::size_t c, std::uint32_t count) {
  const BuildCell& cell = *(*cells_)[c];
  std::uint32_t* const to = to_.data() + to_begins_[c];
  for (std::uint32_t v = 0; v < cell.vertices.size(); ++v) {
    to[v] = add_vertex(cell, v, count);
    count += to[v] == count;
  }
  for (const Triangle& t : cell.triangles)
    mesh_.triangles.push_back({to[t[0]], to[t[1]], to[t[2]]});
  begins_.push_back(mesh_.triangles.size());
  return count;
}

/// A vertex that no other cell uses is new without looking; of the others, the table knows. `next`
/// is what a new one is called.
std::uint32_t BlockBuilder::add_vertex(const BuildCell& cell, std::uint32_t vertex,
                                       std::uint32_t next) {
  const CellVertex& data = cell.vertices[vertex];
  std::uint32_t index = next;
  if (cell.sharers[vertex] != 0) {
    index = table_.find_or_add(data.position, next, [&](std::uint32_t i) {
      return i == next ? data.position : points_[i];
    });
  }
  if (index == next) {
    points_[next] = data.position;
    data_[next] = data;
    data_[next].position = coarsened(data.position);
    mesh_.locked[next] = 0;
    shared_[next] = cell.sharers[vertex] != 0;
  }
  if (cell.sharers[vertex] != 0 && is_outside(cell, vertex)) mesh_.locked[index] = 1;
  return index;
}

/// Whether a cell of another block uses the vertex, too.
bool BlockBuilder::is_outside(const BuildCell& cell, std::uint32_t vertex) const {
  const CellKey block = block_of_cell(cell.key, options_.side, header_.partition);
  bool outside = false;
  for_each_sharer(cell.sharers[vertex], cell.key, [&](const CellKey& other) {
    outside |= block_of_cell(other, options_.side, header_.partition) != block;
  });
  return outside;
}

void BlockBuilder::simplify() {
  SimplifyOptions options;
  options.target_triangles =
      static_cast<std::size_t>(options_.keep_share * static_cast<double>(mesh_.triangles.size()));
  // In steps of the coarser level, half of which rounding may have used up.
  const double side = static_cast<double>(1 << header_.lattice.cell_bits) / 2;
  options.reach = static_cast<float>(std::floor(header_.edge_share * side / 2 - 0.5));
  options.in_plan = header_.partition == Partition::kQuadtree;
  options.max_error = static_cast<float>(options_.max_error_share * side);
  simplifier_.collapse_edges(mesh_, options);
  step_error_.prepare(simplifier_, fine_, mesh_.triangles, shared_);
}

/// Makes one vertex of those that were rounded to one point; locked ones, which other blocks have
/// too, are taken first.
void BlockBuilder::unify() {
  parents_ = simplifier_.parents();
  const auto position = [&](std::uint32_t v) { return data_[v].position; };
  left_.resize(parents_.size());
  std::size_t left = 0;
  for (std::uint32_t v = 0; v < parents_.size(); ++v) {
    left_[left] = v;
    left += parents_[v] == v;
  }
  left_.resize(left);
  filter_.reset(left);
  for (const std::uint32_t v : left_) filter_.add(position(v));
  table_.reset(left / 8);
  for (const std::uint8_t locked : {std::uint8_t{1}, std::uint8_t{0}}) {
    for (const std::uint32_t v : left_) {
      if (mesh_.locked[v] != locked || filter_.is_alone(position(v))) continue;
      parents_[v] = table_.find_or_add(position(v), v, position);
    }
  }
  for (std::uint32_t& parent : parents_) parent = parents_[parent];
}

/// Normals of what became one vertex are averaged by area, supports the largest, codes the
/// highest; colours and texture stay those of the vertex that stays. Locked vertices keep all, for
/// other blocks know nothing of what collapses here.
void BlockBuilder::average() {
  const std::vector<float>& areas = simplifier_.areas();
  sums_.assign(data_.size(), {});
  const bool has_more = (header_.attributes & (kHasSupport | kHasSource)) != 0;
  NormalLanes lanes;
  for (std::size_t first = 0; first < data_.size(); first += NormalLanes::kCount) {
    const std::size_t count = std::min(data_.size() - first, NormalLanes::kCount);
    for (std::size_t k = 0; k < count; ++k) {
      lanes.i[k] = data_[first + k].normal[0], lanes.j[k] = data_[first + k].normal[1];
    }
    decode_octahedral(lanes, header_.normal_bits);
    for (std::size_t k = 0; k < count; ++k) {
      sums_[parents_[first + k]] += areas[first + k] * Vec3f{lanes.x[k], lanes.y[k], lanes.z[k]};
    }
  }
  for (std::uint32_t v = 0; has_more && v < data_.size(); ++v) {
    const std::uint32_t to = parents_[v];
    if (mesh_.locked[to] != 0) continue;
    data_[to].support = std::max(data_[to].support, data_[v].support);
    data_[to].source = std::max(data_[to].source, data_[v].source);
  }
  kept_.clear();
  for (const std::uint32_t v : left_) {
    if (parents_[v] == v && mesh_.locked[v] == 0) kept_.push_back(v);
  }
  encode_octahedral(
      0, kept_.size(), header_.normal_bits, [&](std::size_t k) { return sums_[kept_[k]]; },
      [&](std::size_t k, std::array<std::int16_t, 2> n) { data_[kept_[k]].normal = n; });
}

void BlockBuilder::make_parents(BlockResult& result) {
  for (std::uint32_t p = 0; p < parent_keys_.size(); ++p) {
    BuildCell cell = make_parent(p);
    // Of what is as small as a step of the lattice nothing is left, and no cell either.
    if (!cell.triangles.empty()) result.parents.push_back(std::move(cell));
  }
}

BuildCell BlockBuilder::make_parent(std::uint32_t parent) {
  BuildCell cell;
  cell.key = parent_keys_[parent];
  const auto step = static_cast<float>(header_.lattice.step(cell.key.level));
  place_.assign(data_.size(), kNone);
  std::size_t triangles = 0;
  for (std::size_t c = 0; c < parent_cell_.size(); ++c) {
    if (parent_cell_[c] == parent) triangles += begins_[c + 1] - begins_[c];
  }
  // A quarter more than the share that the whole block keeps.
  triangles = triangles * simplifier_.triangle_count() / (mesh_.triangles.size() + 1) * 5 / 4;
  cell.triangles.reserve(triangles);
  cell.vertices.reserve(triangles * 9 / 16);
  step_error_.begin_part();
  for (std::size_t c = 0; c < parent_cell_.size(); ++c) {
    if (parent_cell_[c] != parent) continue;
    step_error_.add(begins_[c], begins_[c + 1]);
    cell.error_m = std::max(cell.error_m, (*cells_)[c]->error_m);
    for (std::size_t i = begins_[c]; i < begins_[c + 1]; ++i) {
      const Triangle& old = mesh_.triangles[i];
      Triangle t{parents_[old[0]], parents_[old[1]], parents_[old[2]]};
      if ((int{t[0] == t[1]} | int{t[1] == t[2]} | int{t[2] == t[0]}) != 0) continue;
      for (std::uint32_t& v : t) {
        if (place_[v] == kNone) {
          place_[v] = static_cast<std::uint32_t>(cell.vertices.size());
          cell.vertices.push_back(data_[v]);
        }
        v = place_[v];
      }
      cell.triangles.push_back(t);
    }
  }
  cell.step_error_m = (step_error_.end_part() + kRoundingSteps) * step;
  cell.error_m += cell.step_error_m;
  return cell;
}

void BlockBuilder::finish_cells(BlockResult& result) {
  for (std::uint32_t& v : to_) v = parents_[v];
  for (std::size_t c = 0; c < cells_->size(); ++c) {
    const std::span<const std::uint32_t> parents(to_.data() + to_begins_[c],
                                                 to_begins_[c + 1] - to_begins_[c]);
    part_maker_.add_parts(*(*cells_)[c], parents, data_, result.finished);
  }
}

}  // namespace cornice::hlod
