// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/index/survey_index.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/io/las.h"
#include "tests/support/json_file.h"
#include "tests/support/process.h"
#include "tests/support/temporary_folder.h"

namespace cornice::index {
namespace {

namespace fs = std::filesystem;
using test::TemporaryFolder;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// A tile of 11 x 11 points over side x side metres.
fs::path made_tile(const fs::path& path, double x, double y, double side,
                   const std::string& crs = "EPSG:2154") {
  LasWriteOptions options;
  if (!crs.empty()) options.crs = crs_from_text(crs);
  PointCloud cloud;
  cloud.origin = {x, y, 0.0};
  for (int i = 0; i < 121; ++i) {
    const auto step = static_cast<float>(side / 10.0);
    cloud.positions.push_back(
        {static_cast<float>(i % 11) * step, static_cast<float>(i / 11) * step, 5.0f});
  }
  LasWriter writer(path, options);
  writer.write(cloud);
  writer.close();
  return path;
}

const IndexedTile& tile_named(const SurveyIndex& survey, const std::string& name) {
  for (const IndexedTile& tile : survey.tiles)
    if (tile.name == name) return tile;
  throw std::runtime_error("no tile " + name);
}

TEST(SurveyIndex, FindsNeighboursAcrossEdgesAndCorners) {
  const TemporaryFolder folder;
  std::vector<fs::path> files;
  for (int i = 0; i < 9; ++i)
    files.push_back(made_tile(folder / ("t" + std::to_string(i) + ".laz"), 600000 + 100 * (i % 3),
                              200000 + 100 * (i / 3), 100.0));
  const SurveyIndex survey = index_survey(files, {});
  EXPECT_EQ(survey.crs, "EPSG:2154");
  EXPECT_THAT(tile_named(survey, "t0").neighbours, ElementsAre(1, 3, 4));
  EXPECT_EQ(tile_named(survey, "t4").neighbours.size(), 8u);
  EXPECT_EQ(tile_named(survey, "t4").box, (Box2d{600100, 200100, 600200, 200200}));
}

TEST(SurveyIndex, TakesATilesBoxFromItsName) {
  const TemporaryFolder folder;
  const SurveyIndex survey =
      index_survey({made_tile(folder / "swisssurface3d_2019_2746-1234_2056_5728.laz", 2746100,
                              1234200, 50.0, "")},
                   {});
  EXPECT_EQ(survey.tiles.at(0).box, (Box2d{2746000, 1234000, 2747000, 1235000}));
  EXPECT_EQ(survey.tiles.at(0).product, "swisssurface3d");
  EXPECT_EQ(survey.crs, "EPSG:2056+5728");
}

TEST(SurveyIndex, DoesNotTrustTheNameOfATileThatLiesElsewhere) {
  const TemporaryFolder folder;
  const SurveyIndex survey =
      index_survey({made_tile(folder / "swisssurface3d_2019_2746-1234_2056_5728.laz", 2750000,
                              1234200, 50.0, "")},
                   {});
  EXPECT_EQ(survey.tiles.at(0).box, (Box2d{2750000, 1234200, 2750050, 1234250}));
}

TEST(SurveyIndex, KeepsTheGoodTilesWhereOneIsBad) {
  const TemporaryFolder folder;
  const fs::path a = made_tile(folder / "a.laz", 600000, 200000, 100.0);
  const fs::path b = made_tile(folder / "b.laz", 600100, 200000, 100.0);
  const fs::path empty = folder / "empty.laz";
  test::write_text(empty, "");
  const fs::path cut = folder / "cut.laz";
  fs::copy_file(a, cut);
  fs::resize_file(cut, fs::file_size(cut) - 50);
  const SurveyIndex survey = index_survey({empty, cut, b, a}, {});
  EXPECT_THAT(tile_named(survey, "a").problem, IsEmpty());
  EXPECT_EQ(tile_named(survey, "a").neighbours.size(), 1u);
  EXPECT_THAT(tile_named(survey, "empty").problem, HasSubstr("empty"));
  EXPECT_THAT(tile_named(survey, "cut").problem, HasSubstr("cut short"));
}

TEST(SurveyIndex, RefusesTheTilesOfTheRarerCoordinateSystem) {
  const TemporaryFolder folder;
  const SurveyIndex survey =
      index_survey({made_tile(folder / "a.laz", 600000, 200000, 100.0, "EPSG:2056"),
                    made_tile(folder / "b.laz", 600100, 200000, 100.0),
                    made_tile(folder / "c.laz", 600200, 200000, 100.0)},
                   {});
  EXPECT_EQ(survey.crs, "EPSG:2154");
  EXPECT_THAT(tile_named(survey, "a").problem, HasSubstr("EPSG:2056"));
  EXPECT_THAT(tile_named(survey, "a").problem, HasSubstr("--crs"));
}

TEST(SurveyIndex, RefusesTheSecondTileOverTheSameGroundAndOfTheSameName) {
  const TemporaryFolder folder;
  fs::create_directories(folder / "other");
  const SurveyIndex survey =
      index_survey({made_tile(folder / "a.laz", 600000, 200000, 100.0),
                    made_tile(folder / "again.laz", 600000, 200000, 100.0),
                    made_tile(folder / "other" / "a.laz", 600100, 200000, 100.0)},
                   {});
  EXPECT_THAT(survey.tiles.at(0).problem, IsEmpty());
  EXPECT_THAT(survey.tiles.at(1).problem, HasSubstr("name of"));
  EXPECT_THAT(tile_named(survey, "again").problem, HasSubstr("covers the ground of"));
}

TEST(SurveyIndex, CountsATileOnceThatIsGivenTwice) {
  const TemporaryFolder folder;
  const fs::path tile = made_tile(folder / "t.laz", 600000, 200000, 100.0);
  const SurveyIndex survey = index_survey({tile, folder.path() / "." / "t.laz"}, {});
  ASSERT_EQ(survey.tiles.size(), 2u);
  EXPECT_EQ(survey.tiles[0].problem + survey.tiles[1].problem, "is given twice; it counts once");
}

TEST(SurveyIndex, RefusesDegrees) {
  const TemporaryFolder folder;
  EXPECT_THROW(index_survey({made_tile(folder / "a.laz", 7, 46, 0.1, "EPSG:4326")}, {}),
               InputError);
}

TEST(SurveyIndex, RefusesANameThatItsJsonCouldNotHold) {
  const TemporaryFolder folder;
  const fs::path tile = made_tile(folder / "a.laz", 600000, 200000, 100.0);
  fs::rename(tile, folder / "Gr\xf6\xdf.laz");
  EXPECT_THROW(index_survey({folder / "Gr\xf6\xdf.laz"}, {}), InputError);
}

TEST(SurveyIndex, DoesNotDependOnTheOrderOfTheFiles) {
  const TemporaryFolder folder;
  std::vector<fs::path> files;
  for (int i = 0; i < 6; ++i)
    files.push_back(made_tile(folder / ("t" + std::to_string(i) + ".laz"), 600000 + 313 * (i % 3),
                              200000 + 287 * (i / 3), 300.0 + i));
  const std::string forwards = to_json(index_survey(files, {}));
  std::reverse(files.begin(), files.end());
  EXPECT_EQ(to_json(index_survey(files, {})), forwards);
}

TEST(IndexProgram, WritesTheIndexAndNamesEachUnusableTile) {
  const TemporaryFolder folder;
  made_tile(folder / "a.laz", 600000, 200000, 100.0);
  test::write_text(folder / "bad.laz", "not a tile");
  const auto result = test::run_process({std::string(CORNICE_BIN_DIR) + "/cornice-index",
                                         (folder / "a.laz").string(), (folder / "bad.laz").string(),
                                         "-o", (folder / "survey.json").string()});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("bad.laz: "));
  const auto document = test::read_json(folder / "survey.json");
  EXPECT_EQ(document.at("format"), "cornice survey 1");
  EXPECT_EQ(document.at("tiles").size(), 2u);
  EXPECT_FALSE(document.at("tiles").at(1).at("problem").get<std::string>().empty());
}

TEST(IndexProgram, FailsWhereNoTileIsUsable) {
  const TemporaryFolder folder;
  test::write_text(folder / "bad.laz", "not a tile");
  const auto result =
      test::run_process({std::string(CORNICE_BIN_DIR) + "/cornice-index",
                         (folder / "bad.laz").string(), "-o", (folder / "survey.json").string()});
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_FALSE(fs::exists(folder / "survey.json"));
}

}  // namespace
}  // namespace cornice::index
