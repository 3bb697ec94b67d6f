// SPDX-License-Identifier: GPL-3.0-or-later
// The header of a PLY file, taken apart and checked against the size of the file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "core/base/vec.h"

namespace cornice {

enum class PlyFormat { kAscii, kLittleEndian, kBigEndian };
enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

/// Bytes of one value.
std::size_t ply_size(PlyType type);
/// The oldest name, which every reader knows: "char", "uchar", ... "float", "double".
const char* ply_type_name(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat32;
  std::optional<PlyType> list_count;  ///< type of a list's length; nothing: no list

  bool is_list() const { return list_count.has_value(); }
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;

  bool has_lists() const;
  /// Bytes of one binary record; with lists, of one whose lists are empty.
  std::size_t record_bytes() const;
  /// Index of the first property of one of these names; nothing where there is none.
  std::optional<std::size_t> find(std::initializer_list<const char*> names) const;
};

struct PlyHeader {
  PlyFormat format = PlyFormat::kAscii;
  std::vector<PlyElement> elements;
  std::vector<std::string> comments;
  Vec3d origin;
  std::string crs_text;
  std::uint64_t header_bytes = 0;
  std::uint64_t file_bytes = 0;
};

/// Throws InputError for what is no PLY, is truncated in the header, or whose elements cannot fit
/// into the bytes that follow the header.
PlyHeader read_ply_header(const std::filesystem::path& path);

}  // namespace cornice
