// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/base/memory.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>

#include "core/base/error.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();

/// A limit file holds a number of bytes or "max".
std::uint64_t limit_in(const fs::path& file) {
  std::ifstream stream(file);
  std::uint64_t bytes = 0;
  return stream >> bytes ? bytes : kNoLimit;
}

/// Lowest limit of `group` (absolute within `mount`) and every group above it.
std::uint64_t lowest_limit(const fs::path& mount, fs::path group, const char* limit_file) {
  std::uint64_t lowest = kNoLimit;
  for (;;) {
    lowest = std::min(lowest, limit_in(mount / group.relative_path() / limit_file));
    if (!group.has_relative_path()) return lowest;
    group = group.parent_path();
  }
}

/// True where the comma-separated `list` of version 1 controllers has memory in it.
bool has_memory_controller(const std::string& list) {
  return ("," + list + ",").find(",memory,") != std::string::npos;
}

std::string gib_text(std::uint64_t bytes) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f GiB", static_cast<double>(bytes) / 0x1p30);
  return text;
}

}  // namespace

std::uint64_t peak_resident_bytes() {
  // ru_maxrss survives exec, so it can be the peak of the process that started this one.
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    std::uint64_t kib = 0;
    if (word == "VmHWM:" && status >> kib) return kib * 1024;
  }
  rusage usage{};
  if (getrusage(RUSAGE_SELF, &usage) != 0) return 0;
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

std::uint64_t control_group_limit_bytes(const fs::path& membership, const fs::path& root) {
  // Each line is ID:CONTROLLERS:PATH; version 2 is the line with ID 0 and no controllers.
  std::uint64_t lowest = kNoLimit;
  std::ifstream stream(membership);
  for (std::string line; std::getline(stream, line);) {
    const std::size_t first = line.find(':');
    const std::size_t second = first == std::string::npos ? first : line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    const fs::path group = line.substr(second + 1);
    if (controllers.empty()) {
      lowest = std::min(lowest, lowest_limit(root, group, "memory.max"));
    } else if (has_memory_controller(controllers)) {
      lowest = std::min(lowest, lowest_limit(root / "memory", group, "memory.limit_in_bytes"));
    }
  }
  return lowest;
}

std::uint64_t available_memory_bytes() {
  const long pages = sysconf(_SC_PHYS_PAGES);
  const long page_bytes = sysconf(_SC_PAGESIZE);
  const std::uint64_t machine =
      pages > 0 && page_bytes > 0
          ? static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page_bytes)
          : kNoLimit;
  return std::min(machine, control_group_limit_bytes("/proc/self/cgroup", "/sys/fs/cgroup"));
}

MemoryBudget::MemoryBudget(std::uint64_t limit_bytes)
    : limit_bytes_(limit_bytes == 0 ? available_memory_bytes() : limit_bytes) {}

void MemoryBudget::charge(const std::string& what, std::uint64_t bytes) {
  if (bytes > limit_bytes_ - charged_bytes_) {
    throw RunError(what, "needs " + gib_text(bytes) + ", but of the limit of " +
                             gib_text(limit_bytes_) + " " + gib_text(charged_bytes_) +
                             " are in use; raise --memory or give a smaller part");
  }
  charged_bytes_ += bytes;
}

void MemoryBudget::release(std::uint64_t bytes) {
  assert(bytes <= charged_bytes_ && "more memory released than charged");
  charged_bytes_ -= std::min(bytes, charged_bytes_);
}

}  // namespace cornice
