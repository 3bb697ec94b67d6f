// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geo/file_crs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

namespace cornice {
namespace {

TEST(CrsOfFile, IsTheOneThatTheTextNames) {
  EXPECT_EQ(crs_of_file("a.ply", "EPSG:2056+5728").text(), "EPSG:2056+5728");
}

TEST(CrsOfFile, BlamesTheFileWhereItsTextIsNoCrs) {
  try {
    crs_of_file("a.ply", "EPSG:99999999");
    FAIL() << "was accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(error.subject(), "a.ply");
    EXPECT_THAT(error.problem(), testing::HasSubstr("its CRS, 'EPSG:99999999' is no known CRS"));
  }
}

}  // namespace
}  // namespace cornice
