// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/cli/command_line.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "core/base/error.h"

namespace cornice {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

struct Fields {
  std::vector<std::filesystem::path> tiles;
  std::vector<std::filesystem::path> neighbours;
  std::filesystem::path output;
  int count = 1;
  bool las = false;
  std::vector<int> classes;
};

std::vector<Option> describe(Fields& f) {
  return {Option("TILES", f.tiles, "point files").positional().required(),
          Option("neighbours", f.neighbours, "tiles around it"),
          Option("output", f.output, "what is written").short_flag('o').required(),
          Option("count", f.count, "how many").range(-5, 5).short_flag('j').unit("pieces"),
          Option("las", f.las, "writes LAS too").advanced(),
          Option("classes", f.classes, "classes kept")};
}

struct Parsed {
  CommandAction action = CommandAction::kRun;
  std::string problem;
};

Parsed parse(Fields& f, std::vector<const char*> words) {
  words.insert(words.begin(), "tool");
  std::vector<Option> options = describe(f);
  try {
    return {parse_command_line(static_cast<int>(words.size()), words.data(), options), ""};
  } catch (const UsageError& error) {
    return {CommandAction::kRun, error.what()};
  }
}

std::string problem_of(std::vector<const char*> words) {
  Fields f;
  return parse(f, std::move(words)).problem;
}

TEST(CommandLine, ReadsPositionalArgumentsFlagsAndLists) {
  Fields f;
  EXPECT_EQ(parse(f, {"a.laz", "b.laz", "--neighbours", "c.laz", "d.laz", "-o", "x.ply", "--count",
                      "-3", "--las", "--classes", "2,9"})
                .problem,
            "");
  EXPECT_THAT(f.tiles, ElementsAre("a.laz", "b.laz"));
  EXPECT_THAT(f.neighbours, ElementsAre("c.laz", "d.laz"));
  EXPECT_EQ(f.output, "x.ply");
  EXPECT_EQ(f.count, -3);
  EXPECT_TRUE(f.las);
  EXPECT_THAT(f.classes, ElementsAre(2, 9));
}

TEST(CommandLine, TakesValuesBehindAnEqualsSignOrAShortFlag) {
  Fields f;
  EXPECT_EQ(parse(f, {"a", "--output=x", "-j4"}).problem, "");
  EXPECT_EQ(f.output, "x");
  EXPECT_EQ(f.count, 4);
}

TEST(CommandLine, TakesFilesThatBeginWithADashBehindTwoDashes) {
  Fields f;
  EXPECT_EQ(parse(f, {"-o", "x", "--", "-odd.laz"}).problem, "");
  EXPECT_THAT(f.tiles, ElementsAre("-odd.laz"));
}

TEST(CommandLine, CollectsARepeatedListOfPaths) {
  Fields f;
  EXPECT_EQ(parse(f, {"a", "--neighbours", "b", "-o", "x", "--neighbours", "c"}).problem, "");
  EXPECT_THAT(f.neighbours, ElementsAre("b", "c"));
}

TEST(CommandLine, RefusesUnknownFlagsAndNamesTheNearest) {
  EXPECT_EQ(problem_of({"a", "-o", "x", "--cuont", "3"}),
            "--cuont: unknown option, did you mean --count?");
  EXPECT_EQ(problem_of({"a", "-o", "x", "--zzzzzz"}), "--zzzzzz: unknown option");
  EXPECT_EQ(problem_of({"a", "-o", "x", "--verion"}),
            "--verion: unknown option, did you mean --version?");
  EXPECT_THAT(problem_of({"a", "-o", "x", "-q"}), HasSubstr("-q: unknown option"));
}

TEST(CommandLine, RefusesMissingAndMalformedValuesInOneLine) {
  EXPECT_EQ(problem_of({"-o", "x"}), "TILES: is required");
  EXPECT_EQ(problem_of({"a"}), "--output: is required");
  EXPECT_THAT(problem_of({"a", "-o"}), HasSubstr("--output"));
  EXPECT_THAT(problem_of({"a", "-o", "x", "--count", "3m"}), HasSubstr("--count: '3m' is not"));
  EXPECT_THAT(problem_of({"a", "-o", "x", "--count", "6"}), HasSubstr("[-5, 5] pieces"));
  EXPECT_THAT(problem_of({"a", "-o", "x", "--count", "1", "--count", "2"}), HasSubstr("--count"));
  EXPECT_THAT(problem_of({"a", "-o", "x", "--las=3"}), HasSubstr("las"));
  for (const auto& problem : {problem_of({"a", "-o"}), problem_of({"a", "-o", "x", "--las=3"})}) {
    EXPECT_EQ(problem.find('\n'), std::string::npos);
  }
}

TEST(CommandLine, HelpWinsOverWhatIsMissingOrWrong) {
  Fields f;
  EXPECT_EQ(parse(f, {"--help"}).action, CommandAction::kHelp);
  EXPECT_EQ(parse(f, {"-h", "--nonsense"}).action, CommandAction::kHelp);
  EXPECT_EQ(parse(f, {"--help-all"}).action, CommandAction::kHelpAll);
  EXPECT_EQ(parse(f, {"-v"}).action, CommandAction::kVersion);
  EXPECT_EQ(parse(f, {"--version", "a"}).action, CommandAction::kVersion);
}

TEST(HelpText, FitsTheScreenAndNamesTypeUnitRangeAndDefault) {
  Fields f;
  const HelpPage page{"cornice-x", "Does x", {"cornice-x a.laz -o b.ply"}};
  const std::string text = help_text(page, describe(f), false);
  EXPECT_THAT(text, HasSubstr("Usage: cornice-x TILES... -o PATH [options]"));
  EXPECT_THAT(text, HasSubstr("how many ([-5, 5] pieces; default 1)"));
  EXPECT_THAT(text, HasSubstr("cornice-x a.laz -o b.ply"));
  EXPECT_THAT(text, HasSubstr("--help-all"));
  EXPECT_THAT(text, Not(HasSubstr("--las")));
  EXPECT_THAT(help_text(page, describe(f), true), HasSubstr("--las"));
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100u) << line;
}

}  // namespace
}  // namespace cornice
