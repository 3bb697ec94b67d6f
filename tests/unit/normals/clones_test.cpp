// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cstring>

#include "tests/unit/normals/one_version.h"
#include "tests/unit/normals/shapes.h"

namespace cornice::normals {
namespace {

/// Ground, and a blade on it whose faces have to be told apart.
test::Shape ground_and_blade() {
  test::Shape shape = test::rolling_ground(20000, 40.0);
  test::add_blade(shape, 0.6, 20.0);
  return shape;
}

TEST(Clones, GiveTheSameBitsAsCodeForTheLeastProcessor) {
#if defined(__x86_64__)
  if (!__builtin_cpu_supports("avx2")) GTEST_SKIP() << "this processor has no AVX2 to compare with";
#endif
  const test::Indexed data(ground_and_blade());
  const OrientedNormals fast = orient_normals(data.tree, data.beams(), {});
  const cornice::test::PlainOrientation plain =
      cornice::test::orient_without_clones(data.shape.positions, data.shape.beams);
  ASSERT_EQ(plain.directions.size(), fast.normals.size());
  EXPECT_EQ(std::memcmp(plain.directions.data(), fast.normals.data(),
                        fast.normals.size() * sizeof(Vec3f)),
            0);
  EXPECT_EQ(
      std::memcmp(plain.quality.data(), fast.quality.data(), fast.quality.size() * sizeof(float)),
      0);
  for (std::size_t i = 0; i < plain.settled_by.size(); ++i) {
    ASSERT_EQ(plain.settled_by[i], static_cast<std::uint8_t>(fast.settled_by[i])) << i;
  }
}

}  // namespace
}  // namespace cornice::normals
