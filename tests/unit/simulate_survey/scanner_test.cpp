// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/simulate/scanner.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "core/base/error.h"

namespace cornice::simulate {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

double across_deg(Vec3d body) { return kDegrees * std::atan2(body.y, body.z); }
double lean_deg(Vec3d body) { return kDegrees * std::atan2(body.x, std::hypot(body.y, body.z)); }

ScannerOptions with(ScannerPattern pattern) {
  ScannerOptions options;
  options.pattern = pattern;
  return options;
}

TEST(Scanner, BeamsAreUnitAndStayWithinTheFieldOfView) {
  for (const ScannerPattern pattern :
       {ScannerPattern::kOscillating, ScannerPattern::kPolygon, ScannerPattern::kPalmer}) {
    const ScannerOptions options = with(pattern);
    const Scanner scanner(options, 1.0 / 250.3);
    const double half = 0.5 * options.field_of_view_deg();
    double least = 0.0, most = 0.0;
    for (std::uint64_t pulse = 0; pulse < 5000; ++pulse) {
      const Vec3d d = scanner.beam(pulse, 0).direction;
      EXPECT_NEAR(norm(d), 1.0, 1e-7);
      least = std::min(least, across_deg(d));
      most = std::max(most, across_deg(d));
    }
    EXPECT_NEAR(least, -half, 0.5) << scanner_name(pattern);
    EXPECT_NEAR(most, half, 0.5) << scanner_name(pattern);
  }
}

TEST(Scanner, PalmerBeamsLieOnAConeAheadAndBehind) {
  const Scanner scanner(with(ScannerPattern::kPalmer), 1.0 / 100.7);
  double ahead = 0.0, behind = 0.0;
  for (std::uint64_t pulse = 0; pulse < 1000; ++pulse) {
    const Vec3d d = scanner.beam(pulse, 0).direction;
    EXPECT_NEAR(kDegrees * std::acos(d.z / norm(d)), 18.0, 1e-5);
    ahead = std::max(ahead, lean_deg(d));
    behind = std::min(behind, lean_deg(d));
  }
  EXPECT_NEAR(ahead, 18.0, 0.1);
  EXPECT_NEAR(behind, -18.0, 0.1);
}

TEST(Scanner, PolygonLinesRunOneWayAndEndOncePerFacet) {
  const Scanner scanner(with(ScannerPattern::kPolygon), 1.0 / 50.0);
  int ends = 0, backwards = 0;
  for (std::uint64_t pulse = 0; pulse < 5000; ++pulse) {
    const BodyBeam beam = scanner.beam(pulse, 0);
    const double step =
        across_deg(scanner.beam(pulse + 1, 0).direction) - across_deg(beam.direction);
    EXPECT_TRUE(beam.scans_to_the_right);
    if (beam.is_last_of_line) {
      ++ends;
    } else if (step <= 0.0) {
      ++backwards;
    }
  }
  EXPECT_NEAR(ends, 100, 1);
  EXPECT_EQ(backwards, 0);
}

TEST(Scanner, SwingingMirrorMovesTheWayItsFlagSaysAndMarksItsTurns) {
  const Scanner scanner(with(ScannerPattern::kOscillating), 1.0 / 50.3);
  int turns = 0;
  for (std::uint64_t pulse = 0; pulse < 5000; ++pulse) {
    const BodyBeam beam = scanner.beam(pulse, 0);
    const double step =
        across_deg(scanner.beam(pulse + 1, 0).direction) - across_deg(beam.direction);
    if (beam.is_last_of_line) {
      ++turns;
    } else {
      EXPECT_EQ(step > 0.0, beam.scans_to_the_right) << pulse;
    }
  }
  EXPECT_NEAR(turns, 5000 / 50.3, 1.5);
}

TEST(Scanner, TiltLeansTheWholeScanTowardsTheNose) {
  ScannerOptions options = with(ScannerPattern::kPolygon);
  options.tilt_deg = 12.0;
  options.channels = 2;
  options.second_tilt_deg = -5.0;
  const Scanner scanner(options, 1.0 / 64.0);
  // In the middle of a facet the mirror looks straight down.
  EXPECT_NEAR(lean_deg(scanner.beam(32, 0).direction), 12.0, 1e-9);
  EXPECT_NEAR(lean_deg(scanner.beam(32, 1).direction), -5.0, 1e-9);
  EXPECT_NEAR(options.largest_lean_deg(), 12.0, 1e-12);
}

TEST(Scanner, NoStepBetweenPulsesExceedsItsBoundButAPolygonsJump) {
  for (const ScannerPattern pattern :
       {ScannerPattern::kOscillating, ScannerPattern::kPolygon, ScannerPattern::kPalmer}) {
    const Scanner scanner(with(pattern), 1.0 / 120.9);
    for (std::uint64_t pulse = 0; pulse < 3000; ++pulse) {
      if (scanner.jumps_within(pulse, 1)) continue;
      const double turn =
          norm(cross(scanner.beam(pulse, 0).direction, scanner.beam(pulse + 1, 0).direction));
      EXPECT_LE(turn, scanner.largest_step_rad()) << scanner_name(pattern) << " " << pulse;
    }
  }
}

TEST(Scanner, EveryOptionOutOfRangeIsRefusedByName) {
  const auto message = [](auto change) {
    ScannerOptions options;
    change(options);
    try {
      check(options);
    } catch (const UsageError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(message([](ScannerOptions&) {}), "accepted");
  EXPECT_NE(message([](ScannerOptions& o) { o.fov_deg = 120.0; }).find("--fov"), std::string::npos);
  EXPECT_NE(message([](ScannerOptions& o) { o.tilt_deg = 45.0; }).find("--tilt"),
            std::string::npos);
  EXPECT_NE(message([](ScannerOptions& o) { o.second_tilt_deg = -31.0; }).find("--second-tilt"),
            std::string::npos);
  EXPECT_NE(message([](ScannerOptions& o) { o.channels = 3; }).find("--channels"),
            std::string::npos);
  EXPECT_NE(message([](ScannerOptions& o) { o.mirror_sharpness = 1.0; }).find("--mirror-sharpness"),
            std::string::npos);
  EXPECT_THROW(scanner_pattern("zigzag"), UsageError);
  EXPECT_EQ(scanner_pattern("palmer"), ScannerPattern::kPalmer);
}

}  // namespace
}  // namespace cornice::simulate
