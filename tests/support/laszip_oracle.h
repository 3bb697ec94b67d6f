// SPDX-License-Identifier: GPL-3.0-or-later
// A second opinion on point files: LASzip's own sequential reading of the whole file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/points/point_cloud.h"

namespace cornice::test {

/// Every attribute of every point that LASzip reads, positions relative to 0 left out.
struct OracleCloud {
  PointCloud points;    ///< all arrays filled but `positions`; flags and classes as the reader's
  std::string problem;  ///< LASzip's error where it stopped early or did not open the file
};

OracleCloud read_all_with_laszip(const std::filesystem::path& path);

/// All .las and .laz files below a folder, sorted.
std::vector<std::filesystem::path> point_files_below(const std::filesystem::path& folder);

}  // namespace cornice::test
