// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/programs.h"

#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "core/base/error.h"

namespace cornice::bench {
namespace {

std::string error_of(const std::vector<std::string>& arguments) {
  const ScratchFolder folder("programs-test");
  try {
    run_program(arguments, folder / "log");
  } catch (const RunError& error) {
    return error.what();
  }
  return "";
}

TEST(Programs, AFailedProgramsErrorEndsWithItsLastWords) {
  EXPECT_EQ(error_of({"sh", "-c", "echo first; echo 'no more paper' >&2; echo; exit 7"}),
            "sh: failed with exit code 7; it said: no more paper");
}

TEST(Programs, AProgramThatIsKilledIsAnError) {
  EXPECT_EQ(error_of({"sh", "-c", "kill -9 $$"}), "sh: was ended by signal 9");
}

TEST(Programs, AProgramThatIsNotThereIsAnError) {
  EXPECT_NE(error_of({"/no/such/program"}).find("/no/such/program"), std::string::npos);
}

TEST(Programs, ArgumentsArriveAsTheyAreAndAreNotReadByAShell) {
  const ScratchFolder folder("programs-test");
  const std::filesystem::path log = folder / "log";
  run_program({"printf", "%s", "a b'c\"$HOME;*"}, log);
  std::string said;
  std::getline(std::ifstream(log), said);
  EXPECT_EQ(said, "a b'c\"$HOME;*");
}

TEST(Programs, MemoryIsTheProgramsOwn) {
  const std::string held(200'000'000, 'x');
  const ScratchFolder folder("programs-test");
  const ProgramCost cost = run_program({"sleep", "1"}, folder / "log");
  EXPECT_GE(cost.seconds, 1.0);
  EXPECT_GT(cost.peak_resident_bytes, 100'000u);
  EXPECT_LT(cost.peak_resident_bytes, 50'000'000u) << held.size();
}

TEST(Programs, ScratchFoldersGoWithAllTheyHold) {
  std::filesystem::path path;
  {
    const ScratchFolder folder("programs-test");
    path = folder.path();
    std::filesystem::create_directories(folder / "deep");
    std::ofstream(folder / "deep" / "file") << "text";
  }
  EXPECT_FALSE(path.empty());
  EXPECT_FALSE(std::filesystem::exists(path));
}

}  // namespace
}  // namespace cornice::bench
