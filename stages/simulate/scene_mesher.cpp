// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/simulate/scene_mesher.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/parallel.h"
#include "stages/simulate/scene_cubes.h"

namespace cornice::simulate {
namespace {

constexpr int kBlock = 32;  // cells along a side of a block in plan
constexpr int kCoarse = 4;  // cells along a side of a coarse cell
constexpr int kHalo = 4;    // cells sampled around a block, one coarse cell
constexpr float kUnset = 3e38f;
constexpr float kFar = 1e30f;  // stands for a sign alone

/// The lattice of a window: point (i, j, k) lies at (x0 + i dx, y0 + j dy, k dz); cell (i, j, k)
/// has it as its lowest corner. The window's sides pass through the middles of the outer cells.
struct Lattice {
  double x0, y0, dx, dy, dz;
  int nx, ny;  // cells
  Box2d window;

  explicit Lattice(const SurfaceOptions& options) : window(options.window) {
    nx = std::max(1, static_cast<int>(std::lround(window.width() / options.step_m))) + 1;
    ny = std::max(1, static_cast<int>(std::lround(window.height() / options.step_m))) + 1;
    dx = window.width() / (nx - 1);
    dy = window.height() / (ny - 1);
    dz = options.step_m;
    x0 = window.min_x - 0.5 * dx;
    y0 = window.min_y - 0.5 * dy;
  }
  Vec3d point(int i, int j, int k) const { return {x0 + i * dx, y0 + j * dy, k * dz}; }
};

/// Cells that the surface passes, column by column, heights ascending.
struct BlockCells {
  struct Cell {
    std::int32_t k;
    std::uint32_t first_vertex;  // within the block
    std::uint8_t solid;
    std::uint8_t flipped;
  };
  std::vector<std::uint32_t> column_start;  // kBlock * kBlock + 1
  std::vector<Cell> cells;
  std::vector<Vec3d> vertices;
  std::uint64_t unsettled = 0;
  std::uint64_t unsampled = 0;
};

/// Samples of F on a block's lattice points and one coarse cell around it. Only coarse cells near
/// the surface are sampled finely; the others hold the sign alone.
class BlockSamples {
 public:
  BlockSamples(const GroundField& field, const Lattice& lattice, int i0, int j0)
      : i0_(i0 - kHalo), j0_(j0 - kHalo) {
    const Vec3d a = lattice.point(i0_, j0_, 0);
    const Vec3d b = lattice.point(i0_ + kSide - 1, j0_ + kSide - 1, 0);
    const GroundField::Range range = field.height_range({a.x, a.y, b.x, b.y});
    const double coarse = kCoarse * lattice.dz;
    const int low = static_cast<int>(std::floor(range.low / coarse)) - 2;
    const int high = static_cast<int>(std::ceil(range.high / coarse)) + 2;
    k0_ = low * kCoarse;
    nz_ = (high - low) * kCoarse + 1;
    values_.assign(static_cast<std::size_t>(kSide) * kSide * nz_, kUnset);
    sample(field, lattice, high - low);
  }

  int k_begin() const { return k0_; }
  int k_end() const { return k0_ + nz_ - 1; }  // cells
  float at(int i, int j, int k) const { return values_[index(i - i0_, j - j0_, k - k0_)]; }

  /// Cells of a column that the surface can pass.
  std::pair<int, int> column_range(int i, int j) const {
    const Range& range = ranges_[static_cast<std::size_t>((j - j0_) / kCoarse) * kCoarseSide +
                                 static_cast<std::size_t>((i - i0_) / kCoarse)];
    return {k0_ + range.begin, k0_ + range.end};
  }

  /// Bits of the four corners of cell (i, j, k) at its lower end.
  int solid_layer(int i, int j, int k) const {
    int bits = 0;
    for (int c = 0; c < 4; ++c) {
      if (at(i + (c & 1), j + (c >> 1), k) < 0.0f) bits |= 1 << c;
    }
    return bits;
  }

  std::uint8_t solid(int i, int j, int k) const {
    int bits = 0;
    for (int c = 0; c < 8; ++c) {
      if (at(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2)) < 0.0f) bits |= 1 << c;
    }
    return static_cast<std::uint8_t>(bits);
  }

 private:
  static constexpr int kSide = kBlock + 2 * kHalo + 1;
  static constexpr int kCoarseSide = kSide / kCoarse + 1;

  std::size_t index(int i, int j, int k) const {
    return (static_cast<std::size_t>(j) * kSide + i) * nz_ + k;
  }

  void sample(const GroundField& field, const Lattice& lattice, int coarse_cells) {
    sample_points(field, lattice, {0, 0, 0}, {kSide - 1, kSide - 1, nz_ - 1}, kCoarse);
    struct Active {
      int i, j, k;
    };
    std::vector<Active> active;
    for (int j = 0; j + 1 < kSide; j += kCoarse) {
      for (int i = 0; i + 1 < kSide; i += kCoarse) {
        Range& range = ranges_[static_cast<std::size_t>(j / kCoarse * kCoarseSide + i / kCoarse)];
        for (int k = 0; k < coarse_cells * kCoarse; k += kCoarse) {
          bool solid = false;
          if (is_near(i, j, k, kCoarse, 0.6f, solid)) {
            active.push_back({i, j, k});
            range.begin = std::min(range.begin, k);
            range.end = std::max(range.end, k + kCoarse);
          } else {
            fill(i, j, k, kCoarse, solid ? -kFar : kFar);
          }
        }
      }
    }
    for (const auto& [i, j, k] : active) sample_cell(field, lattice, i, j, k);
    while (complete_cells(field, lattice)) {
    }
  }

  /// Samples the corners that a sign alone stands for of every cell that the surface passes: where
  /// it runs out of the cells that were taken to be near it. False once there are none.
  bool complete_cells(const GroundField& field, const Lattice& lattice) {
    bool changed = false;
    for (int j = kHalo - 1; j <= kHalo + kBlock; ++j) {
      for (int i = kHalo - 1; i <= kHalo + kBlock; ++i) {
        Range& range = ranges_[static_cast<std::size_t>(j / kCoarse * kCoarseSide + i / kCoarse)];
        if (range.begin >= range.end) continue;
        const int first = std::max(range.begin - kCoarse, 0);
        const int last = std::min(range.end + kCoarse, nz_ - 1);
        for (int k = first; k < last; ++k) {
          float low = kUnset, high = -kUnset;
          for (int c = 0; c < 8; ++c) {
            const float v = values_[index(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2))];
            low = std::min(low, v);
            high = std::max(high, v);
          }
          if (low >= 0.0f || high < 0.0f || (low > -kFar && high < kFar)) continue;
          sample_points(field, lattice, {i, j, k}, {i + 1, j + 1, k + 1}, 1);
          range.begin = std::min(range.begin, k);
          range.end = std::max(range.end, k + 1);
          changed = true;
        }
      }
    }
    return changed;
  }

  /// Whether the surface can pass a cube of sampled corners: they differ in sign, or one is nearer
  /// to zero than a share of what F changes by over the cube.
  bool is_near(int i, int j, int k, int side, float share, bool& solid) const {
    float low = kFar, high = -kFar;
    for (int c = 0; c < 8; ++c) {
      const float value =
          values_[index(i + (c & 1) * side, j + (c >> 1 & 1) * side, k + (c >> 2) * side)];
      low = std::min(low, value);
      high = std::max(high, value);
    }
    solid = high < 0.0f;
    return std::max(low, -high) < share * (high - low);
  }

  /// Sets the sign of what no sample has been taken of.
  void fill(int i0, int j0, int k0, int side, float value) {
    for (int j = j0; j <= j0 + side; ++j) {
      for (int i = i0; i <= i0 + side; ++i) {
        for (int k = k0; k <= k0 + side; ++k) {
          float& v = values_[index(i, j, k)];
          if (v == kUnset) v = value;
        }
      }
    }
  }

  /// Samples every stride-th point of a box of lattice points.
  void sample_points(const GroundField& field, const Lattice& lattice, std::array<int, 3> first,
                     std::array<int, 3> last, int stride) {
    constexpr std::size_t kBatch = 128;
    std::array<Vec3d, kBatch> places;
    std::array<float*, kBatch> targets;
    std::size_t count = 0;
    const auto flush = [&] {
      std::array<double, kBatch> values;
      field.values(places.data(), count, values.data());
      for (std::size_t n = 0; n < count; ++n) *targets[n] = static_cast<float>(values[n]);
      count = 0;
    };
    for (int j = first[1]; j <= last[1]; j += stride) {
      for (int i = first[0]; i <= last[0]; i += stride) {
        for (int k = first[2]; k <= last[2]; k += stride) {
          float& value = values_[index(i, j, k)];
          if (std::abs(value) < kFar) continue;
          places[count] = lattice.point(i0_ + i, j0_ + j, k0_ + k);
          targets[count] = &value;
          if (++count == kBatch) flush();
        }
      }
    }
    flush();
  }

  /// Halves a coarse cell and samples finely the halves near the surface.
  void sample_cell(const GroundField& field, const Lattice& lattice, int i0, int j0, int k0) {
    constexpr int kHalf = kCoarse / 2;
    sample_points(field, lattice, {i0, j0, k0}, {i0 + kCoarse, j0 + kCoarse, k0 + kCoarse}, kHalf);
    for (int half = 0; half < 8; ++half) {
      const int i = i0 + (half & 1) * kHalf, j = j0 + (half >> 1 & 1) * kHalf;
      const int k = k0 + (half >> 2) * kHalf;
      // One cell around the block is looked at, no more.
      constexpr int kFirst = kHalo - 1, kLast = kHalo + kBlock + 1;
      if (i + kHalf < kFirst || j + kHalf < kFirst || i > kLast || j > kLast) continue;
      bool solid = false;
      if (is_near(i, j, k, kHalf, 0.35f, solid)) {
        sample_points(field, lattice, {i, j, k}, {i + kHalf, j + kHalf, k + kHalf}, 1);
      } else {
        fill(i, j, k, kHalf, solid ? -kFar : kFar);
      }
    }
  }

  struct Range {
    int begin = std::numeric_limits<int>::max();
    int end = 0;
  };
  int i0_, j0_, k0_ = 0, nz_ = 0;
  std::vector<float> values_;
  std::vector<Range> ranges_ = std::vector<Range>(kCoarseSide * kCoarseSide);
};

/// Faces to be cut the other way: where both cubes beside an ambiguous face have one patch that
/// holds both its segments, the dual edge through that face would carry four quads.
std::uint8_t flips_of(const BlockSamples& samples, const Lattice& lattice, int i, int j, int k,
                      std::uint8_t solid) {
  const CubePatches& patches = usual_patches(solid);
  if (patches.doubled_faces == 0) return 0;
  std::uint8_t flips = 0;
  for (int face = 0; face < 6; ++face) {
    if (((patches.doubled_faces >> face) & 1) == 0) continue;
    const int step = face % 2 == 0 ? -1 : 1;
    const int ni = i + (face / 2 == 0 ? step : 0);
    const int nj = j + (face / 2 == 1 ? step : 0);
    const int nk = k + (face / 2 == 2 ? step : 0);
    if (ni < 0 || nj < 0 || ni >= lattice.nx || nj >= lattice.ny) continue;
    if (nk < samples.k_begin() || nk >= samples.k_end()) continue;
    const CubePatches& beside = usual_patches(samples.solid(ni, nj, nk));
    if (((beside.doubled_faces >> (face ^ 1)) & 1) != 0) {
      flips |= static_cast<std::uint8_t>(1 << face);
    }
  }
  return flips;
}

/// Mean of the crossings of one patch's edges.
Vec3d patch_middle(const BlockSamples& samples, const Lattice& lattice, int i, int j, int k,
                   const CubePatches& patches, int patch, bool& unsampled) {
  Vec3d sum;
  int count = 0;
  for (int e = 0; e < 12; ++e) {
    if (patches.of_edge[e] != patch) continue;
    const CubeEdge edge = cube_edge(e);
    const auto corner = [&](int c, Vec3d& p) {
      const int ci = i + (c & 1), cj = j + (c >> 1 & 1), ck = k + (c >> 2);
      p = lattice.point(ci, cj, ck);
      return static_cast<double>(samples.at(ci, cj, ck));
    };
    Vec3d a, b;
    const double fa = corner(edge.from, a);
    const double fb = corner(edge.to, b);
    if (std::max(std::abs(fa), std::abs(fb)) >= kFar) unsampled = true;
    sum += a + (b - a) * (fa / (fa - fb));
    ++count;
  }
  return sum / static_cast<double>(count);
}

/// Moves p onto F = 0, then off it by the offset. On the window's sides it stays on them.
bool settle(const GroundField& field, const Lattice& lattice, const SurfaceOptions& options, int i,
            int j, Vec3d& p) {
  const bool keep_x = i == 0 || i == lattice.nx - 1;
  const bool keep_y = j == 0 || j == lattice.ny - 1;
  if (keep_x) p.x = i == 0 ? lattice.window.min_x : lattice.window.max_x;
  if (keep_y) p.y = j == 0 ? lattice.window.min_y : lattice.window.max_y;
  const Vec3d start = p;
  const int most = options.tolerance_m > 0.0 ? 30 : 2;
  Vec3d gradient;
  double limit = options.step_m;
  for (int iteration = 0; iteration < most; ++iteration) {
    const double value = field.value(p, gradient);
    const double full = norm(gradient);
    if (options.tolerance_m > 0.0 && std::abs(value) < options.tolerance_m * full) break;
    if (keep_x) gradient.x = 0.0;
    if (keep_y) gradient.y = 0.0;
    Vec3d move = gradient * (-value / std::max(dot(gradient, gradient), 1e-4 * full * full));
    const double length = norm(move);
    if (length > limit) move *= limit / length;
    if (iteration > 4) limit *= 0.7;
    p += move;
  }
  if (norm(p - start) > 2.0 * options.step_m && options.offset_m > 0.0) p = start;
  const double value = field.value(p, gradient);
  const double distance = std::abs(value) / norm(gradient);
  const Vec3d normal = normalized(gradient);
  if (options.offset_m > 0.0) {
    // The middle of the crossings lies on a chord: how far the ground was from it says how far the
    // facets around cut into it.
    const double cut = std::abs(dot(p - start, normal));
    const double offset = std::min(options.offset_m + 1.6 * cut, 2.8 * options.offset_m);
    p += Vec3d{keep_x ? 0.0 : normal.x, keep_y ? 0.0 : normal.y, normal.z} * offset;
  }
  return distance <= std::max(options.tolerance_m, 1e-9);
}

BlockCells extract_block(const GroundField& field, const Lattice& lattice,
                         const SurfaceOptions& options, int i0, int j0) {
  const BlockSamples samples(field, lattice, i0, j0);
  BlockCells block;
  block.column_start.reserve(kBlock * kBlock + 1);
  for (int j = j0; j < j0 + kBlock; ++j) {
    for (int i = i0; i < i0 + kBlock; ++i) {
      block.column_start.push_back(static_cast<std::uint32_t>(block.cells.size()));
      if (i >= lattice.nx || j >= lattice.ny) continue;
      const auto [k_begin, k_end] = samples.column_range(i, j);
      int layer = k_begin < k_end ? samples.solid_layer(i, j, k_begin) : 0;
      for (int k = k_begin; k < k_end; ++k) {
        const int above = samples.solid_layer(i, j, k + 1);
        const auto solid = static_cast<std::uint8_t>(layer | above << 4);
        layer = above;
        if (solid == 0 || solid == 255) continue;
        const std::uint8_t flips = flips_of(samples, lattice, i, j, k, solid);
        const CubePatches patches = flips == 0 ? usual_patches(solid) : cube_patches(solid, flips);
        block.cells.push_back({k, static_cast<std::uint32_t>(block.vertices.size()), solid, flips});
        for (int patch = 0; patch < patches.count; ++patch) {
          bool unsampled = false;
          Vec3d p = patch_middle(samples, lattice, i, j, k, patches, patch, unsampled);
          if (!settle(field, lattice, options, i, j, p)) ++block.unsettled;
          if (unsampled) ++block.unsampled;
          block.vertices.push_back(p);
        }
      }
    }
  }
  block.column_start.push_back(static_cast<std::uint32_t>(block.cells.size()));
  return block;
}

/// All blocks with the running number of their first vertices.
struct Blocks {
  int columns = 0, rows = 0;
  std::vector<BlockCells> blocks;
  std::vector<std::uint32_t> first_vertex;

  /// Vertex of the patch that crosses `edge` of cell (i, j, k).
  std::uint32_t vertex(int i, int j, int k, int edge) const {
    const std::size_t b =
        static_cast<std::size_t>(j / kBlock) * columns + static_cast<std::size_t>(i / kBlock);
    const BlockCells& block = blocks[b];
    const int column = j % kBlock * kBlock + i % kBlock;
    const auto begin = block.cells.begin() + block.column_start[column];
    const auto end = block.cells.begin() + block.column_start[column + 1];
    const auto cell = std::lower_bound(
        begin, end, k, [](const BlockCells::Cell& c, int height) { return c.k < height; });
    const CubePatches patches =
        cell->flipped == 0 ? usual_patches(cell->solid) : cube_patches(cell->solid, cell->flipped);
    return first_vertex[b] + cell->first_vertex + patches.of_edge[edge];
  }
};

/// The quads around the crossed lattice edges that start at the lowest corner of the block's cells.
void connect_block(const Blocks& all, std::size_t b, const Lattice& lattice,
                   std::vector<std::array<std::uint32_t, 4>>& quads) {
  const BlockCells& block = all.blocks[b];
  const int i0 = static_cast<int>(b) % all.columns * kBlock;
  const int j0 = static_cast<int>(b) / all.columns * kBlock;
  for (int column = 0; column < kBlock * kBlock; ++column) {
    const int i = i0 + column % kBlock, j = j0 + column / kBlock;
    for (std::uint32_t c = block.column_start[column]; c < block.column_start[column + 1]; ++c) {
      const BlockCells::Cell& cell = block.cells[c];
      for (int axis = 0; axis < 3; ++axis) {
        const bool from_solid = cell.solid & 1, to_solid = cell.solid >> (1 << axis) & 1;
        if (from_solid == to_solid) continue;
        // All four vertices would lie in one side of the window.
        if (axis == 0 && (i == 0 || i == lattice.nx - 1)) continue;
        if (axis == 1 && (j == 0 || j == lattice.ny - 1)) continue;
        const int u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
        int d[4][3] = {};  // the cells around the edge, in turn
        d[1][u] = d[2][u] = d[2][v] = d[3][v] = -1;
        std::array<std::uint32_t, 4> quad{};
        bool inside = true;
        for (int n = 0; n < 4 && inside; ++n) {
          const int ci = i + d[n][0], cj = j + d[n][1], ck = cell.k + d[n][2];
          inside = ci >= 0 && cj >= 0 && ci < lattice.nx && cj < lattice.ny;
          if (!inside) break;
          const int edge = 4 * axis + (d[n][u] < 0 ? 1 : 0) + (d[n][v] < 0 ? 2 : 0);
          quad[n] = all.vertex(ci, cj, ck, edge);
        }
        if (!inside) continue;
        // (u, v, axis) is a right-handed frame for axes 0 and 2, left-handed for axis 1.
        if (from_solid == (axis == 1)) std::swap(quad[1], quad[3]);
        quads.push_back(quad);
      }
    }
  }
}

}  // namespace

Surface extract_surface(const GroundField& field, const SurfaceOptions& options) {
  const Lattice lattice(options);
  Blocks all;
  all.columns = (lattice.nx + kBlock - 1) / kBlock;
  all.rows = (lattice.ny + kBlock - 1) / kBlock;
  const std::size_t count = static_cast<std::size_t>(all.columns) * all.rows;
  all.blocks.resize(count);
  parallel_for(count, 1, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) {
      all.blocks[b] =
          extract_block(field, lattice, options, static_cast<int>(b % all.columns) * kBlock,
                        static_cast<int>(b / all.columns) * kBlock);
    }
  });
  Surface surface;
  surface.origin = {options.window.min_x, options.window.min_y, 0.0};
  std::uint32_t total = 0;
  for (const BlockCells& block : all.blocks) {
    all.first_vertex.push_back(total);
    total += static_cast<std::uint32_t>(block.vertices.size());
    surface.unsettled += block.unsettled;
    surface.unsampled += block.unsampled;
  }
  surface.positions.resize(total);
  std::vector<std::vector<std::array<std::uint32_t, 4>>> quads(count);
  parallel_for(count, 1, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) {
      connect_block(all, b, lattice, quads[b]);
      std::uint32_t at = all.first_vertex[b];
      for (const Vec3d& p : all.blocks[b].vertices) {
        surface.positions[at++] = (p - surface.origin).cast<float>();
      }
    }
  });
  std::size_t quad_count = 0;
  for (const auto& part : quads) quad_count += part.size();
  all.blocks.clear();
  surface.quads.reserve(quad_count);
  for (auto& part : quads) {
    surface.quads.insert(surface.quads.end(), part.begin(), part.end());
    part = {};
  }
  return surface;
}

}  // namespace cornice::simulate
