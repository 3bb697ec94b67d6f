// SPDX-License-Identifier: GPL-3.0-or-later
// Why a file could not be written.
#pragma once

#include <string>

namespace cornice {

/// In words, for the end of a message; of a full disk with the remedy. `error` is errno right after
/// what failed; 0 where nobody set it.
std::string write_problem(int error);

}  // namespace cornice
