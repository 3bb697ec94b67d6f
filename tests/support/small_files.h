// SPDX-License-Identifier: GPL-3.0-or-later
// Small point files, whole and damaged on purpose.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/io/las.h"
#include "core/io/little_endian.h"

namespace cornice::test {

using Bytes = std::vector<std::uint8_t>;

Bytes read_file(const std::filesystem::path& path);
void write_file(const std::filesystem::path& path, const Bytes& bytes);

/// The bytes of a file of `count` made-up points with those options.
Bytes point_file(const LasWriteOptions& options, std::size_t count);

/// A .zip with the given files in it.
void write_zip(const std::filesystem::path& path,
               const std::vector<std::pair<std::string, Bytes>>& members);

/// A copy with the number at `offset` replaced.
template <class T>
Bytes patched(Bytes bytes, std::size_t offset, T value) {
  store_le<T>(bytes, offset, value);
  return bytes;
}

/// The first `count` bytes.
Bytes cut(Bytes bytes, std::size_t count);

/// Offsets of fields of the LAS header.
namespace at {
constexpr std::size_t kMajor = 24, kMinor = 25, kHeaderBytes = 94, kPointOffset = 96,
                      kVlrCount = 100, kFormat = 104, kRecordBytes = 105, kLegacyCount = 107,
                      kScaleX = 131, kOffsetX = 155, kMaxX = 179, kMinX = 187, kEvlrStart = 235,
                      kEvlrCount = 243, kCount = 247;
}

}  // namespace cornice::test
