// SPDX-License-Identifier: GPL-3.0-or-later
// cornice-simulate as a user runs it.
#include <gtest/gtest.h>
#include <signal.h>

#include <atomic>
#include <chrono>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "core/base/error.h"
#include "core/io/flight_lines_file.h"
#include "core/io/las.h"
#include "core/io/ply.h"
#include "core/io/raster.h"
#include "support/full_disk.h"
#include "support/process.h"
#include "support/temporary_folder.h"

namespace cornice::test {
namespace {

namespace fs = std::filesystem;

const std::string kScene = std::string(CORNICE_SOURCE_DIR) + "/samples/scenes/cliff.yaml";

ProcessResult simulate(const fs::path& folder, const std::vector<std::string>& more,
                       int signal_number = 0, const std::string& signal_when = "",
                       const std::string& density = "5") {
  std::vector<std::string> arguments{std::string(CORNICE_BIN_DIR) + "/cornice-simulate",
                                     kScene,
                                     "-o",
                                     folder.string(),
                                     "--tile-size",
                                     "60",
                                     "--density",
                                     density,
                                     "--no-progress"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_process(arguments, signal_number, signal_when);
}

std::vector<fs::path> tiles_in(const fs::path& folder) {
  std::vector<fs::path> tiles;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".laz") tiles.push_back(entry.path());
  return tiles;
}

TEST(CorniceSimulate, WritesTilesAndTruthThatTheProjectsReadersTake) {
  const TemporaryFolder folder;
  const fs::path out = folder / "survey";
  const ProcessResult result =
      simulate(out, {"--product", "lidarhd", "--tiles", "2x1", "--truth-mesh-step", "5", "--report",
                     (folder / "report.json").string()});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(result.out.empty());
  ASSERT_EQ(tiles_in(out).size(), 2u);
  std::uint64_t points = 0;
  for (const fs::path& tile : tiles_in(out)) {
    const LasInfo info = read_las_info(tile);
    EXPECT_EQ(info.crs.text(), "EPSG:2154+5720");
    points += info.point_count;
    const fs::path truth = out / "truth" / tile.filename();
    EXPECT_EQ(read_ply_points(truth.string() + ".points.ply").positions.size(), info.point_count);
    EXPECT_GT(read_ply_mesh(truth.string() + ".ground.ply").triangles.size(), 200u);
  }
  EXPECT_NEAR(static_cast<double>(points), 5.0 * 7200.0, 3600.0);
  const FlightLines lines = read_flight_lines(out / "truth/lines.gpkg");
  EXPECT_EQ(lines.lines.size(), read_flight_lines(out / "truth/lines.json").lines.size());
  const auto summary = nlohmann::json::parse(read_text(out / "truth/survey.json"));
  EXPECT_EQ(summary["points"], points);
  for (const auto& file : summary["files"])
    EXPECT_TRUE(fs::exists(out / file.get<std::string>())) << file;
  const auto report = nlohmann::json::parse(read_text(folder / "report.json"));
  EXPECT_EQ(report["counts"]["points"], points);
  int dems = 0;
  for (const auto& entry : fs::directory_iterator(out / "truth")) {
    if (entry.path().extension() != ".tif") continue;
    const Raster dem = read_raster(entry.path());
    EXPECT_EQ(dem.width, 30);
    EXPECT_EQ(dem.step, 2.0);
    ++dems;
  }
  EXPECT_EQ(dems, 2);
}

TEST(CorniceSimulate, RefusesAnOutputThatExistsAndReplacesItsOwnWhereAsked) {
  const TemporaryFolder folder;
  const fs::path out = folder / "survey";
  ASSERT_EQ(simulate(out, {}).exit_code, 0);
  const std::string tile = tiles_in(out).at(0).filename().string();
  write_text(out / "notes.txt", "mine");
  const ProcessResult refused = simulate(out, {});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.err.find("--overwrite"), std::string::npos) << refused.err;
  ASSERT_EQ(simulate(out, {"--overwrite", "--corner", "2746100,1234000"}).exit_code, 0);
  EXPECT_FALSE(fs::exists(out / tile)) << "the tile of the earlier survey stayed";
  EXPECT_EQ(tiles_in(out).size(), 1u);
  EXPECT_EQ(read_text(out / "notes.txt"), "mine");
}

/// Every file of a folder by its path in it.
std::map<std::string, std::string> contents(const fs::path& folder) {
  std::map<std::string, std::string> all;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file())
      all[entry.path().lexically_relative(folder).string()] = read_text(entry.path());
  return all;
}

TEST(CorniceSimulate, TheSameSeedGivesTheSameFilesWithOneThreadAndTwo) {
  const TemporaryFolder folder;
  const std::vector<std::string> options{
      "--tiles", "2x1", "--defects", "duplicate-points=0.01", "--truth-mesh-step", "3"};
  for (const char* run : {"one", "two", "other"}) {
    std::vector<std::string> all = options;
    all.insert(all.end(), {"--threads", std::string(run) == "one" ? "1" : "2", "--seed",
                           std::string(run) == "other" ? "8" : "7"});
    const ProcessResult result = simulate(folder / run, all);
    ASSERT_EQ(result.exit_code, 0) << result.err;
  }
  const auto one = contents(folder / "one"), two = contents(folder / "two");
  ASSERT_GE(one.size(), 10u);
  ASSERT_EQ(one.size(), two.size());
  for (const auto& [name, bytes] : one) {
    ASSERT_TRUE(two.contains(name)) << name;
    EXPECT_TRUE(bytes == two.at(name)) << name << " differs";
  }
  const auto other = contents(folder / "other");
  int differing = 0;
  for (const auto& [name, bytes] : other)
    if (one.contains(name) && one.at(name) != bytes) ++differing;
  EXPECT_GE(differing, 8) << "another seed changes little";
}

TEST(CorniceSimulate, AFullDiskEndsItWithOneLineAndLeavesNothing) {
  const TemporaryFolder folder;
  ProcessResult result;
  // The child sees the folder as a small disk; the program it starts does, too.
  const auto outcome = on_full_disk(folder.path(), [&] {
    result = simulate(folder / "survey", {}, 0, "", "60");
    throw RunError("exit " + std::to_string(result.exit_code), result.err);
  });
  if (!outcome) GTEST_SKIP() << "nobody may mount a small disk here";
  EXPECT_NE(outcome->find("exit 1"), std::string::npos) << *outcome;
  EXPECT_NE(outcome->find("cornice-simulate: error: "), std::string::npos) << *outcome;
  EXPECT_NE(outcome->find("cannot be written: the disk is full; free some space"),
            std::string::npos)
      << *outcome;
  EXPECT_EQ(outcome->find("|survey"), std::string::npos) << "something stayed: " << *outcome;
  EXPECT_EQ(line_count(*outcome), 1u) << *outcome;
}

struct Mistake {
  const char* what;
  std::vector<std::string> options;
  int exit_code;
  const char* said;
};

TEST(CorniceSimulate, MistakesEndWithOneLineAndNoOutput) {
  const TemporaryFolder folder;
  write_text(folder / "bad.yaml", "cornice_scene: 1\nname: x\nbase_m: 0\ncliffs: []\n");
  const std::vector<Mistake> mistakes{
      {"sensor below the ground", {"--height", "60"}, 2, "--height"},
      {"unknown defect", {"--defects", "gremlins"}, 2, "gremlins"},
      {"unknown scanner", {"--scanner", "zigzag"}, 2, "--scanner"},
      {"bad tiles", {"--tiles", "2by2"}, 2, "--tiles"},
      {"channel in a format without",
       {"--channels", "2", "--channel-tag", "channel"},
       2,
       "--channel-tag"},
      {"too little memory", {"--container", "copc", "--memory", "0.0001"}, 1, "--memory"},
  };
  for (const Mistake& mistake : mistakes) {
    const fs::path out = folder / "survey";
    const ProcessResult result = simulate(out, mistake.options);
    EXPECT_EQ(result.exit_code, mistake.exit_code) << mistake.what << ": " << result.err;
    EXPECT_NE(result.err.find(mistake.said), std::string::npos) << mistake.what << result.err;
    EXPECT_NE(result.err.find("cornice-simulate: error: "), std::string::npos) << result.err;
    EXPECT_FALSE(fs::exists(out)) << mistake.what;
  }
  const ProcessResult unknown_key =
      run_process({std::string(CORNICE_BIN_DIR) + "/cornice-simulate",
                   (folder / "bad.yaml").string(), "-o", (folder / "survey").string()});
  EXPECT_EQ(unknown_key.exit_code, 3);
  EXPECT_NE(unknown_key.err.find("cliffs"), std::string::npos) << unknown_key.err;
}

TEST(CorniceSimulate, AnOutputThatCannotBeWrittenFailsWithTheReason) {
  const TemporaryFolder folder;
  write_text(folder / "file", "");
  const ProcessResult result = simulate(folder / "file/survey", {});
  EXPECT_EQ(result.exit_code, 1) << result.err;
  EXPECT_NE(result.err.find("cannot create its folder"), std::string::npos) << result.err;
}

/// True once a tile in the making has bytes.
bool is_being_written(const fs::path& folder) {
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (it->path().filename().string().find(".partial") != std::string::npos &&
        fs::file_size(it->path(), error) > 0)
      return true;
  return false;
}

TEST(CorniceSimulate, StoppedByASignalWhileItWritesItLeavesNothing) {
  const TemporaryFolder folder;
  const fs::path out = folder / "survey", now = folder / "now";
  bool was_written = false;
  std::atomic<bool> has_ended = false;
  std::thread watch([&] {
    while (!was_written && !has_ended) {
      was_written = is_being_written(out);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    if (was_written) write_text(now, "x");
  });
  const ProcessResult result = simulate(out, {"--noise", "0.02"}, SIGTERM, now.string(), "500");
  has_ended = true;
  watch.join();
  ASSERT_TRUE(was_written);
  EXPECT_EQ(result.exit_code, 128 + SIGTERM) << result.err;
  EXPECT_NE(result.err.find("stopped by signal"), std::string::npos) << result.err;
  EXPECT_FALSE(fs::exists(out));
}

}  // namespace
}  // namespace cornice::test
