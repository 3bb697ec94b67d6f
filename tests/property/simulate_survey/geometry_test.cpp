// SPDX-License-Identifier: GPL-3.0-or-later
// Trajectory, beams, angles, times, normals and points of a survey agree with each other.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "property/simulate_survey/flown.h"

namespace cornice::test {
namespace {

using namespace simulate;

constexpr double kDegrees = 180.0 / std::numbers::pi;

struct Case {
  const char* name;
  ScannerPattern pattern;
  double tilt_deg;
  int channels;
};
void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

class Flight : public testing::TestWithParam<Case> {
 protected:
  Flight() : options_(small_survey()) {
    options_.product = SurveyProduct::kLidarHd;
    options_.scanner.pattern = GetParam().pattern;
    options_.scanner.tilt_deg = GetParam().tilt_deg;
    options_.scanner.channels = GetParam().channels;
    // 52 m apart on the ground: a tile of 100 m sees both at one time.
    options_.scanner.second_tilt_deg = GetParam().tilt_deg + 2.5;
    scene_ = scene_for(options_);
    scene_.slope_x = 0.4;
    scene_.canopy_west = scene_.extent.min_x + 60.0;
    scene_.canopy_east = scene_.extent.max_x;
    scene_.wall_x = scene_.extent.min_x + 120.0;
    scene_.wall_height = 25.0;
    survey_ = std::make_unique<Survey>(options_, scene_);
    points_ = points_of(*survey_);
  }
  SurveyOptions options_;
  PlaneScene scene_;
  std::unique_ptr<Survey> survey_;
  std::vector<SurveyPoint> points_;
};

TEST_P(Flight, TheTrueBeamFromTheSensorAtTheTimeOfThePointMeetsItsTruePlace) {
  ASSERT_GT(points_.size(), 30000u);
  for (const SurveyPoint& point : points_) {
    const Vec3d way = point.truth() - sensor_of(*survey_, point);
    const Vec3d beam = point.beam.cast<double>();
    EXPECT_NEAR(norm(beam), 1.0, 1e-6);
    ASSERT_LT(norm(way - dot(way, beam) * beam), 5e-4);
  }
}

TEST_P(Flight, TruePlacesLieOnTheSurfaceThatIsNamed) {
  for (const SurveyPoint& point : points_) {
    if (point.surface != static_cast<std::uint8_t>(SurfaceId::kGround)) continue;
    const Vec3d p = point.truth();
    const bool is_wall = point.normal.x == -1.0f;
    ASSERT_NEAR(is_wall ? p.x - scene_.wall_x : p.z - scene_.ground(p.x), 0.0, 1e-4);
  }
}

TEST_P(Flight, RecordedPlacesAreTheTrueOnesButForTheNoise) {
  const double altitude = survey_->trajectory.altitude_m() - survey_->ground.mean_m;
  double sum = 0.0, along = 0.0;
  for (const SurveyPoint& point : points_) {
    const Vec3d error = -point.true_offset.cast<double>();
    ASSERT_LT(norm(error), 6.0 * 0.03);
    const double range = norm(point.truth() - sensor_of(*survey_, point));
    const double scale = altitude / range;
    sum += dot(error, error) * scale * scale;
    const double part = dot(error, point.beam.cast<double>());
    along += part * part;
  }
  const auto count = static_cast<double>(points_.size());
  // Noise across grows with range; along it, half of it does. Rounding to 1 cm adds 5 mm.
  EXPECT_NEAR(std::sqrt(sum / count), std::hypot(0.03, 0.005), 0.0015);
  EXPECT_NEAR(std::sqrt(along / count), std::hypot(0.024, 0.003), 0.0015);
}

TEST_P(Flight, TheRecordedAngleIsTheAcrossTrackAngleOfTheRecordedPoint) {
  for (const SurveyPoint& point : points_) {
    const SurveyLine& line = survey_->setup.lines[point.line - 1u];
    const SensorFrame frame =
        survey_->trajectory.at(static_cast<std::size_t>(line.pass), point.gps_time_s);
    const double angle = across_track_angle_deg(frame, point.recorded() - frame.position);
    ASSERT_NEAR(point.scan_angle_deg, angle, 0.006);
  }
}

TEST_P(Flight, PointsOfPositiveAngleLieToTheRightOfTheFlight) {
  std::map<int, Vec3d> right, left;
  for (const SurveyPoint& point : points_) {
    if (point.scan_angle_deg > 3.0f) right[point.line] += point.truth() - points_[0].truth();
    const SurveyLine& line = survey_->setup.lines[point.line - 1u];
    const Pass& pass = survey_->trajectory.passes()[static_cast<std::size_t>(line.pass)];
    const Vec3d along = normalized(pass.end - pass.start);
    const Vec3d from = point.truth() - pass.start;
    const double aside = from.x * along.y - from.y * along.x;
    if (std::abs(aside) > 60.0) {
      ASSERT_EQ(aside > 0.0, point.scan_angle_deg > 0.0f);
    }
  }
}

TEST_P(Flight, TimesRunForwardAlongEachLineAndLinesFollowEachOther) {
  double last = 0.0;
  int last_pass = -1;
  for (const SurveyPoint& point : points_) {
    ASSERT_GE(point.gps_time_s, last);
    const int pass = survey_->setup.lines[point.line - 1u].pass;
    if (pass != last_pass && last_pass >= 0) {
      ASSERT_GT(point.gps_time_s - last, options_.flight.turn_s);
    }
    last = point.gps_time_s;
    last_pass = pass;
  }
}

TEST_P(Flight, NormalsAreUnitAndFaceTheSensor) {
  for (const SurveyPoint& point : points_) {
    ASSERT_NEAR(norm(point.normal), 1.0f, 1e-6f);
    ASSERT_LT(dot(point.normal, point.beam), 0.0f);
  }
}

TEST_P(Flight, ReturnsOfOnePulseShareItsTimeAndLieOnOneLineThroughTheSensor) {
  const Box2d inner = survey_->setup.grid.extent().grown(-15.0);
  int pulses = 0;
  for (std::size_t i = 1; i < points_.size(); ++i) {
    const SurveyPoint &a = points_[i - 1], &b = points_[i];
    if (b.return_number != a.return_number + 1 || b.line != a.line) continue;
    // At the edge of the tiles a pulse can lose its first return.
    if (!inner.contains(b.recorded().x, b.recorded().y)) continue;
    ASSERT_EQ(a.gps_time_s, b.gps_time_s);
    ASSERT_EQ(a.return_count, b.return_count);
    ASSERT_EQ(a.scan_angle_deg, b.scan_angle_deg);
    const Vec3d sensor = sensor_of(*survey_, a);
    const Vec3d to_a = a.recorded() - sensor, to_b = b.recorded() - sensor;
    // Of recorded places: only their rounding to 1 cm bends the line.
    ASSERT_LT(norm(cross(normalized(to_a), normalized(to_b))) * norm(to_a), 0.02);
    ASSERT_GT(norm(to_b), norm(to_a) + 0.3);
    ++pulses;
  }
  EXPECT_GT(pulses, 3000);
}

TEST_P(Flight, DensityIsWhatWasAskedFor) {
  EXPECT_NEAR(static_cast<double>(points_.size()) / 10000.0, 4.0, 0.4);
}

TEST_P(Flight, PointsLieInTheTilesAndEveryTileGetsItsShare) {
  std::map<int, int> of_tile;
  for (const SurveyPoint& point : points_) {
    const auto tile = survey_->setup.grid.find(point.at.x, point.at.y);
    ASSERT_TRUE(tile.has_value());
    ++of_tile[*tile];
  }
  for (int tile = 0; tile < 4; ++tile) EXPECT_GT(of_tile[tile], 4000) << tile;
}

TEST_P(Flight, TwoChannelsFireAtTheSameTimesUnderDifferentLean) {
  if (GetParam().channels < 2) {
    for (const SurveyLine& line : survey_->setup.lines) EXPECT_EQ(line.channel, 0);
    return;
  }
  std::map<double, std::set<int>> lines_at;
  for (const SurveyPoint& point : points_) lines_at[point.gps_time_s].insert(point.line);
  int both = 0;
  for (const auto& [time, lines] : lines_at) both += lines.size() == 2 ? 1 : 0;
  EXPECT_GT(both, 1000);
}

INSTANTIATE_TEST_SUITE_P(Scanners, Flight,
                         testing::Values(Case{"Oscillating", ScannerPattern::kOscillating, 0.0, 1},
                                         Case{"Polygon", ScannerPattern::kPolygon, 14.0, 1},
                                         Case{"Palmer", ScannerPattern::kPalmer, 0.0, 1},
                                         Case{"TwoChannels", ScannerPattern::kPolygon, -4.5, 2}),
                         [](const auto& each) { return std::string(each.param.name); });

TEST(Overlap, OfNeighbouringSwathsIsWhatWasAskedFor) {
  for (const double percent : {20.0, 50.0}) {
    SurveyOptions options = small_survey();
    options.tiles = "1x1";
    options.tile_m = 2000.0;
    options.density = 0.05;
    options.overlap_percent = percent;
    options.flight.azimuth_deg = 0.0;
    options.flight.motion = 0.0;
    const PlaneScene scene = scene_for(options);
    const Survey survey(options, scene);
    std::map<int, Box2d> swaths;
    for (const SurveyPoint& point : points_of(survey))
      swaths[point.line].add(point.recorded().x, point.recorded().y);
    ASSERT_GE(swaths.size(), 3u);
    const Box2d extent = survey.setup.grid.extent();
    int pairs = 0;
    for (std::size_t line = 1; line < swaths.size(); ++line) {
      const Box2d &a = swaths[static_cast<int>(line)], &b = swaths[static_cast<int>(line + 1)];
      // Where the edge of the tile cuts a swath off its width is not known.
      if (a.min_x < extent.min_x + 20.0 || b.max_x > extent.max_x - 20.0) continue;
      EXPECT_NEAR((a.max_x - b.min_x) / a.width(), 0.01 * percent, 0.01) << line;
      ++pairs;
    }
    EXPECT_GE(pairs, 1);
  }
}

TEST(Palmer, EveryPlaceIsSeenAheadAndBehindAndTheAngleDoesNotSay) {
  SurveyOptions options = small_survey();
  options.scanner.pattern = ScannerPattern::kPalmer;
  const PlaneScene scene = scene_for(options);
  const Survey survey(options, scene);
  double most_lean = 0.0, most_angle = 0.0;
  int ahead = 0, behind = 0;
  for (const SurveyPoint& point : points_of(survey)) {
    const SurveyLine& line = survey.setup.lines[point.line - 1u];
    const SensorFrame frame =
        survey.trajectory.at(static_cast<std::size_t>(line.pass), point.gps_time_s);
    const double lean =
        kDegrees * std::asin(dot(point.beam.cast<double>(), normalized(frame.forward)));
    (lean > 0.0 ? ahead : behind) += 1;
    most_lean = std::max(most_lean, std::abs(lean));
    most_angle = std::max(most_angle, std::abs(static_cast<double>(point.scan_angle_deg)));
  }
  EXPECT_GT(most_lean, 12.0);
  EXPECT_NEAR(ahead, behind, 0.15 * ahead);
  EXPECT_LT(most_angle, 20.0);
}

}  // namespace
}  // namespace cornice::test
