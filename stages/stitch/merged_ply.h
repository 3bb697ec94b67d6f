// SPDX-License-Identifier: GPL-3.0-or-later
// One PLY mesh of all tiles, written tile by tile.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/io/output_stream.h"
#include "core/mesh/mesh.h"
#include "stages/stitch/edit.h"

namespace cornice::stitch {

/// Vertices go to the file, triangles to a second one beside it that is appended in the end; in
/// memory there is a number per shared vertex. Positions are float, or double where the survey is
/// too wide for floats to hold them exactly. Attributes are those of the first tile that has
/// triangles; vertices of tiles without one of them have 0 there.
class MergedPly {
 public:
  MergedPly(std::filesystem::path path, Vec3d origin, std::string crs_text, double largest_m,
            std::uint32_t class_count);
  void add(const EditedTile& tile);
  /// Writes the counts and gives the file its name.
  void commit();
  std::uint64_t vertices() const { return vertices_; }
  std::uint64_t triangles() const { return triangles_; }

 private:
  void take_schema(const Mesh& mesh);
  void add_vertex(const Mesh& mesh, std::uint32_t row);
  void append_faces();
  std::string header(std::uint64_t vertices, std::uint64_t triangles) const;

  OutputStream out_;
  AtomicFile faces_file_;  ///< never gets its name
  PatientFileBuffer faces_;
  std::vector<std::uint8_t> record_;
  Vec3d origin_;
  std::string crs_text_;
  bool is_wide_;
  bool has_schema_ = false;
  bool has_normals_ = false;
  std::vector<std::string> floats_, bytes_;
  std::vector<std::uint32_t> class_row_;
  std::uint64_t vertices_ = 0, triangles_ = 0;
};

}  // namespace cornice::stitch
