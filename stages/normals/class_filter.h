// SPDX-License-Identifier: GPL-3.0-or-later
// Which points are ground to reconstruct: by class, height and flags.
#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "core/points/point_cloud.h"

namespace cornice::normals {

/// Classes kept among points up to a height.
struct ClassBand {
  double up_to_m = std::numeric_limits<double>::infinity();  ///< height in the file's system
  std::bitset<256> keep;

  friend bool operator==(const ClassBand&, const ClassBand&) = default;
};

/// Rules of one product. A point belongs to the first band whose up_to_m is not below it; above all
/// bands nothing is kept.
struct ClassRules {
  std::bitset<256> noise;        ///< dropped and counted as noise, whatever the bands say
  std::vector<ClassBand> bands;  ///< by ascending up_to_m

  friend bool operator==(const ClassRules&, const ClassRules&) = default;
};

/// Names of the built-in rules: "swisssurface3d", "lidarhd" (config/*.yaml explain them) and
/// "any", for other sources: ground, bridges, buildings, water, and points that were never classed.
const std::vector<std::string>& rule_names();

/// Built-in rules by name. Throws UsageError for an unknown one.
ClassRules built_in_rules(const std::string& name);

/// Name of the built-in rules for a tile, from its file name; "any" for other names.
std::string rules_for_file(const std::filesystem::path& tile);

/// Rules from the section "normals" of a configuration (config/*.yaml). Throws InputError naming
/// file and key for unknown keys, classes beyond 0..255 and bands out of order.
ClassRules read_class_rules(const std::filesystem::path& config);

/// Rules that keep the given classes (0..255) at any height and call 7 and 18 noise unless given.
ClassRules rules_for_classes(const std::vector<int>& classes);

/// What a filter did.
struct FilterCounts {
  std::size_t withheld = 0;   ///< flag set
  std::size_t synthetic = 0;  ///< flag set, or Lidar HD's virtual class 66
  std::size_t noise = 0;
  std::size_t other_class = 0;
  std::size_t kept = 0;
  std::array<std::size_t, 256> kept_by_class{};
  std::array<std::size_t, 256> dropped_by_class{};

  void add(const FilterCounts& other);
};

/// 1 for every point to keep. Needs classification; flags where there are any. Same for any number
/// of threads (0: all cores).
std::vector<std::uint8_t> points_to_keep(const PointCloud& points, const ClassRules& rules,
                                         FilterCounts& counts, int threads = 0);

}  // namespace cornice::normals
