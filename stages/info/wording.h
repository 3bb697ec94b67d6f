// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers and names as the screen and the defects show them.
#pragma once

#include <cstdint>
#include <string>

#include "core/base/vec.h"
#include "stages/info/facts.h"

namespace cornice::info {

/// 1234567 -> "1,234,567".
std::string grouped(std::uint64_t value);
/// "1 point", "1,234 points".
std::string counted(std::uint64_t value, const std::string& noun);
/// With a fixed number of digits behind the point.
std::string fixed(double value, int digits);
/// As few digits as tell the value to `digits` significant ones.
std::string shortest(double value, int digits = 10);
std::string byte_size(std::uint64_t bytes);
/// "2 ground"; the number alone where the class has no name in LAS 1.4.
std::string class_name(int code);
/// "seconds of the GPS week", "adjusted standard GPS time", ...
std::string time_kind_name(TimeKind kind);
/// UTC date of a time that counts from 1980, "2020-09-14"; empty for other kinds.
std::string date_of(double time_s, TimeKind kind);
/// "metres", "US survey feet", "feet", "degrees", or "units of 0.5 m".
std::string unit_name(double metres_per_unit);
/// Digits behind the point that a step of 0.01 needs: 2. At least 0, at most 9.
int digits_of_step(double step);

}  // namespace cornice::info
