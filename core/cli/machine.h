// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>

namespace cornice {

/// What a timing needs to be understood.
struct Machine {
  std::string cpu;                 ///< model name; the architecture where the system gives no more
  int cores = 0;                   ///< that this process may use
  std::uint64_t memory_bytes = 0;  ///< that this process may use
  std::string os;                  ///< "Debian GNU/Linux 12 (bookworm), Linux 6.1.0"
};

Machine this_machine();

}  // namespace cornice
