// SPDX-License-Identifier: GPL-3.0-or-later
// Marching cubes (Lorensen & Cline 1987) on sparse bricks. Two passes over the bricks: the first
// counts the vertices that each owns, the second fills them in and cuts the triangles. Both read a
// brick with a rim of one node, so that neither looks at another brick's results but its numbers.
#include "stages/poisson/extract.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cassert>
#include <limits>
#include <numeric>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "stages/poisson/extract_brick.h"

namespace cornice {
namespace {

constexpr std::size_t kBricksAtATime = 128;
/// Whole numbers up to here are exact as floats.
constexpr std::int64_t kMostUnits = std::int64_t{1} << 24;
/// Marks a triangle's corner as one of the chunk's centre vertices.
constexpr std::uint32_t kCentreFlag = 0x80000000u;

using Triangle = std::array<std::uint32_t, 3>;

/// Bricks that hold some of the surface, sorted, and the vertices that each owns.
struct Plan {
  std::vector<BrickKey> bricks;
  BrickIndex index;
  std::vector<VertexTable> tables;
  std::vector<std::uint32_t> first_vertex;  ///< by brick
  std::size_t vertices = 0;
  std::size_t welded = 0;
  bool incomplete = false;
};

/// What one pass over new bricks finds.
struct Found {
  std::vector<BrickKey> bricks;
  std::vector<VertexTable> tables;
  std::vector<BrickKey> wanted;  ///< neighbours that hold some of the surface, too
  bool incomplete = false;
};

class Extraction {
 public:
  Extraction(const NodeValues& values, const Lattice& lattice, const ExtractOptions& options,
             Progress& progress)
      : values_(values), lattice_(lattice), options_(options), progress_(progress) {
    rules_.window = options.window;
    rules_.borders = options.borders;
    rules_.borders.push_back(options.window);
    rules_.weld_units = static_cast<std::int32_t>(options.weld * kUnitsPerStep);
    first_ = {options.window.x0 >> 3, options.window.y0 >> 3, 0};
    last_ = {options.window.x1 >> 3, options.window.y1 >> 3, 0};
  }

  Surface run();

 private:
  Found examine(std::span<const BrickKey> bricks) const;
  Found examine_range(std::span<const BrickKey> bricks) const;
  Plan plan() const;
  void choose_origin(const Plan& plan, Mesh& mesh);
  void fill(const Plan& plan, Surface& surface) const;
  struct Chunk {
    std::vector<Triangle> triangles;
    std::vector<Vec3f> centres, centre_normals;
  };
  void fill_brick(const Plan& plan, std::size_t b, const BrickSurface& brick, Mesh& mesh,
                  Chunk& chunk) const;
  void gather_chunks(std::vector<Chunk> chunks, Surface& surface) const;
  Vec3f place(BrickKey brick, Vec3<std::int32_t> units) const;

  const NodeValues& values_;
  const Lattice lattice_;
  const ExtractOptions& options_;
  Progress& progress_;
  BrickRules rules_;
  BrickKey first_, last_;
  Vec3<std::int32_t> origin_{};  ///< node
};

Found Extraction::examine_range(std::span<const BrickKey> bricks) const {
  Found found;
  BrickCache cache(values_);
  BrickSurface surface(rules_);
  for (const BrickKey brick : bricks) {
    if (!surface.load(brick, cache)) continue;
    found.incomplete = found.incomplete || surface.incomplete();
    found.bricks.push_back(brick);
    found.tables.push_back(surface.vertices());
    for (std::uint32_t bits = surface.neighbours_needed(); bits != 0; bits &= bits - 1) {
      const int n = std::countr_zero(bits);
      const BrickKey next = shifted(brick, n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
      if (next.x >= first_.x && next.x <= last_.x && next.y >= first_.y && next.y <= last_.y) {
        found.wanted.push_back(next);
      }
    }
  }
  return found;
}

Found Extraction::examine(std::span<const BrickKey> bricks) const {
  return parallel_reduce(
      bricks.size(), kBricksAtATime, options_.threads, Found{},
      [&](std::size_t begin, std::size_t end) {
        check_cancelled(progress_);
        progress_.advance(end - begin);
        return examine_range(bricks.subspan(begin, end - begin));
      },
      [](Found& sum, Found& part) {
        sum.bricks.insert(sum.bricks.end(), part.bricks.begin(), part.bricks.end());
        sum.tables.insert(sum.tables.end(), part.tables.begin(), part.tables.end());
        sum.wanted.insert(sum.wanted.end(), part.wanted.begin(), part.wanted.end());
        sum.incomplete = sum.incomplete || part.incomplete;
      });
}

/// Examines the bricks that the values name, and follows the surface into those they do not.
Plan Extraction::plan() const {
  std::vector<BrickKey> known;  // examined so far, sorted
  std::vector<BrickKey> next = values_.crossing_bricks(first_, last_, options_.threads);
  Found all;
  progress_.begin("count", next.size());
  while (!next.empty()) {
    Found found = examine(next);
    known.insert(known.end(), next.begin(), next.end());
    std::sort(known.begin(), known.end());
    all.bricks.insert(all.bricks.end(), found.bricks.begin(), found.bricks.end());
    all.tables.insert(all.tables.end(), found.tables.begin(), found.tables.end());
    all.incomplete = all.incomplete || found.incomplete;
    std::sort(found.wanted.begin(), found.wanted.end());
    found.wanted.erase(std::unique(found.wanted.begin(), found.wanted.end()), found.wanted.end());
    next.clear();
    std::set_difference(found.wanted.begin(), found.wanted.end(), known.begin(), known.end(),
                        std::back_inserter(next));
  }
  progress_.end();

  Plan plan;
  plan.incomplete = all.incomplete;
  std::vector<std::uint32_t> order(all.bricks.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return all.bricks[a] < all.bricks[b]; });
  plan.bricks.reserve(order.size());
  plan.tables.reserve(order.size());
  plan.first_vertex.reserve(order.size());
  for (const std::uint32_t o : order) {
    plan.bricks.push_back(all.bricks[o]);
    VertexTable& table = plan.tables.emplace_back(all.tables[o]);
    plan.first_vertex.push_back(static_cast<std::uint32_t>(plan.vertices));
    plan.vertices += table.number();
    for (const std::uint64_t word : table.mask) {
      plan.welded += static_cast<std::size_t>(std::popcount(word & 0x1111111111111111ULL));
    }
    if (plan.vertices >= kCentreFlag) {
      throw RunError("surface", "has more than 2^31 vertices; take smaller tiles");
    }
  }
  plan.index = BrickIndex(plan.bricks);
  return plan;
}

void Extraction::choose_origin(const Plan& plan, Mesh& mesh) {
  std::int32_t low = plan.bricks.empty() ? 0 : plan.bricks.front().z, high = low;
  for (const BrickKey brick : plan.bricks) {
    low = std::min(low, brick.z), high = std::max(high, brick.z);
  }
  const LatticeBox& w = options_.window;
  origin_ = {w.x0, w.y0, kBrickSide * low};
  const std::int64_t extent = std::max({std::int64_t{w.x1} - w.x0, std::int64_t{w.y1} - w.y0,
                                        kBrickSide * (std::int64_t{high} - low + 1)});
  if (extent * kUnitsPerStep > kMostUnits) {
    throw RunError("surface", "spans " + std::to_string(extent) +
                                  " lattice steps, of which float positions hold " +
                                  std::to_string(kMostUnits / kUnitsPerStep) +
                                  "; take smaller tiles or a larger step");
  }
  mesh.origin = origin_.cast<double>() * lattice_.step_m;
}

Vec3f Extraction::place(BrickKey brick, Vec3<std::int32_t> units) const {
  const double unit_m = lattice_.step_m / kUnitsPerStep;
  const auto metres = [&](std::int32_t b, std::int32_t origin, std::int32_t u) {
    return static_cast<float>(((kBrickSide * b - origin) * kUnitsPerStep + u) * unit_m);
  };
  return {metres(brick.x, origin_.x, units.x), metres(brick.y, origin_.y, units.y),
          metres(brick.z, origin_.z, units.z)};
}

void Extraction::fill_brick(const Plan& plan, std::size_t b, const BrickSurface& brick, Mesh& mesh,
                            Chunk& chunk) const {
  const BrickKey key = plan.bricks[b];
  std::uint32_t vertex = plan.first_vertex[b];
  const VertexTable& table = plan.tables[b];
  for (std::size_t w = 0; w < table.mask.size(); ++w) {
    for (std::uint64_t bits = table.mask[w]; bits != 0; bits &= bits - 1, ++vertex) {
      const int bit = static_cast<int>(64 * w) + std::countr_zero(bits);
      const int node = bit >> 2;
      const BrickVertex v{BrickSurface::at(node & 7, node >> 3 & 7, node >> 6),
                          static_cast<VertexKind>(bit & 3)};
      mesh.positions[vertex] = place(key, brick.position(v));
      mesh.normals[vertex] = brick.normal(v);
    }
  }
  // The far faces' vertices belong to the bricks beyond.
  std::array<std::uint32_t, 8> owners;
  for (int o = 0; o < 8; ++o) {
    owners[static_cast<std::size_t>(o)] =
        plan.index.find(plan.bricks, shifted(key, o & 1, o >> 1 & 1, o >> 2));
  }
  const std::size_t first_triangle = chunk.triangles.size();
  const auto first_centre = static_cast<std::uint32_t>(chunk.centres.size());
  std::vector<CentreVertex> centres;
  brick.cut(chunk.triangles, centres);
  for (const CentreVertex& centre : centres) {
    chunk.centres.push_back(place(key, centre.position));
    chunk.centre_normals.push_back(centre.normal);
  }
  const auto number = [&](std::uint32_t code) {
    if (code >= BrickSurface::kCentre) {
      return kCentreFlag | (first_centre + code - BrickSurface::kCentre);
    }
    constexpr int side = BrickSurface::kSide;
    const int node = static_cast<int>(code >> 2);
    const int i = node % side - 1, j = node / side % side - 1, k = node / (side * side) - 1;
    const std::uint32_t owner =
        owners[static_cast<std::size_t>(i >> 3 | j >> 3 << 1 | k >> 3 << 2)];
    assert(owner != BrickIndex::kNone && "every vertex has an owner");
    return plan.first_vertex[owner] + plan.tables[owner].rank((i & 7) + 8 * (j & 7) + 64 * (k & 7),
                                                              static_cast<VertexKind>(code & 3));
  };
  for (std::size_t t = first_triangle; t < chunk.triangles.size(); ++t) {
    for (std::uint32_t& corner : chunk.triangles[t]) corner = number(corner);
  }
}

void Extraction::fill(const Plan& plan, Surface& surface) const {
  surface.mesh.positions.resize(plan.vertices);
  surface.mesh.normals.resize(plan.vertices);
  std::vector<Chunk> chunks((plan.bricks.size() + kBricksAtATime - 1) / kBricksAtATime);
  progress_.begin("triangles", plan.bricks.size());
  parallel_for(plan.bricks.size(), kBricksAtATime, options_.threads,
               [&](std::size_t begin, std::size_t end) {
                 check_cancelled(progress_);
                 BrickCache cache(values_);
                 BrickSurface brick(rules_);
                 for (std::size_t b = begin; b < end; ++b) {
                   if (!brick.load(plan.bricks[b], cache)) continue;
                   fill_brick(plan, b, brick, surface.mesh, chunks[begin / kBricksAtATime]);
                 }
                 progress_.advance(end - begin);
               });
  gather_chunks(std::move(chunks), surface);
  progress_.end();
}

void Extraction::gather_chunks(std::vector<Chunk> chunks, Surface& surface) const {
  std::vector<std::size_t> first_triangle{0};
  std::vector<std::uint32_t> first_centre{0};
  for (const Chunk& chunk : chunks) {
    first_triangle.push_back(first_triangle.back() + chunk.triangles.size());
    first_centre.push_back(first_centre.back() + static_cast<std::uint32_t>(chunk.centres.size()));
  }
  Mesh& mesh = surface.mesh;
  const auto vertices = static_cast<std::uint32_t>(mesh.positions.size());
  surface.centre_vertices = first_centre.back();
  mesh.triangles.resize(first_triangle.back());
  parallel_for(chunks.size(), 1, options_.threads, [&](std::size_t c, std::size_t) {
    Triangle* to = mesh.triangles.data() + first_triangle[c];
    for (Triangle triangle : chunks[c].triangles) {
      for (std::uint32_t& corner : triangle) {
        if ((corner & kCentreFlag) != 0) {
          corner = vertices + first_centre[c] + (corner & ~kCentreFlag);
        }
      }
      *to++ = triangle;
    }
    chunks[c].triangles = {};
  });
  for (const Chunk& chunk : chunks) {
    mesh.positions.insert(mesh.positions.end(), chunk.centres.begin(), chunk.centres.end());
    mesh.normals.insert(mesh.normals.end(), chunk.centre_normals.begin(),
                        chunk.centre_normals.end());
  }
}

/// Drops vertices that no triangle uses: where a cell is not known its neighbours' edges may have
/// been counted.
void drop_unused_vertices(Mesh& mesh) {
  std::vector<std::uint32_t> number(mesh.positions.size(), 0);
  for (const Triangle& triangle : mesh.triangles) {
    for (const std::uint32_t corner : triangle) number[corner] = 1;
  }
  std::uint32_t kept = 0;
  for (std::size_t v = 0; v < number.size(); ++v) {
    if (number[v] == 0) continue;
    mesh.positions[kept] = mesh.positions[v];
    mesh.normals[kept] = mesh.normals[v];
    number[v] = kept++;
  }
  mesh.positions.resize(kept);
  mesh.normals.resize(kept);
  for (Triangle& triangle : mesh.triangles) {
    for (std::uint32_t& corner : triangle) corner = number[corner];
  }
}

Surface Extraction::run() {
  Surface surface;
  if (options_.window.empty()) return surface;
  const Plan plan = this->plan();
  choose_origin(plan, surface.mesh);
  surface.bricks = plan.bricks.size();
  surface.welded = plan.welded;
  fill(plan, surface);
  if (plan.incomplete) drop_unused_vertices(surface.mesh);
  return surface;
}

}  // namespace

Surface extract_surface(const NodeValues& values, const Lattice& lattice,
                        const ExtractOptions& options, Progress& progress) {
  assert(options.weld >= 0.0 && options.weld <= 0.49 && "a node is close to at most one end");
  return Extraction(values, lattice, options, progress).run();
}

}  // namespace cornice
