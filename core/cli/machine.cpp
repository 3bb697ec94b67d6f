// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/cli/machine.h"

#include <sys/utsname.h>

#include <fstream>

#include "core/base/memory.h"
#include "core/base/parallel.h"

namespace cornice {
namespace {

/// The text behind `key` and `separator` in a file of such lines, without quotes and blanks.
std::string value_in(const char* file, const std::string& key, char separator) {
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    const std::size_t at = line.find(separator);
    if (at == std::string::npos || !line.starts_with(key)) continue;
    const std::size_t first = line.find_first_not_of(" \t\"", at + 1);
    const std::size_t last = line.find_last_not_of(" \t\"");
    if (first != std::string::npos) return line.substr(first, last - first + 1);
  }
  return {};
}

}  // namespace

Machine this_machine() {
  Machine machine;
  utsname system{};
  const bool known = uname(&system) == 0;
  machine.cpu = value_in("/proc/cpuinfo", "model name", ':');
  if (machine.cpu.empty() && known) machine.cpu = system.machine;
  machine.cores = thread_count(0);
  machine.memory_bytes = available_memory_bytes();
  machine.os = value_in("/etc/os-release", "PRETTY_NAME", '=');
  if (known) {
    machine.os += machine.os.empty() ? "" : ", ";
    machine.os += std::string(system.sysname) + " " + system.release;
  }
  return machine;
}

}  // namespace cornice
