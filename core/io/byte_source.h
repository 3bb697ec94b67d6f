// SPDX-License-Identifier: GPL-3.0-or-later
// Random access to the bytes of a file, of a file inside a .zip, or of memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace cornice {

/// Bytes at offsets. read_at may be called from one thread at a time only.
class ByteSource {
 public:
  virtual ~ByteSource() = default;
  virtual std::uint64_t size() const = 0;
  /// Copies up to `count` bytes from `offset` on; returns how many there were.
  /// Throws InputError where the device or the compressed file fails.
  virtual std::size_t read_at(std::uint64_t offset, void* to, std::size_t count) = 0;
};

/// The bytes of `data`, which must outlive the source.
class MemorySource : public ByteSource {
 public:
  explicit MemorySource(std::span<const std::uint8_t> data) : data_(data) {}
  std::uint64_t size() const override { return data_.size(); }
  std::size_t read_at(std::uint64_t offset, void* to, std::size_t count) override;

 private:
  std::span<const std::uint8_t> data_;
};

/// An open source and the file inside the .zip that it reads, empty where it is no .zip.
struct OpenedSource {
  std::unique_ptr<ByteSource> bytes;
  std::string zip_member;
};

/// Opens a file, or the one .las or .laz inside a .zip, without unpacking to disk.
/// Throws InputError for a folder, a missing, empty or unreadable file, a git-lfs pointer, and a
/// .zip without exactly one point file in it.
OpenedSource open_point_file(const std::filesystem::path& path);

/// The one .las or .laz inside a .zip. Throws InputError as above.
OpenedSource open_zip_member(const std::filesystem::path& path);

/// Exactly `count` bytes, or fewer where the source ends before.
std::vector<std::uint8_t> read_bytes(ByteSource& source, std::uint64_t offset, std::size_t count);

}  // namespace cornice
