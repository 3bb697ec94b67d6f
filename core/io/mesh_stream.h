// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes of any size, some triangles at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>

#include "core/mesh/mesh.h"

namespace cornice {

/// What a MeshStream may use.
struct MeshStreamOptions {
  /// For what is kept of a file. Where the vertices of a PLY do not fit, it is read several times,
  /// and the vertices of every piece go to a scratch file.
  std::uint64_t vertex_bytes = std::uint64_t{1} << 30;
  std::size_t piece_triangles = std::size_t{1} << 20;  ///< of a piece, at most
  std::filesystem::path scratch;  ///< folder for scratch files; empty: the system's
};

/// The triangles of a mesh in the order of its file, in pieces that hold the vertices they use.
/// Thread contract: one thread at a time.
class MeshStream {
 public:
  virtual ~MeshStream() = default;
  /// The next piece: options.piece_triangles of them, fewer at the end; false where none are left.
  /// Origin, CRS and properties are those of the whole mesh. Throws InputError as the readers of
  /// whole meshes do.
  virtual bool next(Mesh& piece) = 0;
  /// Begins again.
  virtual void rewind() = 0;
  /// Whether opening it again would do much of the work again.
  virtual bool is_spilled() const { return false; }
};

/// A PLY file. Its pieces together are what read_ply_mesh reads, bit for bit, but for vertices that
/// no triangle uses. Throws as that does, and RunError where scratch files cannot be written.
std::unique_ptr<MeshStream> open_ply_mesh_stream(const std::filesystem::path& path,
                                                 const MeshStreamOptions& options);

/// A mesh in memory.
std::unique_ptr<MeshStream> stream_of_mesh(Mesh mesh, const MeshStreamOptions& options);

}  // namespace cornice
