// SPDX-License-Identifier: GPL-3.0-or-later
// What goes wrong in the fields of real tiles, one switch each, composable.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/base/vec.h"
#include "stages/simulate/products.h"
#include "stages/simulate/returns.h"
#include "stages/simulate/survey_point.h"

namespace cornice::simulate {

enum class AngleSign { kRight, kReversed, kReversedEveryOtherLine };

/// All defects, off. Rates are shares of points 0..1.
struct DefectOptions {
  AngleSign angle_sign = AngleSign::kRight;
  bool whole_degrees = false;     ///< in a field that holds 0.006 degree
  bool virtual_on_water = false;  ///< class 66 every kVirtualStepM on water
  bool virtual_everywhere = false;
  bool lost_time_bit = false;  ///< header says seconds of the week, values are adjusted time
  bool week_rollover = false;  ///< seconds of the week, whose end falls into the survey
  bool two_surveys = false;    ///< the second half is flown 44 days later, ids start anew
  bool zeroed_source_ids = false;
  bool reused_source_ids = false;  ///< two passes share each id
  bool unordered = false;          ///< points in spatial order instead of time order
  bool horizontal_crs = false;     ///< the CRS record has no heights
  double zero_times = 0.0;
  double duplicate_points = 0.0;
  double return_numbers = 0.0;  ///< of pulses: numbers repeated, or counted from 2
  double absurd_angles = 0.0;   ///< withheld or synthetic points
  double outliers = 0.0;        ///< echoes of birds and of multiple reflections
  double misclassified = 0.0;   ///< of steep rock: any class but ground
  double strip_offset_m = 0.0;  ///< standard deviation per axis, one offset per line
};

/// "NAME" or "NAME=VALUE" per entry of --defects. "none" first drops what the product has by
/// itself (Lidar HD: virtual points on water). Throws UsageError with the known names.
DefectOptions parse_defects(SurveyProduct product, const std::vector<std::string>& entries);

/// Names of all defects with what they do, for the help text and the page of the stage.
struct DefectName {
  const char* name;
  double default_value;  ///< of NAME=VALUE where no value is given; 0: takes none
  const char* help;
};
std::span<const DefectName> defect_names();

/// The defects that are on, as "NAME" or "NAME=VALUE": what the truth records.
std::vector<std::string> applied(const DefectOptions& defects);

/// Seconds in a GPS week.
inline constexpr double kWeekS = 604800.0;
/// Between the two surveys of DefectOptions::two_surveys.
inline constexpr double kSurveyBreakS = 44.0 * 86400.0;
inline constexpr double kVirtualStepM = 5.0;

/// One pass seen by one channel: what the flight-line stage has to find.
struct SurveyLine {
  std::uint16_t id = 0;  ///< from 1, in order of first time, then channel
  int pass = 0;          ///< index into Trajectory::passes()
  int channel = 0;
  std::uint16_t point_source_id = 0;  ///< as recorded
  std::uint8_t recorded_channel = 0;
  std::uint8_t user_data = 0;
  int angle_sign = 1;  ///< recorded angle / true angle
  Vec3d offset;        ///< of all recorded points of the line
};

/// How a channel is told apart in the file.
enum class ChannelTag { kPointSourceId, kScannerChannel, kUserData };

class Trajectory;

/// Lines of a flight with the fields that the defects leave them.
std::vector<SurveyLine> survey_lines(const Trajectory& trajectory, int channels, ChannelTag tag,
                                     const DefectOptions& defects, std::uint64_t seed);

/// GPS time as recorded, of a true adjusted time.
double recorded_time(const DefectOptions& defects, double adjusted_time_s);

/// Random numbers of one survey, apart by purpose: switching one defect on leaves all else alone.
enum class Stream : std::uint64_t {
  kPulse = 100,
  kOutlier,
  kStripOffset,
  kZeroTime,
  kDuplicate,
  kReturnNumber,
  kAbsurdAngle,
  kMisclassified,
  kVirtual,
  kOrder,
};
inline CounterRandom random_of(std::uint64_t seed, Stream stream, std::uint64_t item) {
  return CounterRandom(seed, static_cast<std::uint64_t>(stream), item);
}

/// Metres that an echo is moved along its beam as an outlier; 0 for the others.
double outlier_shift_m(const DefectOptions& defects, std::uint64_t seed, std::uint64_t pulse_key,
                       int echo);

/// Spoils the points of one pulse in place, appending duplicates. `points` ends with the pulse's
/// points from index `first` on. pulse_key: unique to the pulse in the survey.
void apply_defects(const DefectOptions& defects, std::uint64_t seed, std::uint64_t pulse_key,
                   std::size_t first, std::vector<SurveyPoint>& points);

}  // namespace cornice::simulate
