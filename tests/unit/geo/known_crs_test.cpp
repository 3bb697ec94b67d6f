// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geo/known_crs.h"

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace cornice {
namespace {

TEST(KnownCrs, SaysWhatIsReadAnewHoweverOftenItIsAsked) {
  const Crs swiss = crs_from_text("EPSG:2056+5728");
  const GeotiffRecords keys = geotiff_records_from_crs(crs_from_text("EPSG:2154"));
  for (int round = 0; round < 2; ++round) {
    EXPECT_EQ(known_crs_from_text("EPSG:2056+5728").wkt, swiss.wkt);
    EXPECT_EQ(known_crs_from_wkt(swiss.wkt).value().text(), "EPSG:2056+5728");
    EXPECT_FALSE(known_crs_from_wkt("no WKT").has_value());
    EXPECT_EQ(
        known_crs_from_geotiff_keys(keys.keys, keys.doubles, keys.ascii).value().horizontal_epsg,
        2154);
    EXPECT_FALSE(known_crs_from_geotiff_keys({}, {}, "").has_value());
    EXPECT_THROW(known_crs_from_text("EPSG:nothing"), UsageError);
  }
}

TEST(KnownCrs, SaysTheSameWithMoreSystemsThanItKeeps) {
  for (int code = 32601; code <= 32660; ++code) {
    known_crs_from_text("EPSG:" + std::to_string(code));
    known_crs_from_text("EPSG:" + std::to_string(code + 100));
  }
  EXPECT_EQ(known_crs_from_text("EPSG:32632").horizontal_epsg, 32632);
  EXPECT_EQ(known_crs_from_text("EPSG:32732").horizontal_epsg, 32732);
}

}  // namespace
}  // namespace cornice
