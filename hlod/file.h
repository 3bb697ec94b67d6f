// SPDX-License-Identifier: GPL-3.0-or-later
// The .hlod file: a header, a node table and one block of bytes per cell part.
// docs/formats/hlod.md describes every byte.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/base/vec.h"
#include "hlod/cell.h"

namespace cornice::hlod {

/// What holds for a whole hierarchy.
struct Header {
  Lattice lattice;
  Partition partition = Partition::kQuadtree;
  std::uint32_t attributes = 0;  ///< AttributeBits
  /// s0 of the hierarchy: an edge of level l is at most s0 * cell side, and a vertex is at most
  /// half of that from its parent (max norm in octrees, plan only in quadtrees).
  double edge_share = 0.25;
  int normal_bits = 8;     ///< 8 or 10 per component: off by up to 0.95 or 0.24 degrees
  std::string crs_text;    ///< as Crs::text()
  std::string provenance;  ///< JSON: program, version, parameters, names of the inputs
};

/// What building knows of a level.
struct LevelStatistics {
  std::uint64_t cells = 0, triangles = 0, vertices = 0, bytes = 0;
  double error_max_m = 0, error_mean_m = 0;
};

/// What a cell part may hold at most.
inline constexpr std::size_t kCellVertexLimit = 65535;
inline constexpr std::size_t kCellTriangleLimit = std::size_t{1} << 18;

/// "cell 7/12/-3/0", with " part 1" where there are several: for messages.
std::string cell_name(const CellKey& key, int part = 0);

/// The node of a mesh: its key, counts and box; part, offset, bytes and checksum are 0.
Node make_node(const CellMesh& mesh, float error_m, float step_error_m);

/// Bytes of one cell part and back: decode_cell(encode_cell(x)) is x but for the order of its
/// vertices, parents and triangles and each triangle's first corner; encoding that again gives the
/// same result. Every parent must be named by some vertex; values of attributes that the header
/// lacks are dropped. decode_cell trusts nothing: throws InputError, which names the cell, for
/// anything that is not whole. The bytes depend on the mesh and zstd's version alone, what they
/// decode to on the bytes alone.
std::vector<std::byte> encode_cell(const CellMesh& mesh, const Header& header);
CellMesh decode_cell(std::span<const std::byte> bytes, const Node& node, const Header& header);

/// Writes a file block by block in any order; the final file's bytes depend on the set of cells
/// alone. Blocks are spooled to disk; where they did not come in order of their keys, finish()
/// needs room for the file twice. One object may be given blocks from several threads.
class FileWriter {
 public:
  /// Writes beside `path` until finish. Throws RunError where that cannot be.
  FileWriter(const std::filesystem::path& path, const Header& header);
  ~FileWriter();
  FileWriter(const FileWriter&) = delete;
  FileWriter& operator=(const FileWriter&) = delete;

  /// node.offset, bytes and checksum are filled in. Throws RunError where the disk is full.
  void add(Node node, std::span<const std::byte> block);
  /// Writes the node table and gives the file its name. Throws RunError where that cannot be, or
  /// where a part was added twice or one before it is missing.
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// An open file. Opening reads the header and the node table alone. Safe to read from several
/// threads.
class File {
 public:
  /// Throws InputError for what is no .hlod file, is of a newer version, or is not whole.
  explicit File(const std::filesystem::path& path);
  ~File();
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  const Header& header() const;
  /// Sorted by key, then part.
  const std::vector<Node>& nodes() const;
  const std::vector<LevelStatistics>& levels() const;
  /// Metres, CRS and height as the lattice's; what all vertices of all levels lie in.
  const Box3d& bounds() const;
  std::uint64_t bytes() const;  ///< of the file
  /// One read, its checksum proved. Throws InputError where the block is damaged or gone.
  CellMesh read(const Node& node) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cornice::hlod
