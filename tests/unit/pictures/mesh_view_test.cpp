// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/pictures/mesh_view.h"

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace cornice::pictures {
namespace {

constexpr View kPlan{0.0, 90.0, 100};

/// A horizontal square of side 10 at (x, 0, z); counter-clockwise from above.
Mesh square(float x, float z) {
  Mesh mesh;
  mesh.positions = {{x, 0, z}, {x + 10, 0, z}, {x + 10, 10, z}, {x, 10, z}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

std::array<std::uint8_t, 3> middle_of(const Picture& picture) {
  return picture.pixels.at(static_cast<std::size_t>(picture.height / 2) * picture.width +
                           picture.width / 2);
}

TEST(MeshView, FillsTheTrianglesAndLeavesTheRestWhite) {
  const Picture picture = mesh_picture({square(0, 0)}, kPlan, MeshColour::kRelief);
  EXPECT_EQ(picture.width, 100);
  EXPECT_NEAR(picture.height, 100, 2);
  EXPECT_NE(middle_of(picture), (std::array<std::uint8_t, 3>{255, 255, 255}));
  EXPECT_EQ(picture.pixels.front(), (std::array<std::uint8_t, 3>{255, 255, 255}));
}

TEST(MeshView, ShowsWhatIsNearerToTheViewer) {
  Mesh high = square(0, 5);
  high.float_properties.push_back({"support", std::vector<float>(4, 20.0f)});
  const Mesh low = square(0, 0);
  for (const auto& meshes : {std::vector{high, low}, std::vector{low, high}}) {
    const auto pixel = middle_of(mesh_picture(meshes, kPlan, MeshColour::kSupport));
    EXPECT_GT(pixel[0], 2 * pixel[1]) << "the upper square is red by its support";
  }
}

TEST(MeshView, TintsATriangleThatIsTurnedOver) {
  Mesh mesh = square(0, 0);
  for (auto& triangle : mesh.triangles) std::swap(triangle[0], triangle[1]);
  const auto pixel = middle_of(mesh_picture({mesh}, kPlan, MeshColour::kRelief));
  EXPECT_GT(pixel[0], 2 * pixel[1]);
}

TEST(MeshView, LightsSlopesThatFaceNorthWestMore) {
  const auto brightness = [](Vec3f normal) {
    Mesh mesh = square(0, 0);
    mesh.normals.assign(4, normalized(normal));
    return static_cast<int>(middle_of(mesh_picture({mesh}, kPlan, MeshColour::kRelief))[1]);
  };
  EXPECT_GT(brightness({-1, 1, 1}), brightness({0, 0, 1}));
  EXPECT_GT(brightness({0, 0, 1}), brightness({1, -1, 1}));
}

TEST(MeshView, PlacesTilesByTheirOrigins) {
  Mesh east = square(0, 0);
  east.origin = {2600010.0, 1200000.0, 0.0};
  Mesh west = square(0, 0);
  west.origin = {2600000.0, 1200000.0, 0.0};
  const Picture picture = mesh_picture({west, east}, kPlan, MeshColour::kRelief);
  EXPECT_NEAR(picture.height, picture.width / 2, 6);
}

TEST(MeshView, ShowsALongStripFromSouthToNorthWithinABoundedHeight) {
  std::vector<Mesh> strip;
  for (int i = 0; i < 30; ++i) {
    strip.push_back(square(0, 0));
    strip.back().origin = {2600000.0, 1200000.0 + 10.0 * i, 0.0};
  }
  const Picture picture = mesh_picture(strip, kPlan, MeshColour::kRelief);
  EXPECT_EQ(picture.width, 100);
  EXPECT_NEAR(picture.height, kMostHeight * picture.width, 2);
  // All of it, in the middle: a thirtieth as wide as high.
  const auto is_drawn = [&](int x, int y) {
    return picture.pixels.at(static_cast<std::size_t>(y) * picture.width + x) !=
           std::array<std::uint8_t, 3>{255, 255, 255};
  };
  for (const int y : {8, 75, 141}) {
    EXPECT_TRUE(is_drawn(50, y)) << y;
    EXPECT_FALSE(is_drawn(40, y)) << y;
    EXPECT_FALSE(is_drawn(60, y)) << y;
  }
}

TEST(MeshView, RefusesMeshesWithoutTriangles) {
  EXPECT_THROW(mesh_picture({Mesh{}}, kPlan, MeshColour::kRelief), UsageError);
}

TEST(MeshView, GivesSupportAColourThatGrowsRedder) {
  EXPECT_EQ(support_colour(0.0f), support_colour(0.5f));
  EXPECT_GT(support_colour(1.0f)[1], support_colour(5.0f)[1]);
  EXPECT_EQ(support_colour(10.0f), support_colour(1000.0f));
}

}  // namespace
}  // namespace cornice::pictures
