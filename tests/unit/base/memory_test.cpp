// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/base/memory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "tests/support/temporary_folder.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;
using test::TemporaryFolder;
using test::write_text;
using testing::HasSubstr;

constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();

fs::path folder_in(const fs::path& root, const std::string& path) {
  fs::create_directories(root / path);
  return root / path;
}

TEST(PeakResidentBytes, GrowsByWhatIsTouched) {
  const std::uint64_t before = peak_resident_bytes();
  ASSERT_GT(before, 0u);
  const std::vector<char> touched(std::size_t{64} << 20, 'x');
  EXPECT_GE(peak_resident_bytes(), before + touched.size() / 2);
}

TEST(AvailableMemory, IsThatOfAMachine) {
  EXPECT_GT(available_memory_bytes(), std::uint64_t{64} << 20);
  EXPECT_LT(available_memory_bytes(), std::uint64_t{1} << 50);
}

TEST(ControlGroupLimit, OfVersionTwoIsTheLowestOfTheGroupAndThoseAbove) {
  const TemporaryFolder folder;
  write_text(folder / "cgroup", "0::/slurm/job_7/step_0\n");
  write_text(folder_in(folder.path(), "slurm/job_7/step_0") / "memory.max", "max\n");
  write_text(folder_in(folder.path(), "slurm/job_7") / "memory.max", "2147483648\n");
  write_text(folder_in(folder.path(), "slurm") / "memory.max", "8589934592\n");
  EXPECT_EQ(control_group_limit_bytes(folder / "cgroup", folder.path()), 2147483648u);
}

TEST(ControlGroupLimit, OfVersionOneIsReadFromTheMemoryController) {
  const TemporaryFolder folder;
  write_text(folder / "cgroup", "5:cpu,cpuacct:/other\n4:memory:/docker/abc\n");
  write_text(folder_in(folder.path(), "memory/docker/abc") / "memory.limit_in_bytes", "1000000\n");
  EXPECT_EQ(control_group_limit_bytes(folder / "cgroup", folder.path()), 1000000u);
}

TEST(ControlGroupLimit, IsNoneWhereNothingSetsOne) {
  const TemporaryFolder folder;
  write_text(folder / "cgroup", "0::/\nbroken line\n");
  EXPECT_EQ(control_group_limit_bytes(folder / "cgroup", folder.path()), kNoLimit);
  EXPECT_EQ(control_group_limit_bytes(folder / "absent", folder.path()), kNoLimit);
}

TEST(MemoryBudget, RefusesWhatDoesNotFitAndNamesTheRemedy) {
  MemoryBudget budget(std::uint64_t{3} << 30);
  budget.charge("points", std::uint64_t{2} << 30);
  try {
    budget.charge("grid", (std::uint64_t{1} << 30) + 1);
    FAIL() << "charged more than the limit";
  } catch (const RunError& error) {
    EXPECT_THAT(error.what(), HasSubstr("grid: needs 1.00 GiB"));
    EXPECT_THAT(error.what(), HasSubstr("3.00 GiB"));
    EXPECT_THAT(error.what(), HasSubstr("--memory"));
  }
  EXPECT_EQ(budget.charged_bytes(), std::uint64_t{2} << 30);
  budget.charge("grid", std::uint64_t{1} << 30);
  budget.release(std::uint64_t{3} << 30);
  EXPECT_EQ(budget.charged_bytes(), 0u);
}

TEST(MemoryBudget, DoesNotWrapAroundForHugeCharges) {
  MemoryBudget budget(100);
  budget.charge("a", 60);
  EXPECT_THROW(budget.charge("b", kNoLimit), RunError);
}

TEST(MemoryBudget, WithoutALimitHasTheMachines) {
  EXPECT_EQ(MemoryBudget().limit_bytes(), available_memory_bytes());
}

}  // namespace
}  // namespace cornice
