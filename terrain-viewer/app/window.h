// SPDX-License-Identifier: GPL-3.0-or-later
// The viewer in a window.
#pragma once

#include "core/cli/report.h"
#include "terrain-viewer/app/options.h"

namespace cornice::viewer {

/// Runs until the window is closed. Throws RunError where there is no display or no OpenGL 4.5,
/// naming --headless.
void run_window(const Options& options, Report& report);

}  // namespace cornice::viewer
