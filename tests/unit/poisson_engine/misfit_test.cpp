// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/poisson/misfit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/random.h"
#include "stages/poisson/density.h"

namespace cornice::poisson {
namespace {

constexpr double kSideM = 24.0, kStepM = 0.5;

/// Flat ground with 20 points/m², and its samples on the levels that a misfit needs.
std::vector<SampleLevel> flat_samples() {
  OrientedPoints points;
  Box3d domain;
  for (std::size_t i = 0; i < static_cast<std::size_t>(20.0 * kSideM * kSideM); ++i) {
    CounterRandom random(3, 0, i);
    points.positions.push_back(
        Vec3d{random.uniform(0, kSideM), random.uniform(0, kSideM), 0.25 + 0.03 * random.normal()}
            .cast<float>());
    points.normals.push_back({0, 0, 1});
    points.quality.push_back(1.0f);
    domain.add(points.positions.back().cast<double>());
  }
  LeftOut left_out;
  std::vector<SampleLevel> samples{gather_samples(points, domain, kStepM, 1, left_out)};
  while (samples.size() < 4) samples.push_back(coarser_samples(samples.back(), 1));
  estimate_density(samples, 0.25, 1);
  return samples;
}

/// The mean of pull over area of samples with x in [low, high), counted in finest cells.
double mean_pull(const SampleLevel& level, int low, int high) {
  double sum = 0.0, count = 0.0;
  for (std::size_t b = 0; b < level.bricks.size(); ++b) {
    for (std::uint64_t i = level.first[b]; i < level.first[b + 1]; ++i) {
      const Sample& s = level.samples[i];
      const int x = kBrickSide * level.bricks[b].x + (s.cell & 7);
      if (x < low || x >= high) continue;
      sum += static_cast<double>(s.pull / s.area), count += 1.0;
    }
  }
  return sum / count;
}

/// What a field would miss the samples by: `wave` of the place in metres, and noise.
template <class Wave>
std::vector<float> misses(const SampleLevel& level, Wave wave) {
  std::vector<float> fields;
  for (std::size_t b = 0; b < level.bricks.size(); ++b) {
    for (std::uint64_t i = level.first[b]; i < level.first[b + 1]; ++i) {
      CounterRandom random(5, 0, i);
      const Sample& s = level.samples[i];
      const double x = kStepM * (kBrickSide * level.bricks[b].x + (s.cell & 7));
      const double y = kStepM * (kBrickSide * level.bricks[b].y + (s.cell >> 3 & 7));
      fields.push_back(static_cast<float>(0.02 * random.normal() + wave(x, y)));
    }
  }
  return fields;
}

TEST(LoosenPull, LetsGoOfGroundWhoseSamplesAreMissedEachByItself) {
  std::vector<SampleLevel> samples = flat_samples();
  EXPECT_GT(mean_pull(samples[0], 0, 48), 0.99);
  loosen_pull(samples, misses(samples[0], [](double, double) { return 0.0; }), 1);
  EXPECT_LT(mean_pull(samples[0], 0, 48), 1.3 * static_cast<double>(kLoosePull));
}

TEST(LoosenPull, KeepsHoldOfGroundWhoseNeighboursAreMissedAlike) {
  std::vector<SampleLevel> samples = flat_samples();
  const double before = mean_pull(samples[0], 0, 48);
  loosen_pull(
      samples,
      misses(samples[0],
             [](double x, double y) { return 0.06 * std::sin(1.2 * x) * std::cos(1.0 * y); }),
      1);
  EXPECT_GT(mean_pull(samples[0], 0, 48), 0.9 * before);
}

TEST(LoosenPull, DecidesByWhatIsWithinAFewMetres) {
  std::vector<SampleLevel> samples = flat_samples();
  loosen_pull(samples,
              misses(samples[0],
                     [](double x, double y) {
                       return x < 12.0 ? 0.06 * std::sin(1.2 * x) * std::cos(1.0 * y) : 0.0;
                     }),
              1);
  EXPECT_GT(mean_pull(samples[0], 0, 16), 0.9);
  EXPECT_LT(mean_pull(samples[0], 40, 48), 1.5 * static_cast<double>(kLoosePull));
}

TEST(LoosenPull, FindsTheSameWhateverElseIsFarAway) {
  std::vector<SampleLevel> one = flat_samples(), other = flat_samples();
  const std::vector<float> fields = misses(one[0], [](double, double) { return 0.0; });
  std::vector<float> changed = fields;
  std::size_t i = 0;
  for (std::size_t b = 0; b < one[0].bricks.size(); ++b) {
    for (; i < one[0].first[b + 1]; ++i) {
      if (one[0].bricks[b].x == 0) changed[i] = 1.0f;
    }
  }
  loosen_pull(one, fields, 1);
  loosen_pull(other, changed, 2);
  std::size_t same = 0, touched = 0;
  for (std::size_t b = 0; b < one[0].bricks.size(); ++b) {
    for (std::uint64_t s = one[0].first[b]; s < one[0].first[b + 1]; ++s) {
      const bool equal = one[0].samples[s].pull == other[0].samples[s].pull;
      // Nearer than 8 + 16 finest cells from the border lie the samples that may tell.
      EXPECT_TRUE(equal || one[0].bricks[b].x < 3);
      same += equal, touched += !equal;
    }
  }
  EXPECT_GT(same, 0u);
  EXPECT_GT(touched, 0u);
}

TEST(LoosenPull, LetsGoOfGroundThatIsHitExactly) {
  std::vector<SampleLevel> samples = flat_samples();
  loosen_pull(samples, std::vector<float>(samples[0].samples.size(), 0.0f), 1);
  EXPECT_NEAR(mean_pull(samples[0], 0, 48), static_cast<double>(kLoosePull), 1e-3);
}

}  // namespace
}  // namespace cornice::poisson
