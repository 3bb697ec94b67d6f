// SPDX-License-Identifier: GPL-3.0-or-later
// Files that change behind an open layer's back.
#include <gtest/gtest.h>

#include <fstream>
#include <functional>

#include "tests/property/viewer/crater_fixture.h"
#include "tests/support/picture.h"

namespace cornice::viewer {
namespace {

constexpr double kErrorPixels = 1.0;

class ChangedFile : public CraterFixture {
 protected:
  void SetUp() override { std::filesystem::copy_file(crater_file(), file()); }
  std::filesystem::path file() const { return folder_ / "crater.hlod"; }
  /// The view from one place; whether all of it was to be had.
  struct Seen {
    bool is_whole = false;
    Picture picture;
    std::vector<std::string> failures;
  };
  /// Opens the file, which reads the coarsest level and no more, then changes it, then looks.
  Seen look_after(const std::function<void()>& change) const {
    CraterStudio studio(file(), 160, 120, {});
    change();
    const Camera camera = crater_camera(0.3);
    Seen seen;
    seen.is_whole = studio.settle(camera, kErrorPixels);
    seen.picture = studio.draw(studio.layer().list(), camera);
    seen.failures = studio.layer().take_failures();
    EXPECT_EQ(test::count_of(seen.picture, kMagenta), 0u);
    return seen;
  }
  static void expect_parents_and_notes(const Seen& seen) {
    EXPECT_FALSE(seen.is_whole);
    ASSERT_FALSE(seen.failures.empty());
    for (const std::string& failure : seen.failures) {
      EXPECT_NE(failure.find("crater.hlod"), std::string::npos) << failure;
      EXPECT_NE(failure.find("cell "), std::string::npos) << failure;
    }
  }

  test::TemporaryFolder folder_;
};

TEST_F(ChangedFile, ThatIsDeletedOrReplacedByAnotherOfItsNameIsReadOn) {
  const Seen whole = look_after([] {});
  ASSERT_TRUE(whole.is_whole);
  const Seen after_deletion = look_after([&] { std::filesystem::remove(file()); });
  EXPECT_TRUE(after_deletion.is_whole);
  EXPECT_EQ(after_deletion.picture.pixels, whole.picture.pixels);

  std::filesystem::copy_file(crater_file(), file());
  const Seen after_replacing = look_after([&] {
    test::write_text(folder_ / "other", "something else");
    std::filesystem::rename(folder_ / "other", file());
  });
  EXPECT_EQ(after_replacing.picture.pixels, whole.picture.pixels);
}

TEST_F(ChangedFile, ThatIsCutShortLeavesParentsOnTheScreenAndNotes) {
  expect_parents_and_notes(look_after(
      [&] { std::filesystem::resize_file(file(), std::filesystem::file_size(file()) / 8); }));
}

TEST_F(ChangedFile, ThatIsWrittenOverLeavesParentsOnTheScreenAndNotes) {
  expect_parents_and_notes(look_after([&] {
    std::fstream out(file(), std::ios::in | std::ios::out | std::ios::binary);
    const std::string noise(std::filesystem::file_size(file()), 'x');
    out.write(noise.data(), static_cast<std::streamsize>(noise.size()));
  }));
}

}  // namespace
}  // namespace cornice::viewer
