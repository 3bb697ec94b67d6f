// SPDX-License-Identifier: GPL-3.0-or-later
// PLY files of meshes and oriented points: binary little-endian, origin and CRS as comments.
// docs/formats/ply.md describes every element.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/mesh/mesh.h"

namespace cornice {

/// What a PLY header says.
struct PlyInfo {
  struct Element {
    std::string name;
    std::uint64_t count = 0;
    std::vector<std::pair<std::string, std::string>> properties;  ///< name, type ("list uchar int")
  };
  std::string format;  ///< "binary_little_endian", "binary_big_endian" or "ascii"
  std::vector<Element> elements;
  std::vector<std::string> comments;
  Vec3d origin;          ///< from "comment cornice origin E N H"; 0 where absent
  std::string crs_text;  ///< from "comment cornice crs ..."
  std::uint64_t header_bytes = 0;

  /// How many the header promises of an element ("vertex", "face"); 0 where it names none.
  std::uint64_t count(std::string_view element) const;
};

/// Throws InputError for what is no PLY, is truncated in the header or shorter than it promises.
PlyInfo read_ply_info(const std::filesystem::path& path);

/// Reads a mesh: ascii and both binary byte orders, any numeric type, polygons split into fans.
/// Throws InputError for truncated data, indices out of range, or positions that are not finite.
Mesh read_ply_mesh(const std::filesystem::path& path);
OrientedPoints read_ply_points(const std::filesystem::path& path);

/// The lines of a header up to those of the vertices' properties, for those who write piece by
/// piece. The origin must be finite.
std::string ply_header_start(const Vec3d& origin, const std::string& crs_text,
                             std::uint64_t vertices);

/// Both write atomically. Throw RunError where the disk is full.
void write_ply(const std::filesystem::path& path, const Mesh& mesh);
void write_ply(const std::filesystem::path& path, const OrientedPoints& points);

}  // namespace cornice
