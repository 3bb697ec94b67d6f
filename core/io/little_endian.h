// SPDX-License-Identifier: GPL-3.0-or-later
// Little-endian numbers in byte buffers, as LAS and COPC store them.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>

namespace cornice {

static_assert(std::endian::native == std::endian::little,
              "the readers and writers copy little-endian numbers as they are");

/// The T at `offset`; the caller has checked that it lies inside `bytes`.
template <class T>
T load_le(std::span<const std::uint8_t> bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

template <class T>
void store_le(std::span<std::uint8_t> bytes, std::size_t offset, T value) {
  std::memcpy(bytes.data() + offset, &value, sizeof(T));
}

/// `bytes`: a vector of bytes or a string.
template <class T, class Bytes>
void append_le(Bytes& bytes, T value) {
  const std::size_t at = bytes.size();
  bytes.resize(at + sizeof(T));
  std::memcpy(bytes.data() + at, &value, sizeof(T));
}

/// Text of a fixed field: up to its first NUL.
inline std::string load_text(std::span<const std::uint8_t> bytes, std::size_t offset,
                             std::size_t width) {
  const char* begin = reinterpret_cast<const char*>(bytes.data() + offset);
  return {begin, ::strnlen(begin, width)};
}

}  // namespace cornice
