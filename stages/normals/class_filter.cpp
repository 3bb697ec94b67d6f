// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/normals/class_filter.h"

#include <cassert>
#include <initializer_list>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/geo/product_name.h"

namespace cornice::normals {
namespace {

constexpr std::uint8_t kVirtualClass = 66;  ///< Lidar HD: interpolated points without a pulse

/// From about here up, rock of Lidar HD is often left unclassed or called vegetation.
constexpr double kRockHeight_m = 2200.0;

std::bitset<256> classes(std::initializer_list<int> codes) {
  std::bitset<256> set;
  for (const int code : codes) set.set(static_cast<std::size_t>(code));
  return set;
}

const double kAnyHeight = std::numeric_limits<double>::infinity();

}  // namespace

const std::vector<std::string>& rule_names() {
  static const std::vector<std::string> names{"swisssurface3d", "lidarhd", "any"};
  return names;
}

ClassRules built_in_rules(const std::string& name) {
  if (name == "swisssurface3d") {
    return {classes({7, 18}), {{kAnyHeight, classes({2, 6, 9, 17, 26, 27})}}};
  }
  if (name == "lidarhd") {
    return {classes({7, 18, 65, 66}),
            {{kRockHeight_m, classes({2, 6, 9, 17, 67})},
             {kAnyHeight, classes({0, 1, 2, 3, 4, 5, 6, 8, 9, 17, 67})}}};
  }
  if (name == "any") {
    return {classes({7, 18}), {{kAnyHeight, classes({0, 1, 2, 6, 8, 9, 10, 11, 12, 17})}}};
  }
  throw UsageError("--product", "no class rules are called \"" + name +
                                    "\"; known are swisssurface3d, lidarhd and any");
}

std::string rules_for_file(const std::filesystem::path& tile) {
  const auto name = parse_product_name(tile.filename().string());
  if (!name) return "any";
  switch (name->product) {
    case Product::kSwissSurface3d:
      return "swisssurface3d";
    case Product::kLidarHdPoints:
      return "lidarhd";
    default:
      return "any";
  }
}

ClassRules rules_for_classes(const std::vector<int>& codes) {
  ClassRules rules{classes({7, 18}), {ClassBand{}}};
  for (const int code : codes) {
    rules.bands.front().keep.set(static_cast<std::size_t>(code));
    rules.noise.reset(static_cast<std::size_t>(code));
  }
  return rules;
}

namespace {

/// Judges points [begin, end) into `keep`.
FilterCounts judge(const PointCloud& points, const ClassRules& rules, std::size_t begin,
                   std::size_t end, std::vector<std::uint8_t>& keep) {
  FilterCounts counts;
  for (std::size_t i = begin; i < end; ++i) {
    const std::uint8_t code = points.classification[i];
    const std::uint8_t flags = points.flags.empty() ? std::uint8_t{0} : points.flags[i];
    const double height = points.origin.z + static_cast<double>(points.positions[i].z);
    const auto in_band = [&] {
      for (const ClassBand& band : rules.bands) {
        if (height <= band.up_to_m) return band.keep.test(code);
      }
      return false;
    };
    if ((flags & kWithheld) != 0) {
      ++counts.withheld;
    } else if ((flags & kSynthetic) != 0 || code == kVirtualClass) {
      ++counts.synthetic;
    } else if (rules.noise.test(code)) {
      ++counts.noise;
    } else if (!in_band()) {
      ++counts.other_class;
    } else {
      ++counts.kept;
      keep[i] = 1;
    }
    ++(keep[i] != 0 ? counts.kept_by_class : counts.dropped_by_class)[code];
  }
  return counts;
}

}  // namespace

void FilterCounts::add(const FilterCounts& other) {
  withheld += other.withheld;
  synthetic += other.synthetic;
  noise += other.noise;
  other_class += other.other_class;
  kept += other.kept;
  for (std::size_t c = 0; c < kept_by_class.size(); ++c) {
    kept_by_class[c] += other.kept_by_class[c];
    dropped_by_class[c] += other.dropped_by_class[c];
  }
}

std::vector<std::uint8_t> points_to_keep(const PointCloud& points, const ClassRules& rules,
                                         FilterCounts& counts, int threads) {
  assert(points.classification.size() == points.size());
  constexpr std::size_t kGrain = 1u << 17;
  std::vector<std::uint8_t> keep(points.size(), 0);
  counts = parallel_reduce(
      points.size(), kGrain, threads, FilterCounts{},
      [&](std::size_t begin, std::size_t end) { return judge(points, rules, begin, end, keep); },
      [](FilterCounts& sum, const FilterCounts& part) { sum.add(part); });
  return keep;
}

}  // namespace cornice::normals
