// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/io/ply_stream.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <system_error>

#include "core/base/error.h"

namespace cornice {
namespace {

// Fits into the second-level cache, so that taking the values apart reads no main memory.
constexpr std::size_t kBufferBytes = std::size_t{1} << 19;
constexpr std::size_t kMaxWordBytes = 400;

bool is_blank(std::uint8_t c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

template <class T>
double value_as(const std::uint8_t* from, bool swap_bytes) {
  std::uint8_t bytes[sizeof(T)];
  std::memcpy(bytes, from, sizeof(T));
  if (swap_bytes) std::reverse(bytes, bytes + sizeof(T));
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return static_cast<double>(value);
}

/// Smallest and largest value of an integer type.
std::pair<double, double> limits_of(PlyType type) {
  const double bits = 8.0 * static_cast<double>(ply_size(type));
  const bool has_sign =
      type == PlyType::kInt8 || type == PlyType::kInt16 || type == PlyType::kInt32;
  if (has_sign) return {-std::exp2(bits - 1.0), std::exp2(bits - 1.0) - 1.0};
  return {0.0, std::exp2(bits) - 1.0};
}

}  // namespace

double ply_value(const std::uint8_t* from, PlyType type, bool swap_bytes) {
  switch (type) {
    case PlyType::kInt8:
      return value_as<std::int8_t>(from, swap_bytes);
    case PlyType::kUint8:
      return value_as<std::uint8_t>(from, swap_bytes);
    case PlyType::kInt16:
      return value_as<std::int16_t>(from, swap_bytes);
    case PlyType::kUint16:
      return value_as<std::uint16_t>(from, swap_bytes);
    case PlyType::kInt32:
      return value_as<std::int32_t>(from, swap_bytes);
    case PlyType::kUint32:
      return value_as<std::uint32_t>(from, swap_bytes);
    case PlyType::kFloat32:
      return value_as<float>(from, swap_bytes);
    case PlyType::kFloat64:
      return value_as<double>(from, swap_bytes);
  }
  return 0.0;
}

PlyStream::PlyStream(std::filesystem::path path, const PlyHeader& header)
    : path_(std::move(path)),
      format_(header.format),
      file_bytes_(header.file_bytes),
      left_in_file_(header.file_bytes - header.header_bytes),
      buffer_(static_cast<std::size_t>(std::min<std::uint64_t>(kBufferBytes, left_in_file_))) {
  file_ = open(path_.c_str(), O_RDONLY | O_CLOEXEC);
  if (file_ < 0) throw InputError(path_.string(), std::generic_category().message(errno));
  lseek(file_, static_cast<off_t>(header.header_bytes), SEEK_SET);
}

PlyStream::~PlyStream() { close(file_); }

void PlyStream::fail(const std::string& problem) const {
  std::string where;
  if (element_ != nullptr) where = " (" + *element_ + " " + std::to_string(index_) + ")";
  throw InputError(path_.string(), problem + where);
}

void PlyStream::refill(std::size_t wanted) {
  if (end_ - begin_ >= wanted) return;
  std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
  end_ -= begin_;
  begin_ = 0;
  const std::uint64_t possible = std::min<std::uint64_t>(wanted, end_ + left_in_file_);
  if (buffer_.size() < possible) buffer_.resize(static_cast<std::size_t>(possible));
  while (end_ < buffer_.size() && left_in_file_ > 0) {
    const ssize_t got = read(file_, buffer_.data() + end_, buffer_.size() - end_);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail(std::generic_category().message(errno));
    if (got == 0) left_in_file_ = 0;
    end_ += static_cast<std::size_t>(got);
    left_in_file_ -= std::min(left_in_file_, static_cast<std::uint64_t>(got));
  }
}

const std::uint8_t* PlyStream::bytes(std::size_t count) {
  if (end_ - begin_ < count) {
    // Checked first: a hostile count must not grow the buffer.
    if (count > end_ - begin_ + left_in_file_) fail("is truncated: the file ends");
    refill(count);
    if (end_ - begin_ < count) fail("is truncated: the file ends");
  }
  const std::uint8_t* at = buffer_.data() + begin_;
  begin_ += count;
  return at;
}

std::span<const std::uint8_t> PlyStream::peek(std::size_t wanted) {
  refill(wanted);
  return {buffer_.data() + begin_, end_ - begin_};
}

double PlyStream::ascii_number(PlyType type) {
  do {
    refill(kMaxWordBytes);
    while (begin_ < end_ && is_blank(buffer_[begin_])) ++begin_;
  } while (begin_ == end_ && left_in_file_ > 0);
  refill(kMaxWordBytes);
  const auto* first = reinterpret_cast<const char*>(buffer_.data() + begin_);
  const auto* last = reinterpret_cast<const char*>(buffer_.data() + end_);
  if (first == last) fail("is truncated: the file ends");
  if (*first == '+') ++first;
  double value = 0.0;
  const auto [end, error] = std::from_chars(first, last, value);
  const bool whole =
      error == std::errc() && (end == last || is_blank(static_cast<std::uint8_t>(*end)));
  if (!whole) fail("'" + std::string(first, std::min(first + 20, last)) + "...' is not a number");
  begin_ += static_cast<std::size_t>(end - reinterpret_cast<const char*>(buffer_.data() + begin_));
  if (type == PlyType::kFloat32 || type == PlyType::kFloat64) return value;
  const auto [low, high] = limits_of(type);
  if (value != std::floor(value) || value < low || value > high) {
    fail("a value is not of its type " + std::string(ply_type_name(type)));
  }
  return value;
}

double PlyStream::number(PlyType type) {
  if (format_ == PlyFormat::kAscii) return ascii_number(type);
  return ply_value(bytes(ply_size(type)), type, format_ == PlyFormat::kBigEndian);
}

std::size_t PlyStream::list_length(const PlyProperty& property) {
  const double length = number(*property.list_count);
  if (length < 0.0) fail("a list has a negative length");
  const auto count = static_cast<std::uint64_t>(length);
  const std::uint64_t least = format_ == PlyFormat::kAscii ? 2 : ply_size(property.type);
  if (count > (end_ - begin_ + left_in_file_ + 1) / least) {
    fail("is truncated: a list of " + std::to_string(count) + " values goes beyond the file's end");
  }
  return static_cast<std::size_t>(count);
}

void PlyStream::skip(const PlyProperty& property) {
  if (!property.is_list()) {
    number(property.type);
    return;
  }
  const std::size_t length = list_length(property);
  if (format_ != PlyFormat::kAscii) {
    bytes(length * ply_size(property.type));
    return;
  }
  for (std::size_t i = 0; i < length; ++i) number(property.type);
}

}  // namespace cornice
