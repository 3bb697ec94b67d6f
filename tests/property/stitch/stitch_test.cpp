// SPDX-License-Identifier: GPL-3.0-or-later
// Tiles cut from known surfaces, stitched, and looked at with nothing of the stage itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <string>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/io/ply.h"
#include "core/mesh/quality.h"
#include "core/mesh/surface_distance.h"
#include "stages/stitch/survey.h"
#include "tests/property/stitch/tiles.h"
#include "tests/support/meshes.h"
#include "tests/support/temporary_folder.h"

namespace cornice::stitch {
namespace {

namespace fs = std::filesystem;
using test::CutPlan;

struct Outcome {
  std::vector<Mesh> before, after;  ///< by number of the tile
  StitchResult result;
};

Outcome stitch_tiles(const std::vector<Mesh>& tiles, Options options = {}, bool reversed = false) {
  const test::TemporaryFolder folder;
  std::vector<fs::path> paths = test::write_tiles(folder.path(), tiles);
  if (reversed) std::reverse(paths.begin(), paths.end());
  Outcome run;
  run.before = tiles;
  run.after.resize(tiles.size());
  const Survey survey = learn_survey(paths, options);
  run.result = stitch_survey(survey, options, [&](const fs::path& path, EditedTile& tile) {
    run.after[std::stoul(path.stem().string().substr(1))] = std::move(tile.mesh);
  });
  return run;
}

/// One surface with one outline, and one round each hole: no open edge elsewhere, no T-vertex, no
/// mismatched vertex.
void expect_one_surface(const Outcome& run, std::size_t holes = 0) {
  const test::Welded all = test::weld(run.after);
  const TopologyReport topology = check_topology(all.triangles, all.positions.size(), 1);
  EXPECT_TRUE(topology.is_manifold())
      << topology.non_manifold_edges << " edges, " << topology.non_manifold_vertices
      << " vertices, " << topology.degenerate_triangles << " degenerate, "
      << topology.duplicate_triangles << " duplicate";
  EXPECT_EQ(topology.components, 1u);
  const auto twins = match_half_edges(all.triangles, all.positions.size(), 1);
  EXPECT_EQ(border_loops(all.triangles, twins, all.positions.size()).size(), 1 + holes);
  const SeamReport& seams = run.result.seams;
  EXPECT_EQ(seams.faults(), 0u) << seams.open_edges << " open, " << seams.t_vertices << " T, "
                                << seams.mismatched_vertices << " mismatched, "
                                << seams.non_manifold_edges << " non-manifold, "
                                << seams.turned_triangles << " turned, "
                                << seams.degenerate_triangles << " degenerate";
}

Vec3d facing(const Mesh& m, const Triangle& t) {
  const Vec3d a = m.positions[t[0]].cast<double>();
  return cross(m.positions[t[1]].cast<double>() - a, m.positions[t[2]].cast<double>() - a);
}

/// Moved by no more than the tolerance, and not at all where no triangle touches the border.
void expect_little_changed(const Outcome& run, double tolerance_m) {
  for (std::size_t i = 0; i < run.before.size(); ++i) {
    const Mesh& before = run.before[i];
    const Mesh& after = run.after[i];
    const TriangleTree from(before.positions, before.triangles, 1);
    const TriangleTree to(after.positions, after.triangles, 1);
    ASSERT_EQ(before.origin, after.origin);
    EXPECT_LE(measure_distance(from, to, 0.1f, 1).hausdorff_m(), tolerance_m + 1e-3)
        << "tile " << i;
    const auto border = border_vertices(
        before.triangles, match_half_edges(before.triangles, before.positions.size(), 1),
        before.positions.size());
    std::size_t inner = 0;
    for (std::size_t v = 0; v < border.size(); ++v) {
      if (border[v] != 0) continue;
      ++inner;
      EXPECT_TRUE(std::find(after.positions.begin(), after.positions.end(), before.positions[v]) !=
                  after.positions.end());
    }
    EXPECT_GT(inner, 0u);
  }
}

void expect_nothing_folded(const Outcome& run) {
  for (const Mesh& tile : run.after) {
    for (const Triangle& t : tile.triangles) {
      Vec3d mean{};
      for (const std::uint32_t v : t) mean += tile.normals[v].cast<double>();
      EXPECT_GT(dot(facing(tile, t), mean), 0.0);
    }
  }
}

void expect_stitched(const CutPlan& plan, double tolerance_m = 0.25) {
  Options options;
  options.tolerance_m = tolerance_m;
  const Outcome run = stitch_tiles(test::cut_tiles(plan), options);
  expect_one_surface(run);
  expect_little_changed(run, tolerance_m);
  expect_nothing_folded(run);
}

TEST(Stitch, LeavesTilesThatMeetWhereTheyAre) {
  CutPlan plan;
  plan.columns = 3, plan.rows = 3;
  const Outcome run = stitch_tiles(test::cut_tiles(plan));
  expect_one_surface(run);
  for (std::size_t i = 0; i < run.before.size(); ++i) {
    EXPECT_EQ(run.before[i].positions, run.after[i].positions);
    EXPECT_EQ(run.before[i].triangles, run.after[i].triangles);
  }
  EXPECT_EQ(run.result.plan.moved_vertices, 0u);
}

TEST(Stitch, GivesSharedVerticesOneNormalAndOneValue) {
  const Outcome run = stitch_tiles(test::cut_tiles(CutPlan{}));
  struct Values {
    Vec3f normal;
    float support;
    std::uint8_t source;
    bool operator==(const Values&) const = default;
  };
  std::map<std::tuple<double, double, double>, Values> known;
  std::size_t shared = 0;
  for (const Mesh& tile : run.after) {
    for (std::size_t v = 0; v < tile.positions.size(); ++v) {
      const Vec3d p = tile.origin + tile.positions[v].cast<double>();
      const Values values{tile.normals[v], tile.float_properties[0].values[v],
                          tile.byte_properties[0].values[v]};
      const auto [place, is_new] = known.emplace(std::tuple{p.x, p.y, p.z}, values);
      if (is_new) continue;
      ++shared;
      EXPECT_EQ(place->second, values);
    }
  }
  EXPECT_EQ(shared, 4u * 16u + 3u);
  // Between tile 1 and tile 2 of the lower row, whose supports are 1 and 2.
  EXPECT_EQ(run.after[0].float_properties[0].values[16], 1.5f);
  // The sources are 0 and 2: a code has no mean.
  EXPECT_EQ(run.after[0].byte_properties[0].values[16], 2);
}

TEST(Stitch, JoinsShiftedBorders) {
  for (const double jitter : {1e-4, 0.003, 0.02, 0.05}) {
    SCOPED_TRACE(jitter);
    CutPlan plan;
    plan.jitter_m = jitter;
    plan.columns = 3, plan.rows = 2;
    expect_stitched(plan);
  }
}

TEST(Stitch, JoinsTilesOfDifferentResolution) {
  CutPlan plan;
  plan.cells = [](int column, int row) { return 12 + 7 * column + 5 * row; };
  expect_stitched(plan);
}

TEST(Stitch, JoinsShiftedBordersOfDifferentResolution) {
  CutPlan plan;
  plan.columns = 3, plan.rows = 3;
  plan.jitter_m = 0.02;
  plan.cells = [](int column, int row) { return (column + row) % 2 == 0 ? 10 : 25; };
  expect_stitched(plan);
}

TEST(Stitch, JoinsAnyMixtureOfShiftsAndResolutions) {
  const char* seeds = std::getenv("SEEDS");
  for (std::uint64_t seed = 0; seed < (seeds ? std::stoul(seeds) : 12u); ++seed) {
    SCOPED_TRACE(seed);
    CounterRandom random(seed, 77, 0);
    CutPlan plan;
    plan.seed = seed;
    plan.columns = 1 + static_cast<int>(random.bits() % 3);
    plan.rows = 2;
    plan.surface = random.bits() % 2 == 0 ? test::hills : test::leaning_wall;
    plan.jitter_m = 0.05 * random.uniform();
    const std::uint64_t kind = random.bits();
    plan.cells = [=](int column, int row) {
      return 10 +
             static_cast<int>(mix64(kind + static_cast<std::uint64_t>(10 * column + row)) % 16);
    };
    expect_stitched(plan);
  }
}

TEST(Stitch, JoinsShiftedBordersThatBend) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    SCOPED_TRACE(seed);
    CutPlan plan;
    plan.seed = seed;
    plan.surface = test::rough_hills;
    plan.jitter_m = 0.05;
    plan.cells = [](int, int) { return 20; };
    const Outcome run = stitch_tiles(test::cut_tiles(plan));
    expect_one_surface(run);
    expect_little_changed(run, 0.25);
  }
}

TEST(Stitch, AgreesOnCornersThatFourTilesPlaceDifferently) {
  CutPlan plan;
  plan.jitter_m = 0.05;
  plan.only_corners = true;
  plan.columns = 3, plan.rows = 3;
  expect_stitched(plan);
}

TEST(Stitch, JoinsBordersThroughAWallThatLeansOver) {
  for (const double jitter : {0.0, 0.03}) {
    SCOPED_TRACE(jitter);
    CutPlan plan;
    plan.surface = test::leaning_wall;
    plan.jitter_m = jitter;
    expect_stitched(plan);
  }
}

TEST(Stitch, KeepsHolesThatCrossABorder) {
  CutPlan plan;
  std::vector<Mesh> tiles = test::cut_tiles(plan);
  const Vec3d border = plan.origin + Vec3d{8.0, 3.3, 0.0}, corner = plan.origin + Vec3d{8, 8, 0};
  test::punch_hole(tiles, border, 1.6);
  test::punch_hole(tiles, corner, 1.2);
  const Outcome run = stitch_tiles(tiles);
  expect_one_surface(run, 2);
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    EXPECT_EQ(run.after[i].positions, tiles[i].positions);
    EXPECT_EQ(run.after[i].triangles, tiles[i].triangles);
  }
}

TEST(Stitch, KeepsHolesThatCrossShiftedBorders) {
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    SCOPED_TRACE(seed);
    CutPlan plan;
    plan.seed = seed;
    plan.jitter_m = 0.03;
    std::vector<Mesh> tiles = test::cut_tiles(plan);
    test::punch_hole(tiles, plan.origin + Vec3d{8.0, 3.3, 0.0}, 1.6);
    const Outcome run = stitch_tiles(tiles);
    expect_one_surface(run, 1);
    expect_nothing_folded(run);
  }
}

TEST(Stitch, TakesHolesInTheGridOfTiles) {
  CutPlan plan;
  plan.columns = 3, plan.rows = 3;
  plan.jitter_m = 0.02;
  std::vector<Mesh> tiles = test::cut_tiles(plan);
  tiles.erase(tiles.begin() + 4);
  const Outcome run = stitch_tiles(tiles);
  expect_one_surface(run, 1);
  expect_little_changed(run, 0.25);
}

TEST(Stitch, TakesATileWhoseLongSideMeetsTwoOthers) {
  CutPlan plan;
  plan.jitter_m = 0.02;
  std::vector<Mesh> tiles = test::cut_tiles(plan);
  CutPlan wide = plan;
  wide.columns = 1, wide.rows = 1;
  wide.tile_m = 16.0;
  wide.cells = [](int, int) { return 23; };
  wide.seed = 9;
  // North of the other four, as wide as two.
  wide.surface = [](double u, double v) { return test::hills(u, v + 16.0); };
  tiles.push_back(test::cut_tiles(wide)[0]);
  const Outcome run = stitch_tiles(tiles);
  expect_one_surface(run);
  expect_nothing_folded(run);
}

TEST(Stitch, TakesEmptyTilesAndTilesOfTwoTriangles) {
  CutPlan plan;
  plan.jitter_m = 0.01;
  plan.cells = [](int column, int row) { return column == 1 && row == 1 ? 1 : 16; };
  plan.surface = [](double u, double v) { return Vec3d{u, v, 0.2 * u}; };
  std::vector<Mesh> tiles = test::cut_tiles(plan);
  Mesh empty;
  empty.origin = plan.origin;
  tiles.push_back(empty);
  const Outcome run = stitch_tiles(tiles);
  expect_one_surface(run);
  EXPECT_TRUE(run.after.back().triangles.empty());
}

TEST(Stitch, LeavesBordersFartherApartThanTheTolerance) {
  std::vector<Mesh> tiles = test::cut_tiles(CutPlan{});
  tiles[1].origin.x += 0.5;
  tiles[3].origin.x += 0.5;
  const Outcome run = stitch_tiles(tiles);
  EXPECT_EQ(run.result.plan.moved_vertices, 0u);
  EXPECT_EQ(run.after[0].positions, tiles[0].positions);
  Options wide;
  wide.tolerance_m = 1.0;
  EXPECT_EQ(stitch_tiles(tiles, wide).result.plan.moved_vertices, 0u)
      << "half a metre is as long as the edges: that is no crack";
}

TEST(Stitch, PutsOriginsBetweenWholeMetresOnThem) {
  CutPlan plan;
  plan.origin = {2600000.3, 1200000.1, 1500.7};
  const Outcome run = stitch_tiles(test::cut_tiles(plan));
  expect_one_surface(run);
  EXPECT_EQ(run.after[0].origin, (Vec3d{2600000, 1200000, 1501}));
}

TEST(Stitch, CountsTheFaultsOfASurveyThatIsNotStitched) {
  CutPlan plan;
  plan.columns = 2, plan.rows = 1;
  plan.cells = [](int column, int) { return column == 0 ? 8 : 16; };
  plan.surface = [](double u, double v) { return Vec3d{u, v, 0.25 * v}; };
  std::vector<Mesh> tiles = test::cut_tiles(plan);
  const test::TemporaryFolder folder;
  const Options options;
  const SeamReport halves =
      check_survey(learn_survey(test::write_tiles(folder.path(), tiles), options), options);
  EXPECT_EQ(halves.open_edges, 8u + 16u);
  EXPECT_EQ(halves.t_vertices, 8u);
  EXPECT_EQ(halves.mismatched_vertices, 0u);
  plan.cells = [](int, int) { return 16; };
  tiles = test::cut_tiles(plan);
  tiles[1].positions[8 * 17].y += 0.0625f;
  tiles[0].triangles.push_back({0, 1, 1});
  for (Triangle& t : tiles[1].triangles) std::swap(t[0], t[1]);
  const SeamReport turned =
      check_survey(learn_survey(test::write_tiles(folder.path(), tiles), options), options);
  EXPECT_EQ(turned.turned_triangles, 14u);
  EXPECT_EQ(turned.degenerate_triangles, 1u);
}

/// A tile of hills over [x, x + 24] x [y, y + 24], from the survey's corner.
Mesh hills_tile(double x, double y, int cells) {
  Mesh mesh = test::grid_mesh(cells + 1, cells + 1, [&](int column, int row) {
    const double u = 24.0 * column / cells, v = 24.0 * row / cells;
    return Vec3d{u, v, test::hills(x + u, y + v).z};
  });
  mesh.origin = {2600000.0 + x, 1200000.0 + y, 1500.0};
  mesh.crs_text = "EPSG:2056+5728";
  mesh.normals.assign(mesh.positions.size(), {0, 0, 1});
  mesh.float_properties.push_back({"support", std::vector<float>(mesh.positions.size(), 0.5f)});
  mesh.byte_properties.push_back({"source", std::vector<std::uint8_t>(mesh.positions.size(), 0)});
  return mesh;
}

TEST(Stitch, CutsTilesThatLieOverEachOtherApartAndJoinsThem) {
  Options refusing, options;
  options.overlaps = Overlaps::kCut;
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    SCOPED_TRACE(seed);
    // Four tiles, each 4 m beyond its neighbours' edge, with vertices in other places.
    const auto cells = [&](std::uint64_t tile) {
      return 40 + static_cast<int>(mix64(seed * 4 + tile) % 24);
    };
    const std::vector<Mesh> tiles{hills_tile(0, 0, cells(0)), hills_tile(20, 0, cells(1)),
                                  hills_tile(0, 20, cells(2)), hills_tile(20, 20, cells(3))};
    EXPECT_THROW(stitch_tiles(tiles, refusing), InputError);
    const Outcome run = stitch_tiles(tiles, options);
    expect_one_surface(run);
    expect_nothing_folded(run);
    double area = 0.0;
    for (const Mesh& tile : run.after) {
      for (const Triangle& t : tile.triangles) area += 0.5 * facing(tile, t).z;
    }
    EXPECT_NEAR(area, 44.0 * 44.0, 0.5) << "everything once, in plan";
    EXPECT_EQ(run.after[0].byte_properties[0].values.size(), run.after[0].positions.size());
  }
}

TEST(Stitch, RefusesOneGroundTwiceHoweverItIsAsked) {
  Options options;
  const std::vector<Mesh> tiles{hills_tile(0, 0, 48), hills_tile(2, 1, 50)};
  EXPECT_THROW(stitch_tiles(tiles, options), InputError);
  options.overlaps = Overlaps::kCut;
  EXPECT_THROW(stitch_tiles(tiles, options), InputError);
  options.overlaps = Overlaps::kKeep;
  EXPECT_EQ(stitch_tiles(tiles, options).after.size(), 2u);
}

TEST(Stitch, TakesTilesThatMeetAlongALineThatBendsForNeighbours) {
  // Boxes share 6 m; the surfaces meet on a wave and nowhere lie over each other.
  const auto wavy = [](bool east) {
    Mesh mesh = test::grid_mesh(25, 25, [&](int column, int row) {
      const double border = 24.0 + 3.0 * std::sin(0.5 * row);
      const double x = east ? border + (48.0 - border) * column / 24.0 : border * column / 24.0;
      return Vec3d{x, 1.0 * row, test::hills(x, row).z};
    });
    mesh.origin = {2600000.0, 1200000.0, 0.0};
    mesh.normals.assign(mesh.positions.size(), {0, 0, 1});
    return mesh;
  };
  expect_one_surface(stitch_tiles({wavy(false), wavy(true)}));
}

/// A flat patch of metre cells over [x0, x1] x [y0, y1] at height z, added to a tile.
void add_patch(Mesh& tile, int x0, int x1, int y0, int y1, float z) {
  const auto first = static_cast<std::uint32_t>(tile.positions.size());
  const auto columns = static_cast<std::uint32_t>(x1 - x0 + 1);
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      tile.positions.push_back({static_cast<float>(x), static_cast<float>(y), z});
      tile.normals.push_back({0, 0, 1});
      tile.float_properties[0].values.push_back(0.5f);
      tile.byte_properties[0].values.push_back(0);
    }
  }
  for (std::uint32_t y = 0; y < static_cast<std::uint32_t>(y1 - y0); ++y) {
    for (std::uint32_t x = 0; x + 1 < columns; ++x) {
      const std::uint32_t v = first + y * columns + x;
      tile.triangles.push_back({v, v + 1, v + columns});
      tile.triangles.push_back({v + 1, v + columns + 1, v + columns});
    }
  }
}

TEST(Stitch, DropsPartsThatAreSmallOverAllTiles) {
  Mesh west = hills_tile(0, 0, 24), east = hills_tile(24, 0, 24);
  add_patch(west, 20, 24, 2, 4, 50);  // 8 m2, and 2 m2 next door: goes
  add_patch(east, 0, 1, 2, 4, 50);
  add_patch(west, 22, 24, 10, 14, 50);  // 8 m2, and 12 m2 next door: stays
  add_patch(east, 0, 3, 10, 14, 50);
  add_patch(west, 4, 7, 4, 7, 50);    // 9 m2 inside a tile: goes
  add_patch(east, 10, 14, 4, 9, 50);  // 20 m2 inside a tile: stays
  add_patch(west, 0, 1, 20, 22, 50);  // 2 m2 at the survey's rim: goes
  Options options;
  const Outcome all = stitch_tiles({west, east}, options);
  EXPECT_EQ(all.result.triangles, west.triangles.size() + east.triangles.size());
  options.min_area_m2 = 15.0;
  const Outcome run = stitch_tiles({west, east}, options);
  EXPECT_EQ(run.after[0].triangles.size(), west.triangles.size() - 2 * (8 + 9 + 2));
  EXPECT_EQ(run.after[1].triangles.size(), east.triangles.size() - 2 * 2);
  EXPECT_EQ(run.result.seams.faults(), 0u);
  EXPECT_EQ(run.after[0].float_properties[0].values.size(), run.after[0].positions.size());
  const test::Welded whole = test::weld(run.after);
  EXPECT_EQ(check_topology(whole.triangles, whole.positions.size(), 1).components, 3u);
  const test::TemporaryFolder folder;
  const Survey survey = learn_survey(test::write_tiles(folder.path(), {west, east}), options);
  EXPECT_EQ(survey.small_parts, 3u);
  EXPECT_NEAR(survey.small_parts_area_m2, 10.0 + 9.0 + 2.0, 1e-4);
}

TEST(Stitch, JoinsATileOfATwentiethOfTheDensity) {
  CutPlan plan;
  plan.columns = 2, plan.rows = 2;
  plan.tile_m = 20.0;
  plan.cells = [](int column, int row) { return column == 0 && row == 0 ? 9 : 40; };  // 1:20
  expect_stitched(plan);
  plan.jitter_m = 0.02;
  expect_stitched(plan);
}

TEST(Stitch, JoinsGridsOfOtherSpacing) {
  // As meshes of elevation models of 2 m and 0.5 m come: flat between their nodes.
  const auto tile = [](double x, double step) {
    Mesh mesh = test::height_mesh(0, 0, static_cast<int>(24 / step), step, [&](double u, double v) {
      return 0.2 * std::sin(0.2 * (x + u)) + 0.15 * std::cos(0.3 * v);
    });
    mesh.origin = {2600000.0 + x, 1200000.0, 1500.0};
    mesh.normals.assign(mesh.positions.size(), {0, 0, 1});
    return mesh;
  };
  const Outcome run = stitch_tiles({tile(0, 2.0), tile(24, 0.5)});
  expect_one_surface(run);
  EXPECT_LT(run.result.plan.largest_move_m, 0.05);
}

TEST(Stitch, GivesTheSameWhateverTheOrderAndTheThreads) {
  CutPlan plan;
  plan.jitter_m = 0.03;
  plan.columns = 3;
  plan.cells = [](int column, int row) { return 14 + 3 * column + row; };
  const std::vector<Mesh> tiles = test::cut_tiles(plan);
  Options two;
  two.threads = 2;
  Options one;
  one.threads = 1;
  const Outcome a = stitch_tiles(tiles, one), b = stitch_tiles(tiles, two, true);
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    EXPECT_EQ(a.after[i].positions, b.after[i].positions);
    EXPECT_EQ(a.after[i].normals, b.after[i].normals);
    EXPECT_EQ(a.after[i].triangles, b.after[i].triangles);
    EXPECT_EQ(a.after[i].float_properties[0].values, b.after[i].float_properties[0].values);
  }
}

}  // namespace
}  // namespace cornice::stitch
