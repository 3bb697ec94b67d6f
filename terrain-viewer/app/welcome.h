// SPDX-License-Identifier: GPL-3.0-or-later
// What a window without a file says.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "terrain-viewer/app/window_system.h"

namespace cornice::viewer {

/// Shows what to do until hierarchies are dropped, which it returns; nothing where the window is
/// closed or the process is told to end. problem: why one could not be opened, or empty.
std::vector<std::filesystem::path> ask_for_files(WindowSystem& window, const Progress& progress,
                                                 const std::string& problem);

}  // namespace cornice::viewer
