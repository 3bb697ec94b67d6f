// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace cornice {

/// "0.1.0", or with the commit it was built from, "0.1.0 (v0.1.0-12-gabc1234)".
std::string version_text();

/// Build type and compiler, "Release, GNU 12.2.0".
std::string build_text();

}  // namespace cornice
