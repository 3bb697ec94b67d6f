// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/io/laszip_stream.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "core/io/las_header.h"
#include "core/io/little_endian.h"

namespace cornice {
namespace {

constexpr std::size_t kWindowBytes = 1u << 20;
constexpr std::size_t kHeaderBytes = 375;

}  // namespace

SplicedBuffer::int_type SplicedBuffer::underflow() {
  const std::uint64_t at = position();
  if (at >= size_) end_stream();
  show(at);
  return traits_type::to_int_type(*gptr());
}

SplicedBuffer::pos_type SplicedBuffer::seekoff(off_type offset, std::ios_base::seekdir way,
                                               std::ios_base::openmode) {
  const auto base = way == std::ios_base::beg   ? off_type{0}
                    : way == std::ios_base::cur ? static_cast<off_type>(position())
                                                : static_cast<off_type>(size_);
  return seekpos(base + offset, std::ios_base::in);
}

SplicedBuffer::pos_type SplicedBuffer::seekpos(pos_type to, std::ios_base::openmode) {
  const auto at = static_cast<off_type>(to);
  if (at < 0 || static_cast<std::uint64_t>(at) > size_) return pos_type(off_type(-1));
  if (static_cast<std::uint64_t>(at) != position()) {
    setg(nullptr, nullptr, nullptr);
    shown_from_ = static_cast<std::uint64_t>(at);
  }
  return to;
}

/// LASzip 3.5 looks at eofbit and older ones at badbit; what goes unseen is decoded as bytes of 255
/// for ever. The exception becomes badbit in std::istream.
void SplicedBuffer::end_stream() {
  if (stream_ != nullptr) stream_->setstate(std::ios_base::eofbit);
  throw std::out_of_range("end of the chunk");
}

std::uint64_t SplicedBuffer::position() const {
  return shown_from_ + static_cast<std::uint64_t>(gptr() - eback());
}

void SplicedBuffer::show_bytes(const std::uint8_t* begin, std::size_t count, std::uint64_t from) {
  char* start = reinterpret_cast<char*>(const_cast<std::uint8_t*>(begin));  // never written to
  setg(start, start, start + count);
  shown_from_ = from;
}

void SplicedBuffer::show(std::uint64_t at) {
  if (at < head_.size()) {
    show_bytes(head_.data() + at, head_.size() - static_cast<std::size_t>(at), at);
  } else if (source_ == nullptr) {
    const auto skip = static_cast<std::size_t>(at - head_.size());
    show_bytes(body_.data() + skip, body_.size() - skip, at);
  } else {
    window_ =
        read_bytes(*source_, offset_ + at - head_.size(),
                   static_cast<std::size_t>(std::min<std::uint64_t>(kWindowBytes, size_ - at)));
    if (window_.empty()) end_stream();
    show_bytes(window_.data(), window_.size(), at);
  }
}

std::vector<std::uint8_t> laszip_header(const LasInfo& info, const LazVlr& laz,
                                        std::uint64_t points) {
  std::vector<std::uint8_t> vlr;
  if (laz.compressor != LazVlr::kNone) vlr = encode_laz_vlr(laz);
  const std::size_t offset = kHeaderBytes + (vlr.empty() ? 0 : kVlrHeaderBytes + vlr.size());
  std::vector<std::uint8_t> head(kHeaderBytes, 0);
  std::memcpy(head.data(), "LASF", 4);
  head[24] = 1;
  head[25] = 4;
  store_le<std::uint16_t>(head, 94, kHeaderBytes);
  store_le<std::uint32_t>(head, 96, static_cast<std::uint32_t>(offset));
  store_le<std::uint32_t>(head, 100, vlr.empty() ? 0 : 1);
  head[104] = static_cast<std::uint8_t>(info.point_format | (vlr.empty() ? 0 : 0x80));
  store_le<std::uint16_t>(head, 105, static_cast<std::uint16_t>(info.record_bytes));
  if (info.point_format < 6 && points <= UINT32_MAX) {
    store_le<std::uint32_t>(head, 107, static_cast<std::uint32_t>(points));
  }
  for (std::size_t axis = 0; axis < 3; ++axis) store_le<double>(head, 131 + 8 * axis, 0.01);
  store_le<std::uint64_t>(head, 247, points);
  if (vlr.empty()) return head;
  std::vector<std::uint8_t> vlr_head(kVlrHeaderBytes, 0);
  std::memcpy(vlr_head.data() + 2, "laszip encoded", 14);
  store_le<std::uint16_t>(vlr_head, 18, 22204);
  store_le<std::uint16_t>(vlr_head, 20, static_cast<std::uint16_t>(vlr.size()));
  head.insert(head.end(), vlr_head.begin(), vlr_head.end());
  head.insert(head.end(), vlr.begin(), vlr.end());
  // A pointer to itself stands for "no chunk table": LASzip then takes the chunks as they come.
  if (laz.has_chunks()) append_le<std::uint64_t>(head, offset);
  return head;
}

}  // namespace cornice
