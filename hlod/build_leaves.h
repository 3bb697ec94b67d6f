// SPDX-License-Identifier: GPL-3.0-or-later
// The cells of the finest level: triangles to cells by barycentre, positions to the lattice.
// Li 2024, "Multi-scale simplification and visualization of large 3D models", 3.2.3.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/mesh/mesh.h"
#include "hlod/build_cell.h"
#include "hlod/file.h"

namespace cornice::hlod {

/// What was found in the input that no cell holds.
struct LeafCounts {
  std::uint64_t triangles = 0;     ///< given
  std::uint64_t degenerate = 0;    ///< without three different lattice points: left out
  std::uint64_t duplicate = 0;     ///< beyond the first of the same three points: left out
  std::uint64_t split_pieces = 0;  ///< triangles made of those with long edges
};

/// Triangles of a mesh that follow each other and are all of one cell: mostly many.
struct CellRun {
  std::int32_t i = 0, j = 0, k = 0;  ///< of the cell
  std::uint32_t length = 0;
  std::size_t begin = 0;
};

/// Makes pieces of cells of meshes. Thread contract: one thread at a time.
class LeafMaker {
 public:
  /// max_pieces: InputError where long triangles would make more.
  LeafMaker(const Header& header, std::uint64_t max_pieces, int threads)
      : header_(header), max_pieces_(max_pieces), threads_(threads) {}

  /// Takes a piece of a cell.
  using Sink = std::function<void(BuildCell piece)>;

  /// The mesh's triangles by cell, in the order of their keys; in a cell, triangles keep their
  /// order and vertices are numbered by first use. No sharers yet.
  std::vector<BuildCell> pieces(const Mesh& mesh);
  /// The same for at most `most` triangles at a time, in several pieces of a cell where there are
  /// more.
  void pieces(const Mesh& mesh, std::size_t most, const Sink& sink);
  const LeafCounts& counts() const { return counts_; }

 private:
  struct Soup;
  void take_vertices(const Mesh& mesh, Soup& soup) const;
  void take_triangles(const Mesh& mesh, Soup& soup);
  void split(const Triangle& triangle, Soup& soup);
  void add_piece(const std::array<CellVertex, 3>& corners, Soup& soup);
  void flush(Soup& soup) const;
  std::vector<CellRun> find_runs(const Soup& soup) const;
  std::vector<BuildCell> sort_into_cells(Soup& soup) const;
  BuildCell make_piece(const Soup& soup, std::span<const CellRun> runs) const;

  Header header_;
  std::uint64_t max_pieces_;
  int threads_;
  LeafCounts counts_;
};

/// One cell of its pieces, given in the order of the input: vertices at one position become one,
/// with the attributes of the first; triangles that are there already are left out and counted.
BuildCell join_pieces(std::vector<BuildCell> pieces, LeafCounts& counts);

/// A vertex of one cell that lies in another, or is met by such a vertex there.
struct RimVertex {
  CellKey home;  ///< the cell it lies in
  CellKey cell;  ///< the cell that uses it
  std::uint32_t vertex = 0;
  CellVertex data;
  Vec3f normal_sum;
};

/// Vertices of the cell that lie in other cells.
std::vector<RimVertex> rim_of(const BuildCell& cell, const Header& header);

/// What all users of a vertex have to agree on.
struct RimAnswer {
  CellKey cell;
  std::uint32_t vertex = 0;
  std::uint32_t sharers = 0;
  CellVertex data;
  Vec3f normal_sum;
};

/// The answers to the rim vertices that lie in `home`, which may have no triangles of its own:
/// everyone takes the data of the user with the lowest key and the sum of the normals.
std::vector<RimAnswer> answer_rim(const BuildCell& home, std::vector<RimVertex> rim);

/// Gives the cell of a key, one without triangles where there is none; called from several threads.
using FindCell = std::function<const BuildCell*(const CellKey& key, BuildCell& buffer)>;

/// The answers to all rim vertices of a level, ordered by the cell that they are for.
std::vector<RimAnswer> answer_all(std::vector<RimVertex> rim, const FindCell& find, int threads);

/// Those for one cell.
std::span<const RimAnswer> answers_for(const CellKey& cell, const std::vector<RimAnswer>& all);

/// Tells every cell of a level, given in the order of their keys, which others use its vertices.
void connect_cells(std::vector<BuildCell>& cells, const Header& header, int threads);

/// Puts the answers' sharers into their cell.
void put_sharers(BuildCell& cell, std::span<const RimAnswer> answers);

/// Puts in what was answered (of this cell alone) and gives vertices without normals theirs.
void finish_leaf(BuildCell& cell, std::span<const RimAnswer> answers, int normal_bits);

/// All of that for cells in memory: pieces of several meshes in the order of the input, joined,
/// with sharers, in the order of their keys.
std::vector<BuildCell> finish_leaves(std::vector<std::vector<BuildCell>> pieces,
                                     const Header& header, int threads, LeafCounts& counts);

}  // namespace cornice::hlod
