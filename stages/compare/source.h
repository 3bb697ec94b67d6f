// SPDX-License-Identifier: GPL-3.0-or-later
// One side of a comparison: mesh tiles, rasters of heights or point files of one place, in parts
// that fit into memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/geo/crs.h"
#include "stages/compare/options.h"
#include "stages/compare/surface.h"

namespace cornice::compare {

enum class Kind { kMesh, kDem, kCloud };

/// "mesh", "DEM" or "point cloud".
const char* kind_name(Kind kind);

/// What a side is made of, without its elements.
struct SourceFacts {
  Kind kind = Kind::kMesh;
  std::string title;  ///< the path as it was given
  std::vector<std::filesystem::path> files;
  std::uint64_t file_bytes = 0;
  std::uint64_t vertices = 0;   ///< of DEMs pixels, of clouds points in the files
  std::uint64_t triangles = 0;  ///< of DEMs those that join all pixels
  double step_m = 0.0;          ///< of DEMs
  Crs crs;                      ///< empty: not known
  Box2d box;                    ///< of all files
  std::vector<std::string> warnings;
};

/// A part: a mesh file, a block of pixels or a block of ground with its points.
struct Part {
  std::string name;
  Box2d box;
};

/// Thread contract: one thread at a time; what it hands out may be read from many.
class Source {
 public:
  virtual ~Source() = default;
  const SourceFacts& facts() const { return facts_; }
  const std::vector<Part>& parts() const { return parts_; }

  /// All of one part with normals and curvature. Every element of the source is in one part.
  virtual std::shared_ptr<const Surface> part(std::size_t index) = 0;
  /// What reaches into `box`, relative to `origin`. Without normals, but where the files have them.
  virtual Surface region(const Box2d& box, Vec3d origin) = 0;
  /// Where there can be something: the boxes of files that touch `near`.
  virtual std::vector<Box2d> coverage(const Box2d& near) const = 0;

 protected:
  SourceFacts facts_;
  std::vector<Part> parts_;
};

/// The files behind a path: itself, those of a folder, or those that a .txt file lists, one a line.
/// Throws InputError where there are none.
std::vector<std::filesystem::path> files_of(const std::filesystem::path& path);

/// Opens a side by the ending of its files. `cache_bytes` bounds what is kept of files beyond the
/// one in use. Throws InputError for files that cannot be read, of several kinds or coordinate
/// systems, in feet or degrees, and for empty ones.
std::unique_ptr<Source> open_source(const std::filesystem::path& path, const Options& options,
                                    std::uint64_t cache_bytes);

/// Both in one system and in metres, one above the other; throws InputError in plain words.
/// Returns their common ground.
Box2d check_pair(const SourceFacts& a, const SourceFacts& b, std::vector<std::string>& warnings);

}  // namespace cornice::compare
