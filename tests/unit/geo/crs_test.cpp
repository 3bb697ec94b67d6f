// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geo/crs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <thread>

#include "core/base/error.h"

namespace cornice {
namespace {

using Keys = std::vector<std::array<std::uint16_t, 4>>;

std::vector<unsigned char> key_record(const Keys& keys) {
  std::vector<std::uint16_t> words = {1, 1, 0, static_cast<std::uint16_t>(keys.size())};
  for (const auto& key : keys) words.insert(words.end(), key.begin(), key.end());
  std::vector<unsigned char> bytes(words.size() * 2);
  std::memcpy(bytes.data(), words.data(), bytes.size());
  return bytes;
}

TEST(CrsFromText, ReadsACompoundOfTwoCodes) {
  const Crs swiss = crs_from_text("EPSG:2056+5728");
  EXPECT_EQ(swiss.horizontal_epsg, 2056);
  EXPECT_EQ(swiss.vertical_epsg, 5728);
  EXPECT_TRUE(swiss.projected);
  EXPECT_TRUE(swiss.has_vertical);
  EXPECT_DOUBLE_EQ(swiss.metres_per_unit, 1.0);
  EXPECT_EQ(swiss.text(), "EPSG:2056+5728");
  EXPECT_THAT(swiss.wkt, testing::StartsWith("COMPD_CS["));
  const Crs french = crs_from_text("EPSG:2154+5720");
  EXPECT_EQ(french.text(), "EPSG:2154+5720");
}

TEST(CrsFromText, ReadsAHorizontalCodeAlone) {
  const Crs crs = crs_from_text(" EPSG:2154 ");
  EXPECT_EQ(crs.text(), "EPSG:2154");
  EXPECT_FALSE(crs.has_vertical);
  EXPECT_EQ(crs.vertical_epsg, 0);
}

TEST(CrsFromText, KnowsFeetAndDegrees) {
  EXPECT_NEAR(crs_from_text("EPSG:2903").metres_per_unit, 1200.0 / 3937.0, 1e-12);
  const Crs international = crs_from_text("EPSG:2992");
  EXPECT_DOUBLE_EQ(international.metres_per_unit, 0.3048);
  EXPECT_DOUBLE_EQ(international.vertical_metres_per_unit, 0.3048);
  const Crs mixed = crs_from_text("EPSG:2154+6360");
  EXPECT_DOUBLE_EQ(mixed.metres_per_unit, 1.0);
  EXPECT_NEAR(mixed.vertical_metres_per_unit, 1200.0 / 3937.0, 1e-12);
  const Crs degrees = crs_from_text("EPSG:4326");
  EXPECT_FALSE(degrees.projected);
  EXPECT_EQ(degrees.metres_per_unit, 0.0);
  EXPECT_DOUBLE_EQ(degrees.vertical_metres_per_unit, 1.0);
}

TEST(CrsFromText, ReadsWktAndProjStrings) {
  EXPECT_EQ(crs_from_text(crs_from_text("EPSG:2154+5720").wkt).text(), "EPSG:2154+5720");
  const Crs proj = crs_from_text("+proj=utm +zone=32 +datum=WGS84 +units=m");
  EXPECT_TRUE(proj.projected);
  EXPECT_EQ(proj.horizontal_epsg, 32632);
}

TEST(CrsFromText, RefusesWhatIsNoMapSystemWithoutPrinting) {
  for (const char* text :
       {"", "nonsense", "EPSG:999999", "EPSG:5728", "EPSG:4978", "EPSG:2056+2154", "/etc/passwd",
        "http://127.0.0.1/crs", "PROJCS[\"half"}) {
    testing::internal::CaptureStderr();
    EXPECT_THROW(crs_from_text(text), UsageError) << text;
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << text;
  }
  try {
    crs_from_text("EPSG:999999");
  } catch (const UsageError& error) {
    EXPECT_EQ(error.subject(), "--crs");
    EXPECT_THAT(error.problem(), testing::HasSubstr("EPSG:999999"));
  }
}

TEST(CrsFromWkt, ReadsBothVersionsOfWkt) {
  const std::string wkt2 =
      R"(GEOGCRS["WGS 84",DATUM["World Geodetic System 1984",ELLIPSOID["WGS 84",6378137,)"
      R"(298.257223563]],CS[ellipsoidal,2],AXIS["latitude",north],AXIS["longitude",east],)"
      R"(UNIT["degree",0.0174532925199433],ID["EPSG",4326]])";
  const auto crs = crs_from_wkt(wkt2);
  ASSERT_TRUE(crs);
  EXPECT_EQ(crs->horizontal_epsg, 4326);
  EXPECT_THAT(crs->wkt, testing::StartsWith("GEOGCS["));
}

TEST(CrsFromWkt, IgnoresPaddingAndWhatFollowsTheFirstZeroByte) {
  std::string wkt = "\n " + crs_from_text("EPSG:2154").wkt + "  ";
  wkt.push_back('\0');
  wkt += "rubbish";
  const auto crs = crs_from_wkt(wkt);
  ASSERT_TRUE(crs);
  EXPECT_EQ(crs->text(), "EPSG:2154");
}

TEST(CrsFromWkt, GivesNothingForEmptyBrokenOrVerticalText) {
  EXPECT_FALSE(crs_from_wkt(""));
  EXPECT_FALSE(crs_from_wkt(std::string(40, '\0')));
  EXPECT_FALSE(crs_from_wkt("PROJCS[\"cut off"));
  EXPECT_FALSE(crs_from_wkt(R"(VERT_CS["h",VERT_DATUM["d",2005],UNIT["metre",1]])"));
}

TEST(CrsFromWkt, FindsTheCodeOfAWellKnownSystemThatCarriesNone) {
  const std::string lambert =
      R"(PROJCS["RGF93_Lambert_93",GEOGCS["GCS_RGF_1993",DATUM["D_RGF_1993",)"
      R"(SPHEROID["GRS_1980",6378137.0,298.257222101]],PRIMEM["Greenwich",0.0],)"
      R"(UNIT["Degree",0.0174532925199433]],PROJECTION["Lambert_Conformal_Conic"],)"
      R"(PARAMETER["False_Easting",700000.0],PARAMETER["False_Northing",6600000.0],)"
      R"(PARAMETER["Central_Meridian",3.0],PARAMETER["Standard_Parallel_1",49.0],)"
      R"(PARAMETER["Standard_Parallel_2",44.0],PARAMETER["Latitude_Of_Origin",46.5],)"
      R"(UNIT["Meter",1.0]])";
  const auto crs = crs_from_wkt(lambert);
  ASSERT_TRUE(crs);
  EXPECT_EQ(crs->horizontal_epsg, 2154);
}

TEST(CrsFromGeotiffKeys, ReturnsWhatWasWrittenForSystemsWithCodes) {
  for (const char* text : {"EPSG:2056+5728", "EPSG:2154+5720", "EPSG:2154", "EPSG:2975+5758",
                           "EPSG:4326", "EPSG:2903", "EPSG:32632"}) {
    const Crs crs = crs_from_text(text);
    const auto keys = geotiff_keys_from_crs(crs);
    ASSERT_FALSE(keys.empty()) << text;
    const auto back = crs_from_geotiff_keys(keys, {}, "");
    ASSERT_TRUE(back) << text;
    EXPECT_EQ(back->text(), text);
    EXPECT_TRUE(same_crs(*back, crs));
    EXPECT_DOUBLE_EQ(back->metres_per_unit, crs.metres_per_unit);
  }
}

TEST(CrsFromGeotiffKeys, ReadsKeysOfGeotiffOnePointZeroWithAVerticalPart) {
  // The keys of a real survey: BC Albers with CGVD28 heights.
  const auto crs = crs_from_geotiff_keys(key_record({{1024, 0, 1, 1},
                                                     {3072, 0, 1, 3005},
                                                     {3076, 0, 1, 9001},
                                                     {4096, 0, 1, 5713},
                                                     {4099, 0, 1, 9001}}),
                                         {}, "");
  ASSERT_TRUE(crs);
  EXPECT_EQ(crs->text(), "EPSG:3005+5713");
}

TEST(CrsFromGeotiffKeys, TakesTheUnitOfHeightsFromItsKeyWhereThereIsNoVerticalSystem) {
  const auto crs = crs_from_geotiff_keys(
      key_record({{1024, 0, 1, 1}, {3072, 0, 1, 2154}, {4099, 0, 1, 9003}}), {}, "");
  ASSERT_TRUE(crs);
  EXPECT_EQ(crs->text(), "EPSG:2154");
  EXPECT_FALSE(crs->has_vertical);
  EXPECT_DOUBLE_EQ(crs->metres_per_unit, 1.0);
  EXPECT_NEAR(crs->vertical_metres_per_unit, 1200.0 / 3937.0, 1e-12);
}

TEST(CrsFromGeotiffKeys, UnderstandsTheVerticalSystemsThatOldFilesNameByTheirDatums) {
  const auto named = [](std::uint16_t system, std::uint16_t unit) {
    const auto crs = crs_from_geotiff_keys(
        key_record({{1024, 0, 1, 1}, {3072, 0, 1, 2903}, {4096, 0, 1, system}, {4099, 0, 1, unit}}),
        {}, "");
    return crs ? crs->vertical_epsg : -1;
  };
  EXPECT_EQ(named(5103, 9001), 5703);
  EXPECT_EQ(named(5103, 9003), 6360);
  EXPECT_EQ(named(5102, 9003), 5702);
  EXPECT_EQ(named(5728, 9001), 5728);
}

TEST(CrsFromGeotiffKeys, GivesNothingForEmptyOrMeaninglessKeys) {
  testing::internal::CaptureStderr();
  EXPECT_FALSE(crs_from_geotiff_keys({}, {}, ""));
  EXPECT_FALSE(crs_from_geotiff_keys({1, 0, 1}, {}, ""));
  EXPECT_FALSE(crs_from_geotiff_keys(key_record({}), {}, ""));
  EXPECT_FALSE(crs_from_geotiff_keys(key_record({{3076, 0, 1, 9001}, {4099, 0, 1, 9001}}), {}, ""));
  EXPECT_FALSE(crs_from_geotiff_keys(key_record({{1024, 0, 1, 1}, {3072, 0, 1, 65535}}), {}, ""));
  EXPECT_FALSE(crs_from_geotiff_keys(
      key_record({{1024, 0, 1, 1}, {1026, 34737, 8, 0}, {3076, 0, 1, 9001}}), {}, "unnamed|"));
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(CrsFromGeotiffKeys, ReadsKeysThatAreFollowedByEmptyOnesDoubledOrOutOfOrder) {
  const auto crs = crs_from_geotiff_keys(key_record({{3076, 0, 1, 9001},
                                                     {3072, 0, 1, 32617},
                                                     {3072, 0, 1, 32618},
                                                     {1024, 0, 1, 1},
                                                     {0, 0, 0, 0},
                                                     {0, 0, 0, 0}}),
                                         std::vector<unsigned char>(40), "");
  ASSERT_TRUE(crs);
  EXPECT_EQ(crs->text(), "EPSG:32617");
}

TEST(CrsFromGeotiffKeys, TakesTheCodeInFeetWhereThatOfTheSystemInMetresIsNamed) {
  const auto crs = crs_from_geotiff_keys(
      key_record({{1024, 0, 1, 1}, {3072, 0, 1, 26995}, {3076, 0, 1, 9003}}), {}, "");
  ASSERT_TRUE(crs);
  EXPECT_NEAR(crs->metres_per_unit, 1200.0 / 3937.0, 1e-12);
  EXPECT_EQ(crs->horizontal_epsg, 2255);
}

TEST(CrsFromGeotiffKeys, SurvivesRecordsThatPointPastTheirEnd) {
  for (const std::uint16_t count : {std::uint16_t{0}, std::uint16_t{9}, std::uint16_t{65535}}) {
    auto keys = key_record({{1024, 0, 1, 1}, {3072, 0, 1, 2154}});
    std::memcpy(&keys[6], &count, 2);
    const auto crs = crs_from_geotiff_keys(keys, {}, "");
    EXPECT_EQ(crs.has_value(), count != 0);
  }
  const auto wild = key_record({{1024, 0, 1, 1},
                                {3072, 0, 1, 32767},
                                {3073, 34737, 65535, 60000},
                                {3082, 34736, 1, 65535},
                                {2057, 34736, 65535, 3}});
  EXPECT_NO_THROW(crs_from_geotiff_keys(wild, {1, 2, 3}, "abc"));
}

TEST(CrsFromGeotiffKeys, ReturnsAUserDefinedSystemFromItsParameters) {
  const Crs own = crs_from_text(
      "+proj=lcc +lat_1=43 +lat_2=45.5 +lat_0=41.75 +lon_0=-120.5 +x_0=399999.9999984 +y_0=0 "
      "+ellps=GRS80 +units=ft");
  ASSERT_EQ(own.horizontal_epsg, 0);
  EXPECT_TRUE(geotiff_keys_from_crs(own).empty());
  const GeotiffRecords records = geotiff_records_from_crs(own);
  ASSERT_FALSE(records.keys.empty());
  EXPECT_FALSE(records.doubles.empty());
  const auto back = crs_from_geotiff_keys(records.keys, records.doubles, records.ascii);
  ASSERT_TRUE(back);
  EXPECT_DOUBLE_EQ(back->metres_per_unit, 0.3048);
  EXPECT_TRUE(same_crs(own, *back));
}

TEST(SameCrs, DecidesByCodesAndByMeaning) {
  const Crs swiss = crs_from_text("EPSG:2056+5728");
  EXPECT_TRUE(same_crs(swiss, swiss));
  EXPECT_TRUE(same_crs(swiss, crs_from_text("EPSG:2056")));
  EXPECT_FALSE(same_crs(swiss, crs_from_text("EPSG:2056+5729")));
  EXPECT_FALSE(same_crs(swiss, crs_from_text("EPSG:2154+5728")));
  EXPECT_TRUE(same_crs({}, {}));
  EXPECT_FALSE(same_crs({}, swiss));
  Crs without_code = crs_from_text("EPSG:2056");
  without_code.horizontal_epsg = 0;
  without_code.wkt = without_code.wkt.substr(0, without_code.wkt.rfind(",AUTHORITY")) + "]";
  EXPECT_TRUE(same_crs(without_code, swiss));
  EXPECT_FALSE(same_crs(without_code, crs_from_text("EPSG:2154")));
}

TEST(Crs, TextIsTheWktWhereAPartHasNoCode) {
  Crs crs = crs_from_text("EPSG:2056+5728");
  crs.vertical_epsg = 0;
  EXPECT_EQ(crs.text(), crs.wkt);
  EXPECT_EQ(Crs{}.text(), "");
}

TEST(Crs, IsMadeOnManyThreadsAtOnce) {
  const auto keys = geotiff_keys_from_crs(crs_from_text("EPSG:2154+5720"));
  std::array<int, 4> right{};
  std::vector<std::thread> threads;
  for (int& count : right) {
    threads.emplace_back([&count, &keys] {
      for (int i = 0; i < 20; ++i) {
        const auto crs = crs_from_geotiff_keys(keys, {}, "");
        if (crs && crs->text() == "EPSG:2154+5720" && same_crs(*crs, crs_from_text("EPSG:2154"))) {
          ++count;
        }
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_THAT(right, testing::Each(20));
}

}  // namespace
}  // namespace cornice
