// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/new_file.h"

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"

namespace cornice::viewer {
namespace {

TEST(NewFile, HasANameThatNoneHas) {
  const test::TemporaryFolder folder;
  const auto name = [&] { return unused_stem(folder.path(), "view", {".png", ".json"}); };
  EXPECT_EQ(name(), "view");
  test::write_text(folder / "view.png", "");
  EXPECT_EQ(name(), "view-2");
  test::write_text(folder / "view-2.json", "");
  EXPECT_EQ(name(), "view-3") << "of neither ending";
  test::write_text(folder / "view-3.txt", "");
  EXPECT_EQ(name(), "view-3");
}

TEST(NewFile, TakesALinkThatLeadsNowhereForAFile) {
  const test::TemporaryFolder folder;
  std::filesystem::create_symlink(folder / "elsewhere.png", folder / "view.png");
  EXPECT_EQ(unused_stem(folder.path(), "view", {".png"}), "view-2");
}

TEST(NewFile, HasANameInAFolderThatIsNotThere) {
  EXPECT_EQ(unused_stem("/nowhere/at/all", "view", {".png"}), "view");
}

}  // namespace
}  // namespace cornice::viewer
