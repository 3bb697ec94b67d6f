// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tests/support/small_files.h"

namespace cornice::test {

/// Small written files of every kind the parsers know, by name: what fuzzing starts from.
std::vector<std::pair<std::string, Bytes>> las_seeds();

}  // namespace cornice::test
