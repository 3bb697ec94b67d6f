// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/build_memory.h"

#include <algorithm>
#include <cstdio>

#include "core/base/error.h"

namespace cornice::hlod {
namespace {

// What the program itself takes, its libraries, tables of cells and buffers of files.
constexpr std::uint64_t kOwnBytes = std::uint64_t{128} << 20;
// Memory that was given back stays with the process for a while, in pieces that do not fit.
constexpr double kUsableShare = 0.75;
// Of one piece of a mesh, with all that sorting it into cells takes.
constexpr std::uint64_t kBytesPerPieceTriangle = 250;
// Pieces of any limit end at the same triangles' multiples: sums of areas then are the same.
constexpr std::size_t kPieceGrain = std::size_t{1} << 17;
constexpr std::size_t kMostPieceTriangles = std::size_t{1} << 22;

std::string gib(std::uint64_t bytes) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f GiB", static_cast<double>(bytes) / 0x1p30);
  return text;
}

}  // namespace

MemoryPlan plan_memory(std::uint64_t limit_bytes) {
  if (limit_bytes < kLeastMemory) {
    throw UsageError("--memory", "must be at least 0.5 GiB, but is " + gib(limit_bytes));
  }
  const auto usable =
      static_cast<std::uint64_t>(kUsableShare * static_cast<double>(limit_bytes)) - kOwnBytes;
  MemoryPlan plan;
  plan.vertex_bytes = usable / 2;
  const std::size_t triangles = usable / 4 / kBytesPerPieceTriangle;
  plan.piece_triangles =
      std::clamp(triangles / kPieceGrain * kPieceGrain, kPieceGrain, kMostPieceTriangles);
  plan.work_bytes = usable;
  return plan;
}

MemoryGate::Hold::~Hold() {
  if (gate_ == nullptr) return;
  {
    const std::lock_guard lock(gate_->mutex_);
    gate_->held_ -= bytes_;
  }
  gate_->freed_.notify_all();
}

MemoryGate::Hold MemoryGate::hold(const std::string& what, std::uint64_t bytes) {
  if (bytes > bytes_) {
    throw RunError(what, "takes about " + gib(bytes) + " of memory, and " + gib(bytes_) +
                             " are to be had; raise --memory or choose a smaller --cell-side");
  }
  std::unique_lock lock(mutex_);
  freed_.wait(lock, [&] { return held_ + bytes <= bytes_; });
  held_ += bytes;
  return {this, bytes};
}

}  // namespace cornice::hlod
