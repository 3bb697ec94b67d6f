// SPDX-License-Identifier: GPL-3.0-or-later
// Facts as text for people and as JSON for machines (docs/formats/info.md).
#pragma once

#include <string>
#include <vector>

#include "stages/info/facts.h"

namespace cornice::info {

/// One screen, lines of at most about 100 characters, ending with a line break.
std::string screen_text(const FileFacts& file);

/// One line: name, kind, points, density, CRS, defects.
std::string summary_line(const FileFacts& file);

/// A file that was asked for: its facts, or why there are none.
struct Outcome {
  std::filesystem::path path;
  std::optional<FileFacts> facts;
  std::string error;  ///< one line, the file's name included; empty where there are facts
};

/// The JSON document of all files, indented, ending with a line break.
std::string json_text(const std::vector<Outcome>& outcomes);

/// "LAS", "LAZ", "COPC", "PLY" or the raster's format.
std::string kind_name(const FileFacts& file);

}  // namespace cornice::info
