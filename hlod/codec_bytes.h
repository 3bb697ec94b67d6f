// SPDX-License-Identifier: GPL-3.0-or-later
// A block's bytes: small numbers, and streams of bytes that are each compressed
// on their own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace cornice::hlod {

/// Appends to a block.
class BlockWriter {
 public:
  void number(std::uint32_t value);  ///< 7 bits a byte, lowest first
  void signed_number(std::int32_t value);
  /// Bytes whose count the reader knows: left out where all are 0, as they are,
  /// or by zstd, whichever is least.
  void stream(std::span<const std::uint8_t> bytes);
  /// A stream of any number of zeros.
  void zeros();
  std::vector<std::byte> take() { return std::move(block_); }

 private:
  std::vector<std::byte> block_;
};

/// Reads a block. Trusts nothing: once something is wrong ok() is false,
/// numbers are 0 and streams are zeros.
class BlockReader {
 public:
  explicit BlockReader(std::span<const std::byte> block) : rest_(block) {}
  std::uint32_t number();
  std::int32_t signed_number();
  /// Fills `bytes`; false where all of them are 0.
  bool stream(std::span<std::uint8_t> bytes);
  bool ok() const { return ok_; }
  bool at_end() const { return rest_.empty(); }

 private:
  void fail();

  std::span<const std::byte> rest_;
  bool ok_ = true;
};

/// Small numbers of either sign near 0: 0, -1, 1, -2, ... become 0, 1, 2, 3,
/// ...
constexpr std::uint32_t zigzag(std::uint32_t difference) {
  return (difference << 1) ^ (0u - (difference >> 31));
}
constexpr std::uint32_t unzigzag(std::uint32_t code) { return (code >> 1) ^ (0u - (code & 1u)); }

}  // namespace cornice::hlod
