// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "core/base/error.h"
#include "tests/property/poisson_band/seams.h"
#include "tests/property/poisson_extract/fields.h"

namespace cornice {
namespace {

using namespace cornice::test;

constexpr std::int32_t kRamp = 8;

/// Bricks that cover a tile and what is around it.
BrickBox around(const LatticeBox& tile, int z0, int z1) {
  const LatticeBox wide = tile.grown(3 * kRamp);
  return {{wide.x0 >> 3, wide.y0 >> 3, z0}, {wide.x1 >> 3, wide.y1 >> 3, z1}};
}

/// A ground that leans over itself: its upper part stands several steps out over its foot.
float overhang(double x, double y, double z) {
  const double wall = x - 30.0 - 6.0 * std::tanh((z - 8.0) / 3.0) + 3.0 * std::sin(0.2 * y);
  const double ground = std::max(z - 16.0 - 0.05 * y, std::min(z - 1.0, -wall));
  return static_cast<float>(ground);
}

/// Every tile's own view of a survey: one truth, and an error of its own.
std::vector<TileField> survey(const std::vector<LatticeBox>& tiles, const Function& truth,
                              double error, const std::vector<int>& levels = {}) {
  std::vector<TileField> fields;
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    const Function own_error = smooth_noise(100 + t, 9.0, 6);
    const Function own = [&](double x, double y, double z) {
      return truth(x, y, z) + static_cast<float>(error) * own_error(x, y, z);
    };
    const int count = levels.empty() ? 1 : levels[t];
    fields.push_back({sampled_adaptively(own, around(tiles[t], -2, 4), count,
                                         [](int, BrickKey) { return false; }),
                      tiles[t], kRamp, "EPSG:2056", false});
  }
  return fields;
}

void expect_seamless(const std::vector<TileField>& fields) {
  const std::vector<Surface> surfaces = extract_all(fields);
  std::vector<LatticeBox> tiles;
  for (std::size_t t = 0; t < fields.size(); ++t) {
    tiles.push_back(fields[t].tile);
    EXPECT_GT(surfaces[t].mesh.triangles.size(), 100u);
    expect_sound(surfaces[t], fields[t].field.lattice(), fields[t].tile);
  }
  const JoinedTiles joined = join_tiles(surfaces, tiles, fields[0].field.lattice());
  EXPECT_EQ(joined.open_edges, 0u);
  EXPECT_EQ(joined.mismatched, 0u);
  EXPECT_EQ(joined.turned, 0u);
  EXPECT_EQ(joined.non_manifold, 0u);
}

std::vector<LatticeBox> grid(int columns, int rows, int width, int depth) {
  std::vector<LatticeBox> tiles;
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      tiles.push_back({c * width, r * depth, (c + 1) * width, (r + 1) * depth});
    }
  }
  return tiles;
}

TEST(Band, FourTilesWithDifferentErrorsMeetBitForBitCornerIncluded) {
  // 37 and 29 nodes: no border lies on a plane of bricks.
  expect_seamless(survey(grid(2, 2, 37, 29), overhang, 0.3));
}

TEST(Band, NineTilesMeet) { expect_seamless(survey(grid(3, 3, 21, 25), overhang, 0.5)); }

TEST(Band, TilesNarrowerThanTheRampMeet) {
  expect_seamless(survey(grid(5, 2, 6, 40), overhang, 0.3));
}

TEST(Band, AHoleInTheSurveyIsAnEdgeForAllItsNeighbours) {
  std::vector<LatticeBox> tiles = grid(3, 3, 21, 24);
  tiles.erase(tiles.begin() + 4);
  expect_seamless(survey(tiles, overhang, 0.4));
}

TEST(Band, TilesOfDifferentSizesMeetWhereACornerTouchesASide) {
  expect_seamless(
      survey({{0, 0, 30, 60}, {30, 0, 70, 23}, {30, 23, 52, 60}, {52, 23, 70, 60}}, overhang, 0.4));
}

TEST(Band, ABorderThroughAnOverhangIsMetWhateverItsDirection) {
  expect_seamless(survey({{0, 0, 31, 40}, {31, 0, 60, 40}}, overhang, 0.2));
  expect_seamless(survey({{0, 0, 60, 21}, {0, 21, 60, 40}}, overhang, 0.2));
}

TEST(Band, ACoarseTileMeetsAFineOne) {
  expect_seamless(survey(grid(2, 2, 37, 29), overhang, 0.3, {1, 4, 3, 2}));
}

TEST(Band, WhiteNoiseThatDiffersInEachTileStillMeets) {
  const std::vector<LatticeBox> tiles = grid(2, 2, 22, 19);
  std::vector<TileField> fields;
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    const Function noise = white_noise(7 + t);
    const Function capped = [&](double x, double y, double z) {
      return z > 20 ? 1.0f : z < -4 ? -1.0f : noise(x, y, z);
    };
    fields.push_back({sampled(capped, around(tiles[t], -2, 4)), tiles[t], kRamp, "", false});
  }
  expect_seamless(fields);
}

TEST(Band, TilesThatAgreeGiveTheSurfaceOfOnePiece) {
  const std::vector<LatticeBox> tiles = grid(2, 2, 37, 29);
  const std::vector<TileField> fields = survey(tiles, overhang, 0.0);
  const LatticeBox all{0, 0, 74, 58};
  const Field whole = sampled(overhang, around(all, -2, 4));
  ExtractOptions options = window_options(all);
  options.weld = ExtractOptions{}.weld;
  options.borders = tiles;
  const Surface piece = extract_surface(FieldValues(whole), whole.lattice(), options);
  const JoinedTiles joined = join_tiles(extract_all(fields), tiles, whole.lattice());
  EXPECT_EQ(joined.mesh.positions.size(), piece.mesh.positions.size());
  EXPECT_EQ(joined.mesh.triangles.size(), piece.mesh.triangles.size());
}

TEST(Band, TheOrderOfNeighboursAndTheNumberOfThreadsChangeNoByte) {
  std::vector<TileField> fields = survey(grid(2, 2, 37, 29), overhang, 0.3);
  const Surface first = extract_all(fields, 1)[0];
  std::swap(fields[1], fields[3]);
  const Surface second = extract_all(fields, 2)[0];
  EXPECT_EQ(first.mesh.positions, second.mesh.positions);
  EXPECT_EQ(first.mesh.normals, second.mesh.normals);
  EXPECT_EQ(first.mesh.triangles, second.mesh.triangles);
}

TEST(Band, ABandHoldsWhatNeighboursReadAndNotTheMiddle) {
  const LatticeBox tile{-50, 13, 131, 170};
  const Function noise = smooth_noise(4, 14.0);
  const Field field = sampled_adaptively(noise, around(tile, -2, 2), 4, [](int level, BrickKey b) {
    return (b.x * 7 + b.y * 3 + b.z * 5 + level) % 3 != 0;
  });
  const TileField whole{field, tile, kRamp, "", false};
  const TileField band = make_band(whole);
  EXPECT_LT(band.field.levels()[0].bricks.size(), field.levels()[0].bricks.size() * 3 / 4);
  const LatticeBox outer = tile.grown(kRamp + 2);
  std::size_t compared = 0;
  for (int x = outer.x0 >> 3; x <= outer.x1 >> 3; ++x) {
    for (int y = outer.y0 >> 3; y <= outer.y1 >> 3; ++y) {
      const bool inside = 8 * x > tile.x0 + kRamp + 2 && 8 * x + 7 < tile.x1 - kRamp - 2 &&
                          8 * y > tile.y0 + kRamp + 2 && 8 * y + 7 < tile.y1 - kRamp - 2;
      if (inside) continue;
      for (int z = -2; z <= 2; ++z) {
        std::array<float, kClosedBrickNodes> from_field, from_band;
        ASSERT_EQ(field.closed_brick(0, {x, y, z}, from_field),
                  band.field.closed_brick(0, {x, y, z}, from_band));
        ASSERT_EQ(from_field, from_band) << x << " " << y << " " << z;
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 500u);
}

TEST(Band, TilesThatCannotGoTogetherAreRefusedByName) {
  const std::vector<TileField> fields = survey(grid(2, 1, 37, 29), overhang, 0.0);
  const std::vector<std::string> names{"a.field", "b.band"};
  const auto message_with = [&](const TileField& other) {
    try {
      BlendedValues(fields[0], std::span(&other, 1), names);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  TileField other = make_band(fields[1]);
  EXPECT_EQ(message_with(other), "");
  other.tile.x0 -= 1;
  EXPECT_NE(message_with(other).find("b.band: covers"), std::string::npos);
  EXPECT_NE(message_with(other).find("overlaps a.field"), std::string::npos);
  other = make_band(fields[1]);
  other.ramp = 9;
  EXPECT_NE(message_with(other).find("band"), std::string::npos);
  other = make_band(fields[1]);
  other.crs_text = "EPSG:2154";
  EXPECT_NE(message_with(other).find("EPSG:2154"), std::string::npos);
  other = make_band(fields[1]);
  other.field = Field({0.25}, {});
  EXPECT_NE(message_with(other).find("0.25"), std::string::npos);
}

TEST(LatticeBoxOf, NeighboursGetTheSamePlaneAndThinTilesAreRefused) {
  const Lattice lattice{0.5};
  const LatticeBox west = lattice_box({885022.4, 629157.2, 885264.1, 629400.0}, lattice);
  const LatticeBox east = lattice_box({885264.1, 629157.2, 885300.0, 629400.0}, lattice);
  EXPECT_EQ(west.x1, east.x0);
  EXPECT_EQ(west.x1, 1770528);
  EXPECT_THROW(lattice_box({0, 0, 0.2, 10}, lattice), UsageError);
  EXPECT_THROW(lattice_box({0, 0, 1e12, 10}, lattice), UsageError);
}

}  // namespace
}  // namespace cornice
