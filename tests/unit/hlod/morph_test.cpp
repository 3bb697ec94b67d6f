// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/morph.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/random.h"

namespace cornice::hlod {
namespace {

Metric sample_metric() { return {6, 14, 0.25, Partition::kOctree, 0, 0}; }

Radii by_side(const Metric& metric, double factor) {
  Radii radii;
  for (int l = 0; l < metric.finest_level; ++l) {
    radii.of[static_cast<std::size_t>(l)] = std::llround(factor * metric.side(l));
  }
  return radii;
}

TEST(Morph, GivesTheEndsExactly) {
  for (std::uint64_t i = 0; i < 200'000; ++i) {
    CounterRandom random(1, 0, i);
    const int finer = static_cast<int>(random.bits() % 12);
    const auto limit = static_cast<double>((1 << 29) >> finer);
    const auto own = static_cast<std::int32_t>(random.uniform(-limit, limit));
    const auto parent = static_cast<std::int32_t>(random.uniform(-limit, limit) / 2);
    const auto eye = static_cast<std::int32_t>(random.uniform(-0x1p30, 0x1p30));
    ASSERT_EQ(morph_coordinate(own, parent, eye, 32768, finer), (own << finer) - eye);
    ASSERT_EQ(morph_coordinate(own, parent, eye, 0, finer), (parent << (finer + 1)) - eye);
  }
}

TEST(Morph, IsTheRoundedDownMixInBetween) {
  for (std::uint64_t i = 0; i < 200'000; ++i) {
    CounterRandom random(2, 0, i);
    const int finer = static_cast<int>(random.bits() % 16);
    const auto parent = static_cast<std::int32_t>(random.uniform(-1000.0, 1000.0));
    const auto own = 2 * parent + static_cast<std::int32_t>(random.uniform(-9000.0, 9000.0));
    const auto weight = static_cast<std::int32_t>(random.uniform(0.0, 32768.0));
    const double exact = std::ldexp(2.0 * parent + (own - 2.0 * parent) * weight / 32768.0, finer);
    ASSERT_EQ(morph_coordinate(own, parent, 0, weight, finer), std::floor(exact)) << finer;
  }
}

TEST(Morph, WeightFallsFromStartToEnd) {
  const Metric metric = sample_metric();
  const Radii radii = by_side(metric, 2.5);
  for (int level = 1; level <= metric.finest_level; ++level) {
    const MorphBand m = morph_band(radii, level, metric);
    const auto l = static_cast<std::size_t>(level);
    const auto earliest =
        static_cast<std::int32_t>(radii.of[l] + metric.side(level) + metric.share(level));
    const auto end = static_cast<std::int32_t>(radii.of[l - 1] - 2 * metric.share(level));
    const std::int32_t start = end - std::max(end / 16, metric.side(level) / 8);
    ASSERT_GT(start, earliest) << "nothing is told of the band's own width";
    EXPECT_EQ(morph_weight(0, m), 32768);
    EXPECT_EQ(morph_weight(start, m), 32768);
    EXPECT_EQ(morph_weight(end, m), 0);
    EXPECT_EQ(morph_weight(0x7fffffff, m), 0);
    EXPECT_NEAR(morph_weight(start + (end - start) / 2, m), 16384, 8);
    std::int32_t before = 32768;
    for (std::int32_t d = start - 10; d < end + 10; d += 7) {
      ASSERT_LE(morph_weight(d, m), before);
      before = morph_weight(d, m);
    }
  }
}

TEST(Morph, TakesTheNarrowestAndTheWidestBands) {
  const Metric metric = sample_metric();
  Radii radii;
  radii.of[0] = std::int64_t{1} << 30;
  radii.of[1] = radii.of[0] - metric.gap(1);
  MorphBand m = morph_band(radii, 1, metric);
  EXPECT_EQ(morph_weight(m.end, m), 0);
  EXPECT_EQ(morph_weight(m.end - (metric.side(1) >> 4), m), 32768);
  radii.of[1] = -std::int64_t{metric.gap(1)};
  m = morph_band(radii, 1, metric);
  EXPECT_LE(m.band, 32767);
  EXPECT_EQ(morph_weight(m.end, m), 0);
  // It begins a little before the eye.
  EXPECT_GT(morph_weight(0, m), 32700);
}

TEST(Morph, HoldsEyesThatAreFarAwayOrNowhere) {
  const Lattice lattice{{2'600'000.0, 1'200'000.0, 0.0}, 65'536.0, 10, 14};
  EXPECT_EQ(fine_eye(lattice.origin, lattice), (FinePoint{0, 0, 0}));
  EXPECT_EQ(fine_eye(lattice.origin + Vec3d{1e12, -1e12, std::nan("")}, lattice),
            (FinePoint{1 << 30, -(1 << 30), 0}));
  const double step = lattice.step(lattice.finest_level);
  EXPECT_EQ(fine_eye(lattice.origin + Vec3d{3.5 * step, -0.5 * step, step}, lattice),
            (FinePoint{3, -1, 1}));
}

TEST(Morph, MeasuresColumnsToTheSlab) {
  Metric metric = sample_metric();
  metric.partition = Partition::kQuadtree;
  metric.slab_low = 100, metric.slab_high = 200;
  EXPECT_EQ(slab_distance({0, 0, 150}, metric), 0);
  EXPECT_EQ(slab_distance({0, 0, 90}, metric), 10);
  EXPECT_EQ(slab_distance({0, 0, 230}, metric), 30);
  EXPECT_EQ(eye_distance({3, -4, 1000}, 30, Partition::kQuadtree), 30);
  EXPECT_EQ(eye_distance({3, -4, 1000}, 0, Partition::kOctree), 1000);
}

}  // namespace
}  // namespace cornice::hlod
