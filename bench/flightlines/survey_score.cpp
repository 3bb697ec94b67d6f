// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/flightlines/survey_score.h"

#include <chrono>
#include <numbers>

#include "core/base/parallel.h"
#include "stages/simulate/survey_tiles.h"

namespace cornice::bench {
namespace {

namespace sim = cornice::simulate;
namespace lines = cornice::flightlines;

constexpr double kRadians = std::numbers::pi / 180.0;
constexpr std::uint64_t kBlockPulses = 16384;

void append(const sim::SurveyPoint& point, PointCloud& cloud) {
  cloud.positions.push_back((point.recorded() - cloud.origin).cast<float>());
  sim::append_attributes(point, cloud);
}

void fly_pass(const sim::SurveySetup& setup, std::size_t pass, int threads, FlownSurvey& flown) {
  const std::uint64_t pulses = sim::pulses_of_pass(setup, pass);
  const std::size_t count = (pulses + kBlockPulses - 1) / kBlockPulses;
  std::vector<sim::BlockPoints> blocks(count);
  parallel_for(count, 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      blocks[i] = sim::simulate_block(
          setup, {pass, i * kBlockPulses, std::min(kBlockPulses, pulses - i * kBlockPulses)});
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

/// What a line flew: the mean direction of the nose plus 90, and the course over ground.
struct TrueAzimuths {
  double across_deg = 0.0;
  double along_deg = 0.0;
};

TrueAzimuths true_azimuths(const sim::Survey& survey, const sim::SurveyLine& line,
                           const sim::LineTally& tally) {
  double east = 0.0, north = 0.0;
  for (const sim::TrajectoryPose& pose : survey.trajectory.poses()) {
    if (pose.pass != line.pass || pose.gps_time_s < tally.true_first_time_s ||
        pose.gps_time_s > tally.true_last_time_s)
      continue;
    east += std::sin(pose.heading_deg * kRadians);
    north += std::cos(pose.heading_deg * kRadians);
  }
  const auto pass = static_cast<std::size_t>(line.pass);
  const Vec3d flown = survey.trajectory.at(pass, tally.true_last_time_s).position -
                      survey.trajectory.at(pass, tally.true_first_time_s).position;
  return {std::atan2(east, north) / kRadians + 90.0, std::atan2(flown.x, flown.y) / kRadians};
}

void score_line(const sim::Survey& survey, const sim::SurveyLine& truth,
                const sim::LineTally& tally, const lines::LineEstimate& found, double shift_s,
                Score& score) {
  ++score.lines;
  score.without_path += found.line.beam_source != BeamSource::kTrajectory;
  score.sign_errors += found.line.scan_angle_sign != truth.angle_sign;
  const TrueAzimuths azimuths = true_azimuths(survey, truth, tally);
  const double error = std::remainder(found.line.across_azimuth_deg - azimuths.across_deg, 360.0);
  const double crab = azimuths.across_deg - azimuths.along_deg - 90.0;
  // Where the stage itself says that it does not know the course, there is nothing to judge.
  if (found.along_standard_error_deg < 1.0)
    score.crab_error_deg = std::max(
        score.crab_error_deg, std::abs(std::remainder(found.perpendicular_deg - crab, 360.0)));
  score.azimuth_error_deg = std::max(score.azimuth_error_deg, std::abs(error));
  LineScore each{found.line.id, error, 0.0, 0.0, found.line.nodes.size()};
  for (const TrajectoryNode& node : found.line.nodes) {
    const double time =
        std::clamp(node.gps_time_s + shift_s, tally.true_first_time_s, tally.true_last_time_s);
    // A strip that is moved as a whole takes its sensor along.
    const Vec3d d = node.position - truth.offset -
                    survey.trajectory.at(static_cast<std::size_t>(truth.pass), time).position;
    each.square_sum += dot(d, d);
    each.vertical_square_sum += d.z * d.z;
  }
  score.square_sum += each.square_sum;
  score.horizontal_sum += each.square_sum - each.vertical_square_sum;
  score.nodes += each.nodes;
  score.each.push_back(each);
}

bool is_same_channel(const sim::SurveyLine& truth, const FlightLine& line) {
  return line.scanner_channel ==
         (line.channel_in_user_data ? truth.user_data : truth.recorded_channel);
}

}  // namespace

std::size_t FlownSurvey::points() const {
  std::size_t sum = 0;
  for (const PointCloud& tile : tiles) sum += tile.size();
  return sum;
}

std::unique_ptr<sim::Scene> build_scene(const sim::SurveyOptions& options, int threads) {
  sim::SceneOptions scene;
  scene.file = options.scene_file;
  scene.seed = options.seed;
  scene.extent = sim::scene_extent(sim::tile_grid(options));
  scene.threads = threads;
  return sim::Scene::build(scene);
}

FlownSurvey fly_in_memory(const sim::SurveyOptions& options, const sim::Scene& scene, int threads) {
  FlownSurvey flown;
  flown.survey = std::make_unique<sim::Survey>(options, scene);
  const sim::SurveySetup& setup = flown.survey->setup;
  flown.tiles.resize(static_cast<std::size_t>(setup.grid.count()));
  for (int tile = 0; tile < setup.grid.count(); ++tile) {
    const Box2d box = setup.grid.tile(tile);
    PointCloud& cloud = flown.tiles[static_cast<std::size_t>(tile)];
    cloud.origin = {box.min_x, box.min_y, 0.0};
    for (const auto& point : sim::virtual_points(setup, tile)) append(point, cloud);
  }
  flown.tallies.resize(setup.lines.size());
  for (std::size_t pass = 0; pass < flown.survey->trajectory.passes().size(); ++pass)
    fly_pass(setup, pass, threads, flown);
  return flown;
}

lines::SurveyLines find_lines(const std::vector<PointCloud>& tiles, int threads, double& seconds) {
  lines::SurveyOptions options;
  options.threads = threads;
  lines::SurveyLines survey;
  const auto start = std::chrono::steady_clock::now();
  lines::BinSet bins;
  lines::SheetPairs pairs;
  for (const PointCloud& tile : tiles) {
    lines::TileReader reader(options, options.sample, tile.origin, 10.0);
    reader.add(tile);
    reader.finish("tile", bins, pairs);
  }
  lines::estimate_survey(std::move(bins), pairs, options, survey);
  seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return survey;
}

void Score::add(const Score& other) {
  azimuth_error_deg = std::max(azimuth_error_deg, other.azimuth_error_deg);
  crab_error_deg = std::max(crab_error_deg, other.crab_error_deg);
  square_sum += other.square_sum;
  horizontal_sum += other.horizontal_sum;
  nodes += other.nodes;
  split_errors += other.split_errors;
  sign_errors += other.sign_errors;
  without_path += other.without_path;
  lines += other.lines;
}

Score score_lines(const FlownSurvey& flown, const lines::SurveyLines& found) {
  Score score;
  std::vector<int> used(found.lines.size(), 0);
  const auto& all = flown.survey->setup.lines;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const sim::LineTally& tally = flown.tallies[i];
    if (tally.points == 0) continue;
    // Recorded times may be seconds of a week; a line found across its end goes on.
    const double shift_s = tally.true_first_time_s - tally.first_time_s;
    int matches = 0;
    for (std::size_t j = 0; j < found.lines.size(); ++j) {
      const FlightLine& line = found.lines[j].line;
      if (!line.has_time || line.last_time_s + shift_s < tally.true_first_time_s ||
          line.first_time_s + shift_s > tally.true_last_time_s || !is_same_channel(all[i], line))
        continue;
      // Two channels told by ids share their times.
      if (flown.survey->setup.channels > 1 && line.point_source_id != all[i].point_source_id)
        continue;
      ++matches;
      ++used[j];
      const bool is_whole = std::abs(line.first_time_s + shift_s - tally.true_first_time_s) < 0.5 &&
                            std::abs(line.last_time_s + shift_s - tally.true_last_time_s) < 0.5;
      score.split_errors += !is_whole;
      if (is_whole) score_line(*flown.survey, all[i], tally, found.lines[j], shift_s, score);
    }
    score.split_errors += matches == 0;
  }
  for (const int count : used) score.split_errors += count != 1;
  return score;
}

}  // namespace cornice::bench
