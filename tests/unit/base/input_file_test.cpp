// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/base/input_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <string>

#include "core/base/error.h"
#include "tests/support/temporary_folder.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;
using test::TemporaryFolder;
using test::write_text;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

std::string problem_of(const fs::path& path) {
  try {
    check_input_file(path);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(CheckInputFile, AcceptsFilesAndLinksToThemWhateverTheirNames) {
  const TemporaryFolder folder;
  for (const char* name : {"tile.laz", "two words", "Größe\n2.ply"}) {
    write_text(folder / name, "x");
    EXPECT_EQ(problem_of(folder / name), "accepted");
  }
  fs::create_symlink(folder / "tile.laz", folder / "link");
  EXPECT_EQ(problem_of(folder / "link"), "accepted");
}

TEST(CheckInputFile, TellsWhatIsWrongAndWhatToDo) {
  const TemporaryFolder folder;
  const fs::path none = folder / "none.laz", dangling = folder / "dangling";
  fs::create_symlink(none, dangling);
  for (const fs::path& path : {none, dangling}) {
    EXPECT_THAT(problem_of(path),
                AllOf(StartsWith(path.string() + ": No such file"), HasSubstr("check the path")));
  }
  EXPECT_THAT(problem_of(folder.path()), HasSubstr("is a folder, not a file"));
  EXPECT_THAT(problem_of("/dev/null"), HasSubstr("is no regular file"));
}

TEST(CheckInputFile, DoesNotWaitForTheWriterOfAPipe) {
  const TemporaryFolder folder;
  ASSERT_EQ(mkfifo((folder / "pipe.ply").c_str(), 0600), 0);
  EXPECT_THAT(problem_of(folder / "pipe.ply"), HasSubstr("is no regular file"));
}

TEST(CheckInputFile, NamesMissingPermissions) {
  if (geteuid() == 0) GTEST_SKIP() << "root may read everything";
  const TemporaryFolder folder;
  write_text(folder / "secret.laz", "x");
  fs::permissions(folder / "secret.laz", fs::perms::none);
  EXPECT_THAT(problem_of(folder / "secret.laz"), HasSubstr("check its permissions"));
}

TEST(CheckUtf8Name, AcceptsTextAndNothingElse) {
  for (const char* name :
       {"", "tile.laz", "Größe\n€", "\xf0\x9f\x8f\x94.laz", "\xf4\x8f\xbf\xbf"}) {
    EXPECT_NO_THROW(check_utf8_name(name)) << name;
  }
  // Latin-1, a cut character, a lone continuation, overlong, a surrogate, beyond Unicode.
  for (const char* name : {"Gr\xf6\xdf"
                           "e",
                           "a\xe2\x82", "\x80", "\xc0\xaf", "\xe0\x9f\xbf", "\xf0\x8f\xbf\xbf",
                           "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xff"}) {
    EXPECT_THROW(check_utf8_name(name), InputError) << name;
  }
}

}  // namespace
}  // namespace cornice
