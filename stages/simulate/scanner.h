// SPDX-License-Identifier: GPL-3.0-or-later
// Where a scanner points: one beam per pulse in the frame of the aircraft.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/vec.h"

namespace cornice::simulate {

enum class ScannerPattern {
  kOscillating,  ///< a mirror that swings: zig-zag lines on the ground
  kPolygon,      ///< a rotating polygon: parallel lines, all in one direction
  kPalmer,       ///< a rotating wedge: circles, every place is seen looking ahead and looking back
};

/// A scanner. All angles in degrees.
struct ScannerOptions {
  ScannerPattern pattern = ScannerPattern::kOscillating;
  /// Full field of view across the track; of Palmer, twice the cone's half angle. 0: the pattern's
  /// usual value (40, 60, 36). Range 1..100.
  double fov_deg = 0.0;
  /// Lean of the scan plane or of the cone's axis towards the nose. Range -30..30.
  double tilt_deg = 0.0;
  /// 1, or 2: a second channel fires at the same time stamp with its own lean.
  int channels = 1;
  double second_tilt_deg = 6.5;
  /// Of the swinging mirror: 0 moves as a sine, towards 1 as a triangle. Range 0..0.999.
  double mirror_sharpness = 0.9;

  /// fov_deg with the pattern's usual value in place of 0.
  double field_of_view_deg() const;
  /// Greatest angle between a beam and the across-track plane of a level aircraft.
  double largest_lean_deg() const;
};

/// "oscillating", "polygon" or "palmer"; throws UsageError for anything else.
ScannerPattern scanner_pattern(const std::string& name);
std::string scanner_name(ScannerPattern pattern);

/// Throws UsageError naming the first field out of its range.
void check(const ScannerOptions& options);

/// Direction of one pulse.
struct BodyBeam {
  Vec3d direction;                  ///< unit to 1e-7; x to the nose, y to the right wing, z down
  bool scans_to_the_right = false;  ///< LAS scan direction flag
  bool is_last_of_line = false;     ///< LAS edge of flight line flag
};

/// A scanner at work: `scans_per_pulse` mirror lines, facets or turns per pulse.
/// Thread contract: const members may be called from many threads.
class Scanner {
 public:
  Scanner(const ScannerOptions& options, double scans_per_pulse);
  /// channel: 0 or 1.
  BodyBeam beam(std::uint64_t pulse, int channel) const;
  /// Bound of the angle between the beams of one pulse and the next, radians; a polygon's jump back
  /// to the other edge, and a phase that runs wild in trial flights, exceed it.
  double largest_step_rad() const;
  /// True where one of the `count` pulses after `pulse` begins a new line of a polygon.
  bool jumps_within(std::uint64_t pulse, std::uint64_t count) const;

 private:
  ScannerPattern pattern_;
  double half_view_;
  double sin_tilt_[2];
  double cos_tilt_[2];
  double cycles_per_pulse_;
  std::vector<Vec3d> cycle_;  ///< beams without tilt over one cycle, both ends included
};

}  // namespace cornice::simulate
