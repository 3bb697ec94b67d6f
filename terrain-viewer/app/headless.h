// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures without a window: one camera, or every frame of a path.
#pragma once

#include "core/base/progress.h"
#include "core/cli/report.h"
#include "terrain-viewer/app/options.h"

namespace cornice::viewer {

void run_headless(const Options& options, Report& report, Progress& progress);

}  // namespace cornice::viewer
