// SPDX-License-Identifier: GPL-3.0-or-later
// Where a file's coordinate system comes from.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/io/las.h"
#include "tests/support/small_files.h"
#include "tests/support/temporary_folder.h"

namespace cornice::test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr const char* kSwissName = "swisssurface3d_2019_2746-1234_2056_5728.las";
constexpr const char* kFrenchName = "LHD_FXX_0657_6868_PTS_O_LAMB93_IGN69.laz";
constexpr std::size_t kEncoding = 6;

LasWriteOptions options_of(int format, const std::string& crs) {
  LasWriteOptions options;
  options.point_format = format;
  options.version_minor = format < 6 ? 2 : 4;
  options.compress = false;
  if (!crs.empty()) options.crs = crs_from_text(crs);
  return options;
}

class CrsSources : public ::testing::Test {
 protected:
  LasInfo info_of(const std::string& name, const Bytes& bytes, const std::string& crs = "") {
    write_file(folder_ / name, bytes);
    return read_las_info(folder_ / name, {.crs_override = crs});
  }
  TemporaryFolder folder_;
};

TEST_F(CrsSources, WktOfAModernFileIsReadWithItsHeightPart) {
  const LasInfo info = info_of("a.las", point_file(options_of(6, "EPSG:2154+5720"), 5));
  EXPECT_EQ(info.crs_source, "wkt");
  EXPECT_EQ(info.crs.text(), "EPSG:2154+5720");
  EXPECT_THAT(info.warnings, IsEmpty());
}

TEST_F(CrsSources, GeotiffKeysOfAnOldFileAreReadWithTheirHeightPart) {
  const LasInfo info = info_of("a.las", point_file(options_of(1, "EPSG:2056+5728"), 5));
  EXPECT_EQ(info.crs_source, "geotiff keys");
  EXPECT_EQ(info.crs.text(), "EPSG:2056+5728");
}

TEST_F(CrsSources, WktWithoutItsBitIsReadWithAWarning) {
  const Bytes bytes = point_file(options_of(6, "EPSG:2154+5720"), 5);
  const LasInfo info = info_of("a.las", patched<std::uint16_t>(bytes, kEncoding, 1));
  EXPECT_EQ(info.crs.text(), "EPSG:2154+5720");
  EXPECT_THAT(info.warnings, Contains(HasSubstr("bit 4")));
}

TEST_F(CrsSources, TheProductsNameIsUsedWhereTheFileHasNone) {
  const LasInfo info = info_of(kSwissName, point_file(options_of(1, ""), 5));
  EXPECT_EQ(info.crs_source, "file name");
  EXPECT_EQ(info.crs.text(), "EPSG:2056+5728");
}

TEST_F(CrsSources, TheProductsNameAddsAMissingHeightPart) {
  const LasInfo info = info_of(kFrenchName, point_file(options_of(6, "EPSG:2154"), 5));
  EXPECT_EQ(info.crs_source, "wkt");
  EXPECT_EQ(info.crs.text(), "EPSG:2154+5720");
  EXPECT_THAT(info.warnings, Contains(HasSubstr("no height part")));
}

TEST_F(CrsSources, TheFileWinsOverANameThatDisagrees) {
  const LasInfo info = info_of(kFrenchName, point_file(options_of(6, "EPSG:2975"), 5));
  EXPECT_EQ(info.crs.text(), "EPSG:2975");
  EXPECT_THAT(info.warnings, Contains(HasSubstr("not that of its name")));
}

TEST_F(CrsSources, TheOptionWinsOverEverything) {
  const Bytes bytes = point_file(options_of(6, "EPSG:2154+5720"), 5);
  const LasInfo info = info_of(kSwissName, bytes, "EPSG:32632");
  EXPECT_EQ(info.crs_source, "option");
  EXPECT_EQ(info.crs.text(), "EPSG:32632");
}

TEST_F(CrsSources, NothingAnywhereGivesAnEmptyOne) {
  const LasInfo info = info_of("a.las", point_file(options_of(1, ""), 5));
  EXPECT_TRUE(info.crs.empty());
  EXPECT_EQ(info.crs_source, "");
}

TEST_F(CrsSources, AnUnreadableOneIsAnErrorThatNamesTheOptionWhichThenHelps) {
  const std::string garbage = "PROJCS[\"nonsense";
  LasWriteOptions wkt = options_of(6, "");
  wkt.vlrs.push_back({"LASF_Projection", 2112, "", {garbage.begin(), garbage.end()}, false});
  // One key: ProjectedCSTypeGeoKey = 65535, which is no code.
  LasWriteOptions keys = options_of(1, "");
  keys.vlrs.push_back({"LASF_Projection",
                       34735,
                       "",
                       {1, 0, 1, 0, 0, 0, 1, 0, 0x00, 0x0c, 0, 0, 1, 0, 0xff, 0xff},
                       false});
  for (const LasWriteOptions& options : {wkt, keys}) {
    const Bytes bytes = point_file(options, 5);
    try {
      info_of("a.las", bytes);
      ADD_FAILURE() << "no error";
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("coordinate system that cannot be read"));
      EXPECT_THAT(error.what(), HasSubstr("--crs"));
    }
    EXPECT_EQ(info_of("a.las", bytes, "EPSG:2056").crs.text(), "EPSG:2056");
  }
}

TEST_F(CrsSources, ABlankWktRecordIsAsGoodAsNone) {
  LasWriteOptions options = options_of(6, "");
  options.vlrs.push_back({"LASF_Projection", 2112, "", {' ', '\n', 0, 0}, false});
  EXPECT_TRUE(info_of("a.las", point_file(options, 5)).crs.empty());
}

}  // namespace
}  // namespace cornice::test
