// SPDX-License-Identifier: GPL-3.0-or-later
// Two surfaces of one place against each other.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "stages/compare/height_grid.h"
#include "stages/compare/m3c2.h"
#include "stages/compare/overhangs.h"
#include "stages/compare/profile.h"
#include "stages/compare/source.h"
#include "stages/compare/statistics.h"

namespace cornice::compare {

enum class Side : std::uint8_t { kA = 0, kB = 1 };
inline constexpr std::array<Side, 2> kSides{Side::kA, Side::kB};
inline std::size_t index_of(Side side) { return static_cast<std::size_t>(side); }

/// What was found on one side.
struct SideResult {
  SourceFacts facts;
  std::vector<Overhang> overhangs;  ///< largest first; of clouds none
  double overhang_m2 = 0.0;         ///< of those, surface
  double layered_m2 = 0.0;          ///< ground, with more than one layer in its column
  double area_m2 = 0.0;             ///< of the surface in parts that touch the common ground
  std::uint64_t points_used = 0;    ///< of clouds: of the classes asked for, on common ground
};

/// Distances from one side's surface to the other, positive where B lies outside (above) A.
struct Direction {
  Side from = Side::kA;
  bool has_sign = true;  ///< false where the other side is a cloud
  bool by_place = true;  ///< false between two clouds: nothing says how the ground lies
  std::uint64_t measured = 0;
  double seconds = 0.0;  ///< of the searches alone
  Statistics statistics;
};

/// Another mesh of the same ground, measured against B: what a number of triangles buys.
struct Version {
  std::string title;
  std::uint64_t triangles = 0, file_bytes = 0;
  Summary distances;  ///< from samples of B
};

struct Result {
  Box2d common;
  std::array<SideResult, 2> sides;
  Raster difference;                          ///< B - A
  std::array<std::optional<Raster>, 2> gaps;  ///< where some column has more than one layer
  Statistics vertical;
  std::vector<Direction> directions;
  std::optional<M3c2Result> m3c2;  ///< between two clouds
  std::vector<Version> versions;   ///< A, then those given
  double colour_range_m = 1.0;
  std::vector<Profile> profiles;
  double lowest_m = 0.0, highest_m = 0.0;  ///< ground
  Raster relief;  ///< heights to draw shades from: B's, or A's where B is a cloud
  std::vector<std::string> warnings;
};

/// A part with the distance of each of its vertices, for whoever shows it. `result` holds all but
/// directions and m3c2 by then.
struct MeasuredPart {
  Side side;
  const std::string& name;
  const Surface& surface;
  const std::vector<float>& distances_m;      ///< NaN: none
  const std::vector<std::uint8_t>& overhang;  ///< a byte a triangle, or empty
  const Result& result;
};

/// Compares on the common ground of both; lines are those of the profiles wanted. `show` is called
/// for every part, sides and parts in order. Throws InputError where nothing can be compared.
Result compare(Source& a, Source& b, const Options& options, const std::vector<ProfileLine>& lines,
               const std::function<void(const MeasuredPart&)>& show, Progress& progress);

/// A further mesh against B; `result` is that of compare(). Throws InputError where it is no
/// surface of the same place.
Version measure_version(Source& version, Source& b, const Result& result, const Options& options,
                        Progress& progress);

/// Triangles that versions of B would need for A's root mean square, between the two versions whose
/// errors it lies between, on logarithmic scales; nothing where it lies between none.
std::optional<double> triangles_for_error_of_a(const Result& result);

}  // namespace cornice::compare
