// SPDX-License-Identifier: GPL-3.0-or-later
// A file that appears whole or not at all, written through a large buffer.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <vector>

#include "core/base/atomic_file.h"

namespace cornice {

/// Binary output with a position. Every failure ends in a RunError that names the target.
class OutputStream {
 public:
  explicit OutputStream(std::filesystem::path target);

  std::ostream& stream() { return stream_; }
  std::string name() const { return file_.target().string(); }
  const std::filesystem::path& target() const { return file_.target(); }
  void put(std::span<const std::uint8_t> bytes);
  void seek(std::uint64_t position);
  /// Moves to the end and returns its position.
  std::uint64_t seek_end();
  /// Flushes, closes and gives the file its name.
  void commit();

 private:
  void check() const;

  AtomicFile file_;
  std::vector<char> buffer_;
  std::ofstream stream_;
};

/// Throws the RunError of a stream that failed; `error` is errno at that time, or 0.
[[noreturn]] void throw_cannot_write(const std::string& name, int error);

}  // namespace cornice
