// SPDX-License-Identifier: GPL-3.0-or-later
// What must hold for any survey: its tiles' meshes together are the mesh of the whole, bit for bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <tuple>
#include <vector>

#include "core/base/random.h"
#include "core/io/ply.h"
#include "core/io/raster.h"
#include "core/mesh/topology.h"
#include "stages/dem/mesh_raster.h"
#include "stages/dem/piece_file.h"
#include "stages/dem/pieces.h"
#include "stages/dem/survey.h"
#include "tests/support/temporary_folder.h"

namespace cornice::dem {
namespace {

namespace fs = std::filesystem;
using test::TemporaryFolder;

/// A made survey.
struct Ground {
  double west = 2600000.25, north = 1200000.25, step = 0.5;
  double holes = 0.0;  ///< share of pixels without data
  std::uint64_t seed = 1;

  float at(std::int64_t col, std::int64_t row) const {
    CounterRandom random(seed, static_cast<std::uint64_t>(col), static_cast<std::uint64_t>(row));
    if (random.uniform() < holes) return -9999.0f;
    const auto x = static_cast<double>(col), y = static_cast<double>(row);
    return static_cast<float>(1500.0 + 20.0 * std::sin(x / 7.0 + y / 11.0) + random.normal());
  }
};

fs::path write_tile(const TemporaryFolder& folder, const std::string& name, const Ground& ground,
                    const PixelRect& rect) {
  Raster raster;
  raster.width = static_cast<int>(rect.width);
  raster.height = static_cast<int>(rect.height);
  raster.west = ground.west + static_cast<double>(rect.col) * ground.step;
  raster.north = ground.north - static_cast<double>(rect.row) * ground.step;
  raster.step = ground.step;
  raster.crs = crs_from_text("EPSG:2056+5728");
  for (std::int64_t row = rect.row; row < rect.end_row(); ++row) {
    for (std::int64_t col = rect.col; col < rect.end_col(); ++col) {
      raster.values.push_back(ground.at(col, row));
    }
  }
  write_cog(folder / name, raster);
  return folder / name;
}

/// The meshes of all pieces of a survey, as PLY files read back.
std::vector<fs::path> mesh_survey(const TemporaryFolder& folder, const std::string& to,
                                  const std::vector<fs::path>& tiles, std::int64_t most_pixels,
                                  int threads = 1, const SurveyOptions& options = {}) {
  Survey survey(tiles, options);
  const Lattice lattice(survey.step());
  std::vector<fs::path> files;
  for (const Piece& piece : cut_into_pieces(survey, most_pixels)) {
    HeightWindow window;
    window.own = piece.own;
    window.heights = survey.read(HeightWindow::rect_for(piece.own));
    window.taken = survey.taken(piece.tile, piece.own);
    const GridSurface surface(std::move(window), threads);
    if (surface.triangles() == 0) continue;
    files.push_back(folder / to / (piece.name + ".ply"));
    write_piece(files.back(), surface, lattice.places_of(survey, piece.own),
                {lattice.origin_of(survey, piece.own), survey.crs().text(), {}}, threads,
                no_progress());
  }
  return files;
}

using Corner = std::tuple<double, double, double, float, float, float>;
using Face = std::array<Corner, 3>;

/// Triangles by what their corners are, position and normal, from the smallest corner on.
std::multiset<Face> faces_of(const std::vector<fs::path>& files) {
  std::multiset<Face> faces;
  for (const fs::path& file : files) {
    const Mesh mesh = read_ply_mesh(file);
    EXPECT_EQ(mesh.crs_text, "EPSG:2056+5728");
    for (const auto& t : mesh.triangles) {
      Face face;
      for (int k = 0; k < 3; ++k) {
        const Vec3d p = mesh.origin + mesh.positions[t[k]].cast<double>();
        const Vec3f n = mesh.normals[t[k]];
        face[k] = {p.x, p.y, p.z, n.x, n.y, n.z};
      }
      std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
      faces.insert(face);
    }
  }
  return faces;
}

void expect_sound(const std::vector<fs::path>& files) {
  for (const fs::path& file : files) {
    const Mesh mesh = read_ply_mesh(file);
    const TopologyReport report = check_topology(mesh.triangles, mesh.positions.size(), 1);
    EXPECT_TRUE(report.is_manifold()) << file;
    EXPECT_EQ(report.isolated_vertices, 0u) << file;
    for (const auto& t : mesh.triangles) {
      const Vec3f a = mesh.positions[t[0]], b = mesh.positions[t[1]], c = mesh.positions[t[2]];
      ASSERT_GT(cross(b - a, c - a).z, 0.0f);
    }
  }
}

/// Tiles of unequal sizes that fill a rectangle of 70 x 50 pixels.
std::vector<PixelRect> patchwork() {
  return {{0, 0, 30, 20}, {30, 0, 40, 20}, {0, 20, 45, 30}, {45, 20, 25, 17}, {45, 37, 25, 13}};
}

std::vector<fs::path> write_patchwork(const TemporaryFolder& folder, const Ground& ground) {
  std::vector<fs::path> tiles;
  for (const PixelRect& rect : patchwork()) {
    tiles.push_back(
        write_tile(folder, "tile" + std::to_string(tiles.size()) + ".tif", ground, rect));
  }
  return tiles;
}

class SurveyMeshes : public testing::TestWithParam<std::tuple<double, double, double>> {};

TEST_P(SurveyMeshes, TogetherAreTheMeshOfTheWhole) {
  Ground ground;
  std::tie(ground.west, ground.step, ground.holes) = GetParam();
  const TemporaryFolder folder;
  const fs::path whole = write_tile(folder, "whole.tif", ground, {0, 0, 70, 50});
  const std::vector<fs::path> tiles = write_patchwork(folder, ground);
  const auto one = mesh_survey(folder, "one", {whole}, 4000);
  const auto many = mesh_survey(folder, "many", tiles, 4000);
  const auto cut = mesh_survey(folder, "cut", {whole}, 25);
  ASSERT_EQ(one.size(), 1u);
  ASSERT_EQ(many.size(), 5u);
  ASSERT_EQ(cut.size(), 6u);
  const auto truth = faces_of(one);
  ASSERT_FALSE(truth.empty());
  EXPECT_TRUE(faces_of(many) == truth);
  EXPECT_TRUE(faces_of(cut) == truth);
  expect_sound(one);
  expect_sound(many);
  expect_sound(cut);
}

// Grids of whole quarters, of a step that no binary fraction is, and of corners between
// millimetres.
INSTANTIATE_TEST_SUITE_P(Grids, SurveyMeshes,
                         testing::Values(std::make_tuple(2600000.25, 0.5, 0.0),
                                         std::make_tuple(2600000.25, 0.5, 0.15),
                                         std::make_tuple(247323.244194263, 4.997678230579, 0.1),
                                         std::make_tuple(770549.75, 0.1, 0.3)));

TEST(SurveyMesh, HasTheSameBytesWithOneAndTwoThreadsAndInAnyOrderOfTiles) {
  Ground ground;
  ground.holes = 0.1;
  const TemporaryFolder folder;
  std::vector<fs::path> tiles = write_patchwork(folder, ground);
  const auto one = mesh_survey(folder, "one", tiles, 4000, 1);
  std::reverse(tiles.begin(), tiles.end());
  const auto two = mesh_survey(folder, "two", tiles, 4000, 2);
  ASSERT_EQ(one.size(), two.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].filename(), two[i].filename());
    EXPECT_EQ(test::read_text(one[i]), test::read_text(two[i]));
  }
}

TEST(SurveyMesh, OfTilesThatOverlapHasEveryCellOnce) {
  Ground ground;
  ground.holes = 0.05;
  const TemporaryFolder folder;
  const fs::path whole = write_tile(folder, "whole.tif", ground, {0, 0, 40, 30});
  const std::vector<fs::path> tiles{write_tile(folder, "a.tif", ground, {0, 0, 25, 30}),
                                    write_tile(folder, "b.tif", ground, {20, 0, 20, 18}),
                                    write_tile(folder, "c.tif", ground, {22, 15, 18, 15})};
  const auto many = mesh_survey(folder, "many", tiles, 4000);
  EXPECT_TRUE(faces_of(many) == faces_of(mesh_survey(folder, "one", {whole}, 4000)));
  expect_sound(many);
  EXPECT_EQ(Survey(tiles, {}).warnings().size(), 1u);
}

TEST(SurveyMesh, OfResampledTilesMeetsToo) {
  Ground ground;
  const TemporaryFolder folder;
  const std::vector<fs::path> tiles = write_patchwork(folder, ground);
  for (const double step : {0.3, 1.0, 1.7}) {
    SurveyOptions options;
    options.resample_m = step;
    const auto whole = mesh_survey(folder, "whole", tiles, 4000, 1, options);
    const auto cut =
        mesh_survey(folder, "cut", tiles, static_cast<std::int64_t>(14.0 / step), 2, options);
    EXPECT_GT(cut.size(), whole.size());
    const auto faces = faces_of(whole);
    EXPECT_TRUE(faces_of(cut) == faces);
    // No open edge but those around the survey.
    const double side_x = std::floor(35.0 / step), side_y = std::floor(25.0 / step);
    EXPECT_NEAR(static_cast<double>(faces.size()), 2.0 * side_x * side_y, 4.0 * (side_x + side_y));
    expect_sound(cut);
    fs::remove_all(folder / "whole");
    fs::remove_all(folder / "cut");
  }
}

TEST(SurveyMesh, ResampledKeepsAPlane) {
  const TemporaryFolder folder;
  Raster raster;
  raster.width = raster.height = 40;
  raster.west = 1000.3;
  raster.north = 2000.1;
  raster.step = 0.7;
  raster.crs = crs_from_text("EPSG:2056");
  const auto plane = [](double x, double y) { return 0.5 * (x - 1000.0) - 0.25 * (y - 2000.0); };
  for (int row = 0; row < 40; ++row) {
    for (int col = 0; col < 40; ++col) {
      raster.values.push_back(static_cast<float>(
          plane(raster.west + (col + 0.5) * 0.7, raster.north - (row + 0.5) * 0.7)));
    }
  }
  write_cog(folder / "plane.tif", raster);
  for (const double step : {0.25, 0.7, 2.0}) {
    SurveyOptions options;
    options.resample_m = step;
    Survey survey({folder / "plane.tif"}, options);
    const PixelRect inner = survey.tiles()[0].rect.grown(-2 - static_cast<int>(1.0 / step));
    ASSERT_FALSE(inner.empty());
    const std::vector<float> heights = survey.read(inner);
    for (std::int64_t i = 0; i < static_cast<std::int64_t>(heights.size()); ++i) {
      const double x = survey.east_of(inner.col + i % inner.width);
      const double y = survey.north_of(inner.row + i / inner.width);
      ASSERT_NEAR(heights[static_cast<std::size_t>(i)], plane(x, y), 1e-4);
    }
  }
}

TEST(SurveyMesh, MadeARasterAgainGivesTheGridBack) {
  for (const auto& [west, step] :
       {std::make_pair(2600000.25, 0.5), std::make_pair(247323.244194263, 4.997678230579)}) {
    Ground ground;
    ground.west = west;
    ground.step = step;
    ground.holes = 0.02;
    const TemporaryFolder folder;
    const std::vector<fs::path> tiles = write_patchwork(folder, ground);
    const auto files = mesh_survey(folder, "meshes", tiles, 4000);
    MeshCache cache(1 << 16);
    std::string crs;
    const auto meshes = find_meshes(files, cache, crs, no_progress());
    const RasterGrid grid{70, 50, ground.west, ground.north, ground.step};
    // Blocks smaller than the raster take another way than one block.
    for (const int side : {512, 32}) {
      const LayerCounts counts = write_layers(folder / "back.tif", grid, crs_from_text(crs), meshes,
                                              cache, side, 2, no_progress());
      EXPECT_EQ(counts.folded, 0u);
      const Raster back = read_raster(folder / "back.tif");
      EXPECT_EQ(back.crs.text(), "EPSG:2056+5728");
      int lost = 0, holes_filled = 0;
      for (int row = 0; row < 50; ++row) {
        for (int col = 0; col < 70; ++col) {
          const float was = ground.at(col, row), is = back.at(col, row);
          if (was == -9999.0f) {
            holes_filled += is != back.no_data;
          } else if (is == back.no_data) {
            ++lost;
          } else {
            ASSERT_EQ(is, was) << col << " " << row;
          }
        }
      }
      EXPECT_EQ(holes_filled, 0);
      // Pixels that no triangle has: those cut off by holes.
      EXPECT_LT(lost, 10);
    }
  }
}

}  // namespace
}  // namespace cornice::dem
