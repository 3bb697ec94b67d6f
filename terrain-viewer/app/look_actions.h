// SPDX-License-Identifier: GPL-3.0-or-later
// Keys that change how the scene looks.
#pragma once

#include <optional>
#include <string>

#include "terrain-viewer/app/key_actions.h"
#include "terrain-viewer/app/session.h"

namespace cornice::viewer {

/// What to say of an action that changes the look, empty for nothing; no value where it is none.
std::optional<std::string> heed_look(Asked asked, Session& session, Split::Kind& split);

}  // namespace cornice::viewer
