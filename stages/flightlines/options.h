// SPDX-License-Identifier: GPL-3.0-or-later
// The stage's options.
#pragma once

#include <vector>

#include "core/cli/options.h"
#include "stages/flightlines/survey_lines.h"

namespace cornice::flightlines {

/// Options of the command line; `options` must stay where it is.
std::vector<Option> describe_options(SurveyOptions& options);

}  // namespace cornice::flightlines
