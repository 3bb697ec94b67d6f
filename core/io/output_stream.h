// SPDX-License-Identifier: GPL-3.0-or-later
// A file that appears whole or not at all, written through a large buffer.
#pragma once

#include <cstdint>
#include <filesystem>
#include <ostream>
#include <span>
#include <streambuf>
#include <string>
#include <vector>

#include "core/base/atomic_file.h"

namespace cornice {

/// Buffered writing to a file that never fails towards the stream: the first error is kept and
/// what follows is dropped. LASzip loses memory or crashes where a stream under it fails.
class PatientFileBuffer : public std::streambuf {
 public:
  explicit PatientFileBuffer(const std::filesystem::path& path);
  ~PatientFileBuffer() override;
  PatientFileBuffer(const PatientFileBuffer&) = delete;
  PatientFileBuffer& operator=(const PatientFileBuffer&) = delete;

  /// errno of the first failure; 0 while all went well.
  int error() const { return error_; }
  /// Writes what is buffered and closes the file.
  void close();

 protected:
  int_type overflow(int_type c) override;
  std::streamsize xsputn(const char* bytes, std::streamsize count) override;
  int sync() override;
  pos_type seekoff(off_type offset, std::ios_base::seekdir from,
                   std::ios_base::openmode mode) override;
  pos_type seekpos(pos_type position, std::ios_base::openmode mode) override;

 private:
  void write_out(const char* bytes, std::size_t count);
  void flush_buffer();

  int file_ = -1;
  int error_ = 0;
  std::uint64_t start_ = 0;  ///< position in the file of the buffer's first byte
  std::uint64_t end_ = 0;    ///< of the file
  std::vector<char> buffer_;
};

/// Binary output with a position. Every failure ends in a RunError that names the target.
class OutputStream {
 public:
  explicit OutputStream(std::filesystem::path target);

  /// Never fails; check() tells what became of what was written to it.
  std::ostream& stream() { return stream_; }
  std::string name() const { return file_.target().string(); }
  const std::filesystem::path& target() const { return file_.target(); }
  void put(std::span<const std::uint8_t> bytes);
  void seek(std::uint64_t position);
  /// Moves to the end and returns its position.
  std::uint64_t seek_end();
  /// Throws where a byte could not be written so far.
  void check() const;
  /// Flushes, closes and gives the file its name.
  void commit();

 private:
  AtomicFile file_;
  PatientFileBuffer buffer_;
  std::ostream stream_;
};

}  // namespace cornice
