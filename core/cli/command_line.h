// SPDX-License-Identifier: GPL-3.0-or-later
// argv to options, and options to help text. CLI11 stays behind command_line.cpp.
#pragma once

#include <string>
#include <vector>

#include "core/cli/options.h"

namespace cornice {

enum class CommandAction { kRun, kHelp, kHelpAll, kVersion };

/// Sets the options' fields from argv. --help, --help-all and --version win over everything else
/// that argv holds, and leave the fields alone. Throws UsageError for unknown flags (naming the
/// nearest known one), missing, superfluous, malformed and out-of-range values.
CommandAction parse_command_line(int argc, const char* const* argv, std::vector<Option>& options);

/// What a help page says besides the options.
struct HelpPage {
  std::string tool;  ///< "cornice-normals"
  std::string description;
  std::vector<std::string> examples;
};

/// The help text; advanced options only where `all`.
std::string help_text(const HelpPage& page, const std::vector<Option>& options, bool all);

}  // namespace cornice
