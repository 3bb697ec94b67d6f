// SPDX-License-Identifier: GPL-3.0-or-later
// What this process has used, and may use.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace cornice {

/// Peak resident memory of this process so far, in bytes. 0 where the system does not tell.
std::uint64_t peak_resident_bytes();

/// Memory this process may use: the machine's, or the control group's limit where lower. Bytes.
std::uint64_t available_memory_bytes();

/// Lowest memory limit of the control groups (version 1 or 2) that `membership`, a file as
/// /proc/self/cgroup, names under `root`, a folder as /sys/fs/cgroup, and of the groups above them.
/// Bytes; the largest number there is where none is set.
std::uint64_t control_group_limit_bytes(const std::filesystem::path& membership,
                                        const std::filesystem::path& root);

/// A budget that large buffers are charged to before they are allocated (--memory).
/// Thread contract: one thread at a time.
class MemoryBudget {
 public:
  /// limit_bytes 0: no limit but the machine's.
  explicit MemoryBudget(std::uint64_t limit_bytes = 0);
  std::uint64_t limit_bytes() const { return limit_bytes_; }
  std::uint64_t charged_bytes() const { return charged_bytes_; }
  /// Throws RunError naming `what`, the bytes it needs and the limit, with the remedy, where it
  /// does not fit.
  void charge(const std::string& what, std::uint64_t bytes);
  /// Gives back at most what was charged.
  void release(std::uint64_t bytes);

 private:
  std::uint64_t limit_bytes_;
  std::uint64_t charged_bytes_ = 0;
};

}  // namespace cornice
