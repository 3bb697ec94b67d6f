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
  std::string crs_text;    ///< as Crs::text()
  std::string provenance;  ///< JSON: program, version, parameters, names of the inputs
};

/// What building knows of a level.
struct LevelStatistics {
  std::uint64_t cells = 0, triangles = 0, vertices = 0, bytes = 0;
  double error_max_m = 0, error_mean_m = 0;
};

/// Bytes of one cell part and back: decode_cell(encode_cell(x)) equals x in all that a Node and the
/// order of its triangles' vertices mean. decode_cell trusts nothing: throws InputError for
/// anything that is not whole.
std::vector<std::byte> encode_cell(const CellMesh& mesh, const Header& header);
CellMesh decode_cell(std::span<const std::byte> bytes, const Node& node, const Header& header);

/// Writes a file block by block in any order; the final file's bytes depend on the set of cells
/// alone. One object may be given blocks from several threads.
class FileWriter {
 public:
  /// Writes beside `path` until finish. Throws RunError where that cannot be.
  FileWriter(const std::filesystem::path& path, const Header& header);
  ~FileWriter();
  FileWriter(const FileWriter&) = delete;
  FileWriter& operator=(const FileWriter&) = delete;

  /// node.offset, bytes and checksum are filled in.
  void add(Node node, std::span<const std::byte> block);
  /// Writes the node table and gives the file its name.
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
  /// One read, its checksum proved. Throws InputError where the block is damaged or gone.
  CellMesh read(const Node& node) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cornice::hlod
