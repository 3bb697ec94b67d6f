// SPDX-License-Identifier: GPL-3.0-or-later
// cornice-flightlines as it is run, on simulated tiles.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/json_file.h"
#include "tests/support/process.h"
#include "tests/support/temporary_folder.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;
using test::ProcessResult;

const fs::path kBin = CORNICE_BIN_DIR;

/// Two tiles side by side under a conical scanner.
class LinesOfASurvey : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new test::TemporaryFolder;
    const fs::path scene = fs::path(CORNICE_SOURCE_DIR) / "samples" / "scenes" / "cliff.yaml";
    const ProcessResult run = test::run_process(
        {(kBin / "cornice-simulate").string(), scene.string(), "-o", (*folder_ / "survey").string(),
         "--tiles", "2x1", "--tile-size", "150", "--density", "1", "--scanner", "palmer",
         "--truth-dem-step", "0", "--no-progress"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }
  static fs::path output(const std::string& name) { return *folder_ / name; }
  static std::vector<std::string> tiles() {
    std::vector<std::string> found;
    for (const auto& entry : fs::directory_iterator(*folder_ / "survey"))
      if (entry.path().extension() == ".laz") found.push_back(entry.path().string());
    std::sort(found.begin(), found.end());
    return found;
  }
  static ProcessResult run(const std::vector<std::string>& files, const std::string& name,
                           const std::string& threads) {
    std::vector<std::string> arguments = {(kBin / "cornice-flightlines").string()};
    arguments.insert(arguments.end(), files.begin(), files.end());
    for (const std::string& argument :
         {std::string("-o"), output(name + ".gpkg").string(), std::string("--threads"), threads,
          std::string("--no-progress")})
      arguments.push_back(argument);
    return test::run_process(arguments);
  }

 private:
  static inline test::TemporaryFolder* folder_ = nullptr;
};

TEST_F(LinesOfASurvey, HaveTheSameBytesWithOneAndTwoThreads) {
  ASSERT_EQ(tiles().size(), 2u);
  const ProcessResult one = run(tiles(), "one", "1");
  ASSERT_EQ(one.exit_code, 0) << one.err;
  const ProcessResult two = run(tiles(), "two", "2");
  ASSERT_EQ(two.exit_code, 0) << two.err;
  EXPECT_FALSE(test::read_text(output("one.json")).empty());
  EXPECT_EQ(test::read_text(output("one.json")), test::read_text(output("two.json")));
  EXPECT_FALSE(test::read_text(output("one.gpkg")).empty());
  EXPECT_TRUE(test::read_text(output("one.gpkg")) == test::read_text(output("two.gpkg")));
}

TEST_F(LinesOfASurvey, AreAsManyAsWereFlownAndPrintTheirAcceptTest) {
  const ProcessResult found = run(tiles(), "both", "0");
  ASSERT_EQ(found.exit_code, 0) << found.err;
  const nlohmann::json truth = test::read_json(output("survey") / "truth" / "lines.json");
  const nlohmann::json lines = test::read_json(output("both.json"))["lines"];
  EXPECT_EQ(lines.size(), truth["lines"].size());
  for (const nlohmann::json& line : lines) EXPECT_FALSE(line["accept_test"].empty());
  EXPECT_NE((found.out + found.err).find("accept test"), std::string::npos);
}

TEST_F(LinesOfASurvey, AreFoundInATileThatHasOneLineOnly) {
  const ProcessResult found = run({tiles()[0]}, "alone", "1");
  ASSERT_EQ(found.exit_code, 0) << found.err;
  EXPECT_GE(test::read_json(output("alone.json"))["lines"].size(), 1u);
}

TEST_F(LinesOfASurvey, AreRefusedWhereATileIsNamedTwice) {
  const ProcessResult found = run({tiles()[0], tiles()[0]}, "twice", "1");
  EXPECT_EQ(found.exit_code, 2);
  EXPECT_FALSE(fs::exists(output("twice.gpkg")));
}

}  // namespace
}  // namespace cornice
