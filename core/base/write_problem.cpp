// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/base/write_problem.h"

#include <cerrno>
#include <system_error>

namespace cornice {

std::string write_problem(int error) {
  if (error == ENOSPC || error == EDQUOT) {
    return "the disk is full; free some space or write elsewhere, then run again";
  }
  return error == 0 ? "the system does not say why" : std::generic_category().message(error);
}

}  // namespace cornice
