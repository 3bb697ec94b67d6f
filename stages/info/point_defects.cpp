// SPDX-License-Identifier: GPL-3.0-or-later
// What goes wrong in real point files, one rule each; DATA of the products: docs/stages/info.md.
#include <algorithm>
#include <cmath>

#include "stages/info/examine.h"
#include "stages/info/wording.h"

namespace cornice::info {
namespace {

constexpr int kGroundClass = 2;
/// Ground closer to height 0 than this all over, under points much higher: heights above ground.
constexpr double kFlatGround_m = 0.5;
constexpr double kTallScene_m = 2.0;
constexpr std::uint64_t kEnoughGround = 100;

using Defects = std::vector<Defect>;

void add(Defects& defects, const char* id, std::string text) {
  defects.push_back({id, std::move(text)});
}

void find_missing_points(const PointFacts& facts, Defects& defects) {
  const std::uint64_t promised = facts.header.point_count;
  if (!facts.problem.empty()) {
    add(defects, "truncated",
        "only " + grouped(facts.readable) + " of " + counted(promised, "point") +
            " can be read: " + facts.problem);
  } else if (facts.readable != promised) {
    add(defects, "count",
        "the header counts " + counted(promised, "point") + ", the file has " +
            grouped(facts.readable));
  }
  if (facts.readable == 0) add(defects, "empty", "the file has no points");
}

void find_header_errors(const PointFacts& facts, Defects& defects) {
  const LasInfo& header = facts.header;
  for (const std::string& warning : header.warnings) add(defects, "header", warning);
  if (facts.readable == 0) return;
  if (!facts.bounds_agree && facts.problem.empty()) {
    add(defects, "bounds", "the header's bounds are not those of the points");
  }
  const std::size_t counted_returns = header.version_minor >= 4 ? 15 : 5;
  bool returns_agree = true;
  for (std::size_t i = 0; i < counted_returns; ++i) {
    returns_agree = returns_agree && header.points_by_return[i] == facts.by_return[i + 1];
  }
  if (!returns_agree && facts.problem.empty()) {
    add(defects, "returns_header", "the header's counts by return are not those of the points");
  }
  constexpr std::uint16_t kWktBit = 16;
  if (header.point_format >= 6 && (header.global_encoding & kWktBit) == 0 &&
      std::none_of(defects.begin(), defects.end(),
                   [](const Defect& d) { return d.text.find("bit 4") != std::string::npos; })) {
    add(defects, "wkt_bit",
        "bit 4 of the global encoding (CRS as WKT) is not set, as point formats "
        "6 to 10 need it");
  }
}

void find_crs_defects(const PointFacts& facts, Defects& defects) {
  const Crs& crs = facts.header.crs;
  if (crs.empty()) {
    add(defects, "crs_missing", "no coordinate reference system; give it with --crs");
    return;
  }
  if (facts.header.crs_source == "file name") {
    add(defects, "crs_from_name",
        "the file has no coordinate reference system; it was taken from the file name");
  }
  if (crs.metres_per_unit == 0.0) {
    add(defects, "degrees",
        "coordinates are degrees; slopes and distances need a projected system");
  } else if (std::abs(crs.metres_per_unit - 1.0) > 1e-9) {
    add(defects, "feet", "coordinates are " + unit_name(crs.metres_per_unit) + ", not metres");
  } else if (!crs.projected) {
    add(defects, "not_projected",
        "the coordinate reference system is no map projection (geocentric or local)");
  }
  if (crs.projected && std::abs(crs.vertical_metres_per_unit - crs.metres_per_unit) > 1e-9) {
    add(defects, "mixed_units",
        "heights are " + unit_name(crs.vertical_metres_per_unit) + ", the plan is " +
            unit_name(crs.metres_per_unit));
  }
  if (!crs.has_vertical) {
    add(defects, "no_vertical", "the coordinate reference system has no vertical part");
  }
}

void find_time_defects(const PointFacts& facts, Defects& defects) {
  const TimeFacts& time = facts.time;
  if (facts.readable == 0) return;
  if (!time.has_field) {
    add(defects, "no_time",
        "point format " + std::to_string(facts.header.point_format) +
            " has no GPS time: flight lines cannot be told apart by it");
    return;
  }
  if (time.good == 0) {
    add(defects, "no_good_time", "no point has a GPS time above zero");
  } else if (time.good_min_s == time.good_max_s && time.good > 1) {
    add(defects, "constant_time", "all points have the same GPS time");
  }
  const std::uint64_t other_zero = time.zero - facts.virtual_without_time;
  if (facts.virtual_without_time > 0) {
    add(defects, "virtual_points",
        counted(facts.virtual_without_time, "virtual point") + " (class 66) without GPS time");
  }
  if (other_zero > 0 && time.good > 0) {
    add(defects, "zero_time", counted(other_zero, "point") + " with GPS time 0 among good ones");
  }
  if (time.negative > 0) {
    add(defects, "negative_time", counted(time.negative, "point") + " with a negative GPS time");
  }
  if (time.not_finite > 0) {
    add(defects, "bad_time", counted(time.not_finite, "point") + " whose GPS time is no number");
  }
  if (time.header_type == GpsTimeType::kWeekSeconds && time.kind == TimeKind::kAdjustedStandard) {
    add(defects, "time_bit",
        "the header says seconds of the GPS week, but times reach " +
            shortest(*time.good_max_s, 12) + " s: they are adjusted standard GPS time");
  } else if (time.header_type == GpsTimeType::kAdjustedStandard &&
             time.kind == TimeKind::kWeekSeconds) {
    add(defects, "time_bit",
        "the header says adjusted standard GPS time, but no time is above 604800 s: they are "
        "seconds of the week");
  } else if (time.kind == TimeKind::kStandard) {
    add(defects, "time_not_adjusted",
        "GPS times reach " + shortest(*time.good_max_s, 12) +
            " s: standard time without the 1e9 s taken off");
  }
  // The points of COPC are in the order of its octree; that is no defect.
  if (time.steps_back > 0 && facts.header.container != LasContainer::kCopc) {
    add(defects, "time_order",
        "points are not in order of time: " + counted(time.steps_back, "step") +
            " back in time within point source ids");
  }
}

void find_line_defects(const PointFacts& facts, Defects& defects) {
  if (!facts.lines_complete) {
    add(defects, "scattered_times", "GPS times are too scattered to tell passes apart");
    return;
  }
  std::uint64_t shared = 0;
  for (const LineFacts& line : facts.lines) shared += line.passes > 1 ? 1 : 0;
  if (shared > 0) {
    add(defects, "shared_source_id",
        counted(shared, "point source id") + (shared == 1 ? " covers" : " cover") +
            " several passes (silence of more than " + fixed(kPassGap_s, 0) + " s)");
  }
  const bool only_zero = !facts.lines.empty() && facts.lines.back().point_source_id == 0;
  if (only_zero && facts.readable > 1) {
    add(defects, "no_source_id", "all points have point source id 0");
  }
}

void find_angle_defects(const PointFacts& facts, Defects& defects) {
  const AngleFacts& angle = facts.angle;
  if (facts.readable == 0) return;
  if (angle.all_zero && facts.readable > 1) {
    add(defects, "zero_angles", "all scan angles are 0");
  } else if (angle.whole_degrees && angle.unit_deg < 1.0 && !angle.all_zero) {
    add(defects, "whole_degrees", "scan angles are whole degrees in a field of 0.006 degrees");
  }
  if (angle.not_representable > 0) {
    add(defects, "absurd_angles",
        counted(angle.not_representable, "point") + " with a scan angle beyond 90 degrees");
  }
}

void find_point_defects(const PointFacts& facts, Defects& defects) {
  if (facts.copies > 0) {
    const char* const what = facts.time.has_field ? " (same place, time and return)"
                                                  : " (same place and return; there is no time)";
    add(defects, "copies",
        (facts.copies_estimated ? "about " : "") + counted(facts.copies, "point") +
            " copied from others" + what);
  }
  if (facts.repeated_return > 0) {
    add(defects, "repeated_returns",
        counted(facts.repeated_return, "point") +
            " with the return number of the point before them, of the same pulse");
  }
  if (facts.return_above_count > 0) {
    add(defects, "return_above_count",
        counted(facts.return_above_count, "point") +
            " whose return number is above the number of returns");
  }
  if (facts.return_zero > 0) {
    add(defects, "return_zero", counted(facts.return_zero, "point") + " with return number 0");
  }
  const std::uint64_t classified =
      facts.readable - facts.classes[0] - std::min(facts.classes[1], facts.readable);
  if (facts.readable > 1 && classified == 0) {
    add(defects, "unclassified", "no point is classified");
  }
  const double unit = facts.header.crs.empty() ? 1.0 : facts.header.crs.vertical_metres_per_unit;
  const bool flat =
      facts.ground_min_z && facts.classes[kGroundClass] >= kEnoughGround &&
      std::max(std::abs(*facts.ground_min_z), std::abs(*facts.ground_max_z)) * unit < kFlatGround_m;
  if (flat && facts.bounds.max.z * unit > kTallScene_m) {
    add(defects, "normalised",
        "all ground lies within " + fixed(kFlatGround_m, 1) +
            " m of height 0: heights seem to be above ground");
  }
}

}  // namespace

std::vector<Defect> find_defects(const PointFacts& facts) {
  Defects defects;
  find_missing_points(facts, defects);
  find_header_errors(facts, defects);
  find_crs_defects(facts, defects);
  find_time_defects(facts, defects);
  find_line_defects(facts, defects);
  find_angle_defects(facts, defects);
  find_point_defects(facts, defects);
  return defects;
}

}  // namespace cornice::info
