// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/flightlines/survey_lines.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/base/error.h"
#include "core/base/input_file.h"
#include "core/base/parallel.h"
#include "core/io/las.h"

namespace cornice::flightlines {
namespace {

constexpr std::size_t kChunkPoints = 250'000;
/// Share of the memory that samples of pulses may take.
constexpr double kSampleShare = 0.25;
constexpr std::size_t kLeastSample = 8;  ///< pulses a bin; below it paths get worse than useless

constexpr Attribute kNeeded = Attribute::kGpsTime | Attribute::kScanAngle | Attribute::kReturns |
                              Attribute::kClassification | Attribute::kFlags |
                              Attribute::kPointSource | Attribute::kChannel | Attribute::kUserData;

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Metres per unit of plan and height; 1 where there is no CRS.
struct Units {
  double plan = 1.0;
  double up = 1.0;
};

Units units_of(const Crs& crs, const std::string& file) {
  if (crs.empty()) return {};
  if (!(crs.metres_per_unit > 0.0))
    throw InputError(file, "is in degrees (" + crs.name +
                               "); flight lines need a projected CRS: reproject it first");
  return {crs.metres_per_unit,
          crs.vertical_metres_per_unit > 0.0 ? crs.vertical_metres_per_unit : 1.0};
}

/// Reads one tile into bins and sheet pairs.
TileCounts read_tile(const LasInfo& info, const Units& units, const SurveyOptions& options,
                     const SampleSize& sample, BinSet& bins, SheetPairs& pairs, SurveyLines& survey,
                     Progress& progress) {
  const double area = std::max(
      1.0, info.bounds.plan().width() * info.bounds.plan().height() * units.plan * units.plan);
  TileReader tile(options, sample,
                  {info.bounds.min.x * units.plan, info.bounds.min.y * units.plan,
                   info.bounds.min.z * units.up},
                  static_cast<double>(info.point_count) / area);
  LasReadOptions read;
  read.attributes = kNeeded;
  read.threads = options.threads;
  read.keep_readable_part = options.keep_readable;
  const LasReadResult result = stream_las(
      info, read, kChunkPoints,
      [&](PointCloud& chunk, std::uint64_t) {
        const auto start = Clock::now();
        tile.add(chunk, units.plan, units.up);
        survey.binning_s += seconds_since(start);
      },
      progress);
  const auto start = Clock::now();
  TileCounts counts = tile.finish(info.path.string(), bins, pairs);
  counts.file = info.path;
  counts.problem = result.problem;
  survey.binning_s += seconds_since(start);
  return counts;
}

/// Fewer pulses a bin until the samples fit.
void fit_memory(BinSet& bins, SampleSize& sample, const MemoryBudget& memory, SurveyLines& survey) {
  const auto limit =
      static_cast<std::size_t>(kSampleShare * static_cast<double>(memory.limit_bytes()));
  while (memory_bytes(bins) > limit && sample.any > kLeastSample) {
    sample.any /= 2;
    sample.multiple = std::max(kLeastSample / 2, sample.multiple / 2);
    thin_bins(bins, sample);
    ++survey.sample_halvings;
  }
}

/// Nodes in the units of the CRS, as every file of the survey has them.
void to_crs_units(const Units& units, SurveyLines& survey) {
  for (LineEstimate& estimate : survey.lines)
    for (TrajectoryNode& node : estimate.line.nodes)
      node.position = {node.position.x / units.plan, node.position.y / units.plan,
                       node.position.z / units.up};
}

}  // namespace

TileReader::TileReader(const SurveyOptions& options, const SampleSize& sample, Vec3d corner,
                       double points_per_m2)
    : sample_(sample),
      overlaps_(options.overlaps),
      threads_(options.threads),
      binner_(sample),
      overlap_(corner, points_per_m2) {}

void TileReader::add(const PointCloud& points, double metres, double metres_up) {
  parallel_for(overlaps_ ? 2 : 1, 1, threads_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t part = begin; part < end; ++part) {
      if (part == 0)
        binner_.add(points, metres, metres_up);
      else
        overlap_.add(points, metres, metres_up);
    }
  });
}

TileCounts TileReader::finish(const std::string& file, BinSet& bins, SheetPairs& pairs) {
  BinSet part = binner_.finish(file);
  TileCounts counts{file, part.points, part.valid_points, part.invalid, {}};
  merge_bins(bins, std::move(part), sample_);
  if (overlaps_) merge_pairs(pairs, overlap_.finish());
  return counts;
}

FlightLines SurveyLines::flight_lines() const {
  FlightLines result;
  result.crs_text = crs.text();
  for (const LineEstimate& estimate : lines) result.lines.push_back(estimate.line);
  return result;
}

void estimate_survey(BinSet&& bins, const SheetPairs& pairs, const SurveyOptions& options,
                     SurveyLines& survey, Progress& progress) {
  const auto start = Clock::now();
  BinSet set = std::move(bins);
  survey.channel_in_user_data = settle_user_data(set, options.sample);
  const SplitResult split = split_lines(set, options.split);
  survey.split = split.counts;
  survey.invalid = set.invalid;
  survey.points = set.points;
  survey.valid_points = set.valid_points;
  survey.lines.resize(split.passes.size());
  progress.begin("estimating lines", split.passes.size());
  const auto estimate_one = [&](std::size_t i, const TrajectoryOptions& trajectory) {
    LineEstimate estimate = estimate_line(split.passes[i], trajectory, options.accept);
    estimate.line.id = static_cast<std::uint32_t>(i + 1);
    if (survey.channel_in_user_data) {
      estimate.line.channel_in_user_data = true;
      estimate.line.scanner_channel = split.passes[i].key.user_data;
    }
    return estimate;
  };
  parallel_for(split.passes.size(), 1, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end && !progress.cancelled(); ++i) {
      survey.lines[i] = estimate_one(i, options.trajectory);
      progress.advance(1);
    }
  });
  progress.end();
  // A clip of a swath knows the cone of its scanner badly; the other lines know it well.
  const SharedCone cone = shared_cone(survey.lines);
  TrajectoryOptions with_cone = options.trajectory;
  with_cone.cone_deg = cone.cone_deg;
  with_cone.cone_sigma_deg = cone.sigma_deg;
  parallel_for(split.passes.size(), 1, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end && !progress.cancelled(); ++i) {
      if (!needs_cone(survey.lines[i], cone)) continue;
      LineEstimate again = estimate_one(i, with_cone);
      if (again.scan_model != ScanModel::kCone || again.line.beam_source != BeamSource::kTrajectory)
        continue;
      again.remarks.push_back("takes the scanner's cone from the lines that know it well");
      survey.lines[i] = std::move(again);
    }
  });
  survey.signs_settled = settle_unknown_signs(survey.lines);
  std::uint64_t conflicting = 0;
  for (const PulseBin& bin : set.bins)
    for (const Pulse& pulse : bin.any) conflicting += pulse.conflicting;
  survey.invalid[static_cast<std::size_t>(Invalid::kDuplicateReturn)] += conflicting;
  survey.overlaps = overlaps_of_lines(pairs, survey.flight_lines());
  survey.estimate_s += seconds_since(start);
}

namespace {

/// By whatever name: "tile.laz", "./tile.laz", a link.
void refuse_what_is_named_twice(const std::vector<std::filesystem::path>& files) {
  std::vector<std::filesystem::path> named;
  for (const auto& file : files) {
    std::error_code ignored;
    const auto canonical = std::filesystem::weakly_canonical(file, ignored);
    named.push_back(canonical.empty() ? file : canonical);
  }
  std::sort(named.begin(), named.end());
  if (const auto twice = std::adjacent_find(named.begin(), named.end()); twice != named.end())
    throw UsageError("TILES", twice->string() + " is named twice");
}

}  // namespace

SurveyLines find_survey_lines(const std::vector<std::filesystem::path>& files,
                              const SurveyOptions& options, MemoryBudget& memory,
                              Progress& progress) {
  // Sorted, so that the order on the command line changes no rounding.
  std::vector<std::filesystem::path> sorted = files;
  std::sort(sorted.begin(), sorted.end());
  SurveyLines survey;
  refuse_what_is_named_twice(sorted);
  std::vector<LasInfo> infos;
  for (const auto& file : sorted) {
    check_utf8_name(file);
    infos.push_back(read_las_info(file, {.crs_override = options.crs}));
    if (!same_crs(infos.front().crs, infos.back().crs))
      throw InputError(file.string(), "has another CRS (" + infos.back().crs.text() + ") than " +
                                          sorted.front().string() + " (" +
                                          infos.front().crs.text() +
                                          "); process surveys of one CRS, or give --crs");
  }
  BinSet bins;
  SheetPairs pairs;
  SampleSize sample = options.sample;
  if (!infos.empty()) survey.crs = infos.front().crs;
  if (survey.crs.empty() && !infos.empty())
    survey.warnings.push_back(
        "the tiles have no CRS: coordinates are taken as metres, and no true "
        "north is given");
  for (const LasInfo& info : infos) {
    const Units units = units_of(info.crs, info.path.string());
    survey.tiles.push_back(read_tile(info, units, options, sample, bins, pairs, survey, progress));
    if (!survey.tiles.back().problem.empty())
      survey.warnings.push_back(info.path.string() + ": " + survey.tiles.back().problem);
    fit_memory(bins, sample, memory, survey);
  }
  SurveyOptions thinned = options;
  thinned.sample = sample;
  estimate_survey(std::move(bins), pairs, thinned, survey, progress);
  if (!infos.empty()) to_crs_units(units_of(survey.crs, sorted.front().string()), survey);
  return survey;
}

}  // namespace cornice::flightlines
