// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/cli/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "core/base/error.h"
#include "core/cli/log.h"
#include "tests/support/temporary_folder.h"

namespace cornice {
namespace {

using test::TemporaryFolder;
using test::write_text;
using testing::HasSubstr;

TEST(FileChecksum, IsXxh3Of64Bits) {
  const TemporaryFolder folder;
  write_text(folder / "empty", "");
  write_text(folder / "abc", "abc");
  // Values of `xxhsum -H3`.
  EXPECT_EQ(file_checksum(folder / "empty"), "2d06800538d394c2");
  EXPECT_EQ(file_checksum(folder / "abc"), "78af5f94892f3950");
  EXPECT_THROW(file_checksum(folder / "absent"), InputError);
}

TEST(FileChecksum, OfALargeFileDoesNotDependOnThePiecesRead) {
  const TemporaryFolder folder;
  std::string text(3'000'001, 'x');
  write_text(folder / "a", text);
  const std::string before = file_checksum(folder / "a");
  text[2'999'999] = 'y';
  write_text(folder / "b", text);
  EXPECT_NE(file_checksum(folder / "b"), before);
  write_text(folder / "b", std::string(3'000'001, 'x'));
  EXPECT_EQ(file_checksum(folder / "b"), before);
}

TEST(Report, HoldsInputsOnceWithSizeAndChecksum) {
  const TemporaryFolder folder;
  write_text(folder / "abc", "abc");
  Report report("cornice-probe");
  report.add_input(folder / "abc");
  report.add_input(folder / "abc");
  const auto json = report.to_json();
  ASSERT_EQ(json["inputs"].size(), 1u);
  EXPECT_EQ(json["inputs"][0]["bytes"], 3);
  EXPECT_EQ(json["inputs"][0]["xxh3"], "78af5f94892f3950");
}

TEST(Report, ReadsNoInputForItsChecksumWhereNoneIsAskedFor) {
  const TemporaryFolder folder;
  write_text(folder / "abc", "abc");
  Report report("cornice-probe", false);
  report.add_input(folder / "abc");
  EXPECT_FALSE(report.to_json()["inputs"][0].contains("xxh3"));
}

TEST(Report, RefusesInputsThatAreNotThere) {
  const TemporaryFolder folder;
  Report report("cornice-probe");
  EXPECT_THROW(report.add_input(folder / "absent"), InputError);
  EXPECT_THROW(report.add_input(folder.path()), InputError);
}

TEST(Report, AddsUpCountsAndStepsOfOneName) {
  Report report("cornice-probe");
  report.count("points", 5);
  report.count("points", 7);
  for (int i = 0; i < 3; ++i) report.step("fit", [] {});
  const auto json = report.to_json();
  EXPECT_EQ(json["counts"]["points"], 12);
  ASSERT_EQ(json["steps"].size(), 1u);
  EXPECT_EQ(json["steps"][0]["runs"], 3);
  EXPECT_GE(json["steps"][0]["seconds"], 0.0);
}

TEST(Report, TimesAStepThatThrows) {
  Report report("cornice-probe");
  EXPECT_THROW(report.step("fit", [] { throw std::runtime_error("x"); }), std::runtime_error);
  EXPECT_EQ(report.to_json()["steps"][0]["runs"], 1);
}

TEST(Report, KeepsTheOuterStepWhenStepsNest) {
  Report report("cornice-probe");
  report.step("all", [&] { report.step("part", [] {}); });
  const auto json = report.to_json();
  ASSERT_EQ(json["steps"].size(), 2u);
  EXPECT_EQ(json["steps"][0]["name"], "all");
  EXPECT_GE(json["steps"][0]["seconds"], json["steps"][1]["seconds"]);
}

TEST(Report, ListsOutputsThatExistWithTheirSize) {
  const TemporaryFolder folder;
  write_text(folder / "abc", "abc");
  Report report("cornice-probe");
  report.add_output(folder / "abc");
  report.add_output(folder / "abc");
  report.add_output(folder / "never-written");
  report.add_output("");
  const auto json = report.to_json();
  ASSERT_EQ(json["outputs"].size(), 1u);
  EXPECT_EQ(json["outputs"][0]["bytes"], 3);
}

TEST(Report, SummarisesInOneLine) {
  set_up_log("cornice-probe", "error");
  Report report("cornice-probe");
  report.count("points", 12);
  report.add_output("out.ply");
  report.warn("odd");
  EXPECT_THAT(report.summary(), HasSubstr("0 inputs, points 12 -> out.ply; "));
  EXPECT_THAT(report.summary(), HasSubstr("GiB, 1 warning"));
}

}  // namespace
}  // namespace cornice
