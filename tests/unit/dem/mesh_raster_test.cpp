// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/dem/mesh_raster.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/base/error.h"

namespace cornice::dem {
namespace {

using testing::HasSubstr;

std::string problem_of(const std::vector<MeshPlace>& meshes, double step) {
  try {
    grid_around(meshes, step);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(GridAround, CoversAllMeshesOnMultiplesOfItsStep) {
  const RasterGrid grid =
      grid_around({{"a", {0.5, 10.5, 3.5, 12.0}}, {"b", {6.0, 9.0, 7.9, 11.0}}}, 2.0);
  EXPECT_EQ(grid.west, 0.0);
  EXPECT_EQ(grid.north, 12.0);
  EXPECT_EQ(grid.width, 4);
  EXPECT_EQ(grid.height, 2);
}

TEST(GridAround, SaysHowManyPixelsItWouldHaveHoweverFarAVertexLies) {
  const MeshPlace near{"a", {2600000.0, 1200000.0, 2601000.0, 1201000.0}};
  EXPECT_THAT(problem_of({near}, 1e-5), HasSubstr("would have 1e+08 x 1e+08 pixels"));
  EXPECT_THAT(problem_of({near, {"b", {1e30, 1200000.0, 1e30, 1200001.0}}}, 1.0),
              HasSubstr("would have 1e+30 x 1000 pixels, from 2600000, 1200000 to 1e+30, 1201000"));
}

}  // namespace
}  // namespace cornice::dem
