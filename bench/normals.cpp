// SPDX-License-Identifier: GPL-3.0-or-later
// Speed and memory of the normals stage's computation, and of its neighbour search beside FLANN's.
#include "stages/normals/normals.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <flann/flann.hpp>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "bench/bench_json.h"
#include "core/base/memory.h"
#include "core/base/parallel.h"
#include "core/base/random.h"
#include "stages/normals/leaf_search.h"
#include "stages/normals/morton_order.h"
#include "stages/normals/plane_fit.h"

namespace {

using namespace cornice;
using namespace cornice::bench;

constexpr std::uint32_t kNeighbours = 16;

/// Ground of an alpine tile: ridges 150 m high, in one place a wall of 40 m that beams of the
/// nearest line graze, with 3 cm noise; flown by two lines, points shuffled among them by time.
PointCloud make_ground(std::size_t count, double density, std::uint64_t seed, int threads) {
  const double side = std::sqrt(static_cast<double>(count) / density);
  PointCloud points;
  points.origin = {2600000, 1200000, 1000};
  points.positions.resize(count);
  points.gps_time_s.resize(count);
  points.scan_angle_deg.resize(count);
  points.classification.assign(count, 2);
  points.flags.assign(count, 0);
  points.point_source_id.resize(count);
  points.scanner_channel.assign(count, 0);
  points.user_data.assign(count, 0);
  points.intensity.assign(count, 1000);
  parallel_for(count, 1u << 16, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      CounterRandom random(seed, 0, i);
      const double x = random.uniform(0, side);
      // Along the line in order of time, as a scanner's lines come.
      const double y = side * (static_cast<double>(i % (count / 2)) + random.uniform()) /
                       (0.5 * static_cast<double>(count));
      const double wall = 20.0 * std::tanh((x - 0.5 * side - 20.0 * std::sin(y / 60.0)) / 2.0);
      const double z = 75.0 * std::sin(x / 130.0) * std::cos(y / 170.0) + wall +
                       1.5 * std::sin(x / 7.0) * std::sin(y / 9.0) + 0.03 * random.normal();
      points.positions[i] = Vec3d{x, std::min(y, side), 500.0 + z}.cast<float>();
      points.gps_time_s[i] = 3e8 + (i < count / 2 ? 0.0 : 200.0) + std::min(y, side) / 60.0;
      points.point_source_id[i] = i < count / 2 ? 1 : 2;
    }
  });
  return points;
}

FlightLines make_lines(double side) {
  FlightLines lines;
  for (std::uint16_t id = 1; id <= 2; ++id) {
    FlightLine line;
    line.id = line.point_source_id = id;
    line.first_time_s = 3e8 + 200.0 * (id - 1);
    line.last_time_s = line.first_time_s + side / 60.0;
    line.beam_source = BeamSource::kTrajectory;
    for (double t = 0.0; t <= side / 60.0 + 0.5; t += 0.5) {
      line.nodes.push_back({line.first_time_s + t,
                            {2600000 + side * (0.1 + 0.6 * (id - 1)), 1200000 + 60.0 * t, 2700.0},
                            {},
                            false});
    }
    lines.lines.push_back(line);
  }
  return lines;
}

/// Wall-clock seconds of each step.
class StepClock final : public Progress {
 public:
  void begin(std::string_view step, std::uint64_t /*total*/) override {
    end();
    step_ = step;
    start_ = std::chrono::steady_clock::now();
  }
  void end() override {
    if (step_.empty()) return;
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start_;
    seconds[step_].push_back(spent.count());
    step_.clear();
  }
  std::map<std::string, std::vector<double>> seconds;  ///< by step, one entry a run

 private:
  std::string step_;
  std::chrono::steady_clock::time_point start_;
};

normals::Result compute(PointCloud points, const FlightLines& lines, int threads,
                        Progress& progress = no_progress()) {
  normals::Options options;
  options.threads = threads;
  const std::size_t n = points.size();
  return normals::compute_normals(std::move(points), n, lines, normals::built_in_rules("any"),
                                  options, progress);
}

/// Peak memory of a run on its own input, less what the process had before; the first thing to do.
double bytes_per_point(std::size_t count, double density, const FlightLines& lines,
                       const Options& options) {
  const std::uint64_t before = peak_resident_bytes();
  const normals::Result result =
      compute(make_ground(count, density, options.seed, options.threads), lines, options.threads);
  return static_cast<double>(peak_resident_bytes() - before) / static_cast<double>(count);
}

/// Fits the planes of a block and empties it.
void fit(normals::NeighbourBlock& block, std::vector<float>& quality) {
  block.finish();
  normals::PlaneBlock planes;
  fit_planes(block, planes);
  for (std::size_t l = 0; l < block.lanes(); ++l) quality[block.point(l)] = planes.quality[l];
  block.clear();
}

/// Points a second of our search and plane fit, sorting and tree included.
double search_rate(const std::vector<Vec3f>& points, int threads) {
  const double seconds = seconds_of([&] {
    const normals::MortonOrder sorted = normals::sort_along_curve(points, threads);
    std::vector<Vec3f> ordered(points.size());
    for (std::size_t r = 0; r < ordered.size(); ++r) ordered[r] = points[sorted.order[r]];
    const normals::PointTree tree(ordered, sorted.keys, threads);
    std::vector<float> quality(points.size());
    parallel_for(tree.leaves().size(), 512, threads, [&](std::size_t begin, std::size_t end) {
      normals::LeafSearch search(tree, {kNeighbours, kNeighbours, 0.0f});
      normals::NeighbourBlock block;
      for (std::size_t l = begin; l < end; ++l) {
        const normals::TreeNode& leaf = tree.nodes()[tree.leaves()[l]];
        search.open(tree.leaves()[l]);
        for (std::uint32_t i = leaf.begin; i < leaf.end; ++i) {
          search.find(i, block);
          if (block.is_full()) fit(block, quality);
        }
      }
      fit(block, quality);
    });
  });
  return static_cast<double>(points.size()) / seconds;
}

/// The same with FLANN's exact kd-tree, built on one thread and searched on all.
double flann_rate(std::vector<Vec3f> points, int threads) {
  std::vector<float> quality(points.size());
  const double seconds = seconds_of([&] {
    const flann::Matrix<float> matrix(&points[0].x, points.size(), 3);
    flann::Index<flann::L2_Simple<float>> index(matrix, flann::KDTreeSingleIndexParams(15));
    index.buildIndex();
    parallel_for(points.size(), 4096, threads, [&](std::size_t begin, std::size_t end) {
      std::vector<std::vector<std::size_t>> ids;
      std::vector<std::vector<float>> distances;
      const flann::Matrix<float> queries(&points[begin].x, end - begin, 3);
      index.knnSearch(queries, ids, distances, kNeighbours, flann::SearchParams(-1, 0.0f));
      std::vector<float> x(kNeighbours), y(kNeighbours), z(kNeighbours);
      std::vector<std::uint32_t> found(kNeighbours);
      normals::NeighbourBlock block;
      for (std::size_t i = begin; i < end; ++i) {
        for (std::size_t c = 0; c < kNeighbours; ++c) {
          const Vec3f d = points[ids[i - begin][c]] - points[i];
          x[c] = d.x, y[c] = d.y, z[c] = d.z;
        }
        block.add(static_cast<std::uint32_t>(i),
                  {kNeighbours, found.data(), x.data(), y.data(), z.data(), 0.0f});
        if (block.is_full()) fit(block, quality);
      }
      fit(block, quality);
    });
  });
  return static_cast<double>(points.size()) / seconds;
}

void measure(std::size_t count, double density, int repeats, bool chain_only,
             const Options& options, Result& result) {
  if (options.quick) count = std::min<std::size_t>(count, 400000);
  const FlightLines lines = make_lines(std::sqrt(static_cast<double>(count) / density));
  result.figure("bytes_per_point", bytes_per_point(count, density, lines, options));
  const PointCloud ground = make_ground(count, density, options.seed, options.threads);
  std::vector<double> whole, search, flann;
  normals::Counts counts;
  StepClock clock;
  for (int repeat = 0; repeat < (options.quick ? 2 : repeats); ++repeat) {
    PointCloud points = ground;
    const double seconds = seconds_of(
        [&] { counts = compute(std::move(points), lines, options.threads, clock).counts; });
    whole.push_back(static_cast<double>(count) / seconds);
    if (chain_only) continue;
    search.push_back(search_rate(ground.positions, options.threads));
    if (repeat < 2) flann.push_back(flann_rate(ground.positions, options.threads));
  }
  result.figure("points_per_s", median(whole));
  result.figure("points_per_s_best", *std::max_element(whole.begin(), whole.end()));
  if (!chain_only) {
    result.figure("search_points_per_s", median(search));
    result.figure("flann_points_per_s", median(flann));
  }
  for (const auto& [step, seconds] : clock.seconds) {
    result.figure("seconds_" + step, median(seconds));
  }
  result.figure("settled_by_neighbours_share",
                static_cast<double>(counts.settled_by[3]) / static_cast<double>(count));
  result.parameter("points", static_cast<std::int64_t>(count));
  result.parameter("density", density);
  result.parameter("k", static_cast<std::int64_t>(kNeighbours));
}

}  // namespace

int main(int argc, char** argv) {
  std::size_t count = 4000000;
  double density = 20.0;
  int repeats = 5;
  bool chain_only = false;
  return run(
      "normals", "Points a second and bytes a point of normals, fit to propagation", argc, argv,
      [&](CLI::App& app) {
        app.add_option("--points", count, "points of the made ground");
        app.add_option("--density", density, "points per square metre");
        app.add_option("--repeats", repeats, "turns; figures are their medians")
            ->check(CLI::PositiveNumber);
        app.add_flag("--chain-only", chain_only, "without the search alone and without FLANN");
      },
      [&](const Options& options, Result& result) {
        measure(count, density, repeats, chain_only, options, result);
      });
}
