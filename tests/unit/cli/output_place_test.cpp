// SPDX-License-Identifier: GPL-3.0-or-later
// Where nothing can be written a stage says so before its work.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/support/process.h"
#include "tests/support/temporary_folder.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;
using test::ProcessResult;
using test::run_process;
using testing::HasSubstr;

class OutputPlace : public testing::Test {
 protected:
  void SetUp() override {
    test::write_text(folder_ / "in.txt", "input");
    test::write_text(folder_ / "file", "");
  }

  /// `mark` is written when the work begins.
  ProcessResult probe(const fs::path& output, const fs::path& report) const {
    return run_process({std::string(CORNICE_BIN_DIR) + "/test-probe-stage", folder_ / "in.txt",
                        "-o", output, "--report", report, "--mark", folder_ / "mark"});
  }
  void expect_refused(const ProcessResult& result, const fs::path& path,
                      const std::string& problem) const {
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_THAT(result.err, HasSubstr("error: " + path.string() + ": " + problem));
    EXPECT_FALSE(fs::exists(folder_ / "mark")) << "it has worked";
  }
  test::TemporaryFolder folder_;
};

TEST_F(OutputPlace, BelowAFileIsRefusedBeforeTheWork) {
  const fs::path below = folder_ / "file" / "new" / "out.txt";
  const std::string problem = "cannot create its folder: " + (folder_ / "file").string();
  expect_refused(probe(below, folder_ / "report.json"), below, problem);
  expect_refused(probe(folder_ / "out.txt", below), below, problem);
}

TEST_F(OutputPlace, InAFolderThatMayNotBeWrittenIsRefusedBeforeTheWork) {
  if (geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  fs::create_directory(folder_ / "closed");
  fs::permissions(folder_ / "closed", fs::perms::owner_read | fs::perms::owner_exec);
  const fs::path output = folder_ / "closed" / "new" / "out.txt";
  expect_refused(probe(output, folder_ / "report.json"), output, "cannot write in ");
}

TEST_F(OutputPlace, MayBeAFolderThatIsNotThereYet) {
  const ProcessResult result = probe(folder_ / "a" / "b" / "out.txt", folder_ / "c" / "r.json");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(fs::exists(folder_ / "a" / "b" / "out.txt"));
  EXPECT_TRUE(fs::exists(folder_ / "c" / "r.json"));
}

}  // namespace
}  // namespace cornice
