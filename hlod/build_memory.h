// SPDX-License-Identifier: GPL-3.0-or-later
// How a build that does not fit into memory shares out the memory it may use.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <string>

namespace cornice::hlod {

/// Bytes that building in memory takes for each triangle, measured on grids and on LiDAR meshes,
/// with some room.
inline constexpr std::uint64_t kBytesInMemory = 150;

/// The least limit that can be kept to.
inline constexpr std::uint64_t kLeastMemory = std::uint64_t{512} << 20;

/// Shares of one limit. Reading and simplifying do not happen at the same time.
struct MemoryPlan {
  std::uint64_t vertex_bytes = 0;   ///< for the vertices of the mesh that is read
  std::size_t piece_triangles = 0;  ///< that are sorted at a time
  std::uint64_t work_bytes = 0;     ///< for the cells and blocks that are worked on at a time
};

/// Throws UsageError where the limit is below kLeastMemory.
MemoryPlan plan_memory(std::uint64_t limit_bytes);

/// Lets threads wait until there is memory for what they are about to do. Safe to use from several
/// threads; who holds memory must not ask for more.
class MemoryGate {
 public:
  explicit MemoryGate(std::uint64_t bytes) : bytes_(bytes) {}
  std::uint64_t bytes() const { return bytes_; }

  /// Memory that is given back with the object.
  class Hold {
   public:
    Hold(MemoryGate* gate, std::uint64_t bytes) : gate_(gate), bytes_(bytes) {}
    ~Hold();
    Hold(const Hold&) = delete;
    Hold& operator=(const Hold&) = delete;

   private:
    MemoryGate* gate_;
    std::uint64_t bytes_;
  };
  /// Waits until `bytes` are free. Throws RunError naming `what`, with the remedy, where they never
  /// will be.
  Hold hold(const std::string& what, std::uint64_t bytes);

 private:
  std::uint64_t bytes_, held_ = 0;
  std::mutex mutex_;
  std::condition_variable freed_;
};

}  // namespace cornice::hlod
