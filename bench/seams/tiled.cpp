// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/seams/tiled.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/mesh/triangle_tree.h"
#include "stages/poisson/solve.h"
#include "stages/poisson/support.h"
#include "tests/property/poisson_band/seams.h"

namespace cornice::bench {
namespace {

constexpr double kHeightMarginM = 16.0;
/// Surface farther from the mesh in one piece than this is not followed.
constexpr float kFarthestM = 2.0f;

TileField solve_tile(const OrientedPoints& points, const Box2d& tile, double halo_m,
                     const TilingOptions& options) {
  SolveOptions solve;
  solve.lattice.step_m = options.step_m;
  solve.threads = options.threads;
  const Box2d plan = tile.grown(halo_m);
  Box3d domain;
  for (const Vec3f p : points.positions) {
    const Vec3d at = points.origin + p.cast<double>();
    if (plan.contains(at.x, at.y)) domain.add(at);
  }
  domain.min = {plan.min_x, plan.min_y, domain.min.z - kHeightMarginM};
  domain.max = {plan.max_x, plan.max_y, domain.max.z + kHeightMarginM};
  TileField field;
  field.field = solve_poisson(points, domain, solve, no_progress()).field;
  field.tile = lattice_box(tile, solve.lattice);
  field.ramp = static_cast<std::int32_t>(std::lround(options.band_m / options.step_m));
  field.z0 = static_cast<std::int32_t>(std::floor(domain.min.z / options.step_m));
  field.z1 = static_cast<std::int32_t>(std::ceil(domain.max.z / options.step_m));
  return field;
}

Mesh one_piece(const OrientedPoints& points, const std::vector<Box2d>& tiles,
               const TilingOptions& options) {
  Box2d all;
  for (const Box2d& tile : tiles) {
    all.add(tile.min_x, tile.min_y);
    all.add(tile.max_x, tile.max_y);
  }
  const TileField field = solve_tile(points, all, options.halo_m, options);
  ExtractOptions extract;
  extract.window = field.tile;
  extract.threads = options.threads;
  return extract_surface(FieldValues(field.field, field.z0, field.z1), field.field.lattice(),
                         extract)
      .mesh;
}

/// True near a border that two tiles share.
bool is_seam(Vec3d p, const std::vector<Box2d>& tiles, double near_m) {
  int near = 0;
  for (const Box2d& tile : tiles) near += tile.grown(near_m).contains(p.x, p.y);
  return near > 1;
}

void compare(const Mesh& joined, const Mesh& piece, const OrientedPoints& points,
             const std::vector<Box2d>& tiles, const TilingOptions& options, SeamReport& report) {
  SupportOptions support_options;
  support_options.cap_m = 2.0 * options.measured_m;
  support_options.threads = options.threads;
  const std::vector<float> support = measure_support(joined, points, support_options).distance_m;
  const TriangleTree tree(piece.positions, piece.triangles, options.threads);
  NearestQuery query;
  query.max_distance_sq = kFarthestM * kFarthestM;
  double seam = 0.0, anywhere = 0.0;
  std::size_t seams = 0, all = 0;
  for (std::size_t v = 0; v < joined.positions.size(); ++v) {
    if (support[v] > options.measured_m) continue;
    const Vec3d at = joined.origin + joined.positions[v].cast<double>();
    const NearestPoint nearest = tree.nearest((at - piece.origin).cast<float>(), query);
    const double square = nearest.found() ? nearest.distance_sq : query.max_distance_sq;
    anywhere += square, ++all;
    if (!is_seam(at, tiles, options.near_m)) continue;
    seam += square, ++seams;
    report.largest_m = std::max(report.largest_m, std::sqrt(square));
  }
  report.rms_m = seams == 0 ? 0.0 : std::sqrt(seam / static_cast<double>(seams));
  report.rms_anywhere_m = all == 0 ? 0.0 : std::sqrt(anywhere / static_cast<double>(all));
}

}  // namespace

SeamReport measure_seams(const OrientedPoints& points, const std::vector<Box2d>& tiles,
                         const TilingOptions& options) {
  std::vector<TileField> fields;
  std::vector<LatticeBox> boxes;
  for (const Box2d& tile : tiles) {
    fields.push_back(solve_tile(points, tile, options.halo_m, options));
    boxes.push_back(fields.back().tile);
  }
  const std::vector<Surface> surfaces = test::extract_all(fields, options.threads);
  test::JoinedTiles joined = test::join_tiles(surfaces, boxes, fields.front().field.lattice());
  SeamReport report;
  report.triangles = joined.mesh.triangles.size();
  report.open_edges = joined.open_edges;
  report.mismatched = joined.mismatched;
  report.turned = joined.turned;
  report.non_manifold = joined.non_manifold;
  report.joined = std::move(joined.mesh);
  compare(report.joined, one_piece(points, tiles, options), points, tiles, options, report);
  return report;
}

std::vector<Box2d> side_by_side(std::vector<Box2d> boxes, double step_m) {
  // A side that faces another tile's within this lies on one line with it.
  constexpr double kGapM = 2.0;
  for (std::size_t a = 0; a < boxes.size(); ++a) {
    for (std::size_t b = 0; b < boxes.size(); ++b) {
      const auto meet = [&](double& high, double& low) {
        if (a == b || std::abs(high - low) > kGapM) return;
        high = low = std::round(0.5 * (high + low) / step_m) * step_m;
      };
      meet(boxes[a].max_x, boxes[b].min_x);
      meet(boxes[a].max_y, boxes[b].min_y);
    }
  }
  return boxes;
}

}  // namespace cornice::bench
