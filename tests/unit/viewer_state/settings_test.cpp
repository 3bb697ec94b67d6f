// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/settings.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "core/base/error.h"
#include "tests/support/temporary_folder.h"

namespace cornice::viewer {
namespace {

/// An environment variable for the time of a test.
class Variable {
 public:
  Variable(const char* name, const char* value) : name_(name) {
    if (const char* before = std::getenv(name)) before_ = before, was_set_ = true;
    value != nullptr ? setenv(name, value, 1) : unsetenv(name);
  }
  ~Variable() { was_set_ ? setenv(name_, before_.c_str(), 1) : unsetenv(name_); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  const char* name_;
  std::string before_;
  bool was_set_ = false;
};

TEST(Settings, AreKeptWhereTheDesktopKeepsThem) {
  const Variable home("HOME", "/home/someone");
  {
    const Variable config("XDG_CONFIG_HOME", "/elsewhere");
    EXPECT_EQ(settings_path(), "/elsewhere/cornice/viewer.json");
  }
  {
    const Variable config("XDG_CONFIG_HOME", "not/absolute");
    EXPECT_EQ(settings_path(), "/home/someone/.config/cornice/viewer.json");
  }
  const Variable config("XDG_CONFIG_HOME", nullptr);
  EXPECT_EQ(settings_path(), "/home/someone/.config/cornice/viewer.json");
  const Variable no_home("HOME", nullptr);
  EXPECT_TRUE(settings_path().empty());
}

TEST(Settings, KeepTheBookmarksOfEachScene) {
  test::TemporaryFolder folder;
  const Camera camera{{2600123.25, 1200456.5, 1789.0}, 271.5, -12.25, 47.0};
  Settings settings;
  settings.set_bookmarks("/a/one.hlod", {{"view 1", camera}, {"view 2", {}}});
  settings.set_bookmarks("/a/two.hlod", {{"summit \"N\"", camera}});
  settings.set_bookmarks("/a/one.hlod", {{"view 2", {}}});
  write_settings(folder / "viewer.json", settings);
  const SettingsRead read = read_settings(folder / "viewer.json");
  EXPECT_EQ(read.problem, "");
  const auto one = read.settings.bookmarks_of("/a/b/../one.hlod");
  ASSERT_EQ(one.size(), 1u);
  EXPECT_EQ(one[0].name, "view 2");
  const auto two = read.settings.bookmarks_of("/a/two.hlod");
  ASSERT_EQ(two.size(), 1u);
  EXPECT_EQ(two[0].name, "summit \"N\"");
  EXPECT_EQ(two[0].camera, camera);
  EXPECT_TRUE(read.settings.bookmarks_of("/a/three.hlod").empty());
}

TEST(Settings, TakeNothingForABookmarkThatIsNone) {
  test::TemporaryFolder folder;
  for (const char* entry :
       {R"(7)", R"({"file": "/a"})", R"({"file": "/a", "name": "b", "eye": [1, 2]})",
        R"({"file": "/a", "name": 3, "eye": [1, 2, 3]})"}) {
    std::ofstream(folder / "viewer.json") << R"({"edges": true, "bookmarks": [)" << entry << "]}";
    const SettingsRead read = read_settings(folder / "viewer.json");
    EXPECT_TRUE(read.settings.marked.empty()) << entry;
    EXPECT_TRUE(read.settings.has_edges) << entry;
    EXPECT_NE(read.problem.find("\"bookmarks\""), std::string::npos) << entry;
  }
}

TEST(Settings, ComeBackAsTheyWereWritten) {
  test::TemporaryFolder folder;
  const auto file = folder / "new" / "viewer.json";
  Settings settings;
  settings.window = {1700, 950};
  settings.shading = Shading::kSlope;
  settings.contour_interval_m = 20.0;
  settings.error_pixels = 3.5;
  settings.frame_ms = 33.0;
  settings.has_edges = true;
  settings.shows_layers = false;
  settings.shows_frames = true;
  settings.opened("/data/a b \"c\".hlod");
  settings.opened("/data/\xc3\xa9.hlod");
  write_settings(file, settings);
  const SettingsRead read = read_settings(file);
  EXPECT_EQ(read.problem, "");
  EXPECT_EQ(read.settings.window.width, 1700);
  EXPECT_EQ(read.settings.window.height, 950);
  EXPECT_EQ(read.settings.shading, Shading::kSlope);
  EXPECT_EQ(read.settings.contour_interval_m, 20.0);
  EXPECT_EQ(read.settings.error_pixels, 3.5);
  EXPECT_EQ(read.settings.frame_ms, 33.0);
  EXPECT_TRUE(read.settings.has_edges);
  EXPECT_FALSE(read.settings.shows_layers);
  EXPECT_TRUE(read.settings.shows_frames);
  EXPECT_EQ(read.settings.recent, settings.recent);
}

TEST(Settings, AreDefaultsWhereThereAreNone) {
  test::TemporaryFolder folder;
  for (const auto& path : {folder / "none.json", std::filesystem::path()}) {
    const SettingsRead read = read_settings(path);
    EXPECT_EQ(read.problem, "");
    EXPECT_EQ(read.settings.window.width, 1280);
    EXPECT_TRUE(read.settings.recent.empty());
  }
}

TEST(Settings, ThatAreDamagedAreReportedAndIgnored) {
  test::TemporaryFolder folder;
  const auto file = folder / "viewer.json";
  for (const char* text : {"", "{", "[1, 2]", "\x01\x02\xff", "3", "{\"window_width\": 800"}) {
    test::write_text(file, text);
    const SettingsRead read = read_settings(file);
    EXPECT_NE(read.problem.find("viewer.json"), std::string::npos) << text;
    EXPECT_EQ(read.settings.window.width, 1280) << text;
  }
  const SettingsRead folder_read = read_settings(folder.path());
  EXPECT_NE(folder_read.problem, "");
}

TEST(Settings, KeepWhatMakesSenseAndNameWhatDoesNot) {
  test::TemporaryFolder folder;
  const auto file = folder / "viewer.json";
  test::write_text(file,
                   R"({"window_width": 900, "window_height": -4, "shading": "pink", "edges": 1,
                       "error_pixels": 1e99, "frame_ms": 20, "recent": ["/a.hlod", 7, "/b.hlod"],
                       "of a later version": {}})");
  const SettingsRead read = read_settings(file);
  EXPECT_EQ(read.settings.window.width, 900);
  EXPECT_EQ(read.settings.window.height, 720);
  EXPECT_EQ(read.settings.shading, Shading::kNatural);
  EXPECT_EQ(read.settings.frame_ms, 20.0);
  EXPECT_EQ(read.settings.error_pixels, 2.0);
  for (const char* key : {"window_height", "shading", "edges", "error_pixels", "recent"})
    EXPECT_NE(read.problem.find(key), std::string::npos) << key << ": " << read.problem;
  EXPECT_EQ(read.problem.find("window_width"), std::string::npos);
}

TEST(Settings, RememberTheLatestFilesOnceEach) {
  Settings settings;
  for (int i = 0; i < 20; ++i) settings.opened("/data/" + std::to_string(i) + ".hlod");
  EXPECT_EQ(settings.recent.size(), Settings::kMostRecent);
  EXPECT_EQ(settings.recent.front(), "/data/19.hlod");
  settings.opened("/data/x/../15.hlod");
  EXPECT_EQ(settings.recent.front(), "/data/15.hlod");
  EXPECT_EQ(settings.recent.size(), Settings::kMostRecent);
  EXPECT_EQ(settings.recent[1], "/data/19.hlod");
  settings.opened("relative.hlod");
  EXPECT_TRUE(settings.recent.front().is_absolute());
}

TEST(Settings, ThatCannotBeWrittenAreAnErrorThatNamesTheFile) {
  test::TemporaryFolder folder;
  test::write_text(folder / "file", "");
  EXPECT_THROW(write_settings(folder / "file" / "viewer.json", {}), RunError);
}

TEST(Settings, AreTheDefaultsOfTheCommandLine) {
  Settings settings;
  settings.window = {800, 600};
  settings.shading = Shading::kAspect;
  settings.error_pixels = 4.0;
  Options options;
  apply(settings, options);
  EXPECT_EQ(options.size, "800x600");
  EXPECT_EQ(options.shading, Shading::kAspect);
  EXPECT_EQ(options.error_pixels, 4.0);
}

}  // namespace
}  // namespace cornice::viewer
