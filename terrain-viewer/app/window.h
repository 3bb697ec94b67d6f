// SPDX-License-Identifier: GPL-3.0-or-later
// The viewer in a window.
#pragma once

#include "core/base/progress.h"
#include "core/cli/report.h"
#include "terrain-viewer/app/options.h"
#include "terrain-viewer/app/settings.h"

namespace cornice::viewer {

/// Runs until the window is closed or the process is told to end; then settings are kept for the
/// next time. Without files in the options, opens the latest one of the settings or, where that
/// cannot be, says what to do and waits for files. Throws RunError where there is no display or no
/// OpenGL 4.5, naming --headless.
void run_window(const Options& options, SettingsRead settings, Report& report, Progress& progress);

}  // namespace cornice::viewer
