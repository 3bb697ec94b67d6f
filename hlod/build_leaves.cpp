// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/build_leaves.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <string>
#include <tuple>
#include <utility>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "hlod/octahedral.h"
#include "hlod/octahedral_lanes.h"
#include "hlod/partition.h"
#include "hlod/position_table.h"

namespace cornice::hlod {
namespace {

constexpr std::size_t kVertexGrain = std::size_t{1} << 16;

std::int32_t nearest_whole(double value) {
  const double moved = value + 0.5;
  const auto whole = static_cast<std::int32_t>(moved);
  return whole - (whole > moved);
}

const std::vector<float>* floats_of(const Mesh& mesh, const std::vector<std::string>& names) {
  for (const FloatProperty& p : mesh.float_properties) {
    if (std::find(names.begin(), names.end(), p.name) != names.end()) return &p.values;
  }
  return nullptr;
}
const std::vector<std::uint8_t>* bytes_of(const Mesh& mesh, const std::vector<std::string>& names) {
  for (const ByteProperty& p : mesh.byte_properties) {
    if (std::find(names.begin(), names.end(), p.name) != names.end()) return &p.values;
  }
  return nullptr;
}

std::uint16_t scaled(float value, float scale) {
  const float moved = value * scale + 0.5f;
  return static_cast<std::uint16_t>(moved > 0 ? std::min(moved, 65535.0f) : 0.0f);
}

void take_attributes(const Mesh& mesh, std::uint32_t attributes,
                     std::vector<CellVertex>& vertices) {
  const auto each = [&](const auto* values, const auto& put) {
    if (values == nullptr) return;
    for (std::size_t v = 0; v < vertices.size(); ++v) put(vertices[v], (*values)[v]);
  };
  if (attributes & kHasSupport) {
    each(floats_of(mesh, {"support"}),
         [](CellVertex& v, float value) { v.support = scaled(value, 100.0f); });
  }
  if (attributes & kHasSource) {
    each(bytes_of(mesh, {"source", "class"}), [](CellVertex& v, std::uint8_t b) { v.source = b; });
  }
  if (attributes & kHasColour) {
    const std::array<const char*, 3> names{"red", "green", "blue"};
    for (std::size_t k = 0; k < 3; ++k) {
      each(bytes_of(mesh, {names[k]}), [k](CellVertex& v, std::uint8_t b) { v.colour[k] = b; });
    }
  }
  if (attributes & kHasTexture) {
    each(floats_of(mesh, {"u", "s", "texture_u"}),
         [](CellVertex& v, float value) { v.texture[0] = scaled(value, 65535.0f); });
    each(floats_of(mesh, {"v", "t", "texture_v"}),
         [](CellVertex& v, float value) { v.texture[1] = scaled(value, 65535.0f); });
  }
}

/// The vertex in the middle of two, the same whichever comes first.
CellVertex middle_of(const CellVertex& a, const CellVertex& b, int normal_bits) {
  CellVertex m = a;
  const auto half = [](std::int32_t p, std::int32_t q) {
    return static_cast<std::int32_t>((std::int64_t{p} + q) >> 1);
  };
  m.position = {half(a.position.x, b.position.x), half(a.position.y, b.position.y),
                half(a.position.z, b.position.z)};
  m.normal = encode_octahedral(
      decode_octahedral(a.normal, normal_bits) + decode_octahedral(b.normal, normal_bits),
      normal_bits);
  m.support = static_cast<std::uint16_t>((a.support + b.support + 1) / 2);
  m.source = std::max(a.source, b.source);
  for (std::size_t k = 0; k < 3; ++k) {
    m.colour[k] = static_cast<std::uint8_t>((a.colour[k] + b.colour[k] + 1) / 2);
  }
  for (std::size_t k = 0; k < 2; ++k) {
    m.texture[k] = static_cast<std::uint16_t>((a.texture[k] + b.texture[k] + 1) / 2);
  }
  return m;
}

std::int64_t edge_length(LatticePoint a, LatticePoint b, Partition partition) {
  const auto apart = [](std::int32_t p, std::int32_t q) { return std::abs(std::int64_t{p} - q); };
  const std::int64_t plan = std::max(apart(a.x, b.x), apart(a.y, b.y));
  return partition == Partition::kQuadtree ? plan : std::max(plan, apart(a.z, b.z));
}

/// Triangles whose vertices are on their way from memory while others are welded.
constexpr std::size_t kAhead = 12;

/// Numbers the vertices of one cell by first use and makes one of those at one position.
class CellWelder {
 public:
  explicit CellWelder(std::size_t triangles) {
    table_.reset(triangles / 2 + 8);
    vertices_.reserve(triangles / 2 + triangles / 16 + 8);
  }

  std::uint32_t add(const CellVertex& vertex) {
    const auto next = static_cast<std::uint32_t>(vertices_.size());
    const std::uint32_t index = table_.find_or_add(vertex.position, next, [&](std::uint32_t i) {
      return i == next ? vertex.position : vertices_[i].position;
    });
    if (index == next) vertices_.push_back(vertex);
    return index;
  }
  /// As add, for a vertex of an indexed mesh: most are met again soon.
  std::uint32_t add(const std::vector<CellVertex>& from, std::uint32_t index) {
    Recent& recent = recent_[index % recent_.size()];
    if (recent.from != index) recent = {index, add(from[index])};
    return recent.to;
  }
  std::vector<CellVertex> take() { return std::move(vertices_); }

 private:
  struct Recent {
    std::uint32_t from = 0xffffffffu, to = 0;
  };
  PositionTable table_;
  std::vector<CellVertex> vertices_;
  std::vector<Recent> recent_ = std::vector<Recent>(4096);
};

bool same_cell(const CellRun& a, const CellRun& b) {
  return a.i == b.i && a.j == b.j && a.k == b.k;
}

void add_normals(BuildCell& cell) {
  const std::size_t count = cell.vertices.size();
  cell.normal_sums.assign(count, {});
  for (const Triangle& t : cell.triangles) {
    const LatticePoint a = cell.vertices[t[0]].position;
    const Vec3f ab = (cell.vertices[t[1]].position - a).cast<float>();
    const Vec3f ac = (cell.vertices[t[2]].position - a).cast<float>();
    const Vec3f n = cross(ab, ac);
    for (const std::uint32_t v : t) cell.normal_sums[v] += n;
  }
}

/// Leaves out triangles that name the three vertices of an earlier one, whichever way round.
std::uint64_t drop_duplicates(std::vector<Triangle>& triangles) {
  std::vector<std::uint32_t> slots(std::bit_ceil(2 * triangles.size() + 16), 0xffffffffu);
  const std::size_t mask = slots.size() - 1;
  const auto sorted = [](Triangle t) {
    if (t[0] > t[1]) std::swap(t[0], t[1]);
    if (t[1] > t[2]) std::swap(t[1], t[2]);
    if (t[0] > t[1]) std::swap(t[0], t[1]);
    return t;
  };
  std::uint32_t kept = 0;
  for (const Triangle& t : triangles) {
    const Triangle s = sorted(t);
    std::uint64_t h = (s[0] | std::uint64_t{s[1]} << 32) * 0x9e3779b97f4a7c15u;
    h = (h ^ h >> 29 ^ s[2]) * 0xd6e8feb86659fd93u;
    std::size_t place = (h >> 32) & mask;
    while (slots[place] != 0xffffffffu && sorted(triangles[slots[place]]) != s) {
      place = (place + 1) & mask;
    }
    if (slots[place] != 0xffffffffu) continue;
    slots[place] = kept;
    triangles[kept++] = t;
  }
  const std::uint64_t dropped = triangles.size() - kept;
  triangles.resize(kept);
  return dropped;
}

}  // namespace

/// A mesh on the lattice, not yet sorted.
struct LeafMaker::Soup {
  std::vector<CellVertex> vertices;
  std::vector<Triangle> triangles;
  bool has_normals = false;
  std::size_t own_vertices = 0;  ///< the mesh's; those of pieces of long triangles follow
  std::size_t most = 0;          ///< triangles
  const Sink* sink = nullptr;
};

std::vector<BuildCell> LeafMaker::pieces(const Mesh& mesh) {
  std::vector<BuildCell> all;
  pieces(mesh, std::numeric_limits<std::size_t>::max(),
         [&](BuildCell piece) { all.push_back(std::move(piece)); });
  return all;
}

void LeafMaker::pieces(const Mesh& mesh, std::size_t most, const Sink& sink) {
  Soup soup;
  soup.most = most;
  soup.sink = &sink;
  take_vertices(mesh, soup);
  take_triangles(mesh, soup);
  flush(soup);
}

void LeafMaker::flush(Soup& soup) const {
  for (BuildCell& piece : sort_into_cells(soup)) (*soup.sink)(std::move(piece));
  soup.triangles.clear();
  soup.vertices.resize(soup.own_vertices);
}

void LeafMaker::take_vertices(const Mesh& mesh, Soup& soup) const {
  soup.has_normals = !mesh.normals.empty();
  soup.own_vertices = mesh.positions.size();
  soup.vertices.resize(soup.own_vertices);
  const Lattice& lattice = header_.lattice;
  const double scale = 1.0 / lattice.step(lattice.finest_level);
  const Vec3d shift = mesh.origin - lattice.origin;
  parallel_for(
      soup.vertices.size(), kVertexGrain, threads_, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
          const Vec3d p = (mesh.positions[v].cast<double>() + shift) * scale;
          soup.vertices[v].position = {nearest_whole(p.x), nearest_whole(p.y), nearest_whole(p.z)};
        }
        if (!soup.has_normals) return;
        encode_octahedral(
            begin, end, header_.normal_bits, [&](std::size_t v) { return mesh.normals[v]; },
            [&](std::size_t v, std::array<std::int16_t, 2> n) { soup.vertices[v].normal = n; });
      });
  take_attributes(mesh, header_.attributes, soup.vertices);
}

void LeafMaker::take_triangles(const Mesh& mesh, Soup& soup) {
  counts_.triangles += mesh.triangles.size();
  soup.triangles.reserve(std::min(mesh.triangles.size(), soup.most));
  const auto limit = static_cast<std::int64_t>(header_.edge_share *
                                               static_cast<double>(1 << header_.lattice.cell_bits));
  for (const Triangle& t : mesh.triangles) {
    if (soup.triangles.size() >= soup.most) flush(soup);
    const LatticePoint a = soup.vertices[t[0]].position, b = soup.vertices[t[1]].position,
                       c = soup.vertices[t[2]].position;
    if (a == b || b == c || c == a) {
      ++counts_.degenerate;
    } else if (edge_length(a, b, header_.partition) > limit ||
               edge_length(b, c, header_.partition) > limit ||
               edge_length(c, a, header_.partition) > limit) {
      split(t, soup);
    } else {
      soup.triangles.push_back(t);
    }
  }
}

/// Halves the longest edge until all are short. Whether and where an edge is halved depends on its
/// two ends alone, so that whoever shares it halves it alike. What waits is kept by value: the soup
/// may be flushed meanwhile.
void LeafMaker::split(const Triangle& triangle, Soup& soup) {
  const auto limit = static_cast<std::int64_t>(header_.edge_share *
                                               static_cast<double>(1 << header_.lattice.cell_bits));
  using Corners = std::array<CellVertex, 3>;
  std::vector<Corners> open{
      {soup.vertices[triangle[0]], soup.vertices[triangle[1]], soup.vertices[triangle[2]]}};
  while (!open.empty()) {
    const Corners t = open.back();
    open.pop_back();
    std::int64_t longest = -1;
    std::size_t at = 0;
    for (std::size_t e = 0; e < 3; ++e) {
      const std::int64_t length =
          edge_length(t[e].position, t[(e + 1) % 3].position, header_.partition);
      if (length > longest) longest = length, at = e;
    }
    if (longest <= limit) {
      add_piece(t, soup);
      continue;
    }
    const CellVertex &a = t[at], &b = t[(at + 1) % 3], &c = t[(at + 2) % 3];
    const CellVertex m = middle_of(a, b, header_.normal_bits);
    open.push_back({m, b, c});
    open.push_back({a, m, c});
  }
}

void LeafMaker::add_piece(const std::array<CellVertex, 3>& corners, Soup& soup) {
  const LatticePoint a = corners[0].position, b = corners[1].position, c = corners[2].position;
  if (a == b || b == c || c == a) return;
  if (++counts_.split_pieces > max_pieces_) {
    throw InputError("", "triangles much longer than a cell's side would make more than " +
                             std::to_string(max_pieces_) + " pieces; choose a larger --cell-side");
  }
  if (soup.triangles.size() >= soup.most) flush(soup);
  const auto first = static_cast<std::uint32_t>(soup.vertices.size());
  soup.vertices.insert(soup.vertices.end(), corners.begin(), corners.end());
  soup.triangles.push_back({first, first + 1, first + 2});
}

std::vector<CellRun> LeafMaker::find_runs(const Soup& soup) const {
  const std::size_t count = soup.triangles.size();
  const Lattice& lattice = header_.lattice;
  // As cell_of_triangle, without dividing.
  const std::int64_t side = std::int64_t{3} << lattice.cell_bits;
  const bool is_flat = header_.partition == Partition::kQuadtree;
  const auto is_within = [side](std::int32_t cell, std::int64_t p, std::int64_t q, std::int64_t r) {
    const std::int64_t from_low = p + q + r - cell * side;
    return from_low >= 0 && from_low < side;
  };
  const auto continues = [&](const CellRun& run, LatticePoint a, LatticePoint b, LatticePoint c) {
    return is_within(run.i, a.x, b.x, c.x) && is_within(run.j, a.y, b.y, c.y) &&
           (is_flat || is_within(run.k, a.z, b.z, c.z));
  };
  std::vector<std::vector<CellRun>> parts((count + kVertexGrain - 1) / kVertexGrain);
  parallel_for(count, kVertexGrain, threads_, [&](std::size_t begin, std::size_t end) {
    std::vector<CellRun>& runs = parts[begin / kVertexGrain];
    for (std::size_t i = begin; i < end; ++i) {
      const Triangle& t = soup.triangles[i];
      const LatticePoint a = soup.vertices[t[0]].position, b = soup.vertices[t[1]].position,
                         c = soup.vertices[t[2]].position;
      if (!runs.empty() && continues(runs.back(), a, b, c)) {
        ++runs.back().length;
        continue;
      }
      const CellKey key =
          cell_of_triangle(a, b, c, lattice.finest_level, lattice.cell_bits, header_.partition);
      runs.push_back({key.i, key.j, key.k, 1, i});
    }
  });
  std::vector<CellRun> runs;
  for (std::vector<CellRun>& part : parts) {
    runs.insert(runs.end(), part.begin(), part.end());
    part = {};
  }
  std::sort(runs.begin(), runs.end(), [](const CellRun& a, const CellRun& b) {
    return std::tie(a.i, a.j, a.k, a.begin) < std::tie(b.i, b.j, b.k, b.begin);
  });
  return runs;
}

std::vector<BuildCell> LeafMaker::sort_into_cells(Soup& soup) const {
  const std::vector<CellRun> runs = find_runs(soup);
  std::vector<std::size_t> begins;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    if (r == 0 || !same_cell(runs[r], runs[r - 1])) begins.push_back(r);
  }
  begins.push_back(runs.size());
  std::vector<BuildCell> result(begins.size() - 1);
  parallel_for(result.size(), 8, threads_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      result[c] = make_piece(soup, std::span(runs).subspan(begins[c], begins[c + 1] - begins[c]));
    }
  });
  return result;
}

BuildCell LeafMaker::make_piece(const Soup& soup, std::span<const CellRun> runs) const {
  BuildCell cell;
  cell.key = {header_.lattice.finest_level, runs.front().i, runs.front().j, runs.front().k};
  std::size_t count = 0;
  for (const CellRun& run : runs) count += run.length;
  cell.triangles.reserve(count);
  CellWelder welder(count);
  for (const CellRun& run : runs) {
    const auto triangles = std::span(soup.triangles).subspan(run.begin, run.length);
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      // Vertices of the rows of a mesh lie far apart: asked for before they are needed.
      const Triangle& ahead = triangles[std::min(i + kAhead, triangles.size() - 1)];
      for (const std::uint32_t v : ahead) __builtin_prefetch(&soup.vertices[v]);
      const Triangle& t = triangles[i];
      const std::uint32_t a = welder.add(soup.vertices, t[0]);
      const std::uint32_t b = welder.add(soup.vertices, t[1]);
      const std::uint32_t c = welder.add(soup.vertices, t[2]);
      cell.triangles.push_back({a, b, c});
    }
  }
  cell.vertices = welder.take();
  if (!soup.has_normals) add_normals(cell);
  return cell;
}

BuildCell join_pieces(std::vector<BuildCell> pieces, LeafCounts& counts) {
  if (pieces.size() == 1) {
    BuildCell cell = std::move(pieces.front());
    const std::uint64_t dropped = drop_duplicates(cell.triangles);
    counts.duplicate += dropped;
    if (dropped > 0 && !cell.normal_sums.empty()) add_normals(cell);
    return cell;
  }
  BuildCell cell;
  cell.key = pieces.front().key;
  std::size_t triangles = 0;
  for (const BuildCell& piece : pieces) triangles += piece.triangles.size();
  CellWelder welder(triangles);
  bool has_normals = false;
  for (const BuildCell& piece : pieces) {
    has_normals |= piece.normal_sums.empty();
    std::vector<std::uint32_t> to(piece.vertices.size());
    for (std::size_t v = 0; v < to.size(); ++v) to[v] = welder.add(piece.vertices[v]);
    for (const Triangle& t : piece.triangles) {
      cell.triangles.push_back({to[t[0]], to[t[1]], to[t[2]]});
    }
  }
  cell.vertices = welder.take();
  counts.duplicate += drop_duplicates(cell.triangles);
  if (!has_normals) add_normals(cell);
  return cell;
}

}  // namespace cornice::hlod
