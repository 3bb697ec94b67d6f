// SPDX-License-Identifier: GPL-3.0-or-later
// cornice-info as a user runs it: what it prints where, and how it ends.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/io/las.h"
#include "tests/support/process.h"
#include "tests/support/temporary_folder.h"

namespace cornice {
namespace {

using test::ProcessResult;
using test::TemporaryFolder;
using testing::HasSubstr;

ProcessResult run_info(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), std::string(CORNICE_BIN_DIR) + "/cornice-info");
  arguments.push_back("--no-progress");
  return test::run_process(arguments);
}

std::string made_tile(const TemporaryFolder& folder, const std::string& name, int points) {
  LasWriteOptions options;
  options.crs = crs_from_text("EPSG:2154+5720");
  PointCloud cloud;
  for (int i = 0; i < points; ++i) {
    cloud.positions.push_back({static_cast<float>(i % 50), static_cast<float>(i / 50), 1.0f});
  }
  LasWriter writer(folder / name, options);
  writer.write(cloud);
  writer.close();
  return (folder / name).string();
}

/// Lines of stderr that say why it failed.
std::vector<std::string> error_lines(const ProcessResult& result) {
  std::vector<std::string> lines;
  std::istringstream text(result.err);
  for (std::string line; std::getline(text, line);) {
    if (line.find("error:") != std::string::npos) lines.push_back(line);
  }
  return lines;
}

TEST(InfoProgram, PrintsAScreenForOneFile) {
  const TemporaryFolder folder;
  const ProcessResult result = run_info({made_tile(folder, "a.laz", 500)});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("LAZ, LAS 1.4, point format 6"));
  EXPECT_THAT(result.out, HasSubstr("EPSG:2154+5720"));
  EXPECT_GT(test::line_count(result.out), 8u);
}

TEST(InfoProgram, PrintsALineForEachOfSeveralFilesOrAScreenIfAsked) {
  const TemporaryFolder folder;
  const std::string a = made_tile(folder, "a.laz", 500);
  const std::string b = made_tile(folder, "b.laz", 700);
  const ProcessResult lines = run_info({a, b});
  EXPECT_EQ(lines.exit_code, 0);
  EXPECT_EQ(test::line_count(lines.out), 2u);
  EXPECT_THAT(lines.out, HasSubstr("700 points"));
  EXPECT_GT(test::line_count(run_info({a, b, "--full"}).out), 16u);
}

TEST(InfoProgram, PrintsJsonAndNothingElseOnStandardOutput) {
  const TemporaryFolder folder;
  const std::string a = made_tile(folder, "a.laz", 500);
  const ProcessResult result = run_info({"--json", a});
  EXPECT_EQ(result.exit_code, 0);
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json["files"][0]["points"], 500);
}

TEST(InfoProgram, EndsWithThreeAndOneLineWhereNothingCanBeSaid) {
  const TemporaryFolder folder;
  test::write_text(folder / "empty.laz", "");
  for (const std::string& bad : {(folder / "empty.laz").string(), (folder / "absent.laz").string(),
                                 folder.path().string()}) {
    const ProcessResult result = run_info({bad});
    EXPECT_EQ(result.exit_code, 3) << bad;
    EXPECT_EQ(result.out, "") << bad;
    ASSERT_EQ(error_lines(result).size(), 1u) << result.err;
    EXPECT_THAT(error_lines(result)[0], testing::StartsWith("cornice-info: error: " + bad + ": "));
  }
}

TEST(InfoProgram, GoesOnAfterABadFileAndStillEndsWithThree) {
  const TemporaryFolder folder;
  test::write_text(folder / "empty.laz", "");
  const std::string good = made_tile(folder, "a.laz", 500);
  const ProcessResult text = run_info({(folder / "empty.laz").string(), good});
  EXPECT_EQ(text.exit_code, 3);
  EXPECT_EQ(test::line_count(text.out), 2u);
  EXPECT_THAT(text.out, HasSubstr("500 points"));
  EXPECT_THAT(text.err, HasSubstr("1 of 2 files cannot be read"));
  const ProcessResult json = run_info({"--json", (folder / "empty.laz").string(), good});
  EXPECT_EQ(json.exit_code, 3);
  const auto document = nlohmann::json::parse(json.out);
  EXPECT_THAT(document["files"][0]["error"].get<std::string>(), HasSubstr("is empty"));
  EXPECT_EQ(document["files"][1]["points"], 500);
}

TEST(InfoProgram, RefusesAnUnknownCrs) {
  const TemporaryFolder folder;
  const ProcessResult result = run_info({"--crs", "EPSG:999999", made_tile(folder, "a.laz", 50)});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("--crs"));
}

}  // namespace
}  // namespace cornice
