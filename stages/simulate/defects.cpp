// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/simulate/defects.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>

#include "core/base/error.h"
#include "core/points/point_cloud.h"
#include "stages/simulate/trajectory.h"

namespace cornice::simulate {
namespace {

/// Adjusted standard GPS time is GPS time less this.
constexpr double kAdjustedOffsetS = 1e9;
/// Ground steeper than 60 degrees is what classifiers take for something else.
constexpr float kSteepNormalZ = 0.5f;

constexpr std::array<DefectName, 18> kNames{{
    {"reversed-angle", 0, "scan angles positive to the left of flight, in all lines"},
    {"reversed-angle-alternate", 0, "the same in every other line"},
    {"whole-degrees", 0, "whole degrees in the 16-bit angle field"},
    {"virtual-points", 0, "points of class 66 all over, without time, angle, line, return"},
    {"lost-time-bit", 0, "header says seconds of the week, values are adjusted standard time"},
    {"week-rollover", 0, "seconds of the week, starting anew during the first line"},
    {"two-surveys", 0, "second half of the lines flown 44 days later, their ids starting anew"},
    {"zeroed-source-ids", 0, "point source id 0 everywhere"},
    {"reused-source-ids", 0, "every point source id is used by two passes"},
    {"unordered", 0, "points in spatial order instead of time order"},
    {"horizontal-crs", 0, "CRS record without heights"},
    {"zero-times", 0.01, "share of points with GPS time 0"},
    {"duplicate-points", 0.01, "share of points stored twice"},
    {"return-numbers", 0.05, "share of pulses whose return numbers repeat or start at 2"},
    {"absurd-angles", 0.002, "share of points withheld or synthetic, with angles of 75 to 90"},
    {"outliers", 0.001, "share of echoes metres above or below the surface"},
    {"misclassified", 0.5, "share of ground steeper than 60 degrees with another class"},
    {"strip-offset", 0.1, "metres, standard deviation of each line's own offset per axis"},
}};

std::string known_names() {
  std::string text;
  for (const DefectName& defect : kNames)
    text += std::string(text.empty() ? "" : ", ") + defect.name;
  return text;
}

double value_of(const DefectName& defect, const std::string& entry, std::size_t equals) {
  if (equals == std::string::npos) return defect.default_value;
  const std::string text = entry.substr(equals + 1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool is_length = std::string(defect.name) == "strip-offset";
  if (defect.default_value == 0.0 || error != std::errc() || end != text.data() + text.size() ||
      !(value >= 0.0 && value <= (is_length ? 100.0 : 1.0)))
    throw UsageError("--defects", "\"" + entry + "\": " + defect.name +
                                      (defect.default_value == 0.0 ? " takes no value"
                                       : is_length                 ? " takes metres in 0 .. 100"
                                                                   : " takes a share in 0 .. 1"));
  return value;
}

void set(DefectOptions& defects, const std::string& name, double value) {
  if (name == "reversed-angle") defects.angle_sign = AngleSign::kReversed;
  if (name == "reversed-angle-alternate") defects.angle_sign = AngleSign::kReversedEveryOtherLine;
  if (name == "whole-degrees") defects.whole_degrees = true;
  if (name == "virtual-points") defects.virtual_everywhere = true;
  if (name == "lost-time-bit") defects.lost_time_bit = true;
  if (name == "week-rollover") defects.week_rollover = true;
  if (name == "two-surveys") defects.two_surveys = true;
  if (name == "zeroed-source-ids") defects.zeroed_source_ids = true;
  if (name == "reused-source-ids") defects.reused_source_ids = true;
  if (name == "unordered") defects.unordered = true;
  if (name == "horizontal-crs") defects.horizontal_crs = true;
  if (name == "zero-times") defects.zero_times = value;
  if (name == "duplicate-points") defects.duplicate_points = value;
  if (name == "return-numbers") defects.return_numbers = value;
  if (name == "absurd-angles") defects.absurd_angles = value;
  if (name == "outliers") defects.outliers = value;
  if (name == "misclassified") defects.misclassified = value;
  if (name == "strip-offset") defects.strip_offset_m = value;
}

void spoil_return_numbers(const DefectOptions& defects, std::uint64_t seed, std::uint64_t pulse_key,
                          std::span<SurveyPoint> pulse) {
  CounterRandom random = random_of(seed, Stream::kReturnNumber, pulse_key);
  if (random.uniform() >= defects.return_numbers) return;
  const bool repeat = pulse.size() > 1 && random.uniform() < 0.5;
  for (SurveyPoint& point : pulse)
    point.return_number =
        repeat ? std::uint8_t{1} : static_cast<std::uint8_t>(point.return_number + 1);
}

void spoil_point(const DefectOptions& defects, std::uint64_t seed, std::uint64_t item,
                 SurveyPoint& point) {
  if (defects.whole_degrees) point.scan_angle_deg = std::round(point.scan_angle_deg);
  if (defects.absurd_angles > 0.0) {
    CounterRandom random = random_of(seed, Stream::kAbsurdAngle, item);
    if (random.uniform() < defects.absurd_angles) {
      point.flags |= random.uniform() < 0.5 ? kWithheld : kSynthetic;
      const double angle = std::floor(random.uniform(75.0, 91.0));
      point.scan_angle_deg = static_cast<float>(random.uniform() < 0.5 ? -angle : angle);
    }
  }
  if (defects.misclassified > 0.0 && point.classification == kClassGround &&
      point.normal.z < kSteepNormalZ) {
    constexpr std::array<std::uint8_t, 3> kWrong{kClassUnclassified, kClassLowVegetation,
                                                 kClassBuilding};
    CounterRandom random = random_of(seed, Stream::kMisclassified, item);
    if (random.uniform() < defects.misclassified)
      point.classification = kWrong[static_cast<std::size_t>(3.0 * random.uniform())];
  }
  if (defects.zero_times > 0.0 &&
      random_of(seed, Stream::kZeroTime, item).uniform() < defects.zero_times)
    point.gps_time_s = 0.0;
}

int reversed(const DefectOptions& defects, int pass) {
  switch (defects.angle_sign) {
    case AngleSign::kRight:
      return 1;
    case AngleSign::kReversed:
      return -1;
    case AngleSign::kReversedEveryOtherLine:
      return pass % 2 == 1 ? -1 : 1;
  }
  return 1;
}

}  // namespace

std::span<const DefectName> defect_names() { return kNames; }

DefectOptions parse_defects(SurveyProduct product, const std::vector<std::string>& entries) {
  DefectOptions defects;
  defects.virtual_on_water = product == SurveyProduct::kLidarHd;
  for (const std::string& entry : entries) {
    if (entry == "none") {
      defects.virtual_on_water = false;
      continue;
    }
    const std::size_t equals = entry.find('=');
    const std::string name = entry.substr(0, equals);
    const DefectName* found = nullptr;
    for (const DefectName& defect : kNames)
      if (name == defect.name) found = &defect;
    if (found == nullptr)
      throw UsageError("--defects", "\"" + name + "\" is none of none, " + known_names());
    set(defects, name, value_of(*found, entry, equals));
  }
  return defects;
}

std::vector<std::string> applied(const DefectOptions& defects) {
  std::vector<std::string> names;
  const auto flag = [&](bool is_on, const char* name) {
    if (is_on) names.emplace_back(name);
  };
  const auto rate = [&](double value, const char* name) {
    char text[80];
    std::snprintf(text, sizeof text, "%s=%g", name, value);
    if (value > 0.0) names.emplace_back(text);
  };
  flag(defects.angle_sign == AngleSign::kReversed, "reversed-angle");
  flag(defects.angle_sign == AngleSign::kReversedEveryOtherLine, "reversed-angle-alternate");
  flag(defects.whole_degrees, "whole-degrees");
  flag(defects.virtual_on_water, "virtual-points-on-water");
  flag(defects.virtual_everywhere, "virtual-points");
  flag(defects.lost_time_bit, "lost-time-bit");
  flag(defects.week_rollover, "week-rollover");
  flag(defects.two_surveys, "two-surveys");
  flag(defects.zeroed_source_ids, "zeroed-source-ids");
  flag(defects.reused_source_ids, "reused-source-ids");
  flag(defects.unordered, "unordered");
  flag(defects.horizontal_crs, "horizontal-crs");
  rate(defects.zero_times, "zero-times");
  rate(defects.duplicate_points, "duplicate-points");
  rate(defects.return_numbers, "return-numbers");
  rate(defects.absurd_angles, "absurd-angles");
  rate(defects.outliers, "outliers");
  rate(defects.misclassified, "misclassified");
  rate(defects.strip_offset_m, "strip-offset");
  return names;
}

std::vector<SurveyLine> survey_lines(const Trajectory& trajectory, int channels, ChannelTag tag,
                                     const DefectOptions& defects, std::uint64_t seed) {
  const int passes = static_cast<int>(trajectory.passes().size());
  int second_survey = 0;
  while (second_survey < passes &&
         trajectory.passes()[static_cast<std::size_t>(second_survey)].survey == 0)
    ++second_survey;
  std::vector<SurveyLine> lines;
  for (int pass = 0; pass < passes; ++pass) {
    for (int channel = 0; channel < channels; ++channel) {
      SurveyLine line;
      line.id = static_cast<std::uint16_t>(lines.size() + 1);
      line.pass = pass;
      line.channel = channel;
      int number = pass < second_survey ? pass : pass - second_survey;
      if (defects.reused_source_ids) number %= (passes + 1) / 2;
      // IGN numbers the second channel of pass 1028 as 2028.
      const int thousand = tag == ChannelTag::kPointSourceId ? 1000 * (channel + 1) : 1000;
      if (!defects.zeroed_source_ids)
        line.point_source_id = static_cast<std::uint16_t>(thousand + number + 1);
      if (tag == ChannelTag::kScannerChannel)
        line.recorded_channel = static_cast<std::uint8_t>(channel);
      // 6 and 7 are the values of a block of 2021.
      if (tag == ChannelTag::kUserData && channels > 1)
        line.user_data = static_cast<std::uint8_t>(6 + channel);
      line.angle_sign = reversed(defects, pass);
      CounterRandom random =
          random_of(seed, Stream::kStripOffset, static_cast<std::uint64_t>(pass));
      line.offset = {random.normal(), random.normal(), random.normal()};
      line.offset *= defects.strip_offset_m;
      lines.push_back(line);
    }
  }
  return lines;
}

double recorded_time(const DefectOptions& defects, double adjusted_time_s) {
  if (!defects.week_rollover) return adjusted_time_s;
  return std::fmod(adjusted_time_s + kAdjustedOffsetS, kWeekS);
}

double outlier_shift_m(const DefectOptions& defects, std::uint64_t seed, std::uint64_t pulse_key,
                       int echo) {
  if (defects.outliers <= 0.0) return 0.0;
  CounterRandom random =
      random_of(seed, Stream::kOutlier, pulse_key * kMostEchoes + static_cast<std::uint64_t>(echo));
  if (random.uniform() >= defects.outliers) return 0.0;
  // A bird is met before the ground; a second bounce makes the way longer.
  const double distance = 5.0 * std::pow(40.0, random.uniform());
  return random.uniform() < 0.5 ? -distance : distance;
}

void apply_defects(const DefectOptions& defects, std::uint64_t seed, std::uint64_t pulse_key,
                   std::size_t first, std::vector<SurveyPoint>& points) {
  if (defects.return_numbers > 0.0)
    spoil_return_numbers(defects, seed, pulse_key, {points.data() + first, points.size() - first});
  const std::size_t end = points.size();
  for (std::size_t i = first; i < end; ++i)
    spoil_point(defects, seed, pulse_key * kMostEchoes + (i - first), points[i]);
  if (defects.duplicate_points <= 0.0) return;
  for (std::size_t i = first; i < end; ++i) {
    const std::uint64_t item = pulse_key * kMostEchoes + (i - first);
    if (random_of(seed, Stream::kDuplicate, item).uniform() < defects.duplicate_points)
      points.push_back(SurveyPoint(points[i]));
  }
}

}  // namespace cornice::simulate
