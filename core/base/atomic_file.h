// SPDX-License-Identifier: GPL-3.0-or-later
// Output that appears whole or not at all.
#pragma once

#include <filesystem>
#include <string_view>

namespace cornice {

/// Names a temporary file beside `target`; commit() renames it to its final name, destruction
/// without commit() removes it. The temporary name is ".NAME.HOST.PID-N.partial.EXT": unlike any
/// real output, and different for every writer, so that two writers of one target do not disturb
/// each other (the last to commit wins, whole). remove_stale_partials() clears those of killed
/// processes. A target that is a symbolic link is followed, so the link stays a link.
/// Thread contract: separate objects are independent.
class AtomicFile {
 public:
  /// Creates missing parent folders. Throws RunError where the folder cannot be written, or where
  /// the target exists and is no regular file.
  explicit AtomicFile(std::filesystem::path target);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Where to write; nothing is there yet. Keeps the extension of the target, because GDAL and
  /// LASzip go by it.
  const std::filesystem::path& path() const { return partial_; }
  const std::filesystem::path& target() const { return target_; }
  /// Flushes to disk and renames. Throws RunError where that fails (disk full).
  void commit();

 private:
  std::filesystem::path target_;
  std::filesystem::path partial_;
  bool committed_ = false;
};

/// Writes a whole small file atomically. Throws RunError where that fails (disk full).
void write_file_atomically(const std::filesystem::path& target, std::string_view contents);

/// Removes what killed processes of this machine left of `target` (of any target in the folder
/// where `target` is a folder); returns how many files. Files of processes that still run stay.
int remove_stale_partials(const std::filesystem::path& target);

/// Removes the temporary files of all living AtomicFile objects: for a process that is about to end
/// without unwinding its stack.
void remove_live_partials() noexcept;

}  // namespace cornice
