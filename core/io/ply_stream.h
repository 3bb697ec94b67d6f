// SPDX-License-Identifier: GPL-3.0-or-later
// The values behind a PLY header, one record or one block of records at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/io/ply_header.h"

namespace cornice {

/// Reads the body of a PLY file front to back, from header.header_bytes on. Thread contract: one
/// thread at a time. Every function throws InputError, naming the element and its number, where the
/// file ends early.
class PlyStream {
 public:
  PlyStream(std::filesystem::path path, const PlyHeader& header);
  ~PlyStream();
  PlyStream(const PlyStream&) = delete;
  PlyStream& operator=(const PlyStream&) = delete;

  /// Names what is being read, for messages.
  void at(const std::string& element, std::uint64_t index) {
    element_ = &element;
    index_ = index;
  }
  /// `count` bytes in a row, valid until the next call. Binary files only.
  const std::uint8_t* bytes(std::size_t count);
  /// What is in the buffer, at least `wanted` bytes unless the file ends before. Binary files only.
  std::span<const std::uint8_t> peek(std::size_t wanted);
  /// Where in the file the next value begins.
  std::uint64_t offset() const { return file_bytes_ - left_in_file_ - (end_ - begin_); }
  /// Passes over bytes that were peeked at.
  void consume(std::size_t count) { begin_ += count; }
  /// One value of any format as a number.
  double number(PlyType type);
  /// The length of a list; refuses negative ones and those beyond the end of the file.
  std::size_t list_length(const PlyProperty& property);
  /// Passes over one value or list.
  void skip(const PlyProperty& property);

  [[noreturn]] void fail(const std::string& problem) const;

 private:
  double ascii_number(PlyType type);
  void refill(std::size_t wanted);

  std::filesystem::path path_;
  PlyFormat format_;
  std::uint64_t file_bytes_;
  int file_ = -1;
  std::uint64_t left_in_file_ = 0;  ///< bytes not yet in the buffer
  std::vector<std::uint8_t> buffer_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  const std::string* element_ = nullptr;
  std::uint64_t index_ = 0;
};

/// One binary value at `from` as a number.
double ply_value(const std::uint8_t* from, PlyType type, bool swap_bytes);

}  // namespace cornice
