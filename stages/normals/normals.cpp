// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/normals/normals.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <functional>
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

/// What is known of points beside their places; arrays in step with the positions.
struct Known {
  Beams beams;
  std::vector<std::uint16_t> line_id;
  std::vector<std::uint8_t> classification;
  std::vector<std::uint16_t> intensity;
  std::vector<std::uint8_t> halo;     ///< 1: outside the tile
  std::vector<std::uint32_t> source;  ///< index in the input; empty unless asked for

  template <class Body>
  void for_each_array(const Body& body) {
    body(beams.direction), body(beams.source), body(line_id), body(classification);
    body(intensity), body(halo), body(source);
  }
};

/// Drops what the rules leave out, and says where the rest comes from.
void filter_classes(PointCloud& points, std::size_t tile_points, const ClassRules& rules,
                    const Options& options, Known& known, FilterCounts& counts) {
  const std::vector<std::uint8_t> keep = points_to_keep(points, rules, counts, options.threads);
  known.halo.resize(counts.kept);
  if (options.keep_source) known.source.resize(counts.kept);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < keep.size(); ++i) {
    if (keep[i] == 0) continue;
    known.halo[kept] = i < tile_points ? 0 : 1;
    if (options.keep_source) known.source[kept] = static_cast<std::uint32_t>(i);
    ++kept;
  }
  release(points.flags);
  if (counts.kept < keep.size()) points.filter(keep);
}

/// Takes over what later steps need; lets the rest go.
void take_beams(PointCloud& points, const FlightLines& lines, const Options& options,
                Known& known) {
  PointBeams found = find_beams(points, lines, options.beam, options.threads);
  known.beams = std::move(found.beams);
  known.line_id = std::move(found.line_id);
  known.classification = std::move(points.classification);
  known.intensity = std::move(points.intensity);
  release(points.gps_time_s);
  release(points.scan_angle_deg);
  release(points.point_source_id);
  release(points.scanner_channel);
  release(points.user_data);
}

/// Sorts along the curve and drops all but the first of the points at one place.
std::size_t sort_and_drop_duplicates(std::vector<Vec3f>& positions, Known& known,
                                     std::vector<std::uint64_t>& keys, int threads) {
  MortonOrder sorted = sort_along_curve(positions, threads);
  const std::size_t before = sorted.order.size();
  std::size_t kept = 0;
  for (std::size_t r = 0; r < before; ++r) {
    if (kept > 0 && sorted.keys[r] == sorted.keys[kept - 1] &&
        positions[sorted.order[r]] == positions[sorted.order[kept - 1]])
      continue;
    sorted.order[kept] = sorted.order[r];
    sorted.keys[kept++] = sorted.keys[r];
  }
  sorted.order.resize(kept);
  sorted.keys.resize(kept);
  reorder(positions, sorted.order, threads);
  known.for_each_array([&](auto& values) { reorder(values, sorted.order, threads); });
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
std::size_t drop_isolated(std::vector<Vec3f>& positions, Known& known,
                          std::vector<std::uint64_t>& keys, const PointTree& tree,
                          const IsolatedOptions& options) {
  std::vector<std::uint8_t> keep = find_isolated(tree, options);
  for (std::uint8_t& flag : keep) flag = flag == 0 ? 1 : 0;
  const std::size_t before = keep.size();
  const auto kept = static_cast<std::size_t>(std::count(keep.begin(), keep.end(), 1));
  if (kept == before) return 0;
  known.for_each_array([&](auto& values) { compact(values, keep); });
  compact(keys, keep);
  compact(positions, keep);
  return before - kept;
}

void count_beams(const Known& known, Counts& counts) {
  for (std::size_t i = 0; i < known.line_id.size(); ++i) {
    ++counts.beams_by_source[static_cast<std::size_t>(known.beams.source[i])];
    counts.without_line += known.line_id[i] == 0 ? 1 : 0;
  }
}

OrientOptions orient_options(const Options& options) {
  OrientOptions orient;
  orient.neighbours = options.neighbours;
  orient.tolerance = options.tolerance;
  orient.tolerance_per_lack = options.tolerance_per_lack;
  orient.least_breadth_m = options.least_breadth_m;
  orient.least_support = options.least_support;
  orient.threads = options.threads;
  return orient;
}

void drop_unsettled_and_halo(Result& result, const std::vector<SettledBy>& settled_by,
                             const Options& options) {
  std::vector<std::uint8_t> keep(settled_by.size());
  for (std::size_t i = 0; i < keep.size(); ++i) {
    const bool settled =
        settled_by[i] == SettledBy::kBeams || settled_by[i] == SettledBy::kPropagation;
    const bool outside = settled && result.halo[i] != 0;
    keep[i] = settled && (options.keep_halo || !outside) ? 1 : 0;
    result.counts.halo += outside && !options.keep_halo ? 1 : 0;
    result.counts.put_out += keep[i];
  }
  if (!options.keep_halo) release(result.halo);
  if (result.counts.put_out == keep.size()) return;
  const std::array<std::function<void()>, 8> arrays{
      [&] { compact(result.positions, keep); },      [&] { compact(result.normals, keep); },
      [&] { compact(result.quality, keep); },        [&] { compact(result.line_id, keep); },
      [&] { compact(result.classification, keep); }, [&] { compact(result.intensity, keep); },
      [&] { compact(result.halo, keep); },           [&] { compact(result.source, keep); },
  };
  parallel_for(arrays.size(), 1, options.threads, [&](std::size_t a, std::size_t) { arrays[a](); });
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
  Known known;
  begin("filtering");
  filter_classes(points, tile_points, rules, options, known, counts.filter);
  // In the order of time, where the next point is mostly of the same line.
  begin("beams");
  take_beams(points, lines, options, known);
  begin("sorting");
  std::vector<std::uint64_t> keys;
  std::vector<Vec3f>& positions = points.positions;
  counts.duplicates = sort_and_drop_duplicates(positions, known, keys, options.threads);
  begin("tree");
  PointTree tree(positions, keys, options.threads);
  begin("isolated");
  counts.isolated = drop_isolated(positions, known, keys, tree, options.isolated);
  if (counts.isolated > 0) tree = PointTree(positions, keys, options.threads);
  release(keys);
  count_beams(known, counts);
  begin("normals");
  OrientedNormals oriented = orient_normals(tree, known.beams, orient_options(options), progress);
  counts.settled_by = oriented.counts;
  counts.rounds = oriented.rounds;
  begin("output");
  known.beams = {};
  result.origin = points.origin;
  result.positions = std::move(positions);
  result.normals = std::move(oriented.normals);
  result.quality = std::move(oriented.quality);
  result.line_id = std::move(known.line_id);
  result.classification = std::move(known.classification);
  result.intensity = std::move(known.intensity);
  result.halo = std::move(known.halo);
  result.source = std::move(known.source);
  drop_unsettled_and_halo(result, oriented.settled_by, options);
  progress.end();
  return result;
}

}  // namespace cornice::normals
