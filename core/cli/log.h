// SPDX-License-Identifier: GPL-3.0-or-later
// Log lines on stderr through spdlog. For executables; libraries return counts instead.
#pragma once

#include <string>

namespace cornice {

/// tool: "cornice-normals", what every line begins with. level: "error", "warning", "info" or
/// "debug". Lines read "TOOL: warning: TEXT"; those of level info have no level in them.
void set_up_log(const std::string& tool, const std::string& level);
void log_error(const std::string& line);
void log_warning(const std::string& line);
void log_info(const std::string& line);
void log_debug(const std::string& line);

}  // namespace cornice
