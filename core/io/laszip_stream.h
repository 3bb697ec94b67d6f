// SPDX-License-Identifier: GPL-3.0-or-later
// What LASzip sees of a file: a header written here, then the bytes of one chunk.
#pragma once

#include <cstddef>
#include <cstdint>
#include <istream>
#include <span>
#include <streambuf>
#include <vector>

#include "core/io/byte_source.h"
#include "core/io/las.h"
#include "core/io/laz_vlr.h"

namespace cornice {

/// The bytes of a header, then those of a chunk, as one stream.
class SplicedBuffer : public std::streambuf {
 public:
  /// A chunk in memory, which must stay there.
  SplicedBuffer(std::vector<std::uint8_t> head, std::span<const std::uint8_t> body)
      : head_(std::move(head)), body_(body), size_(head_.size() + body.size()) {}
  /// A chunk read from `source` piece by piece.
  SplicedBuffer(std::vector<std::uint8_t> head, ByteSource& source, std::uint64_t offset,
                std::uint64_t bytes)
      : head_(std::move(head)), source_(&source), offset_(offset), size_(head_.size() + bytes) {}
  /// The stream that reads this, to be told of the end.
  void set_stream(std::istream& stream) { stream_ = &stream; }

 protected:
  int_type underflow() override;
  pos_type seekoff(off_type offset, std::ios_base::seekdir way, std::ios_base::openmode) override;
  pos_type seekpos(pos_type to, std::ios_base::openmode) override;

 private:
  [[noreturn]] void end_stream();
  std::uint64_t position() const;
  void show_bytes(const std::uint8_t* begin, std::size_t count, std::uint64_t from);
  void show(std::uint64_t at);

  std::vector<std::uint8_t> head_;
  std::span<const std::uint8_t> body_;
  ByteSource* source_ = nullptr;
  std::uint64_t offset_ = 0;
  std::uint64_t size_;
  std::uint64_t shown_from_ = 0;
  std::vector<std::uint8_t> window_;
  std::istream* stream_ = nullptr;
};

/// A header under which LASzip reads `points` points of info's format that follow at once,
/// compressed as `laz` says.
std::vector<std::uint8_t> laszip_header(const LasInfo& info, const LazVlr& laz,
                                        std::uint64_t points);

}  // namespace cornice
