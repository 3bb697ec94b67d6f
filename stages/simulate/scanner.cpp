// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/simulate/scanner.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/error.h"

namespace cornice::simulate {
namespace {

constexpr double kPi = std::numbers::pi;

double radians(double degrees) { return degrees * (kPi / 180.0); }

double fraction(double x) { return x - std::floor(x); }

void check_range(const char* option, double value, double low, double high) {
  if (value >= low && value <= high) return;
  throw UsageError(option, "is " + std::to_string(value) + ", must be in " + std::to_string(low) +
                               " .. " + std::to_string(high));
}

/// Steps of the table of beams; the chord between neighbours is off its arc by 1e-8.
constexpr std::size_t kCycleSteps = 1u << 14;

/// Deflection of the swinging mirror in -1..1: asin(k sin) is a sine for small k and a triangle
/// for k = 1.
double swing(double phase, double sharpness) {
  const double sine = std::sin(2.0 * kPi * phase);
  if (sharpness < 1e-3) return sine;
  return std::asin(sharpness * sine) / std::asin(sharpness);
}

Vec3d untilted_beam(const ScannerOptions& options, double half_view, double phase) {
  if (options.pattern == ScannerPattern::kPalmer) {
    const double turn = 2.0 * kPi * phase, sine = std::sin(half_view);
    return {sine * std::cos(turn), sine * std::sin(turn), std::cos(half_view)};
  }
  const double deflection = options.pattern == ScannerPattern::kPolygon
                                ? 2.0 * phase - 1.0
                                : swing(phase, options.mirror_sharpness);
  return {0.0, std::sin(half_view * deflection), std::cos(half_view * deflection)};
}

}  // namespace

double ScannerOptions::field_of_view_deg() const {
  if (fov_deg != 0.0) return fov_deg;
  switch (pattern) {
    case ScannerPattern::kOscillating:
      return 40.0;
    case ScannerPattern::kPolygon:
      return 60.0;
    case ScannerPattern::kPalmer:
      return 36.0;
  }
  return 40.0;
}

double ScannerOptions::largest_lean_deg() const {
  const double cone = pattern == ScannerPattern::kPalmer ? 0.5 * field_of_view_deg() : 0.0;
  double lean = std::abs(tilt_deg);
  if (channels > 1) lean = std::max(lean, std::abs(second_tilt_deg));
  return cone + lean;
}

ScannerPattern scanner_pattern(const std::string& name) {
  if (name == "oscillating") return ScannerPattern::kOscillating;
  if (name == "polygon") return ScannerPattern::kPolygon;
  if (name == "palmer") return ScannerPattern::kPalmer;
  throw UsageError("--scanner", "\"" + name + "\" is none of oscillating, polygon, palmer");
}

std::string scanner_name(ScannerPattern pattern) {
  switch (pattern) {
    case ScannerPattern::kOscillating:
      return "oscillating";
    case ScannerPattern::kPolygon:
      return "polygon";
    case ScannerPattern::kPalmer:
      return "palmer";
  }
  return "";
}

void check(const ScannerOptions& options) {
  if (options.fov_deg != 0.0) check_range("--fov", options.fov_deg, 1.0, 100.0);
  check_range("--tilt", options.tilt_deg, -30.0, 30.0);
  check_range("--second-tilt", options.second_tilt_deg, -30.0, 30.0);
  check_range("--channels", options.channels, 1, 2);
  check_range("--mirror-sharpness", options.mirror_sharpness, 0.0, 0.999);
}

Scanner::Scanner(const ScannerOptions& options, double scans_per_pulse)
    : pattern_(options.pattern),
      half_view_(radians(0.5 * options.field_of_view_deg())),
      sin_tilt_{std::sin(radians(options.tilt_deg)), std::sin(radians(options.second_tilt_deg))},
      cos_tilt_{std::cos(radians(options.tilt_deg)), std::cos(radians(options.second_tilt_deg))},
      // A swinging mirror draws two lines per cycle.
      cycles_per_pulse_(options.pattern == ScannerPattern::kOscillating ? 0.5 * scans_per_pulse
                                                                        : scans_per_pulse),
      cycle_(kCycleSteps + 1) {
  for (std::size_t i = 0; i <= kCycleSteps; ++i)
    cycle_[i] = untilted_beam(options, half_view_, static_cast<double>(i) / kCycleSteps);
}

double Scanner::largest_step_rad() const {
  // Of the swinging mirror: asin(k sin x) / asin(k) is steepest at x = 0, where its slope is
  // below 1.
  return 2.0 * kPi * half_view_ * cycles_per_pulse_;
}

bool Scanner::jumps_within(std::uint64_t pulse, std::uint64_t count) const {
  if (pattern_ != ScannerPattern::kPolygon) return false;
  return fraction(static_cast<double>(pulse) * cycles_per_pulse_) +
             static_cast<double>(count) * cycles_per_pulse_ >=
         1.0;
}

BodyBeam Scanner::beam(std::uint64_t pulse, int channel) const {
  const double phase = fraction(static_cast<double>(pulse) * cycles_per_pulse_);
  const double next = phase + cycles_per_pulse_;
  const auto rises = [](double p) { return p < 0.25 || (p >= 0.75 && p < 1.25); };
  BodyBeam beam;
  beam.scans_to_the_right = pattern_ == ScannerPattern::kPolygon || rises(phase);
  if (pattern_ == ScannerPattern::kPolygon)
    beam.is_last_of_line = next >= 1.0;
  else if (pattern_ == ScannerPattern::kOscillating)
    beam.is_last_of_line = rises(phase) != rises(next);
  const double place = phase * kCycleSteps;
  const std::size_t i = std::min(static_cast<std::size_t>(place), std::size_t{kCycleSteps - 1});
  const Vec3d d = cycle_[i] + (place - static_cast<double>(i)) * (cycle_[i + 1] - cycle_[i]);
  const double s = sin_tilt_[channel], c = cos_tilt_[channel];
  beam.direction = {c * d.x + s * d.z, d.y, c * d.z - s * d.x};
  return beam;
}

}  // namespace cornice::simulate
