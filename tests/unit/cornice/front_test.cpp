// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "tests/support/process.h"
#include "tests/support/temporary_folder.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;
using test::line_count;
using test::ProcessResult;
using test::run_process;
using test::TemporaryFolder;
using test::write_text;
using testing::HasSubstr;
using testing::StartsWith;

const std::string kFront = std::string(CORNICE_BIN_DIR) + "/cornice";

/// A copy of the front in a folder of its own, with made-up stages beside it or on PATH.
class Front : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(folder_ / "bin");
    fs::create_directories(folder_ / "elsewhere");
    fs::copy_file(kFront, folder_ / "bin/cornice");
    setenv("PATH", (path_ + ":" + (folder_ / "elsewhere").string()).c_str(), 1);
  }
  void TearDown() override { setenv("PATH", path_.c_str(), 1); }

  void add_script(const std::string& name, const std::string& says) const {
    write_text(folder_ / name, "#!/bin/sh\necho \"" + says + ":$@\"\nexit 7\n");
    fs::permissions(folder_ / name, fs::perms::owner_all);
  }
  ProcessResult front(std::vector<std::string> words) const {
    words.insert(words.begin(), folder_ / "bin/cornice");
    return run_process(words);
  }

  const std::string path_ = std::getenv("PATH");
  TemporaryFolder folder_;
};

TEST_F(Front, BecomesTheStageBesideItWithItsArgumentsAndExitCode) {
  add_script("bin/cornice-normals", "beside");
  add_script("elsewhere/cornice-normals", "on PATH");
  const ProcessResult result = front({"normals", "a b", "--help"});
  EXPECT_EQ(result.exit_code, 7);
  EXPECT_EQ(result.out, "beside:a b --help\n");
  EXPECT_EQ(result.err, "");
}

TEST_F(Front, FindsStagesOnPathToo) {
  add_script("elsewhere/cornice-special", "on PATH");
  EXPECT_EQ(front({"special", "x"}).out, "on PATH:x\n");
}

TEST_F(Front, ShowsTheHelpOfAStage) {
  add_script("bin/cornice-info", "info");
  EXPECT_EQ(front({"help", "info"}).out, "info:--help\n");
  EXPECT_EQ(front({"--help", "info"}).out, "info:--help\n");
}

TEST_F(Front, RefusesUnknownStagesAndNamesTheNearest) {
  const ProcessResult result = front({"normls"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(result.err,
            "cornice: error: normls: unknown stage, did you mean normals? (see cornice --help)\n");
  EXPECT_EQ(front({"../bin/cornice"}).exit_code, 2);
  EXPECT_EQ(front({"--threads", "3"}).exit_code, 2);
  EXPECT_EQ(front({}).exit_code, 2);
  EXPECT_EQ(line_count(front({}).err), 1u);
}

TEST_F(Front, SaysWhereAKnownStageIsMissing) {
  const ProcessResult result = front({"normals"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("cornice-normals: is neither beside cornice nor on PATH"));
}

TEST_F(Front, PrintsHelpAndVersionOnStdout) {
  const ProcessResult help = front({"--help"});
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_EQ(help.err, "");
  EXPECT_LE(line_count(help.out), 24u);
  EXPECT_THAT(front({"--version"}).out, StartsWith("cornice "));
}

TEST_F(Front, ListsEveryStageOfThisProject) {
  const std::string help = front({"--help"}).out;
  int stages = 0;
  for (const auto& entry : fs::directory_iterator(fs::path(CORNICE_SOURCE_DIR) / "stages")) {
    if (!fs::exists(entry.path() / "main.cpp") || entry.path().filename() == "cornice") continue;
    EXPECT_THAT(help, HasSubstr("\n  " + entry.path().filename().string() + " "));
    ++stages;
  }
  EXPECT_GT(stages, 0);
}

}  // namespace
}  // namespace cornice
