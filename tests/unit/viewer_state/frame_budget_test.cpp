// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/scene/frame_budget.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/base/random.h"

namespace cornice::viewer {
namespace {

/// A renderer whose frames take base + slope * detail^power, whose detail follows the share within
/// a third of a second, and whose times are noisy.
struct Renderer {
  double base_ms = 2.0, slope_ms = 60.0, power = 2.0, noise = 0.1, spike_share = 0.02;
  double detail = 1.0;

  double draw(double share, double seconds, CounterRandom& random) {
    detail += (share - detail) * (1.0 - std::exp(-seconds / 0.35));
    double ms = base_ms + slope_ms * std::pow(detail, power);
    ms *= 1.0 + random.uniform(-noise, noise);
    if (random.uniform(0.0, 1.0) < spike_share) ms += 80.0;
    return ms;
  }
};

struct Course {
  std::vector<double> shares, ms;
  int turns = 0;  ///< of the share's direction
};

Course follow(FrameBudget& budget, Renderer& renderer, double seconds, std::uint64_t seed) {
  CounterRandom random(9, seed, 0);
  Course course;
  double direction = 0.0, at = 0.0, step = 1.0 / 60.0;
  while (at < seconds) {
    const double before = budget.share();
    // A display of 60 Hz makes frames wait.
    const double ms = renderer.draw(before, step, random);
    step = std::max(1.0, std::ceil(ms / 16.7)) / 60.0;
    budget.add(ms, step);
    const double change = budget.share() - before;
    if (change * direction < 0.0) ++course.turns;
    if (change != 0.0) direction = change;
    course.shares.push_back(budget.share());
    course.ms.push_back(ms);
    at += step;
  }
  return course;
}

TEST(FrameBudget, LeavesAllDetailWithoutATargetAndWhereThereIsTime) {
  FrameBudget none;
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(none.add(500.0, 0.5), 1.0);
  FrameBudget enough;
  enough.set_target_ms(33.0);
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(enough.add(20.0, 0.016), 1.0);
}

TEST(FrameBudget, ComesToItsTargetAndStaysThereWhateverTheRendererIsLike) {
  std::uint64_t seed = 0;
  for (const double power : {0.7, 1.0, 2.0, 3.0})
    for (const double slope : {20.0, 60.0, 400.0})
      for (const double base : {0.5, 5.0}) {
        FrameBudget budget;
        budget.set_target_ms(16.0);
        Renderer renderer{base, slope, power};
        follow(budget, renderer, 30.0, ++seed);
        const Course later = follow(budget, renderer, 60.0, ++seed);
        EXPECT_LE(later.turns, 2) << "swings; power " << power << " slope " << slope;
        const double ms = base + slope * std::pow(budget.share(), power);
        if (budget.share() > FrameBudget::kLeast) {
          EXPECT_LE(ms, 16.0 * 1.1) << power << " " << slope << " " << base;
        }
        if (budget.share() < 1.0) {
          EXPECT_GE(ms, 16.0 * 0.65) << power << " " << slope << " " << base;
        }
      }
}

TEST(FrameBudget, AnswersFramesThatAreFarTooLongWithinThreeSeconds) {
  FrameBudget budget;
  budget.set_target_ms(16.0);
  Renderer renderer{1.0, 150.0, 2.0, 0.05, 0.0};
  const Course first = follow(budget, renderer, 3.0, 1);
  EXPECT_LE(first.ms.back(), 2.0 * 16.0);
}

TEST(FrameBudget, GivesDetailBackWhenTheSceneBecomesEasy) {
  FrameBudget budget;
  budget.set_target_ms(16.0);
  Renderer heavy{1.0, 100.0, 2.0};
  follow(budget, heavy, 20.0, 1);
  const double low = budget.share();
  EXPECT_LT(low, 0.5);
  Renderer light{1.0, 5.0, 2.0};
  light.detail = heavy.detail;
  follow(budget, light, 25.0, 2);
  EXPECT_EQ(budget.share(), 1.0);
}

TEST(FrameBudget, DoesNotHeedSingleLongFrames) {
  FrameBudget budget;
  budget.set_target_ms(16.0);
  for (int i = 0; i < 2000; ++i) {
    budget.add(i % 12 == 0 ? 200.0 : 10.0, 0.0167);
    ASSERT_EQ(budget.share(), 1.0) << "frame " << i;
  }
}

TEST(FrameBudget, GoesNoLowerThanItsLeastAndForgetsAllWithoutTarget) {
  FrameBudget budget;
  budget.set_target_ms(1.0);
  for (int i = 0; i < 1000; ++i) budget.add(1000.0, 1.0);
  EXPECT_EQ(budget.share(), FrameBudget::kLeast);
  budget.set_target_ms(0.0);
  EXPECT_EQ(budget.share(), 1.0);
}

}  // namespace
}  // namespace cornice::viewer
