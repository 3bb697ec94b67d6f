// SPDX-License-Identifier: GPL-3.0-or-later
// Marching cubes (Lorensen & Cline 1987) on sparse bricks. Each brick is read once, with a rim of
// one node, and gives the vertices that it owns and the triangles of its cells, whose corners are
// named by place. Once all are counted the numbers are known, and everything is moved to where it
// belongs.
#include "stages/poisson/extract.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <numeric>
#include <utility>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "stages/poisson/extract_brick.h"

namespace cornice {
namespace {

constexpr std::size_t kBricksAtATime = 256;
/// Bricks are worked on in columns of 2^kBlockShift squared, so that those at a time share
/// neighbours.
constexpr int kBlockShift = 2;
/// Whole numbers up to here are exact as floats.
constexpr std::int64_t kMostUnits = std::int64_t{1} << 24;
constexpr std::size_t kMostVertices = std::size_t{1} << 31;

using Triangle = std::array<std::uint32_t, 3>;

bool is_before_in_blocks(BrickKey a, BrickKey b) {
  const auto block = [](BrickKey k) { return std::pair(k.x >> kBlockShift, k.y >> kBlockShift); };
  return block(a) != block(b) ? block(a) < block(b) : a < b;
}

/// What a run of bricks gives. Arrays by brick, then by vertex, triangle and centre vertex.
struct Part {
  std::vector<BrickKey> bricks;
  std::vector<VertexTable> tables;
  std::vector<std::uint32_t> vertices, triangles_of;  ///< how many
  std::vector<Vec3f> positions, normals;
  std::vector<Triangle> triangles;  ///< vertex codes; centre vertices by number in this part
  std::vector<Vec3f> centres, centre_normals;
  std::vector<BrickKey> wanted;  ///< neighbours that hold some of the surface, too
  bool incomplete = false;
};

/// Where a brick's results lie, and where they go.
struct Place {
  std::uint32_t part = 0, in_part = 0;
  std::uint32_t first_vertex = 0;  ///< of the surface
  std::size_t first_triangle = 0;
  std::uint32_t vertex_in_part = 0;
  std::size_t triangle_in_part = 0;
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
  Part extract_range(std::span<const BrickKey> bricks) const;
  void extract_brick(const BrickSurface& surface, BrickKey brick, Part& part) const;
  void extract_bricks();
  void choose_origin(const std::vector<BrickKey>& bricks);
  void number_vertices();
  void move_brick(std::size_t b, Mesh& mesh) const;
  void append_centres(Surface& surface) const;
  void check_size() const;
  Vec3f place(BrickKey brick, Vec3<std::int32_t> units) const;
  const VertexTable& table(std::size_t b) const {
    return parts_[places_[b].part].tables[places_[b].in_part];
  }

  const NodeValues& values_;
  const Lattice lattice_;
  const ExtractOptions& options_;
  Progress& progress_;
  BrickRules rules_;
  BrickKey first_, last_;
  Vec3<std::int32_t> origin_{};  ///< node
  std::vector<Part> parts_;
  std::vector<BrickKey> bricks_;  ///< that hold some of the surface, sorted
  std::vector<Place> places_;     ///< by brick
  BrickIndex index_;
  std::size_t vertices_ = 0, triangles_ = 0;
  std::vector<std::uint32_t> first_centre_;  ///< by part, among all vertices
};

Vec3f Extraction::place(BrickKey brick, Vec3<std::int32_t> units) const {
  const double unit_m = lattice_.step_m / kUnitsPerStep;
  const auto metres = [&](std::int32_t b, std::int32_t origin, std::int32_t u) {
    return static_cast<float>((double{kUnitsPerStep} * (kBrickSide * b - origin) + u) * unit_m);
  };
  return {metres(brick.x, origin_.x, units.x), metres(brick.y, origin_.y, units.y),
          metres(brick.z, origin_.z, units.z)};
}

void Extraction::extract_brick(const BrickSurface& surface, BrickKey brick, Part& part) const {
  part.bricks.push_back(brick);
  VertexTable& owned = part.tables.emplace_back(surface.vertices());
  part.vertices.push_back(owned.number());
  for (std::size_t w = 0; w < owned.mask.size(); ++w) {
    for (std::uint64_t bits = owned.mask[w]; bits != 0; bits &= bits - 1) {
      const int bit = static_cast<int>(64 * w) + std::countr_zero(bits);
      const int node = bit >> 2;
      const BrickVertex vertex{BrickSurface::at(node & 7, node >> 3 & 7, node >> 6),
                               static_cast<VertexKind>(bit & 3)};
      part.positions.push_back(place(brick, surface.position(vertex)));
      part.normals.push_back(surface.normal(vertex));
    }
  }
  const std::size_t first = part.triangles.size();
  const auto first_centre = static_cast<std::uint32_t>(part.centres.size());
  std::vector<CentreVertex> centres;
  surface.cut(part.triangles, centres);
  part.triangles_of.push_back(static_cast<std::uint32_t>(part.triangles.size() - first));
  for (const CentreVertex& centre : centres) {
    part.centres.push_back(place(brick, centre.position));
    part.centre_normals.push_back(centre.normal);
  }
  if (centres.empty()) return;
  for (std::size_t t = first; t < part.triangles.size(); ++t) {
    for (std::uint32_t& corner : part.triangles[t]) {
      if (corner >= BrickSurface::kCentre) corner += first_centre;
    }
  }
}

Part Extraction::extract_range(std::span<const BrickKey> bricks) const {
  Part part;
  BrickCache cache(values_);
  BrickSurface surface(rules_);
  for (const BrickKey brick : bricks) {
    if (!surface.load(brick, cache)) continue;
    part.incomplete = part.incomplete || surface.incomplete();
    extract_brick(surface, brick, part);
    for (std::uint32_t bits = surface.neighbours_needed(); bits != 0; bits &= bits - 1) {
      const int n = std::countr_zero(bits);
      const BrickKey next = shifted(brick, n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
      if (next.x >= first_.x && next.x <= last_.x && next.y >= first_.y && next.y <= last_.y) {
        part.wanted.push_back(next);
      }
    }
  }
  return part;
}

/// Extracts the bricks that the values name, and follows the surface into those they do not.
void Extraction::extract_bricks() {
  std::vector<BrickKey> known;  // extracted so far, sorted
  std::vector<BrickKey> next = values_.crossing_bricks(first_, last_, options_.threads);
  choose_origin(next);
  while (!next.empty()) {
    std::sort(next.begin(), next.end(), is_before_in_blocks);
    progress_.begin("extract", next.size());
    const std::size_t first_part = parts_.size();
    parts_.resize(first_part + (next.size() + kBricksAtATime - 1) / kBricksAtATime);
    parallel_for(next.size(), kBricksAtATime, options_.threads,
                 [&](std::size_t begin, std::size_t end) {
                   check_cancelled(progress_);
                   parts_[first_part + begin / kBricksAtATime] =
                       extract_range(std::span(next).subspan(begin, end - begin));
                   progress_.advance(end - begin);
                 });
    progress_.end();
    known.insert(known.end(), next.begin(), next.end());
    std::sort(known.begin(), known.end());
    std::vector<BrickKey> wanted;
    for (std::size_t p = first_part; p < parts_.size(); ++p) {
      wanted.insert(wanted.end(), parts_[p].wanted.begin(), parts_[p].wanted.end());
      parts_[p].wanted = {};
    }
    std::sort(wanted.begin(), wanted.end());
    wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
    next.clear();
    std::set_difference(wanted.begin(), wanted.end(), known.begin(), known.end(),
                        std::back_inserter(next));
  }
}

void Extraction::choose_origin(const std::vector<BrickKey>& bricks) {
  std::int32_t low = bricks.empty() ? 0 : bricks.front().z;
  for (const BrickKey brick : bricks) low = std::min(low, brick.z);
  origin_ = {options_.window.x0, options_.window.y0, kBrickSide * low};
}

void Extraction::check_size() const {
  std::int64_t extent = std::max(std::int64_t{options_.window.x1} - options_.window.x0,
                                 std::int64_t{options_.window.y1} - options_.window.y0);
  for (const BrickKey brick : bricks_) {
    const std::int64_t below = std::int64_t{kBrickSide} * brick.z - origin_.z;
    extent = std::max({extent, below + kBrickSide, -below});
  }
  if (extent * kUnitsPerStep > kMostUnits) {
    throw RunError("surface", "spans " + std::to_string(extent) +
                                  " lattice steps, of which float positions hold " +
                                  std::to_string(kMostUnits / kUnitsPerStep) +
                                  "; take smaller tiles or a larger step");
  }
}

/// Sorts the bricks and says where each one's vertices and triangles go.
void Extraction::number_vertices() {
  for (std::uint32_t p = 0; p < parts_.size(); ++p) {
    Place place{p};
    const Part& part = parts_[p];
    for (; place.in_part < part.bricks.size(); ++place.in_part) {
      bricks_.push_back(part.bricks[place.in_part]);
      places_.push_back(place);
      place.vertex_in_part += part.vertices[place.in_part];
      place.triangle_in_part += part.triangles_of[place.in_part];
    }
  }
  std::vector<std::uint32_t> order(bricks_.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return bricks_[a] < bricks_[b]; });
  std::vector<BrickKey> bricks;
  std::vector<Place> places;
  for (const std::uint32_t o : order) {
    bricks.push_back(bricks_[o]);
    Place& place = places.emplace_back(places_[o]);
    const Part& part = parts_[place.part];
    place.first_vertex = static_cast<std::uint32_t>(vertices_);
    place.first_triangle = triangles_;
    vertices_ += part.vertices[place.in_part];
    triangles_ += part.triangles_of[place.in_part];
  }
  bricks_ = std::move(bricks);
  places_ = std::move(places);
  index_ = BrickIndex(bricks_);
  std::size_t all = vertices_;
  for (const Part& part : parts_) {
    first_centre_.push_back(static_cast<std::uint32_t>(all));
    all += part.centres.size();
  }
  if (all > kMostVertices) {
    throw RunError("surface", "has " + std::to_string(all) + " vertices, of which " +
                                  std::to_string(kMostVertices) +
                                  " can be numbered; take smaller tiles or a larger step");
  }
}

void Extraction::move_brick(std::size_t b, Mesh& mesh) const {
  const Place& place = places_[b];
  const Part& part = parts_[place.part];
  std::copy_n(part.positions.begin() + place.vertex_in_part, part.vertices[place.in_part],
              mesh.positions.begin() + place.first_vertex);
  std::copy_n(part.normals.begin() + place.vertex_in_part, part.vertices[place.in_part],
              mesh.normals.begin() + place.first_vertex);
  // The far faces' vertices belong to the bricks beyond.
  std::array<std::uint32_t, 8> owners;
  for (int o = 0; o < 8; ++o) {
    owners[static_cast<std::size_t>(o)] =
        index_.find(bricks_, shifted(bricks_[b], o & 1, o >> 1 & 1, o >> 2));
  }
  const auto number = [&](std::uint32_t code) {
    if (code >= BrickSurface::kCentre) {
      return first_centre_[place.part] + code - BrickSurface::kCentre;
    }
    constexpr int side = BrickSurface::kSide;
    const int node = static_cast<int>(code >> 2);
    const int i = node % side - 1, j = node / side % side - 1, k = node / (side * side) - 1;
    const std::uint32_t owner =
        owners[static_cast<std::size_t>(i >> 3 | j >> 3 << 1 | k >> 3 << 2)];
    assert(owner != BrickIndex::kNone && "every vertex has an owner");
    return places_[owner].first_vertex + table(owner).rank((i & 7) + 8 * (j & 7) + 64 * (k & 7),
                                                           static_cast<VertexKind>(code & 3));
  };
  for (std::size_t t = 0; t < part.triangles_of[place.in_part]; ++t) {
    const Triangle& codes = part.triangles[place.triangle_in_part + t];
    mesh.triangles[place.first_triangle + t] = {number(codes[0]), number(codes[1]),
                                                number(codes[2])};
  }
}

void Extraction::append_centres(Surface& surface) const {
  for (const Part& part : parts_) {
    surface.mesh.positions.insert(surface.mesh.positions.end(), part.centres.begin(),
                                  part.centres.end());
    surface.mesh.normals.insert(surface.mesh.normals.end(), part.centre_normals.begin(),
                                part.centre_normals.end());
    surface.centre_vertices += part.centres.size();
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
  extract_bricks();
  number_vertices();
  check_size();
  surface.mesh.origin = origin_.cast<double>() * lattice_.step_m;
  surface.bricks = bricks_.size();
  bool incomplete = false;
  for (const Part& part : parts_) {
    incomplete = incomplete || part.incomplete;
    for (const VertexTable& owned : part.tables) surface.welded += owned.welded();
  }
  surface.mesh.positions.resize(vertices_);
  surface.mesh.normals.resize(vertices_);
  surface.mesh.triangles.resize(triangles_);
  parallel_for(bricks_.size(), kBricksAtATime, options_.threads,
               [&](std::size_t begin, std::size_t end) {
                 for (std::size_t b = begin; b < end; ++b) move_brick(b, surface.mesh);
               });
  append_centres(surface);
  if (incomplete) drop_unused_vertices(surface.mesh);
  return surface;
}

}  // namespace

Surface extract_surface(const NodeValues& values, const Lattice& lattice,
                        const ExtractOptions& options, Progress& progress) {
  assert(options.weld >= 0.0 && options.weld <= 0.49 && "a node is close to at most one end");
  return Extraction(values, lattice, options, progress).run();
}

}  // namespace cornice
