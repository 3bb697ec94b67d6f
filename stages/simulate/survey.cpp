// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/simulate/survey.h"

#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "core/base/error.h"
#include "core/base/parallel.h"

namespace cornice::simulate {
namespace {

/// Ground outside the tiles that beams near the border meet on their way, in a scene's terms.
constexpr double kSceneMarginM = 30.0;
/// Pulses of the trial flight that finds the pulse rate: 1 % of scatter at worst.
constexpr double kTrialPulses = 60000.0;
/// Mirror phase of successive trial pulses, in turns: fills the swath evenly.
constexpr double kGoldenTurn = 0.6180339887498949;
constexpr std::uint64_t kBlockPulses = 16384;
constexpr int kGroundSamples = 128;
/// Lines are numbered in 16 bits, in files and truth.
constexpr std::size_t kMostLines = 900;

GroundRange ground_range(const Scene& scene, const Box2d& extent) {
  GroundRange range{std::numeric_limits<double>::infinity(), 0.0,
                    -std::numeric_limits<double>::infinity()};
  double sum = 0.0;
  int count = 0;
  for (int row = 0; row < kGroundSamples; ++row) {
    for (int col = 0; col < kGroundSamples; ++col) {
      const double height =
          scene.ground_height(extent.min_x + (col + 0.5) * extent.width() / kGroundSamples,
                              extent.min_y + (row + 0.5) * extent.height() / kGroundSamples);
      if (!std::isfinite(height)) continue;
      range.lowest_m = std::min(range.lowest_m, height);
      range.highest_m = std::max(range.highest_m, height);
      sum += height;
      ++count;
    }
  }
  if (count == 0) throw InputError(scene.name(), "has no ground under the tiles");
  range.mean_m = sum / count;
  return range;
}

/// Start of the flight; with a week's end in the middle of the first pass where that is asked for.
Trajectory plan_flight(const SurveyOptions& options, const DefectOptions& defects,
                       const Box2d& extent, const GroundRange& ground) {
  FlightOptions flight = options.flight;
  flight.overlap = 0.01 * options.overlap_percent;
  flight.start_time_s = start_time_s(options.year);
  flight.survey_break_s = defects.two_surveys ? kSurveyBreakS : 0.0;
  Trajectory trajectory = Trajectory::plan(flight, options.scanner, extent, ground, options.seed);
  if (!defects.week_rollover) return trajectory;
  const Pass& first = trajectory.passes().front();
  const double half = 0.5 * (first.last_time_s - first.first_time_s);
  const double to_week_end = kWeekS - recorded_time(defects, flight.start_time_s);
  flight.start_time_s += to_week_end - half;
  return Trajectory::plan(flight, options.scanner, extent, ground, options.seed);
}

/// Points per pulse rate, from a thin flight with the mirror at evenly spread phases.
double points_per_hertz(const SurveySetup& survey, const ScannerOptions& options) {
  const Scanner scanner(options, kGoldenTurn);
  SurveySetup trial = survey;
  trial.scanner = &scanner;
  trial.defects = DefectOptions{};
  for (SurveyLine& line : trial.lines) line.offset = {};
  trial.pulse_rate = kTrialPulses / survey.trajectory->measuring_s();
  double points = 0.0;
  for (std::size_t pass = 0; pass < survey.trajectory->passes().size(); ++pass)
    points += static_cast<double>(
        simulate_block(trial, {pass, 0, pulses_of_pass(trial, pass)}).points.size());
  if (points == 0.0)
    throw UsageError("--height", "no beam meets the ground within the tiles; fly higher");
  return points / trial.pulse_rate;
}

SurveySetup base_setup(const SurveyOptions& options, const Scene& scene,
                       const Trajectory& trajectory, const DefectOptions& defects) {
  SurveySetup setup;
  setup.scene = &scene;
  setup.heights = scene.height_bounds();
  setup.trajectory = &trajectory;
  setup.channels = options.scanner.channels;
  setup.lines =
      survey_lines(trajectory, setup.channels, options.channel_tag, defects, options.seed);
  setup.defects = defects;
  setup.noise = {options.noise_m, options.flight.height_m};
  setup.product = options.product;
  setup.most_returns = most_returns(options.product, options.container);
  setup.grid = tile_grid(options);
  setup.seed = options.seed;
  return setup;
}

/// Mirror lines per pulse that give points as far apart along the track as across it.
double scans_per_pulse(const SurveyOptions& options, const Survey& survey, double pulse_rate) {
  const double speed = options.flight.speed_ms;
  double density = pulse_rate / (speed * survey.trajectory.swath_m(survey.ground.mean_m));
  // Each turn of a cone draws two arcs, one ahead and one behind.
  if (options.scanner.pattern == ScannerPattern::kPalmer) density *= 0.5;
  return speed * std::sqrt(density) / pulse_rate;
}

TileTarget target_of(const Survey& survey, const std::filesystem::path& folder, int tile,
                     int threads) {
  const SurveyOptions& options = survey.options;
  const SurveySetup& setup = survey.setup;
  const std::string name = tile_name(options.product, options.container, setup.grid, tile,
                                     options.year, setup.scene->name());
  TileTarget target;
  target.path = folder / name;
  target.truth = options.truth;
  if (options.truth == PointTruth::kPly)
    target.truth_path = folder / "truth" / (name + ".points.ply");
  target.box = setup.grid.tile(tile);
  target.origin = {target.box.min_x, target.box.min_y, std::floor(survey.ground.lowest_m)};
  target.crs_text = crs_text(options.product);
  target.las = write_options(options.product, options.container, target.box, options.year);
  if (setup.defects.lost_time_bit || setup.defects.week_rollover)
    target.las.gps_time_type = GpsTimeType::kWeekSeconds;
  if (setup.defects.horizontal_crs && !target.las.crs.empty())
    target.las.crs = crs_from_text("EPSG:" + std::to_string(target.las.crs.horizontal_epsg));
  target.las.threads = threads;
  target.is_zipped = options.container == TileContainer::kZippedLas;
  target.is_copc = options.container == TileContainer::kCopc;
  target.is_unordered = setup.defects.unordered;
  target.seed = options.seed;
  return target;
}

/// Points sorted into tiles, keeping their order, and made ready to write.
std::vector<TilePart> parts_of(const TileGrid& grid, const std::vector<TileTarget>& targets,
                               std::vector<SurveyPoint> points) {
  std::vector<TilePart> parts;
  if (grid.count() == 1) {
    if (!points.empty()) parts.push_back(make_part(targets[0], 0, std::move(points)));
    return parts;
  }
  std::vector<std::vector<SurveyPoint>> sorted(static_cast<std::size_t>(grid.count()));
  for (const SurveyPoint& point : points)
    sorted[static_cast<std::size_t>(*grid.find(point.at.x, point.at.y))].push_back(point);
  for (std::size_t tile = 0; tile < sorted.size(); ++tile)
    if (!sorted[tile].empty())
      parts.push_back(make_part(targets[tile], tile, std::move(sorted[tile])));
  return parts;
}

struct BlockResult {
  PulseBlock block;
  std::vector<LineTally> tallies;
  std::vector<TilePart> parts;
};

/// The blocks of all passes, in order.
class BlockSource {
 public:
  explicit BlockSource(const SurveySetup& setup) : setup_(setup) {}
  /// Count 0 where none is left.
  PulseBlock next() {
    while (pass_ < setup_.trajectory->passes().size()) {
      const std::uint64_t pulses = pulses_of_pass(setup_, pass_);
      if (next_ < pulses) {
        const PulseBlock block{pass_, next_, std::min(kBlockPulses, pulses - next_)};
        next_ += block.count;
        return block;
      }
      ++pass_;
      next_ = 0;
    }
    return {};
  }

 private:
  const SurveySetup& setup_;
  std::size_t pass_ = 0;
  std::uint64_t next_ = 0;
};

}  // namespace

Box2d scene_extent(const TileGrid& grid) { return grid.extent().grown(kSceneMarginM); }

Survey::Survey(const SurveyOptions& survey_options, const Scene& scene)
    : options(survey_options),
      ground(ground_range(scene, tile_grid(options).extent())),
      trajectory(plan_flight(options, parse_defects(options.product, options.defects),
                             tile_grid(options).extent(), ground)),
      scanner(options.scanner, kGoldenTurn),
      setup(
          base_setup(options, scene, trajectory, parse_defects(options.product, options.defects))) {
  if (setup.lines.size() > kMostLines)
    throw UsageError("--height", "the survey needs " + std::to_string(setup.lines.size()) +
                                     " lines, " + std::to_string(kMostLines) +
                                     " are possible; fly higher or survey fewer tiles");
  const Box2d extent = setup.grid.extent();
  const double wanted = options.density * extent.width() * extent.height();
  setup.pulse_rate = wanted / points_per_hertz(setup, options.scanner);
  scanner = Scanner(options.scanner, scans_per_pulse(options, *this, setup.pulse_rate));
  setup.scanner = &scanner;
}

SurveyResult fly_survey(const Survey& survey, const std::filesystem::path& folder, int threads,
                        MemoryBudget& memory, Progress& progress) {
  const SurveySetup& setup = survey.setup;
  SurveyResult result;
  result.tallies.resize(setup.lines.size());
  result.points_of_tile.resize(static_cast<std::size_t>(setup.grid.count()));
  std::vector<TileTarget> targets;
  std::vector<std::unique_ptr<TileWriter>> writers;
  for (int tile = 0; tile < setup.grid.count(); ++tile) {
    targets.push_back(target_of(survey, folder, tile, threads));
    writers.push_back(std::make_unique<TileWriter>(targets.back()));
  }
  for (std::size_t pass = 0; pass < survey.trajectory.passes().size(); ++pass)
    result.pulses += pulses_of_pass(setup, pass);
  progress.begin("fly and write tiles", result.pulses);
  BlockSource source(setup);
  const auto draw = [&](tbb::flow_control& control) {
    check_cancelled(progress);
    const PulseBlock block = source.next();
    if (block.count == 0) control.stop();
    return block;
  };
  const auto simulate = [&](PulseBlock block) {
    BlockPoints points = simulate_block(setup, block);
    return std::make_shared<BlockResult>(BlockResult{
        block, std::move(points.tallies), parts_of(setup.grid, targets, std::move(points.points))});
  };
  const auto write_points = [&](std::shared_ptr<BlockResult> done) {
    for (std::size_t channel = 0; channel < done->tallies.size(); ++channel)
      result.tallies[done->block.pass * done->tallies.size() + channel].add(done->tallies[channel]);
    for (const TilePart& part : done->parts) {
      writers[part.tile]->write_points(part);
      result.points_of_tile[part.tile] += part.size();
    }
    return done;
  };
  const auto write_truth = [&](const std::shared_ptr<BlockResult>& done) {
    for (const TilePart& part : done->parts) writers[part.tile]->write_truth(part);
    progress.advance(done->block.count);
  };
  // A pipeline holds few blocks at a time, and its writers work while others simulate. shared_ptr
  // because its stages copy what they hand on.
  tbb::task_arena arena(thread_count(threads));
  arena.execute([&] {
    using Done = std::shared_ptr<BlockResult>;
    tbb::parallel_pipeline(
        static_cast<std::size_t>(2 * thread_count(threads) + 2),
        tbb::make_filter<void, PulseBlock>(tbb::filter_mode::serial_in_order, draw) &
            tbb::make_filter<PulseBlock, Done>(tbb::filter_mode::parallel, simulate) &
            tbb::make_filter<Done, Done>(tbb::filter_mode::serial_in_order, write_points) &
            tbb::make_filter<Done, void>(tbb::filter_mode::serial_in_order, write_truth));
  });
  for (std::size_t tile = 0; tile < writers.size(); ++tile) {
    std::vector<SurveyPoint> extra = virtual_points(setup, static_cast<int>(tile));
    result.virtual_points += extra.size();
    const TilePart part = make_part(targets[tile], tile, std::move(extra));
    writers[tile]->write_points(part);
    writers[tile]->write_truth(part);
    result.points_of_tile[tile] += part.size();
  }
  progress.end();
  progress.begin("finish tiles", writers.size());
  for (std::size_t tile = 0; tile < writers.size(); ++tile) {
    check_cancelled(progress);
    writers[tile]->close(memory, no_progress());
    writers[tile].reset();
    progress.advance(1);
    result.points += result.points_of_tile[tile];
    result.files.push_back(targets[tile].path.lexically_relative(folder));
    if (!targets[tile].truth_path.empty())
      result.files.push_back(targets[tile].truth_path.lexically_relative(folder));
  }
  progress.end();
  return result;
}

}  // namespace cornice::simulate
