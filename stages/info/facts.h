// SPDX-License-Identifier: GPL-3.0-or-later
// What can be known of a file, as values. docs/formats/info.md describes the same fields in JSON.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/base/vec.h"
#include "core/geo/crs.h"
#include "core/io/las.h"
#include "core/io/ply.h"

namespace cornice::info {

/// Something wrong or unusual, one plain sentence without full stop; `id` is stable for machines.
struct Defect {
  std::string id;
  std::string text;
};

/// What times are, judged by their values: the header's bit is lost too often.
enum class TimeKind {
  kNone,              ///< the format has no time, or all are zero
  kWeekSeconds,       ///< seconds of the GPS week, up to 604800
  kAdjustedStandard,  ///< GPS seconds since 1980-01-06, less 1e9
  kStandard,          ///< the same without the 1e9 taken off
};

struct TimeFacts {
  bool has_field = false;
  GpsTimeType header_type = GpsTimeType::kNone;
  TimeKind kind = TimeKind::kNone;
  std::uint64_t good = 0;  ///< finite and above zero
  std::uint64_t zero = 0;
  std::uint64_t negative = 0;
  std::uint64_t not_finite = 0;
  std::optional<double> min_s, max_s;            ///< of all finite times
  std::optional<double> good_min_s, good_max_s;  ///< of the good ones
  /// Points whose time lies before that of the point before them of the same source id.
  std::uint64_t steps_back = 0;
};

struct AngleFacts {
  std::optional<double> min_deg, max_deg;
  std::uint64_t distinct = 0;
  double unit_deg = 1.0;                ///< what the format stores: 1 or 0.006
  bool whole_degrees = false;           ///< every angle is a whole degree to within the unit
  bool all_zero = false;                ///< there are points, and no angle but 0
  std::uint64_t not_representable = 0;  ///< beyond +-90 degrees
};

/// The points of one point source id and channel.
struct LineFacts {
  std::uint16_t point_source_id = 0;
  std::uint8_t channel = 0;
  std::uint64_t points = 0;
  std::optional<double> first_s, last_s;  ///< of the good times
  std::uint64_t passes = 0;  ///< runs of good times without a silence of more than kPassGap_s
};

/// Silence that separates passes here; `cornice flightlines` looks at the course as well.
inline constexpr double kPassGap_s = 20.0;

struct PointFacts {
  LasInfo header;
  std::uint64_t readable = 0;            ///< points decoded
  std::string problem;                   ///< why not all of them; empty where all are readable
  Box3d bounds;                          ///< of the points, in the file's CRS
  bool bounds_agree = true;              ///< with the header's
  std::optional<double> density_per_m2;  ///< over occupied cells
  double occupied_m2 = 0.0;
  double cell_m = 0.0;  ///< side of those cells
  std::array<std::uint64_t, 256> classes{};
  std::array<std::uint64_t, 16> by_return{};        ///< index: return number
  std::array<std::uint64_t, 16> by_return_count{};  ///< index: number of returns
  std::array<std::uint64_t, 4> by_channel{};
  std::uint64_t withheld = 0, overlap = 0, synthetic = 0, key_points = 0;
  std::uint64_t return_above_count = 0;
  std::uint64_t return_zero = 0;      ///< return number 0, but for virtual points
  std::uint64_t repeated_return = 0;  ///< same pulse and return as the point before, other place
  std::uint64_t virtual_without_time = 0;  ///< class 66, time 0
  std::uint64_t copies = 0;       ///< points that another one equals in place, time and return
  bool copies_estimated = false;  ///< from a sample: files of more than 4 million points
  std::optional<double> ground_min_z, ground_max_z;  ///< class 2
  int intensity_min = 0, intensity_max = 0;
  TimeFacts time;
  AngleFacts angle;
  std::vector<LineFacts> lines;  ///< by id, then channel
  bool lines_complete = true;    ///< false where times are too scattered to tell passes
};

struct PlyFacts {
  PlyInfo header;
  Crs crs;
  std::uint64_t vertices = 0;
  std::uint64_t faces = 0;
  bool has_normals = false;
  Box3d bounds;  ///< of the vertices, in the CRS; empty without any
  std::uint64_t not_finite = 0;
  std::uint64_t normals_not_unit = 0;
};

struct RasterFacts {
  std::string format;
  std::string layout;  ///< "COG" or empty
  std::string compression;
  int width = 0, height = 0, bands = 0, overviews = 0;
  std::string type;
  bool has_position = false;
  bool rotated = false;
  double step_x = 0.0, step_y = 0.0;
  Box2d bounds;  ///< outer edges of the pixels
  bool pixel_is_point = false;
  Crs crs;
  bool crs_from_name = false;  ///< the file itself has none
  std::optional<double> no_data;
  std::uint64_t valid = 0;  ///< pixels of the first band with a value
  std::optional<double> min, max;
  std::uint64_t not_finite = 0;
};

struct FileFacts {
  std::filesystem::path path;
  std::uint64_t bytes = 0;
  std::variant<PointFacts, PlyFacts, RasterFacts> facts;
  std::vector<Defect> defects;
};

struct ExamineOptions {
  int threads = 0;       ///< 0: all cores
  std::string crs_text;  ///< --crs; empty: the file's own
};

}  // namespace cornice::info
