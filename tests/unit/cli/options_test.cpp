// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/cli/options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "core/base/error.h"

namespace cornice {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

enum class Colour { kRed, kBlue };

struct Fields {
  bool off = false;
  bool on = true;
  int count = 3;
  std::uint64_t seed = 1;
  float share = 0.25f;
  double width_m = 1.5;
  std::optional<double> maybe;
  std::string word = "a";
  std::filesystem::path path;
  std::vector<int> classes{2, 9};
  std::vector<double> steps;
  std::vector<std::string> names;
  std::vector<std::filesystem::path> files;
  Colour colour = Colour::kRed;
};

std::vector<std::pair<std::string, Colour>> colours() {
  return {{"red", Colour::kRed}, {"blue", Colour::kBlue}};
}

std::string usage_problem(Option option, const std::vector<std::string>& words) {
  try {
    option.parse(words);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Option, SetsFieldsOfEveryType) {
  Fields f;
  Option("off", f.off, "").parse({});
  Option("on", f.on, "").parse({});
  Option("count", f.count, "").parse({"-12"});
  Option("seed", f.seed, "").parse({"18446744073709551615"});
  Option("share", f.share, "").parse({"+0.5"});
  Option("width-m", f.width_m, "").parse({"1e3"});
  Option("maybe", f.maybe, "").parse({"-0.5"});
  Option("word", f.word, "").parse({"b c"});
  Option("path", f.path, "").parse({"x/y"});
  Option("classes", f.classes, "").parse({"1,2,3"});
  Option("steps", f.steps, "").parse({"0.5"});
  Option("names", f.names, "").parse({"p,q"});
  Option("files", f.files, "").parse({"p,q", "r"});
  Option("colour", f.colour, colours(), "").parse({"blue"});
  EXPECT_TRUE(f.off);
  EXPECT_FALSE(f.on);
  EXPECT_EQ(f.count, -12);
  EXPECT_EQ(f.seed, std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(f.share, 0.5f);
  EXPECT_EQ(f.width_m, 1000.0);
  EXPECT_EQ(f.maybe, -0.5);
  EXPECT_EQ(f.word, "b c");
  EXPECT_EQ(f.path, "x/y");
  EXPECT_THAT(f.classes, ElementsAre(1, 2, 3));
  EXPECT_THAT(f.steps, ElementsAre(0.5));
  EXPECT_THAT(f.names, ElementsAre("p", "q"));
  EXPECT_THAT(f.files, ElementsAre("p,q", "r"));
  EXPECT_EQ(f.colour, Colour::kBlue);
}

TEST(Option, RefusesTrailingTextAndWhatIsNoFiniteNumber) {
  Fields f;
  for (const char* word :
       {"3m", "", " 3", "3 ", "nan", "NaN", "inf", "-inf", "1e999", "0x10", "+-3", "1,5", "--3"}) {
    EXPECT_THAT(usage_problem(Option("width-m", f.width_m, ""), {word}),
                HasSubstr("is not a finite number"))
        << word;
  }
  for (const char* word : {"3.0", "1e3", "3m", "", "2147483648", "nan"}) {
    EXPECT_THAT(usage_problem(Option("count", f.count, ""), {word}),
                HasSubstr("is not a whole number"))
        << word;
  }
  EXPECT_THAT(usage_problem(Option("seed", f.seed, ""), {"-1"}), HasSubstr("is not"));
  EXPECT_THAT(usage_problem(Option("classes", f.classes, ""), {"1,,2"}), HasSubstr("is not"));
  EXPECT_THAT(usage_problem(Option("names", f.names, ""), {"a,"}), HasSubstr("is not"));
  EXPECT_THAT(usage_problem(Option("path", f.path, ""), {""}), HasSubstr("is not a path"));
  EXPECT_EQ(f.count, 3) << "a refused value was stored";
  EXPECT_EQ(f.width_m, 1.5) << "a refused value was stored";
}

TEST(Option, RefusalsNameTheFullOptionAndWhatIsAccepted) {
  Fields f;
  EXPECT_EQ(usage_problem(Option("halo-m", f.width_m, "").range(0, 500).unit("m"), {"900"}),
            "--halo-m: must be in [0, 500] m, but is 900");
  EXPECT_EQ(usage_problem(Option("halo-m", f.width_m, "").range(0, 500).unit("m"), {"x"}),
            "--halo-m: 'x' is not a finite number in [0, 500] m");
  EXPECT_EQ(usage_problem(Option("step-m", f.width_m, "").above(0).unit("m"), {"0"}),
            "--step-m: must be above 0 m, but is 0");
  EXPECT_EQ(usage_problem(Option("count", f.count, "").at_least(2), {"1"}),
            "--count: must be at least 2, but is 1");
  EXPECT_EQ(usage_problem(Option("classes", f.classes, "").range(0, 255), {"2,256"}),
            "--classes: must be in [0, 255], but is 256");
  EXPECT_EQ(usage_problem(Option("colour", f.colour, colours(), ""), {"green"}),
            "--colour: 'green' is not one of red|blue");
  EXPECT_EQ(usage_problem(Option("word", f.word, "").words({"a", "b"}), {"c"}),
            "--word: must be one of a|b, but is 'c'");
}

TEST(Option, AcceptsBothEndsOfARange) {
  Fields f;
  EXPECT_EQ(usage_problem(Option("count", f.count, "").range(1, 5), {"1"}), "accepted");
  EXPECT_EQ(usage_problem(Option("count", f.count, "").range(1, 5), {"5"}), "accepted");
  EXPECT_NE(usage_problem(Option("count", f.count, "").range(1, 5), {"0"}), "accepted");
  EXPECT_NE(usage_problem(Option("count", f.count, "").range(1, 5), {"6"}), "accepted");
}

TEST(Option, TellsTheEndingThatAPathMustHave) {
  std::filesystem::path path;
  Option option = Option("output", path, "mesh, .ply").ending(".ply");
  EXPECT_EQ(option.broken_rule(), std::nullopt) << "not given";
  option.parse({"a.b.ply"});
  EXPECT_EQ(path, "a.b.ply");
  try {
    option.parse({"a.obj"});
    FAIL() << "accepted";
  } catch (const UsageError& error) {
    EXPECT_STREQ(error.what(), "--output: must end in .ply, but is a.obj");
  }
}

TEST(Option, ChecksFieldsThatCodeHasSet) {
  Fields f;
  const std::vector<Option> options{Option("count", f.count, "").range(1, 5),
                                    Option("width-m", f.width_m, "").range(0, 2).unit("m"),
                                    Option("path", f.path, "").required(),
                                    Option("colour", f.colour, colours(), "")};
  EXPECT_EQ(first_broken_rule(options), "--path: is required");
  f.path = "x";
  EXPECT_EQ(first_broken_rule(options), std::nullopt);
  f.width_m = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(*first_broken_rule(options), HasSubstr("--width-m: must be finite"));
  f.count = 9;
  EXPECT_EQ(first_broken_rule(options), "--count: must be in [1, 5], but is 9");
  EXPECT_THROW(check_options(options), UsageError);
  f.count = 5;
  f.width_m = 0.0;
  f.colour = static_cast<Colour>(17);
  EXPECT_EQ(first_broken_rule(options), "--colour: must be one of red|blue");
}

TEST(Option, ShowsDefaultsAsTheUserWouldWriteThem) {
  Fields f;
  EXPECT_EQ(Option("share", f.share, "").default_text(), "0.25");
  EXPECT_EQ(Option("classes", f.classes, "").default_text(), "2,9");
  f.width_m = 100000.0;
  EXPECT_EQ(Option("width-m", f.width_m, "").default_text(), "100000");
  f.width_m = 1e-9;
  EXPECT_EQ(Option("width-m", f.width_m, "").default_text(), "1e-09");
  EXPECT_EQ(Option("colour", f.colour, colours(), "").default_text(), "red");
  EXPECT_EQ(Option("maybe", f.maybe, "").default_text(), "");
  EXPECT_EQ(Option("on", f.on, "").title(), "--no-on");
  EXPECT_EQ(Option("off", f.off, "").title(), "--off");
}

TEST(NearestNames, FindsTyposAndBeginningsButNothingFar) {
  const std::vector<std::string> known{"--halo-m", "--threads", "--report"};
  EXPECT_THAT(nearest_names("--hallo-m", known), ElementsAre("--halo-m"));
  EXPECT_THAT(nearest_names("--thr", known), ElementsAre("--threads"));
  EXPECT_THAT(nearest_names("--quality", known), IsEmpty());
  EXPECT_EQ(did_you_mean("--hallo-m", known), ", did you mean --halo-m?");
  EXPECT_EQ(did_you_mean("--quality", known), "");
}

}  // namespace
}  // namespace cornice
