// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/flightlines/line_split.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include "stages/flightlines/robust.h"

namespace cornice::flightlines {
namespace {

constexpr double kWeek = 604800.0;
constexpr auto kWeekBins = static_cast<std::int64_t>(kWeek / kBinSeconds);
/// Pulses of a bin that a track is fitted to; more would not move it.
constexpr std::size_t kPulsesPerBin = 24;

double course_of(Vec3d v) {
  const double degrees = std::atan2(v.x, v.y) / kRadians;
  return degrees < 0.0 ? degrees + 360.0 : degrees;
}

double angle_between(double a_deg, double b_deg) {
  return std::abs(std::remainder(a_deg - b_deg, 360.0));
}

struct Sample {
  double t;
  double tangent;
  Vec3d p;
};

std::vector<Sample> samples_of(const std::vector<const PulseBin*>& bins, std::size_t begin,
                               std::size_t end, Vec3d origin, double time_s) {
  std::vector<Sample> samples;
  for (std::size_t i = begin; i < end; ++i) {
    std::vector<Pulse> pulses = bins[i]->any;
    std::sort(pulses.begin(), pulses.end(),
              [](const Pulse& a, const Pulse& b) { return a.hash < b.hash; });
    if (pulses.size() > kPulsesPerBin) pulses.resize(kPulsesPerBin);
    for (const Pulse& pulse : pulses)
      samples.push_back({pulse.time_s - time_s, std::tan(pulse.angle_deg * kRadians),
                         bins[i]->origin - origin + pulse.last.cast<double>()});
  }
  return samples;
}

using Coefficients = Eigen::Matrix<double, 3, 2>;

/// One weighted solution of [1 t tan] C = [x y], with a whiff of damping: a clip of a swath may
/// hold a single angle.
Eigen::Matrix3d solve(const std::vector<Sample>& samples, const std::vector<double>& weights,
                      Coefficients& solution) {
  Eigen::Matrix3d normal = Eigen::Vector3d(0.0, 1e-6, 1e-4).asDiagonal();
  Coefficients right = Coefficients::Zero();
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Eigen::Vector3d row(1.0, samples[i].t, samples[i].tangent);
    normal += weights[i] * row * row.transpose();
    right += weights[i] * row * Eigen::RowVector2d(samples[i].p.x, samples[i].p.y);
  }
  const Eigen::Matrix3d inverse = normal.inverse();
  solution = inverse * right;
  return inverse;
}

/// Cuts where the course of neighbouring windows differs for good.
std::vector<std::size_t> cut_turns(const std::vector<const PulseBin*>& bins, std::size_t begin,
                                   std::size_t end, const SplitOptions& options,
                                   SplitCounts& counts) {
  std::vector<std::size_t> cuts;
  const auto window = static_cast<std::size_t>(options.window_s / kBinSeconds);
  if (end - begin < 3 * window) return cuts;
  std::size_t last_cut = begin;
  for (std::size_t at = begin + window; at + window <= end; at += window / 2) {
    if (at - last_cut < window) continue;
    const TrackFit before = fit_track(bins, at - window, at);
    const TrackFit after = fit_track(bins, at, at + window);
    if (!before.is_reliable() || !after.is_reliable() ||
        angle_between(before.course_deg, after.course_deg) < options.course_change_deg)
      continue;
    // Relief at the edge of a swath bends the course of a window; only where one straight line does
    // far worse than two has the aircraft turned.
    const TrackFit both = fit_track(bins, at - window, at + window);
    if (both.residual_m > 2.5 * std::max(before.residual_m, after.residual_m)) {
      cuts.push_back(at);
      last_cut = at;
      ++counts.turns_cut;
    }
  }
  return cuts;
}

/// True where the second segment is the same pass as the first, seen again after a gap.
bool continues(const TrackFit& a, const TrackFit& b, double gap_s, const SplitOptions& options) {
  const bool sure = a.is_reliable() && b.is_reliable();
  const double turned = angle_between(a.course_deg, b.course_deg);
  if (gap_s <= options.sure_gap_s) return !sure || turned <= options.course_change_deg;
  if (gap_s > options.longest_gap_s || !sure) return false;
  // On the same straight flight the nadir of b lies ahead of that of a by speed times time.
  const Vec3d mean = (a.velocity + b.velocity) * 0.5;
  const double flown = norm(mean) * (b.time_s - a.time_s);
  const Vec3d along = normalized(mean);
  const Vec3d step{b.start.x - a.start.x, b.start.y - a.start.y, 0.0};
  const double ahead = dot(step, along);
  const double aside = std::abs(step.x * along.y - step.y * along.x);
  return turned < 12.0 && std::abs(ahead - flown) < 0.15 * flown + 200.0 &&
         aside < 0.05 * flown + 150.0;
}

/// Splits the timed bins [begin, end) of one key, which lie in time order.
void split_key(const std::vector<const PulseBin*>& bins, const SplitOptions& options,
               SplitResult& result) {
  struct Segment {
    std::size_t begin, end;
    bool after_turn;
  };
  std::vector<Segment> segments;
  std::size_t begin = 0;
  for (std::size_t i = 1; i <= bins.size(); ++i) {
    const bool ends =
        i == bins.size() || bins[i]->first_time_s - bins[i - 1]->last_time_s > options.gap_s;
    if (!ends) continue;
    bool after_turn = false;
    std::size_t from = begin;
    for (const std::size_t cut : cut_turns(bins, begin, i, options, result.counts)) {
      segments.push_back({from, cut, after_turn});
      from = cut;
      after_turn = true;
    }
    segments.push_back({from, i, after_turn});
    begin = i;
  }
  LinePass pass;
  TrackFit last_fit;
  for (const Segment& segment : segments) {
    const TrackFit fit = fit_track(bins, segment.begin, segment.end);
    bool joined = false;
    if (!pass.bins.empty() && !segment.after_turn) {
      const double gap_s = bins[segment.begin]->first_time_s - pass.bins.back()->last_time_s;
      joined = continues(last_fit, fit, gap_s, options);
      ++(joined ? result.counts.gaps_bridged : result.counts.gaps_ended);
    }
    if (!joined && !pass.bins.empty()) result.passes.push_back(std::exchange(pass, {}));
    pass.key = bins[segment.begin]->key;
    pass.bins.insert(pass.bins.end(), bins.begin() + static_cast<std::ptrdiff_t>(segment.begin),
                     bins.begin() + static_cast<std::ptrdiff_t>(segment.end));
    // The better known of the two courses speaks for the pass from here on.
    last_fit = joined ? fit_track(pass.bins, 0, pass.bins.size()) : fit;
  }
  if (!pass.bins.empty()) result.passes.push_back(std::move(pass));
}

/// Seconds of the week that go on after midnight between Saturday and Sunday: the survey's bins are
/// contiguous over the end of the week. Shifts the later ones up by a week.
void unwrap_week(std::vector<PulseBin*>& bins, SplitCounts& counts) {
  const auto by_index = [](const PulseBin* a, const PulseBin* b) { return a->index < b->index; };
  std::sort(bins.begin(), bins.end(), by_index);
  if (bins.empty() || bins.front()->index < 0 || bins.back()->index >= kWeekBins) return;
  const std::int64_t over = bins.front()->index + kWeekBins - bins.back()->index;
  if (static_cast<double>(over) * kBinSeconds > 30.0) return;
  std::size_t cut = 0;
  std::int64_t widest = 0;
  for (std::size_t i = 1; i < bins.size(); ++i) {
    const std::int64_t gap = bins[i]->index - bins[i - 1]->index;
    if (gap > widest) {
      widest = gap;
      cut = i;
    }
  }
  if (widest < kWeekBins / 2) return;
  for (std::size_t i = 0; i < cut; ++i) {
    bins[i]->index += kWeekBins;
    bins[i]->first_time_s += kWeek;
    bins[i]->last_time_s += kWeek;
    for (Pulse& pulse : bins[i]->any) pulse.time_s += kWeek;
    for (Pulse& pulse : bins[i]->multiple) pulse.time_s += kWeek;
  }
  ++counts.week_rollovers;
  std::sort(bins.begin(), bins.end(), by_index);
}

/// Many points over a wide place at one instant: the field was filled with a constant.
bool is_constant_time(const std::vector<PulseBin*>& bins) {
  if (bins.size() != 1 || bins[0]->points < 20) return false;
  return bins[0]->first_time_s == bins[0]->last_time_s;
}

}  // namespace

bool TrackFit::is_reliable() const {
  const double speed = norm(velocity);
  return pulses >= 40 && course_error_deg < 6.0 && speed > 15.0 && speed < 250.0 &&
         speed_error_ms < 0.3 * speed;
}

TrackFit fit_track(const std::vector<const PulseBin*>& bins, std::size_t begin, std::size_t end) {
  TrackFit fit;
  if (begin >= end) return fit;
  fit.time_s = 0.5 * (bins[begin]->first_time_s + bins[end - 1]->last_time_s);
  const Vec3d origin = bins[begin]->origin;
  const std::vector<Sample> samples = samples_of(bins, begin, end, origin, fit.time_s);
  fit.pulses = samples.size();
  fit.start = origin;
  if (samples.size() < 8) return fit;
  std::vector<double> weights(samples.size(), 1.0);
  std::vector<double> residuals(samples.size());
  Coefficients solution = Coefficients::Zero();
  Eigen::Matrix3d inverse = Eigen::Matrix3d::Zero();
  double height = 0.0;
  for (const Sample& sample : samples) height += sample.p.z / static_cast<double>(samples.size());
  for (int iteration = 0; iteration < 5; ++iteration) {
    inverse = solve(samples, weights, solution);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const Eigen::RowVector2d predicted =
          Eigen::RowVector3d(1.0, samples[i].t, samples[i].tangent) * solution;
      residuals[i] = std::hypot(samples[i].p.x - predicted(0), samples[i].p.y - predicted(1));
    }
    std::vector<double> sorted = residuals;
    fit.residual_m =
        std::max(0.01, median_in_place(sorted) / 1.177);  // median of a 2D normal's radius
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double ratio = residuals[i] / (3.0 * fit.residual_m);
      weights[i] = 1.0 / (1.0 + ratio * ratio);
    }
  }
  fit.start = origin + Vec3d{solution(0, 0), solution(0, 1), height};
  fit.velocity = {solution(1, 0), solution(1, 1), 0.0};
  fit.across = {solution(2, 0), solution(2, 1), 0.0};
  fit.course_deg = course_of(fit.velocity);
  // Pulses of one bin share what the model does not know (relief), so they count as a few.
  const double shared =
      std::sqrt(static_cast<double>(samples.size()) / (4.0 * static_cast<double>(end - begin)));
  fit.speed_error_ms = fit.residual_m * std::sqrt(inverse(1, 1)) * std::max(1.0, shared);
  fit.course_error_deg =
      std::min(180.0, fit.speed_error_ms / std::max(1e-9, norm(fit.velocity)) / kRadians);
  return fit;
}

SplitResult split_lines(BinSet& set, const SplitOptions& options) {
  SplitResult result;
  bool positive = false;
  for (const PulseBin& bin : set.bins) positive |= bin.index > 0;
  for (std::size_t begin = 0; begin < set.bins.size();) {
    std::size_t end = begin;
    PulseBin* timeless = nullptr;
    std::vector<PulseBin*> timed;
    for (; end < set.bins.size() && set.bins[end].key == set.bins[begin].key; ++end) {
      PulseBin& bin = set.bins[end];
      if (bin.index == kTimelessBin) {
        timeless = &bin;
      } else if (bin.index < 0 && positive) {
        result.counts.negative_dropped += bin.points;
        set.invalid[static_cast<std::size_t>(Invalid::kNegativeTime)] += bin.points;
      } else {
        timed.push_back(&bin);
      }
    }
    begin = end;
    if (is_constant_time(timed)) {
      ++result.counts.constant_times;
      result.passes.push_back({timed[0]->key, {timed[0]}, true});
      timed.clear();
    }
    unwrap_week(timed, result.counts);
    split_key({timed.begin(), timed.end()}, options, result);
    if (timeless == nullptr) continue;
    // Zero times among good ones belong to an unknown pass of the same id: they stay out.
    if (timed.empty())
      result.passes.push_back({timeless->key, {timeless}, true});
    else
      result.counts.timeless_dropped += timeless->points;
  }
  std::stable_sort(result.passes.begin(), result.passes.end(),
                   [](const LinePass& a, const LinePass& b) {
                     if (a.is_timeless != b.is_timeless) return b.is_timeless;
                     const double ta = a.bins.front()->first_time_s;
                     const double tb = b.bins.front()->first_time_s;
                     return ta != tb ? ta < tb : a.key < b.key;
                   });
  return result;
}

}  // namespace cornice::flightlines
