// SPDX-License-Identifier: GPL-3.0-or-later
// Runs a real executable of the frame and looks at exit code, stdout, stderr and files.
#include "core/cli/stage.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>

#include "core/base/error.h"
#include "tests/support/json_file.h"
#include "tests/support/process.h"
#include "tests/support/temporary_folder.h"

namespace cornice {
namespace {

using test::line_count;
using test::ProcessResult;
using test::read_text;
using test::run_process;
using test::TemporaryFolder;
using test::write_text;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

const std::string kProbe = std::string(CORNICE_BIN_DIR) + "/test-probe-stage";

class StageFrame : public testing::Test {
 protected:
  void SetUp() override { write_text(folder_ / "in.txt", "input"); }

  ProcessResult probe(const std::vector<std::string>& more) const {
    std::vector<std::string> words{kProbe, folder_ / "in.txt", "-o", folder_ / "out.txt"};
    words.insert(words.end(), more.begin(), more.end());
    return run_process(words);
  }

  void expect_failure(const ProcessResult& result, int exit_code, const std::string& line) {
    EXPECT_EQ(result.exit_code, exit_code);
    EXPECT_THAT(result.err, StartsWith("cornice-probe: error: " + line));
    EXPECT_EQ(line_count(result.err), 1u) << result.err;
    EXPECT_EQ(result.out, "");
    EXPECT_THAT(folder_.entries(), ElementsAre("in.txt"));
  }

  nlohmann::json report_of(const std::vector<std::string>& more) const {
    std::vector<std::string> words = more;
    words.insert(words.end(), {"--report", folder_ / "report.json"});
    probe(words);
    return test::read_json(folder_ / "report.json");
  }

  TemporaryFolder folder_;
};

TEST_F(StageFrame, WritesItsOutputAndASummaryAndNothingOnStdout) {
  const ProcessResult result = probe({});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.out, "");
  EXPECT_THAT(result.err, HasSubstr("1 input, steps 3 -> "));
  EXPECT_THAT(folder_.entries(), ElementsAre("in.txt", "out.txt"));
}

TEST_F(StageFrame, EndsInOneLineAndTheExitCodeOfItsKind) {
  const auto ending = [&](const std::string& end) {
    return probe({"--no-progress", "--end", end});
  };
  expect_failure(ending("input"), 3, "a.laz: is not LAS\n");
  expect_failure(ending("run"), 1, "a.ply: the disk is full\n");
  expect_failure(ending("memory"), 1, "out of memory; ");
  expect_failure(ending("files"), 1, "b.ply: Input/output error\n");
  expect_failure(ending("unknown"), 1, "unexpected failure");
}

TEST_F(StageFrame, RefusesWrongUsageInOneLine) {
  expect_failure(probe({"--cuont", "3"}), 2, "--cuont: unknown option, did you mean --count?");
  expect_failure(probe({"--width-m", "3m"}), 2, "--width-m: '3m' is not a finite number in");
  expect_failure(probe({"--width-m", "nan"}), 2, "--width-m: 'nan' is not");
  expect_failure(probe({"--width-m", "11"}), 2, "--width-m: must be in [0.5, 10] m, but is 11");
  expect_failure(probe({"--threads", "-1"}), 2, "--threads: must be in [0, 1024], but is -1");
  expect_failure(probe({"--log-level", "loud"}), 2, "--log-level: must be one of error|warning");
  expect_failure(probe({"extra"}), 2, "'extra': is one argument too many");
  expect_failure(run_process({kProbe}), 2, "FILE: is required (see cornice-probe --help)");
}

TEST_F(StageFrame, SaysWhichInputIsMissing) {
  expect_failure(run_process({kProbe, folder_ / "absent", "-o", folder_ / "out.txt"}), 3,
                 (folder_ / "absent").string() + ": No such file or directory");
}

TEST_F(StageFrame, KeepsAnExistingOutputUnlessToldToOverwrite) {
  write_text(folder_ / "out.txt", "old");
  const ProcessResult refused = probe({});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("exists already; give --overwrite"));
  EXPECT_EQ(read_text(folder_ / "out.txt"), "old");
  EXPECT_EQ(probe({"--overwrite"}).exit_code, 0);
  EXPECT_NE(read_text(folder_ / "out.txt"), "old");
}

TEST_F(StageFrame, NeverReplacesAFileThatItReads) {
  const std::string in = folder_ / "in.txt";
  std::filesystem::create_hard_link(in, folder_ / "again.txt");
  const std::vector<std::string> names{in, folder_.path() / "." / "in.txt", folder_ / "again.txt"};
  for (const std::string& name : names) {
    const ProcessResult as_output = run_process({kProbe, in, "-o", name, "--overwrite"});
    EXPECT_EQ(as_output.exit_code, 2);
    EXPECT_THAT(as_output.err, HasSubstr(name + ": is read by this run; write to another file"));
    EXPECT_EQ(probe({"--report", name}).exit_code, 2);
  }
  EXPECT_EQ(read_text(in), "input");
  EXPECT_THAT(folder_.entries(), ElementsAre("again.txt", "in.txt"));
}

TEST_F(StageFrame, KeepsTheOldOutputWhenTheNewRunFails) {
  write_text(folder_ / "out.txt", "old");
  EXPECT_EQ(probe({"--overwrite", "--end", "run"}).exit_code, 1);
  EXPECT_EQ(read_text(folder_ / "out.txt"), "old");
}

TEST_F(StageFrame, PrintsHelpAndVersionOnStdout) {
  const ProcessResult help = run_process({kProbe, "--help"});
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_EQ(help.err, "");
  EXPECT_THAT(help.out, HasSubstr("Usage: cornice-probe FILE -o PATH [options]"));
  EXPECT_LE(line_count(help.out), 40u) << "more than a screen";
  const ProcessResult all = run_process({kProbe, "--help-all"});
  EXPECT_EQ(all.exit_code, 0);
  EXPECT_THAT(all.out, HasSubstr("--deaf"));
  const ProcessResult version = run_process({kProbe, "--version"});
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_THAT(version.out, StartsWith("cornice-probe " CORNICE_VERSION));
}

TEST_F(StageFrame, StopsOnASignalWithoutAHalfFile) {
  for (const int number : {SIGTERM, SIGINT}) {
    const TemporaryFolder marks;
    const std::string mark = marks / "mark";
    const auto start = std::chrono::steady_clock::now();
    const ProcessResult result = run_process({kProbe, folder_ / "in.txt", "-o", folder_ / "out.txt",
                                              "--count", "100000", "--no-progress", "--mark", mark},
                                             number, mark);
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(100))
        << "went on to its end";
    expect_failure(result, 128 + number, "stopped by signal " + std::to_string(number));
  }
}

TEST_F(StageFrame, ReportsARunThatWentWell) {
  const auto report = report_of({"--width-m", "9.5", "--end", "well", "--no-trim"});
  EXPECT_EQ(report["tool"], "cornice-probe");
  EXPECT_EQ(report["outcome"], "done");
  EXPECT_EQ(report["exit_code"], 0);
  EXPECT_EQ(report["parameters"]["width-m"], 9.5);
  EXPECT_EQ(report["parameters"]["end"], "well");
  EXPECT_EQ(report["parameters"]["trim"], false);
  EXPECT_EQ(report["parameters"]["threads"], 0);
  EXPECT_EQ(report["inputs"][0]["bytes"], 5);
  EXPECT_EQ(report["outputs"][0]["path"], (folder_ / "out.txt").string());
  EXPECT_EQ(report["counts"]["steps"], 3);
  EXPECT_EQ(report["steps"][0]["name"], "work");
  EXPECT_THAT(report["warnings"], ElementsAre("rather wide"));
  EXPECT_GT(report["peak_memory_bytes"], 0);
  EXPECT_TRUE(report["quality"]["not_a_number"].is_null());
}

TEST_F(StageFrame, ReportsARunThatFailed) {
  const auto report = report_of({"--end", "input"});
  EXPECT_EQ(report["outcome"], "failed");
  EXPECT_EQ(report["exit_code"], 3);
  EXPECT_EQ(report["error"], "a.laz: is\nnot LAS");
  EXPECT_TRUE(report["outputs"].empty());
  EXPECT_THAT(folder_.entries(), ElementsAre("in.txt", "report.json"));
}

TEST_F(StageFrame, KeepsTheReportOfARunWhoseRepetitionIsRefused) {
  EXPECT_EQ(report_of({})["outcome"], "done");
  EXPECT_EQ(report_of({})["outcome"], "done");
  EXPECT_EQ(probe({"--report", folder_ / "report.json"}).exit_code, 2);
}

TEST_F(StageFrame, FailsWhereTheReportCannotBeWritten) {
  const ProcessResult result = probe({"--report", "/proc/nowhere/report.json", "--no-progress"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("error: /proc/nowhere/report.json: "));
}

TEST_F(StageFrame, WritesReportsThatFollowTheSchema) {
  report_of({});
  // The system's own Python: another one on PATH does not see Debian's python3-jsonschema.
  const std::string python = "/usr/bin/python3";
  const std::string script =
      "import json, sys, jsonschema\n"
      "schema = json.load(open(sys.argv[1]))\n"
      "jsonschema.Draft7Validator.check_schema(schema)\n"
      "jsonschema.Draft7Validator(schema).validate(json.load(open(sys.argv[2])))\n";
  const std::string schema = std::string(CORNICE_SOURCE_DIR) + "/docs/report.schema.json";
  const std::string report = folder_ / "report.json";
  ProcessResult result = run_process({python, "-c", script, schema, report});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  for (const char* end : {"input", "memory"}) {
    probe({"--overwrite", "--end", end, "--report", report});
    result = run_process({python, "-c", script, schema, report});
    EXPECT_EQ(result.exit_code, 0) << result.err;
  }
  auto broken = test::read_json(report);
  broken.erase("machine");
  broken["surprise"] = 1;
  write_text(report, broken.dump());
  EXPECT_NE(run_process({python, "-c", script, schema, report}).exit_code, 0);
}

TEST(CheckOutput, TakesAnEmptyFolderAsFree) {
  const TemporaryFolder folder;
  CommonOptions options;
  EXPECT_NO_THROW(check_output(folder.path(), options));
  EXPECT_NO_THROW(check_output(folder / "absent", options));
  write_text(folder / "a", "");
  EXPECT_THROW(check_output(folder.path(), options), UsageError);
  options.overwrite = true;
  EXPECT_NO_THROW(check_output(folder.path(), options));
}

}  // namespace
}  // namespace cornice
