// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

#include "core/geo/crs.h"

namespace cornice {

/// As crs_from_text, for the text that a file has of its own system: what is wrong with it is the
/// file's fault, an InputError.
Crs crs_of_file(const std::filesystem::path& file, const std::string& text);

}  // namespace cornice
