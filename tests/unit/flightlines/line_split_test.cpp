// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/flightlines/line_split.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/unit/flightlines/flown_line.h"

namespace cornice::flightlines::test {
namespace {

/// A pass out and the next one back, 300 m to the side, `turn_s` later.
std::vector<Flight> out_and_back(double turn_s = 90.0) {
  Flight out;
  out.duration_s = 12.0;
  Flight back = out;
  back.azimuth_deg = out.azimuth_deg + 180.0;
  const double a = out.azimuth_deg * 3.14159265358979 / 180.0;
  const double length = out.speed_ms * out.duration_s;
  back.start = out.start + Vec3d{std::sin(a) * length + 300.0 * std::cos(a),
                                 std::cos(a) * length - 300.0 * std::sin(a), 0.0};
  back.start_time_s = out.start_time_s + out.duration_s + turn_s;
  back.id = 8;
  return {out, back};
}

BinSet bins_of(const std::vector<PointCloud>& tiles) {
  BinSet set;
  for (const PointCloud& tile : tiles) {
    TileBinner binner;
    binner.add(tile);
    merge_bins(set, binner.finish("test"), {});
  }
  return set;
}

BinSet bins_of_flights(std::vector<Flight> flights, bool zero_ids = false) {
  std::vector<PointCloud> tiles;
  for (Flight& flight : flights) {
    if (zero_ids) flight.id = 0;
    tiles.push_back(fly(flight));
  }
  return bins_of(tiles);
}

TEST(LineSplit, GivesOneLineAPassWhereIdsAreFilled) {
  BinSet set = bins_of_flights(out_and_back());
  const SplitResult split = split_lines(set);
  ASSERT_EQ(split.passes.size(), 2u);
  EXPECT_EQ(split.passes[0].key.id, 7);
  EXPECT_EQ(split.passes[1].key.id, 8);
}

TEST(LineSplit, GivesOneLineAPassWhereIdsAreZero) {
  BinSet set = bins_of_flights(out_and_back(), true);
  const SplitResult split = split_lines(set);
  ASSERT_EQ(split.passes.size(), 2u);
  EXPECT_NEAR(split.passes[0].bins.back()->last_time_s, 1012.0, 0.1);
  EXPECT_NEAR(split.passes[1].bins.front()->first_time_s, 1102.0, 0.1);
}

TEST(LineSplit, TellsPassesApartEvenWhereTheTurnIsShort) {
  BinSet set = bins_of_flights(out_and_back(10.0), true);
  EXPECT_EQ(split_lines(set).passes.size(), 2u);
}

TEST(LineSplit, CutsATurnThatIsFlownWithoutAPause) {
  BinSet set = bins_of_flights(out_and_back(0.0), true);
  const SplitResult split = split_lines(set);
  EXPECT_EQ(split.passes.size(), 2u);
  EXPECT_EQ(split.counts.turns_cut, 1u);
}

TEST(LineSplit, SplitsAnIdThatTwoSurveysReuse) {
  Flight first;
  first.duration_s = 8.0;
  Flight second = first;
  second.start_time_s += 44.0 * 86400.0;
  BinSet set = bins_of_flights({first, second});
  EXPECT_EQ(split_lines(set).passes.size(), 2u);
}

TEST(LineSplit, MakesOneLineOfTenTiles) {
  Flight flight;
  std::vector<PointCloud> tiles;
  for (int tile = 0; tile < 10; ++tile)
    tiles.push_back(fly(flight, [&](Vec3d p) {
      return static_cast<int>(std::floor((p.y - flight.start.y) / 150.0)) == tile;
    }));
  BinSet set = bins_of(tiles);
  EXPECT_EQ(split_lines(set).passes.size(), 1u);
}

TEST(LineSplit, BridgesWaterThatReturnsNothing) {
  Flight flight;
  flight.duration_s = 60.0;
  flight.id = 0;
  const double a = flight.azimuth_deg * 3.14159265358979 / 180.0;
  // A lake of 2 km: 33 s without a return.
  const PointCloud points = fly(flight, [&](Vec3d p) {
    const double along =
        (p.x - flight.start.x) * std::sin(a) + (p.y - flight.start.y) * std::cos(a);
    return along < 800.0 || along > 2800.0;
  });
  BinSet set = bins_of({points});
  const SplitResult split = split_lines(set);
  ASSERT_EQ(split.passes.size(), 1u);
  EXPECT_EQ(split.counts.gaps_bridged, 1u);
}

TEST(LineSplit, TellsTwoChannelsOfOneTimeStampApart) {
  Flight one;
  one.duration_s = 5.0;
  Flight two = one;
  two.channel = 1;
  two.tilt_deg = 6.0;
  BinSet set = bins_of_flights({one, two});
  EXPECT_EQ(split_lines(set).passes.size(), 2u);
}

TEST(LineSplit, TellsChannelsApartByUserDataOnlyWhereTimesAreShared) {
  Flight one;
  one.duration_s = 5.0;
  one.user_data = 6;
  Flight two = one;
  two.user_data = 7;
  two.tilt_deg = 6.0;
  BinSet shared = bins_of_flights({one, two});
  EXPECT_TRUE(settle_user_data(shared, {}));
  EXPECT_EQ(split_lines(shared).passes.size(), 2u);

  // The same values on points of their own times say nothing of channels.
  PointCloud mixed = fly(one);
  for (std::size_t i = 0; i < mixed.size(); ++i)
    mixed.user_data[i] = static_cast<std::uint8_t>(6 + i % 2);
  BinSet apart = bins_of({mixed});
  EXPECT_FALSE(settle_user_data(apart, {}));
  EXPECT_EQ(split_lines(apart).passes.size(), 1u);
}

TEST(LineSplit, GoesOnOverTheEndOfAGpsWeek) {
  Flight flight;
  flight.start_time_s = 604795.0;
  flight.duration_s = 12.0;
  PointCloud points = fly(flight);
  for (double& time : points.gps_time_s)
    if (time >= 604800.0) time -= 604800.0;
  points.gps_time_s[0] = 604795.0;
  BinSet set = bins_of({points});
  const SplitResult split = split_lines(set);
  ASSERT_EQ(split.passes.size(), 1u);
  EXPECT_EQ(split.counts.week_rollovers, 1u);
  EXPECT_NEAR(split.passes[0].bins.back()->last_time_s, 604807.0, 0.1);
}

TEST(LineSplit, DoesNotCareAboutTheOrderOfPoints) {
  Flight flight;
  flight.duration_s = 6.0;
  flight.tree_share = 0.3;
  const PointCloud in_order = fly(flight);
  // Every 7th point first, then the next 7th: far from time order.
  PointCloud shuffled;
  shuffled.origin = in_order.origin;
  std::vector<std::uint8_t> keep(in_order.size());
  for (std::size_t phase = 0; phase < 7; ++phase) {
    for (std::size_t i = 0; i < keep.size(); ++i) keep[i] = (i % 7) == phase;
    PointCloud part = in_order;
    part.filter(keep);
    shuffled.append(part);
  }
  const BinSet a = bins_of({in_order}), b = bins_of({shuffled});
  ASSERT_EQ(a.bins.size(), b.bins.size());
  const auto times = [](const std::vector<Pulse>& heap) {
    std::vector<double> all;
    for (const Pulse& pulse : heap) all.push_back(pulse.time_s + pulse.first.x + pulse.last.z);
    std::sort(all.begin(), all.end());
    return all;
  };
  for (std::size_t i = 0; i < a.bins.size(); ++i) {
    EXPECT_EQ(a.bins[i].points, b.bins[i].points);
    EXPECT_EQ(times(a.bins[i].any), times(b.bins[i].any));
    EXPECT_EQ(times(a.bins[i].multiple), times(b.bins[i].multiple));
  }
}

TEST(PulseBins, CountInvalidPointsByTheirReason) {
  Flight flight;
  flight.duration_s = 0.1;
  PointCloud points = fly(flight);
  ASSERT_GT(points.size(), 20u);
  points.classification[0] = 66;
  points.flags[1] = kSynthetic;
  points.flags[2] = kWithheld;
  points.gps_time_s[3] = 0.0;
  points.gps_time_s[4] = std::numeric_limits<double>::quiet_NaN();
  points.gps_time_s[5] = -40787201.0;
  points.scan_angle_deg[6] = 170.0f;
  points.return_number[7] = 0;
  points.return_number[8] = 3;  // of 1
  BinSet set = bins_of({points});
  const SplitResult split = split_lines(set);
  ASSERT_EQ(split.passes.size(), 1u);
  const auto count = [&](Invalid kind) { return set.invalid[static_cast<std::size_t>(kind)]; };
  EXPECT_EQ(count(Invalid::kVirtualClass), 1u);
  EXPECT_EQ(count(Invalid::kSynthetic), 1u);
  EXPECT_EQ(count(Invalid::kWithheld), 1u);
  EXPECT_EQ(count(Invalid::kZeroTime), 1u);
  EXPECT_EQ(count(Invalid::kNotFiniteTime), 1u);
  EXPECT_EQ(count(Invalid::kNegativeTime), 1u);
  EXPECT_EQ(count(Invalid::kAbsurdAngle), 1u);
  EXPECT_EQ(count(Invalid::kReturnNumber), 2u);
  EXPECT_EQ(split.counts.timeless_dropped, 1u);
}

TEST(PulseBins, SeeWholeDegreesInAFieldOfFinerSteps) {
  Flight flight;
  flight.duration_s = 0.4;
  flight.whole_degrees = true;
  PointCloud points = fly(flight);
  for (float& angle : points.scan_angle_deg) angle = std::round(angle / 0.006f) * 0.006f;
  const BinSet whole = bins_of({points});
  EXPECT_FALSE(whole.bins[0].fractional_angles);
  flight.whole_degrees = false;
  EXPECT_TRUE(bins_of({fly(flight)}).bins[0].fractional_angles);
}

TEST(PulseBins, MarkDuplicateReturnNumbersAtTwoPlaces) {
  Flight flight;
  flight.duration_s = 0.05;
  flight.tree_share = 1.0;
  PointCloud points = fly(flight);
  for (std::size_t i = 0; i < points.size(); ++i) points.return_number[i] = 2;
  const BinSet set = bins_of({points});
  std::size_t conflicting = 0;
  for (const Pulse& pulse : set.bins[0].any) conflicting += pulse.conflicting;
  EXPECT_EQ(conflicting, set.bins[0].any.size());
}

TEST(PulseBins, KeepABoundedSampleThatThinsToASubset) {
  Flight flight;
  flight.duration_s = 4.0;
  flight.tree_share = 0.5;
  BinSet set = bins_of({fly(flight)});
  for (const PulseBin& bin : set.bins) {
    EXPECT_LE(bin.any.size(), SampleSize{}.any);
    EXPECT_LE(bin.multiple.size(), SampleSize{}.multiple);
  }
  const std::size_t before = memory_bytes(set);
  const BinSet whole = set;
  thin_bins(set, {20, 10});
  EXPECT_LT(memory_bytes(set), before / 4);
  for (std::size_t i = 0; i < set.bins.size(); ++i)
    for (const Pulse& pulse : set.bins[i].any)
      EXPECT_TRUE(std::any_of(whole.bins[i].any.begin(), whole.bins[i].any.end(),
                              [&](const Pulse& p) { return p.time_s == pulse.time_s; }));
}

TEST(LineSplit, SetsKeysOfConstantTimeApart) {
  Flight flight;
  flight.duration_s = 1.0;
  PointCloud points = fly(flight);
  std::fill(points.gps_time_s.begin(), points.gps_time_s.end(), 1234.5);
  BinSet set = bins_of({points});
  const SplitResult split = split_lines(set);
  ASSERT_EQ(split.passes.size(), 1u);
  EXPECT_TRUE(split.passes[0].is_timeless);
  EXPECT_EQ(split.counts.constant_times, 1u);
}

TEST(LineSplit, OfNothingIsNothing) {
  BinSet set;
  EXPECT_TRUE(split_lines(set).passes.empty());
}

}  // namespace
}  // namespace cornice::flightlines::test
