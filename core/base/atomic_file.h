// SPDX-License-Identifier: GPL-3.0-or-later
// Output that appears whole or not at all.
#pragma once

#include <filesystem>
#include <string_view>

namespace cornice {

/// Names a temporary file beside `target`; commit() renames it to its final name, destruction
/// without commit() removes it. Temporary names of killed processes are unlike any real output
/// (".NAME.PID.partial") and remove_stale_partials() clears them.
class AtomicFile {
 public:
  /// Creates missing parent folders. Throws RunError where the folder cannot be written.
  explicit AtomicFile(std::filesystem::path target);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Where to write. Keeps the extension of the target, because GDAL and LASzip go by it.
  const std::filesystem::path& path() const { return partial_; }
  const std::filesystem::path& target() const { return target_; }
  /// Flushes to disk and renames. Throws RunError where that fails (disk full).
  void commit();

 private:
  std::filesystem::path target_;
  std::filesystem::path partial_;
  bool committed_ = false;
};

/// Writes a whole small file atomically.
void write_file_atomically(const std::filesystem::path& target, std::string_view contents);

/// Removes what killed processes left of `target`; returns how many files.
int remove_stale_partials(const std::filesystem::path& target);

}  // namespace cornice
