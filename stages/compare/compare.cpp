// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/compare/compare.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "core/base/error.h"
#include "stages/compare/refine.h"
#include "stages/compare/sampling.h"

namespace cornice::compare {
namespace {

/// Seed of the samples, by side.
constexpr std::uint64_t kSeed = 0xc0111;
constexpr double kFeetPerMetre = 3.280839895;
/// Heights whose ratio is as near to feet by metres as this are taken for feet.
constexpr double kFeetTolerance = 0.01;
/// Two surfaces this far apart everywhere have two zeros of height, whatever their files say.
constexpr double kDatumSuspicionM = 15.0;
constexpr double kMostPixels = 1e8;
/// Edges of what is shown are at most so many spacings of samples long.
constexpr double kShownEdgeSpacings = 4.0;

Box2d common_part(const Box2d& part, const Box2d& common) {
  return {std::max(part.min_x, common.min_x), std::max(part.min_y, common.min_y),
          std::min(part.max_x, common.max_x), std::min(part.max_y, common.max_y)};
}

void add_measured(const std::vector<Measured>& measured, float sign, Statistics& statistics) {
  for (const Measured& m : measured) {
    if (std::isnan(m.distance_m)) {
      statistics.add_missing(m.place);
    } else {
      statistics.add(m.place, static_cast<double>(sign * m.distance_m));
    }
  }
}

class Comparison {
 public:
  Comparison(Source& a, Source& b, const Options& options, const std::vector<ProfileLine>& lines,
             const std::function<void(const MeasuredPart&)>& show, Progress& progress)
      : sources_{&a, &b},
        options_(options),
        show_(show),
        progress_(progress),
        finders_{OverhangFinder(options.overhang_deg), OverhangFinder(options.overhang_deg)},
        result_{.common = {},
                .sides = {},
                .difference = {},
                .gaps = {},
                .vertical = Statistics(options.max_distance_m, options.tolerances_m),
                .directions = {},
                .m3c2 = {},
                .versions = {},
                .profiles = {},
                .relief = {},
                .warnings = {}} {
    for (const Side side : kSides) {
      SideResult& s = result_.sides[index_of(side)];
      s.facts = source(side).facts();
      for (const std::string& warning : s.facts.warnings) result_.warnings.push_back(warning);
    }
    result_.common = check_pair(a.facts(), b.facts(), result_.warnings);
    for (const ProfileLine& line : lines) {
      if (!line.box().intersects(result_.common)) {
        throw UsageError("--profile", "lies outside the common ground");
      }
      result_.profiles.push_back({line, {}, {}});
    }
  }

  Result run() {
    grid_pass();
    distance_pass();
    if (clouds() == 2) m3c2_pass();
    return std::move(result_);
  }

 private:
  Source& source(Side side) { return *sources_[index_of(side)]; }
  bool is_cloud(Side side) const {
    return result_.sides[index_of(side)].facts.kind == Kind::kCloud;
  }
  int clouds() const { return is_cloud(Side::kA) + is_cloud(Side::kB); }

  GridFrame choose_frame() const;
  void grid_pass();
  void add_to_grid(Side side, HeightGrid& grid);
  void check_heights(const HeightGrid& a, const HeightGrid& b);
  void vertical_statistics(const HeightGrid& a, const HeightGrid& b);
  void distance_pass();
  void measure_part(Side side, std::size_t part, Direction& direction);
  void m3c2_pass();

  std::array<Source*, 2> sources_;
  const Options& options_;
  const std::function<void(const MeasuredPart&)>& show_;
  Progress& progress_;
  std::array<OverhangFinder, 2> finders_;
  Result result_;
};

GridFrame Comparison::choose_frame() const {
  const SourceFacts& a = result_.sides[0].facts;
  const SourceFacts& b = result_.sides[1].facts;
  const SourceFacts& dem = a.kind == Kind::kDem ? a : b;
  double step = options_.step_m;
  if (step <= 0.0) {
    step = dem.kind == Kind::kDem ? dem.step_m : clouds() > 0 ? 1.0 : 0.5;
    while (result_.common.width() / step * (result_.common.height() / step) > kMostPixels) {
      step *= 2.0;
    }
  }
  // On a DEM's own grid its heights come through as they are: its centres are half a pixel in.
  const bool on_dem = dem.kind == Kind::kDem && step == dem.step_m;
  const double west = on_dem ? dem.box.min_x - 0.5 * step : 0.0;
  const double north = on_dem ? dem.box.max_y + 0.5 * step : 0.0;
  return frame_over(result_.common, step, west, north);
}

void Comparison::add_to_grid(Side side, HeightGrid& grid) {
  SideResult& s = result_.sides[index_of(side)];
  const std::vector<Part>& parts = source(side).parts();
  for (std::size_t i = 0; i < parts.size(); ++i) {
    check_cancelled(progress_);
    progress_.advance(1);
    if (!parts[i].box.intersects(result_.common)) continue;
    const std::shared_ptr<const Surface> surface = source(side).part(i);
    grid.add(*surface);
    for (const Triangle& t : surface->triangles) {
      const Vec3f a = surface->positions[t[0]];
      s.area_m2 += 0.5 * static_cast<double>(norm(
                             cross(surface->positions[t[1]] - a, surface->positions[t[2]] - a)));
    }
    if (is_cloud(side)) {
      s.points_used += surface->positions.size();
    } else {
      finders_[index_of(side)].add(i, *surface);
    }
    for (Profile& profile : result_.profiles) {
      if (!profile.line.box().intersects(parts[i].box)) continue;
      cut_profile(*surface, index_of(side), 0.5 * grid.frame().step, profile);
    }
  }
  grid.finish();
  if (grid.filled() == 0) {
    throw InputError(s.facts.title, "has no height on the ground that both have in common");
  }
  s.overhangs = finders_[index_of(side)].finish(options_.min_overhang_m2);
  for (const Overhang& overhang : s.overhangs) s.overhang_m2 += overhang.area_m2;
}

/// Feet for metres, and two zeros of height.
void Comparison::check_heights(const HeightGrid& a, const HeightGrid& b) {
  std::vector<double> ratios, offsets;
  for (std::size_t i = 0; i < a.frame().pixels(); ++i) {
    const auto za = static_cast<double>(a.top(i)), zb = static_cast<double>(b.top(i));
    if (std::isnan(za + zb)) continue;
    offsets.push_back(zb - za);
    if (std::abs(za) > 10.0) ratios.push_back(zb / za);
    const bool first = offsets.size() == 1;
    result_.highest_m = first ? std::max(za, zb) : std::max({result_.highest_m, za, zb});
    result_.lowest_m = first ? std::min(za, zb) : std::min({result_.lowest_m, za, zb});
  }
  if (offsets.empty()) {
    throw InputError(result_.sides[1].facts.title,
                     "has heights nowhere where " + result_.sides[0].facts.title + " has some");
  }
  const auto middle = [](std::vector<double>& values) {
    const auto half = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), half, values.end());
    return *half;
  };
  const double offset = middle(offsets);
  if (!ratios.empty() && std::abs(offset) > kDatumSuspicionM) {
    const double ratio = middle(ratios);
    for (const Side side : kSides) {
      const double feet = side == Side::kB ? ratio / kFeetPerMetre : 1.0 / (ratio * kFeetPerMetre);
      if (std::abs(feet - 1.0) > kFeetTolerance) continue;
      throw InputError(result_.sides[index_of(side)].facts.title,
                       "has heights in feet: they are " + std::to_string(kFeetPerMetre) +
                           " times those of the other; convert them to metres first");
    }
  }
  for (double& o : offsets) o = std::abs(o - offset);
  const double spread = middle(offsets);
  if (std::abs(offset) > kDatumSuspicionM && spread < 0.1 * std::abs(offset)) {
    char text[160];
    std::snprintf(text, sizeof text,
                  "B lies %.1f m from A nearly everywhere: their heights seem to count from two "
                  "zeros (geoid and ellipsoid?)",
                  offset);
    result_.warnings.push_back(text);
  }
}

void Comparison::vertical_statistics(const HeightGrid& a, const HeightGrid& b) {
  const HeightGrid& shape = is_cloud(Side::kA) && !is_cloud(Side::kB) ? b : a;
  const auto gap = static_cast<float>(options_.min_layer_gap_m);
  const double pixel_m2 = a.frame().step * a.frame().step;
  for (std::size_t i = 0; i < a.frame().pixels(); ++i) {
    const bool layered_a = a.gap(i) > gap, layered_b = b.gap(i) > gap;
    if (layered_a) result_.sides[0].layered_m2 += pixel_m2;
    if (layered_b) result_.sides[1].layered_m2 += pixel_m2;
    const float value = b.top(i) - a.top(i);
    if (std::isnan(a.top(i)) && std::isnan(b.top(i))) continue;
    const Place place = place_on_grid(shape, i, layered_a || layered_b);
    if (std::isnan(value)) {
      result_.vertical.add_missing(place);
    } else {
      result_.vertical.add(place, static_cast<double>(value));
    }
  }
}

/// The colours' end: 1, 2 or 5 times a power of ten that nineteen of twenty differences are within,
/// 0.1 m at least.
double nice_range(const Distribution& values) {
  const double largest =
      std::max(std::abs(values.quantile(0.025)), std::abs(values.quantile(0.975)));
  double range = 0.1;
  for (int step = 0; range < largest && range < 1000.0; ++step) {
    range *= step % 3 == 1 ? 2.5 : 2.0;
  }
  return range;
}

void Comparison::grid_pass() {
  const GridFrame frame = choose_frame();
  progress_.begin("heights", source(Side::kA).parts().size() + source(Side::kB).parts().size());
  HeightGrid a(frame), b(frame);
  add_to_grid(Side::kA, a);
  add_to_grid(Side::kB, b);
  progress_.end();
  check_heights(a, b);
  vertical_statistics(a, b);
  const SourceFacts& with_crs = result_.sides[result_.sides[0].facts.crs.empty() ? 1 : 0].facts;
  result_.difference = difference(a, b, with_crs.crs);
  result_.relief = heights_of(is_cloud(Side::kB) && !is_cloud(Side::kA) ? a : b, with_crs.crs);
  if (result_.sides[0].layered_m2 > 0.0) result_.gaps[0] = layer_gaps(a, with_crs.crs);
  if (result_.sides[1].layered_m2 > 0.0) result_.gaps[1] = layer_gaps(b, with_crs.crs);
  result_.colour_range_m =
      options_.colour_range_m > 0.0 ? options_.colour_range_m : nice_range(result_.vertical.all());
}

/// A part of `from` in the common box, and what it is measured against.
struct PartAndTarget {
  PartAndTarget(Source& from, std::size_t part, Source& to, const Box2d& in, const Options& options)
      : box(in),
        surface(from.part(part)),
        target(to.region(in.grown(options.max_distance_m), surface->origin)),
        covered(to.coverage(in)),
        field(target, options.threads) {}

  bool wanted(double x, double y) const {
    return box.contains(x, y) && std::any_of(covered.begin(), covered.end(),
                                             [&](const Box2d& b) { return b.contains(x, y); });
  }

  Box2d box;
  std::shared_ptr<const Surface> surface;
  Surface target;
  std::vector<Box2d> covered;
  DistanceField field;
};

void Comparison::measure_part(Side side, std::size_t part, Direction& direction) {
  const Side other = side == Side::kA ? Side::kB : Side::kA;
  const Part& own = source(side).parts()[part];
  const Box2d box = common_part(own.box, result_.common);
  if (box.empty()) return;
  const PartAndTarget pair(source(side), part, source(other), box, options_);
  const auto wanted = [&](double x, double y) { return pair.wanted(x, y); };
  const std::vector<std::uint8_t> overhang =
      finders_[index_of(side)].triangles_of(part, pair.surface->triangles.size());
  const auto start = std::chrono::steady_clock::now();
  const std::vector<Measured> measured =
      measure_samples(*pair.surface, pair.field, overhang, options_.spacing_m,
                      options_.max_distance_m, kSeed + part, wanted, options_.threads);
  direction.seconds +=
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  direction.measured += measured.size();
  // Positive where B lies outside A: what lies outside B, seen from A, is inside.
  const float sign = side == Side::kA && direction.has_sign ? -1.0f : 1.0f;
  add_measured(measured, sign, direction.statistics);
  Surface shown = *pair.surface;
  std::vector<std::uint8_t> marks = overhang;
  refine_long_edges(shown, marks, static_cast<float>(kShownEdgeSpacings * options_.spacing_m));
  std::vector<float> distances =
      measure_vertices(shown, pair.field, options_.max_distance_m, wanted, options_.threads);
  for (float& d : distances) d *= sign;
  show_({side, own.name, shown, distances, marks, result_});
}

void Comparison::distance_pass() {
  progress_.begin("distances", source(Side::kA).parts().size() + source(Side::kB).parts().size());
  for (const Side side : kSides) {
    const Side other = side == Side::kA ? Side::kB : Side::kA;
    Direction direction{.from = side,
                        .has_sign = !is_cloud(other),
                        .by_place = clouds() < 2,
                        .measured = 0,
                        .seconds = 0.0,
                        .statistics = Statistics(options_.max_distance_m, options_.tolerances_m)};
    for (std::size_t i = 0; i < source(side).parts().size(); ++i) {
      check_cancelled(progress_);
      measure_part(side, i, direction);
      progress_.advance(1);
    }
    result_.directions.push_back(std::move(direction));
  }
  const SourceFacts& a = result_.sides[0].facts;
  result_.versions.push_back(
      {a.title, a.triangles, a.file_bytes, result_.directions[1].statistics.all().summary()});
  progress_.end();
}

void Comparison::m3c2_pass() {
  result_.m3c2.emplace(M3c2Result{Statistics(options_.max_distance_m, options_.tolerances_m)});
  M3c2Result& total = *result_.m3c2;
  const std::vector<Part>& parts = source(Side::kA).parts();
  progress_.begin("M3C2", parts.size());
  double detection = 0.0;
  for (const Part& part : parts) {
    check_cancelled(progress_);
    progress_.advance(1);
    const Box2d box = common_part(part.box, result_.common);
    if (box.empty()) continue;
    const Box2d wide = box.grown(m3c2_halo_m(options_.m3c2));
    const Vec3d origin{std::floor(box.min_x), std::floor(box.min_y), std::floor(result_.highest_m)};
    const Surface a = source(Side::kA).region(wide, origin),
                  b = source(Side::kB).region(wide, origin);
    for (const M3c2Point& point : m3c2_points(a, b, box, options_.m3c2, options_.threads)) {
      ++total.core_points;
      const Place place = place_of(point.normal, 0.0f, point.normal.z < 0.0f);
      if (std::isnan(point.distance_m)) {
        total.statistics.add_missing(place);
        continue;
      }
      total.statistics.add(place, static_cast<double>(point.distance_m));
      ++total.measured;
      if (point.is_significant()) ++total.significant;
      detection += static_cast<double>(point.detection_95_m);
    }
  }
  if (total.measured > 0)
    total.mean_detection_95_m = detection / static_cast<double>(total.measured);
  progress_.end();
}

}  // namespace

Result compare(Source& a, Source& b, const Options& options, const std::vector<ProfileLine>& lines,
               const std::function<void(const MeasuredPart&)>& show, Progress& progress) {
  return Comparison(a, b, options, lines, show, progress).run();
}

Version measure_version(Source& version, Source& b, const Result& result, const Options& options,
                        Progress& progress) {
  const SourceFacts& facts = version.facts();
  std::vector<std::string> warnings;
  check_pair(facts, b.facts(), warnings);
  if (facts.kind == Kind::kCloud) throw InputError(facts.title, "is a point cloud, not a surface");
  Statistics statistics(options.max_distance_m, options.tolerances_m);
  for (std::size_t part = 0; part < b.parts().size(); ++part) {
    check_cancelled(progress);
    const Box2d box = common_part(b.parts()[part].box, result.common);
    if (box.empty()) continue;
    const PartAndTarget pair(b, part, version, box, options);
    add_measured(
        measure_samples(
            *pair.surface, pair.field, {}, options.spacing_m, options.max_distance_m, kSeed + part,
            [&](double x, double y) { return pair.wanted(x, y); }, options.threads),
        1.0f, statistics);
  }
  return {facts.title, facts.triangles, facts.file_bytes, statistics.all().summary()};
}

std::optional<double> triangles_for_error_of_a(const Result& result) {
  if (result.versions.empty()) return std::nullopt;
  const double wanted = result.versions.front().distances.rms;
  const Version* better = nullptr;
  const Version* worse = nullptr;
  for (std::size_t i = 1; i < result.versions.size(); ++i) {
    const Version& v = result.versions[i];
    const double rms = v.distances.rms;
    if (rms <= wanted && (better == nullptr || rms > better->distances.rms)) better = &v;
    if (rms >= wanted && (worse == nullptr || rms < worse->distances.rms)) worse = &v;
  }
  if (better == nullptr || worse == nullptr) return std::nullopt;
  const double low = better->distances.rms, high = worse->distances.rms;
  if (!(low > 0.0) || better->triangles == 0 || worse->triangles == 0) return std::nullopt;
  const double share = high > low ? std::log(wanted / low) / std::log(high / low) : 0.0;
  return std::exp((1.0 - share) * std::log(static_cast<double>(better->triangles)) +
                  share * std::log(static_cast<double>(worse->triangles)));
}

}  // namespace cornice::compare
