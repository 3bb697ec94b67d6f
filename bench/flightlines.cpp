// SPDX-License-Identifier: GPL-3.0-or-later
// How well flight lines are found: simulated surveys of each scanner pattern and product, with fine
// and whole-degree angles, ids as they are and zeroed, against what the simulator knows.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "bench/bench_json.h"
#include "core/base/parallel.h"
#include "stages/flightlines/survey_lines.h"
#include "stages/simulate/scene.h"
#include "stages/simulate/survey.h"

namespace {

using namespace cornice;
namespace lines = cornice::flightlines;
namespace sim = cornice::simulate;

constexpr double kRadians = std::numbers::pi / 180.0;

/// Points of a survey, tile by tile, and the truth that goes with them.
struct Flown {
  std::unique_ptr<sim::Survey> survey;
  std::vector<PointCloud> tiles;
  std::vector<sim::LineTally> tallies;
};

void append(const sim::SurveyPoint& point, PointCloud& cloud) {
  cloud.positions.push_back((point.recorded() - cloud.origin).cast<float>());
  cloud.gps_time_s.push_back(point.gps_time_s);
  cloud.scan_angle_deg.push_back(point.scan_angle_deg);
  cloud.return_number.push_back(point.return_number);
  cloud.return_count.push_back(point.return_count);
  cloud.classification.push_back(point.classification);
  cloud.flags.push_back(point.flags);
  cloud.point_source_id.push_back(point.point_source_id);
  cloud.scanner_channel.push_back(point.channel);
  cloud.user_data.push_back(point.user_data);
}

Flown fly(const sim::SurveyOptions& options, const sim::Scene& scene, int threads) {
  Flown flown;
  flown.survey = std::make_unique<sim::Survey>(options, scene);
  const sim::SurveySetup& setup = flown.survey->setup;
  flown.tiles.resize(static_cast<std::size_t>(setup.grid.count()));
  for (int tile = 0; tile < setup.grid.count(); ++tile) {
    const Box2d box = setup.grid.tile(tile);
    flown.tiles[static_cast<std::size_t>(tile)].origin = {box.min_x, box.min_y, 0.0};
    for (const auto& point : sim::virtual_points(setup, tile))
      append(point, flown.tiles[static_cast<std::size_t>(tile)]);
  }
  flown.tallies.resize(setup.lines.size());
  constexpr std::uint64_t kBlock = 16384;
  for (std::size_t pass = 0; pass < flown.survey->trajectory.passes().size(); ++pass) {
    const std::uint64_t pulses = sim::pulses_of_pass(setup, pass);
    const std::size_t count = (pulses + kBlock - 1) / kBlock;
    std::vector<sim::BlockPoints> blocks(count);
    parallel_for(count, 1, threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        blocks[i] =
            sim::simulate_block(setup, {pass, i * kBlock, std::min(kBlock, pulses - i * kBlock)});
    });
    for (const sim::BlockPoints& block : blocks) {
      for (const auto& point : block.points)
        if (const auto tile = setup.grid.find(point.at.x, point.at.y))
          append(point, flown.tiles[static_cast<std::size_t>(*tile)]);
      for (std::size_t channel = 0; channel < block.tallies.size(); ++channel)
        flown.tallies[pass * static_cast<std::size_t>(setup.channels) + channel].add(
            block.tallies[channel]);
    }
  }
  return flown;
}

/// What a run on one survey gave.
struct Score {
  double azimuth_error_deg = 0.0;
  double square_sum = 0.0;  ///< of all nodes' position errors
  double horizontal_sum = 0.0;
  std::size_t nodes = 0;
  int split_errors = 0;
  int without_path = 0;
  int lines = 0;
  double points = 0.0;
  double seconds = 0.0;

  void add(const Score& other) {
    azimuth_error_deg = std::max(azimuth_error_deg, other.azimuth_error_deg);
    square_sum += other.square_sum;
    horizontal_sum += other.horizontal_sum;
    nodes += other.nodes;
    split_errors += other.split_errors;
    without_path += other.without_path;
    lines += other.lines;
  }
  double per_node(double sum) const {
    return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(1, nodes)));
  }
  double rms_m() const { return per_node(square_sum); }
  double horizontal_m() const { return per_node(horizontal_sum); }
  double vertical_m() const { return per_node(square_sum - horizontal_sum); }
};

/// Mean direction of the nose over the points of a line, plus 90.
double true_across_deg(const sim::Survey& survey, const sim::SurveyLine& line,
                       const sim::LineTally& tally) {
  double east = 0.0, north = 0.0;
  for (const sim::TrajectoryPose& pose : survey.trajectory.poses()) {
    if (pose.pass != line.pass || pose.gps_time_s < tally.true_first_time_s ||
        pose.gps_time_s > tally.true_last_time_s)
      continue;
    east += std::sin(pose.heading_deg * kRadians);
    north += std::cos(pose.heading_deg * kRadians);
  }
  return std::atan2(east, north) / kRadians + 90.0;
}

void score_line(const sim::Survey& survey, const sim::SurveyLine& truth,
                const sim::LineTally& tally, const lines::LineEstimate& found, Score& score) {
  ++score.lines;
  score.without_path += found.line.beam_source != BeamSource::kTrajectory;
  const double error =
      std::remainder(found.line.across_azimuth_deg - true_across_deg(survey, truth, tally), 360.0);
  score.azimuth_error_deg = std::max(score.azimuth_error_deg, std::abs(error));
  for (const TrajectoryNode& node : found.line.nodes) {
    const double time =
        std::clamp(node.gps_time_s, tally.true_first_time_s, tally.true_last_time_s);
    const Vec3d d =
        node.position - survey.trajectory.at(static_cast<std::size_t>(truth.pass), time).position;
    score.square_sum += dot(d, d);
    score.horizontal_sum += d.x * d.x + d.y * d.y;
    ++score.nodes;
  }
}

/// Each true line with points must be found once, over the same time.
Score score_of(const Flown& flown, const lines::SurveyLines& found) {
  Score score;
  std::vector<int> used(found.lines.size(), 0);
  const auto& all = flown.survey->setup.lines;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const sim::LineTally& tally = flown.tallies[i];
    if (tally.points == 0) continue;
    int matches = 0;
    for (std::size_t j = 0; j < found.lines.size(); ++j) {
      const FlightLine& line = found.lines[j].line;
      if (line.last_time_s < tally.first_time_s || line.first_time_s > tally.last_time_s) continue;
      ++matches;
      ++used[j];
      const bool whole = std::abs(line.first_time_s - tally.first_time_s) < 0.5 &&
                         std::abs(line.last_time_s - tally.last_time_s) < 0.5;
      score.split_errors += !whole;
      if (whole) score_line(*flown.survey, all[i], tally, found.lines[j], score);
    }
    score.split_errors += matches == 0;
  }
  for (const int count : used) score.split_errors += count != 1;
  return score;
}

lines::SurveyLines find_lines(const std::vector<PointCloud>& tiles, int threads, double& seconds) {
  lines::SurveyOptions options;
  options.threads = threads;
  lines::SurveyLines survey;
  seconds = bench::seconds_of([&] {
    lines::BinSet bins;
    lines::SheetPairs pairs;
    for (const PointCloud& tile : tiles) {
      lines::TileBinner binner;
      lines::TileOverlap overlap(tile.origin, 10.0);
      binner.add(tile);
      overlap.add(tile);
      lines::merge_bins(bins, binner.finish("tile"), options.sample);
      lines::merge_pairs(pairs, overlap.finish());
    }
    lines::estimate_survey(std::move(bins), pairs, options, survey);
  });
  return survey;
}

/// Angles rounded, as formats 0-5 hold them; ids zeroed where asked.
std::vector<PointCloud> spoiled(std::vector<PointCloud> tiles, bool whole_degrees, bool zero_ids) {
  for (PointCloud& tile : tiles) {
    if (whole_degrees)
      for (float& angle : tile.scan_angle_deg) angle = std::round(angle);
    if (zero_ids) std::fill(tile.point_source_id.begin(), tile.point_source_id.end(), 0);
  }
  return tiles;
}

const char* product_name(sim::SurveyProduct product) {
  return product == sim::SurveyProduct::kLidarHd ? "lidarhd" : "swiss";
}

struct Totals {
  Score fine, whole;
  double best_points_per_s = 0.0;
};

void run_survey(const sim::SurveyOptions& options, const sim::Scene& scene, bool show_lines,
                const bench::Options& bench, Totals& totals, bench::Result& result) {
  const Flown flown = fly(options, scene, bench.threads);
  const std::string name = sim::scanner_name(options.scanner.pattern) + "_" +
                           product_name(options.product) + "_" + scene.name();
  for (const bool whole : {false, true}) {
    for (const bool zero : {false, true}) {
      const std::vector<PointCloud> tiles = spoiled(flown.tiles, whole, zero);
      double seconds = 0.0;
      const lines::SurveyLines found = find_lines(tiles, bench.threads, seconds);
      const Score score = score_of(flown, found);
      (whole ? totals.whole : totals.fine).add(score);
      std::size_t points = 0;
      for (const PointCloud& tile : tiles) points += tile.size();
      std::printf(
          "%-34s %-5s %-8s %3d lines, across %.4f deg, sensor %.3f m (plan %.3f, height %.3f), %d "
          "split errors, %d without path, %.2f M points, %.2f s\n",
          name.c_str(), whole ? "whole" : "fine", zero ? "no ids" : "ids", score.lines,
          score.azimuth_error_deg, score.rms_m(), score.horizontal_m(), score.vertical_m(),
          score.split_errors, score.without_path, 1e-6 * static_cast<double>(points), seconds);
      if (show_lines)
        for (const lines::LineEstimate& e : found.lines)
          std::printf("    %u: %.1f..%.1f s, %s, sigma %.2f %.2f m, angle %.4f scan %.4f %s\n",
                      e.line.id, e.line.first_time_s, e.line.last_time_s, e.method.c_str(),
                      e.position_error_m, e.height_error_m, e.angle_residual_deg,
                      e.scan_residual_deg, e.line.beam_reason.c_str());
      if (zero) continue;
      const std::string suffix = "_" + name + (whole ? "_whole" : "_fine");
      result.figure("azimuth_error_deg" + suffix, score.azimuth_error_deg);
      result.figure("sensor_rms_m" + suffix, score.rms_m());
    }
  }
}

/// Points per second after decoding, of a dense tile: the work on points and that on lines.
double points_per_second(const sim::Scene& scene, const sim::SurveyOptions& base,
                         const bench::Options& bench, double side_m, double density) {
  sim::SurveyOptions options = base;
  options.tiles = "1x1";
  options.tile_m = side_m;
  options.density = density;
  const Flown flown = fly(options, scene, bench.threads);
  std::vector<double> rates;
  for (int turn = 0; turn < 3; ++turn) {
    double seconds = 0.0;
    find_lines(flown.tiles, bench.threads, seconds);
    rates.push_back(static_cast<double>(flown.tiles[0].size()) / seconds);
  }
  return bench::median(rates);
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> scenes;
  double density = 1.0;
  bool show_lines = false;
  return bench::run(
      "flightlines", "Flight lines and sensor paths against the truth of simulated surveys", argc,
      argv,
      [&](CLI::App& app) {
        app.add_option("--scene", scenes, "scenes by name (alp valley; with --quick valley)");
        app.add_option("--density", density, "points/m2 of the surveys");
        app.add_flag("--lines", show_lines, "prints every line");
      },
      [&](const bench::Options& options, bench::Result& result) {
        if (scenes.empty())
          scenes = options.quick ? std::vector<std::string>{"valley"}
                                 : std::vector<std::string>{"alp", "valley"};
        Totals totals;
        double rate = 0.0;
        for (const std::string& name : scenes) {
          sim::SurveyOptions survey;
          survey.scene_file = std::filesystem::path(CORNICE_SCENES) / (name + ".yaml");
          survey.seed = options.seed;
          survey.tiles = "2x2";
          survey.tile_m = options.quick ? 250.0 : 500.0;
          survey.density = density;
          survey.flight.cross_line = !options.quick;
          // One scene serves both products: it stands on the corner of the first.
          const Vec3d corner = sim::default_corner(sim::SurveyProduct::kSwissSurface3d);
          survey.corner = {corner.x, corner.y};
          sim::SceneOptions scene_options;
          scene_options.file = survey.scene_file;
          scene_options.seed = options.seed;
          scene_options.extent = sim::scene_extent(sim::tile_grid(survey));
          scene_options.threads = options.threads;
          const auto scene = sim::Scene::build(scene_options);
          for (const auto pattern : {sim::ScannerPattern::kOscillating,
                                     sim::ScannerPattern::kPolygon, sim::ScannerPattern::kPalmer})
            for (const auto product :
                 {sim::SurveyProduct::kSwissSurface3d, sim::SurveyProduct::kLidarHd}) {
              survey.scanner.pattern = pattern;
              survey.product = product;
              run_survey(survey, *scene, show_lines, options, totals, result);
            }
          if (rate == 0.0)
            rate = points_per_second(*scene, survey, options, options.quick ? 200.0 : 500.0, 20.0);
        }
        result.figure("azimuth_error_deg_max",
                      std::max(totals.fine.azimuth_error_deg, totals.whole.azimuth_error_deg));
        result.figure("sensor_rms_m_fine", totals.fine.rms_m());
        result.figure("sensor_rms_m_whole", totals.whole.rms_m());
        result.figure("split_errors", totals.fine.split_errors + totals.whole.split_errors);
        result.figure("lines_without_path", totals.fine.without_path + totals.whole.without_path);
        result.figure("lines", totals.fine.lines + totals.whole.lines);
        result.figure("points_per_s", rate);
        result.parameter("density_points_per_m2", density);
        result.parameter("tiles", std::string("2x2"));
        result.parameter("tile_m", options.quick ? 250.0 : 500.0);
        std::string names;
        for (const std::string& name : scenes) names += (names.empty() ? "" : " ") + name;
        result.parameter("scenes", names);
      });
}
