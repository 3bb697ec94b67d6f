// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gtest/gtest.h>

#include "tests/property/viewer/crater.h"
#include "tests/support/temporary_folder.h"

namespace cornice::viewer {

/// Tests of a suite look at one file of the crater.
class CraterFixture : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    made_ = new test::TemporaryFolder;
    write_crater(crater_file());
  }
  static void TearDownTestSuite() { delete made_; }
  static std::filesystem::path crater_file() { return *made_ / "crater.hlod"; }

 private:
  static inline test::TemporaryFolder* made_ = nullptr;
};

}  // namespace cornice::viewer
