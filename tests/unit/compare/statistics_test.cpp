// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/compare/statistics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/random.h"

namespace cornice::compare {
namespace {

TEST(Distribution, AgreesWithSortingTheValues) {
  Distribution distribution(25.0, {0.1, 0.5});
  std::vector<double> values;
  for (std::uint64_t i = 0; i < 20001; ++i) {
    CounterRandom random(4, 0, i);
    values.push_back(0.3 + 0.2 * random.normal() + (i % 100 == 0 ? 6.0 : 0.0));
    distribution.add(values.back());
  }
  for (int i = 0; i < 5000; ++i) distribution.add_missing();
  const Summary s = distribution.summary();
  double sum = 0.0, squares = 0.0;
  std::size_t within = 0;
  for (const double v : values) {
    sum += v, squares += v * v;
    if (std::abs(v) <= 0.1) ++within;
  }
  std::sort(values.begin(), values.end());
  constexpr double kBin = 0.001;
  EXPECT_NEAR(s.mean, sum / 20001.0, 1e-9);
  EXPECT_NEAR(s.rms, std::sqrt(squares / 20001.0), 1e-9);
  EXPECT_NEAR(s.median, values[10000], kBin);
  EXPECT_NEAR(s.percentiles[1], values[1000], kBin);
  EXPECT_NEAR(s.percentiles[7], values[19000], kBin);
  EXPECT_DOUBLE_EQ(s.lowest, values.front());
  EXPECT_DOUBLE_EQ(s.highest, values.back());
  EXPECT_DOUBLE_EQ(s.completeness[0], static_cast<double>(within) / 25001.0);
  const double median = values[10000];
  for (double& v : values) v = std::abs(v - median);
  std::sort(values.begin(), values.end());
  EXPECT_NEAR(s.nmad, 1.4826 * values[10000], 3.0 * kBin);
}

TEST(Distribution, WithoutValuesHasNoMeanButKnowsWhatIsMissing) {
  Distribution distribution(25.0, {1.0});
  distribution.add_missing();
  const Summary s = distribution.summary();
  EXPECT_EQ(s.count, 0u);
  EXPECT_EQ(s.missing, 1u);
  EXPECT_EQ(s.rms, 0.0);
  EXPECT_EQ(s.completeness[0], 0.0);
}

TEST(Places, AreToldApartBySlopeAspectCurvatureAndOverhang) {
  const auto slope = [](double deg, double azimuth_deg) {
    const double r = deg * M_PI / 180.0, a = azimuth_deg * M_PI / 180.0;
    return place_of(
        Vec3d{std::sin(r) * std::sin(a), std::sin(r) * std::cos(a), std::cos(r)}.cast<float>(),
        0.0f, false);
  };
  const auto name = [](Grouping grouping, std::uint8_t code) {
    return group_names(grouping)[code];
  };
  EXPECT_EQ(name(Grouping::kSlope, slope(3, 0).slope), "0-15");
  EXPECT_EQ(name(Grouping::kSlope, slope(40, 0).slope), "30-45");
  EXPECT_EQ(name(Grouping::kSlope, slope(89, 0).slope), "75-90");
  EXPECT_EQ(name(Grouping::kSlope, slope(91, 0).slope), "over 90");
  EXPECT_EQ(name(Grouping::kSlope, slope(180, 0).slope), "over 90");
  EXPECT_EQ(name(Grouping::kAspect, slope(3, 90).aspect), "flat");
  EXPECT_EQ(name(Grouping::kAspect, slope(30, 350).aspect), "N");
  EXPECT_EQ(name(Grouping::kAspect, slope(30, 90).aspect), "E");
  EXPECT_EQ(name(Grouping::kAspect, slope(30, 225).aspect), "SW");
  EXPECT_EQ(name(Grouping::kCurvature, place_of({0, 0, 1}, -0.5f, false).curvature), "hollow");
  EXPECT_EQ(name(Grouping::kCurvature, place_of({0, 0, 1}, 0.5f, false).curvature), "crest");
  EXPECT_EQ(name(Grouping::kOverhang, place_of({0, 0, -1}, 0.0f, true).overhang), "yes");
}

TEST(Statistics, PutsEveryValueIntoOneGroupOfEachKind) {
  Statistics statistics(25.0, {1.0});
  statistics.add(place_of({0, 0, 1}, 0.0f, false), 0.5);
  statistics.add(place_of({0, 1, 0}, 0.5f, true), -0.25);
  statistics.add_missing(place_of({0, 1, 0}, 0.5f, true));
  for (const Grouping grouping : kGroupings) {
    std::uint64_t count = 0, missing = 0;
    for (std::size_t i = 0; i < group_names(grouping).size(); ++i) {
      count += statistics.group(grouping, i).count();
      missing += statistics.group(grouping, i).missing();
    }
    EXPECT_EQ(count, 2u) << grouping_name(grouping);
    EXPECT_EQ(missing, 1u) << grouping_name(grouping);
  }
  EXPECT_DOUBLE_EQ(statistics.group(Grouping::kOverhang, 1).summary().mean, -0.25);
}

}  // namespace
}  // namespace cornice::compare
