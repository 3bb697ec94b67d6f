// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/dropped_files.h"

#include <gtest/gtest.h>

#include "terrain-viewer/render/offscreen_context.h"
#include "tests/support/foreign_tiff.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/viewer_session/plates.h"

namespace cornice::viewer {
namespace {

namespace fs = std::filesystem;

class Dropped : public testing::Test {
 protected:
  Dropped() {
    write("first.hlod");
    write("second.hlod");
    desk_.emplace(std::vector<fs::path>{folder_ / "first.hlod"});
    layers_ = {folder_ / "first.hlod"};
    test::write_text(folder_ / "text.txt", "no raster");
    test::write_text(folder_ / "broken.hlod", "no hierarchy");
  }
  void write(const std::string& name) {
    write_plate(folder_ / name, [](double, double) { return 0.0; }, {90, 90, 90});
  }
  void write_raster(const std::string& name, GDALDataType type, double east_m = 0.0) {
    test::ForeignTiff tiff(folder_ / name, 50, 100, type);
    const Vec3d corner = plate_corner();
    tiff.transform({corner.x + east_m, 1.0, 0.0, corner.y + kPlateM, 0.0, -1.0});
    tiff.fill(std::vector<double>(50 * 100, 100.0));
  }
  std::string open(const std::vector<fs::path>& files) {
    const Opened opened = open_files(session(), layers_, files);
    layers_.insert(layers_.end(), opened.hierarchies.begin(), opened.hierarchies.end());
    return opened.message;
  }
  Session& session() { return desk_->session(); }

  test::TemporaryFolder folder_;
  OffscreenContext context_;
  std::optional<Desk> desk_;
  std::vector<fs::path> layers_;
};

TEST_F(Dropped, AHierarchyBecomesALayerOnce) {
  EXPECT_EQ(open({folder_ / "second.hlod"}), "opened second.hlod");
  ASSERT_EQ(session().layers().size(), 2u);
  EXPECT_EQ(session().looks().size(), 2u);
  EXPECT_NE(open({folder_ / "x" / ".." / "second.hlod"}).find("not there"), std::string::npos);
  EXPECT_NE(open({folder_ / "second.hlod"}).find("is a layer already"), std::string::npos);
  EXPECT_EQ(session().layers().size(), 2u);
}

TEST_F(Dropped, BytesAreAPhotographAndOtherNumbersDifferences) {
  write_raster("west.tif", GDT_Byte);
  write_raster("east.tif", GDT_Byte, 50.0);
  EXPECT_EQ(open({folder_ / "west.tif", folder_ / "east.tif"}), "opened west.tif, east.tif");
  EXPECT_EQ(session().cover(), Cover::kPhoto);
  EXPECT_EQ(session().difference(), nullptr);
  write_raster("difference.tif", GDT_Float32);
  EXPECT_EQ(open({folder_ / "difference.tif"}), "opened difference.tif");
  EXPECT_EQ(session().cover(), Cover::kDifference);
  EXPECT_NE(session().photo(), nullptr) << "is still there";
}

TEST_F(Dropped, WhatCannotBeOpenedIsNamedAndChangesNothing) {
  struct Case {
    fs::path file;
    const char* says;
  };
  fs::create_directory(folder_ / "empty");
  for (const auto& [file, says] :
       {Case{folder_ / "text.txt", "neither a hierarchy"}, Case{folder_ / "broken.hlod", "is no"},
        Case{folder_ / "none.hlod", "not there"}, Case{folder_ / "empty", "folder without"}}) {
    const std::string message = open({file});
    EXPECT_NE(message.find(says), std::string::npos) << message;
    EXPECT_EQ(message.rfind(file.string(), 0), 0u) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  EXPECT_EQ(session().layers().size(), 1u);
  EXPECT_EQ(session().looks().size(), 1u);
  EXPECT_EQ(session().cover(), Cover::kNone);
  desk_->draw(above_plates());
}

TEST_F(Dropped, OfSeveralTheGoodOnesAreOpenedAndOneLineSaysAll) {
  const std::string message =
      open({folder_ / "text.txt", folder_ / "second.hlod", folder_ / "broken.hlod"});
  EXPECT_EQ(message.rfind("opened second.hlod; not opened: ", 0), 0u) << message;
  EXPECT_NE(message.find("text.txt"), std::string::npos) << message;
  EXPECT_NE(message.find("(and 1 more not opened)"), std::string::npos) << message;
  EXPECT_EQ(session().layers().size(), 2u);
}

TEST_F(Dropped, AFolderStandsForItsHierarchiesOrElseItsRasters) {
  fs::create_directory(folder_ / "tiles");
  write_raster("tiles/b.tif", GDT_Byte, 50.0);
  write_raster("tiles/a.tif", GDT_Byte);
  test::write_text(folder_ / "tiles" / "a.tfw", "");
  EXPECT_EQ(without_folders({folder_ / "tiles"}),
            (std::vector<fs::path>{folder_ / "tiles" / "a.tif", folder_ / "tiles" / "b.tif"}));
  fs::copy_file(folder_ / "second.hlod", folder_ / "tiles" / "c.hlod");
  EXPECT_EQ(without_folders({folder_ / "tiles", "x"}),
            (std::vector<fs::path>{folder_ / "tiles" / "c.hlod", "x"}));
  EXPECT_EQ(open({folder_ / "tiles"}), "opened c.hlod");
}

TEST_F(Dropped, ALongListIsCutShort) {
  std::vector<fs::path> files;
  for (int i = 0; i < 6; ++i) {
    write("n" + std::to_string(i) + ".hlod");
    files.push_back(folder_ / ("n" + std::to_string(i) + ".hlod"));
  }
  EXPECT_EQ(open(files), "opened n0.hlod, n1.hlod, n2.hlod and 3 more");
  EXPECT_EQ(session().layers().size(), 7u);
}

}  // namespace
}  // namespace cornice::viewer
