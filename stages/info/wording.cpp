// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/info/wording.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>

namespace cornice::info {
namespace {

constexpr double kAdjustment_s = 1e9;
// GPS time runs ahead of UTC by the leap seconds since 1980: 18 from 2017 on. For a date enough.
constexpr double kLeapSeconds = 18.0;

std::string formatted(const char* format, int digits, double value) {
  std::array<char, 400> text{};
  std::snprintf(text.data(), text.size(), format, digits, value);
  return text.data();
}

}  // namespace

std::string grouped(std::uint64_t value) {
  std::string digits = std::to_string(value);
  for (std::size_t at = digits.size(); at > 3; at -= 3) digits.insert(at - 3, ",");
  return digits;
}

std::string counted(std::uint64_t value, const std::string& noun) {
  return grouped(value) + " " + noun + (value == 1 ? "" : "s");
}

std::string fixed(double value, int digits) { return formatted("%.*f", digits, value); }

std::string shortest(double value, int digits) { return formatted("%.*g", digits, value); }

std::string byte_size(std::uint64_t bytes) {
  constexpr std::array<const char*, 5> kUnits = {"bytes", "KiB", "MiB", "GiB", "TiB"};
  double size = static_cast<double>(bytes);
  std::size_t unit = 0;
  while (size >= 1024.0 && unit + 1 < kUnits.size()) {
    size /= 1024.0;
    ++unit;
  }
  return fixed(size, unit == 0 ? 0 : 1) + " " + kUnits[unit];
}

std::string class_name(int code) {
  // LAS 1.4 R15, table 17; 64 to 67 as Lidar HD uses them.
  static constexpr std::array<const char*, 23> kNames = {"never classified",
                                                         "unclassified",
                                                         "ground",
                                                         "low vegetation",
                                                         "medium vegetation",
                                                         "high vegetation",
                                                         "building",
                                                         "low noise",
                                                         "model key-point",
                                                         "water",
                                                         "rail",
                                                         "road",
                                                         "overlap",
                                                         "wire guard",
                                                         "wire conductor",
                                                         "tower",
                                                         "wire connector",
                                                         "bridge deck",
                                                         "high noise",
                                                         "overhead structure",
                                                         "ignored ground",
                                                         "snow",
                                                         "temporal exclusion"};
  static constexpr std::array<const char*, 4> kLidarHd = {"cables and pylons", "artefacts",
                                                          "virtual", "other buildings"};
  std::string text = std::to_string(code);
  if (code >= 0 && code < static_cast<int>(kNames.size())) {
    text += std::string(" ") + kNames[static_cast<std::size_t>(code)];
  } else if (code >= 64 && code <= 67) {
    text += std::string(" ") + kLidarHd[static_cast<std::size_t>(code - 64)];
  }
  return text;
}

std::string time_kind_name(TimeKind kind) {
  switch (kind) {
    case TimeKind::kNone:
      return "none";
    case TimeKind::kWeekSeconds:
      return "seconds of the GPS week";
    case TimeKind::kAdjustedStandard:
      return "adjusted standard GPS time";
    case TimeKind::kStandard:
      return "standard GPS time, not adjusted";
  }
  return "none";
}

std::string date_of(double time_s, TimeKind kind) {
  if (kind != TimeKind::kAdjustedStandard && kind != TimeKind::kStandard) return "";
  const double shift = kind == TimeKind::kAdjustedStandard ? kAdjustment_s : 0.0;
  const double since_1980 = time_s + shift - kLeapSeconds;
  constexpr double kLatest = 1e11;  // the year 5148
  if (!(since_1980 >= 0.0 && since_1980 < kLatest)) return "";
  using namespace std::chrono;
  const sys_days epoch{year{1980} / January / 6};
  const year_month_day date{epoch + days{static_cast<int>(since_1980 / 86400.0)}};
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%04d-%02u-%02u", static_cast<int>(date.year()),
                static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()));
  return text.data();
}

std::string unit_name(double metres_per_unit) {
  const auto is = [&](double value) { return std::abs(metres_per_unit - value) < 1e-9; };
  if (is(0.0)) return "degrees";
  if (is(1.0)) return "metres";
  if (is(0.3048)) return "feet";
  if (is(1200.0 / 3937.0)) return "US survey feet";
  return "units of " + shortest(metres_per_unit) + " m";
}

int digits_of_step(double step) {
  if (!(step > 0.0) || !std::isfinite(step)) return 3;
  return std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 9);
}

}  // namespace cornice::info
