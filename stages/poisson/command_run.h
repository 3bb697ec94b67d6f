// SPDX-License-Identifier: GPL-3.0-or-later
// The work behind each action of cornice-poisson.
#pragma once

#include "core/base/error.h"
#include "core/cli/stage.h"
#include "stages/poisson/command.h"

namespace cornice::poisson {

void run_solve(Command& command, StageContext& context);
void run_extract(Command& command, StageContext& context);
void run_mesh(Command& command, StageContext& context);

}  // namespace cornice::poisson
