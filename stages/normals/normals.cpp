// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/normals/normals.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "core/base/parallel.h"
#include "stages/normals/beams.h"
#include "stages/normals/morton_order.h"
#include "stages/normals/point_tree.h"

namespace cornice::normals {
namespace {

constexpr std::size_t kGrain = 1u << 18;

/// values[r] = old values[order[r]]; nothing for an array that is not filled.
template <class T>
void reorder(std::vector<T>& values, const std::vector<std::uint32_t>& order, int threads) {
  if (values.empty()) return;
  std::vector<T> sorted(order.size());
  parallel_for(order.size(), kGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r) sorted[r] = values[order[r]];
  });
  values = std::move(sorted);
}

template <class T>
void release(std::vector<T>& values) {
  std::vector<T>().swap(values);
}

void reorder(PointCloud& points, const std::vector<std::uint32_t>& order, int threads) {
  reorder(points.positions, order, threads);
  reorder(points.gps_time_s, order, threads);
  reorder(points.scan_angle_deg, order, threads);
  reorder(points.classification, order, threads);
  reorder(points.point_source_id, order, threads);
  reorder(points.scanner_channel, order, threads);
  reorder(points.user_data, order, threads);
  reorder(points.intensity, order, threads);
}

/// What a point's place in the input says, in step with a PointCloud.
struct Provenance {
  std::vector<std::uint8_t> halo;     ///< 1: outside the tile
  std::vector<std::uint32_t> source;  ///< index in the input; empty unless asked for
};

/// Drops what the rules leave out.
Provenance filter_classes(PointCloud& points, std::size_t tile_points, bool keep_source,
                          const ClassRules& rules, FilterCounts& counts) {
  const std::vector<std::uint8_t> keep = points_to_keep(points, rules, counts);
  Provenance from;
  from.halo.reserve(counts.kept);
  if (keep_source) from.source.reserve(counts.kept);
  for (std::size_t i = 0; i < keep.size(); ++i) {
    if (keep[i] == 0) continue;
    from.halo.push_back(i < tile_points ? 0 : 1);
    if (keep_source) from.source.push_back(static_cast<std::uint32_t>(i));
  }
  points.filter(keep);
  release(points.flags);
  return from;
}

/// Sorts along the curve and drops all but the first of the points at one place.
std::size_t sort_and_drop_duplicates(PointCloud& points, Provenance& from,
                                     std::vector<std::uint64_t>& keys, int threads) {
  MortonOrder sorted = sort_along_curve(points.positions, threads);
  const std::size_t before = sorted.order.size();
  std::size_t kept = 0;
  for (std::size_t r = 0; r < before; ++r) {
    const Vec3f p = points.positions[sorted.order[r]];
    if (kept > 0 && p == points.positions[sorted.order[kept - 1]]) continue;
    sorted.order[kept] = sorted.order[r];
    sorted.keys[kept++] = sorted.keys[r];
  }
  sorted.order.resize(kept);
  sorted.keys.resize(kept);
  reorder(points, sorted.order, threads);
  reorder(from.halo, sorted.order, threads);
  reorder(from.source, sorted.order, threads);
  keys = std::move(sorted.keys);
  return before - kept;
}

/// Keeps the entries marked in `keep`, in order.
template <class T>
void compact(std::vector<T>& values, const std::vector<std::uint8_t>& keep) {
  if (values.empty()) return;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < keep.size(); ++i) {
    if (keep[i] != 0) values[kept++] = values[i];
  }
  values.resize(kept);
  values.shrink_to_fit();
}

/// Drops isolated points; the rest stays in order.
std::size_t drop_isolated(PointCloud& points, Provenance& from, std::vector<std::uint64_t>& keys,
                          const PointTree& tree, const IsolatedOptions& options) {
  std::vector<std::uint8_t> keep = find_isolated(tree, options);
  for (std::uint8_t& flag : keep) flag = flag == 0 ? 1 : 0;
  const std::size_t before = keep.size();
  const auto kept = static_cast<std::size_t>(std::count(keep.begin(), keep.end(), 1));
  if (kept == before) return 0;
  compact(from.halo, keep);
  compact(from.source, keep);
  compact(keys, keep);
  points.filter(keep);
  return before - kept;
}

void drop_unsettled_and_halo(Result& result, const std::vector<SettledBy>& settled_by,
                             bool keep_halo) {
  std::vector<std::uint8_t> keep(settled_by.size());
  for (std::size_t i = 0; i < keep.size(); ++i) {
    const bool settled =
        settled_by[i] == SettledBy::kBeams || settled_by[i] == SettledBy::kPropagation;
    const bool outside = settled && result.halo[i] != 0;
    keep[i] = settled && (keep_halo || !outside) ? 1 : 0;
    result.counts.halo += outside && !keep_halo ? 1 : 0;
    result.counts.put_out += keep[i];
  }
  compact(result.positions, keep);
  compact(result.normals, keep);
  compact(result.quality, keep);
  compact(result.line_id, keep);
  compact(result.classification, keep);
  compact(result.intensity, keep);
  compact(result.halo, keep);
  compact(result.source, keep);
  if (!keep_halo) release(result.halo);
}

}  // namespace

Result compute_normals(PointCloud points, std::size_t tile_points, const FlightLines& lines,
                       const ClassRules& rules, const Options& options, Progress& progress) {
  assert(tile_points <= points.size());
  Result result;
  Counts& counts = result.counts;
  const auto begin = [&](const char* step) {
    check_cancelled(progress);
    progress.begin(step, 0);
  };
  counts.read = points.size();
  begin("filtering");
  Provenance from = filter_classes(points, tile_points, options.keep_source, rules, counts.filter);
  begin("sorting");
  std::vector<std::uint64_t> keys;
  counts.duplicates = sort_and_drop_duplicates(points, from, keys, options.threads);
  PointTree tree(points.positions, keys, options.threads);
  counts.isolated = drop_isolated(points, from, keys, tree, options.isolated);
  if (counts.isolated > 0) tree = PointTree(points.positions, keys, options.threads);
  release(keys);
  begin("beams");
  PointBeams found = find_beams(points, lines, options.beam, options.threads);
  counts.beams_by_source = found.by_source;
  counts.without_line = found.without_line;
  release(points.gps_time_s);
  release(points.scan_angle_deg);
  release(points.point_source_id);
  release(points.scanner_channel);
  release(points.user_data);
  begin("normals");
  OrientOptions orient;
  orient.neighbours = options.neighbours;
  orient.tolerance = options.tolerance;
  orient.tolerance_per_lack = options.tolerance_per_lack;
  orient.least_breadth_m = options.least_breadth_m;
  orient.least_support = options.least_support;
  orient.threads = options.threads;
  OrientedNormals oriented = orient_normals(tree, found.beams, orient);
  counts.settled_by = oriented.counts;
  counts.rounds = oriented.rounds;
  found.beams = {};
  result.origin = points.origin;
  result.positions = std::move(points.positions);
  result.normals = std::move(oriented.normals);
  result.quality = std::move(oriented.quality);
  result.line_id = std::move(found.line_id);
  result.classification = std::move(points.classification);
  result.intensity = std::move(points.intensity);
  result.halo = std::move(from.halo);
  result.source = std::move(from.source);
  drop_unsettled_and_halo(result, oriented.settled_by, options.keep_halo);
  progress.end();
  return result;
}

}  // namespace cornice::normals
