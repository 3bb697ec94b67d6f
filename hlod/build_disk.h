// SPDX-License-Identifier: GPL-3.0-or-later
// Building with the cells on disk, level by level, for what does not fit into memory.
// Li 2024, "Multi-scale simplification and visualization of large 3D models", 3.3.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hlod/build.h"
#include "hlod/build_region.h"
#include "hlod/build_spool.h"

namespace cornice::hlod {

/// The folder of one build. What a killed build finished in it is used again by a build of the
/// same text; anything else in it is removed.
class WorkFolder {
 public:
  /// Throws RunError where it cannot be made, or where it holds files that are no build's.
  WorkFolder(std::filesystem::path folder, std::string text);
  std::filesystem::path leaves() const { return folder_ / "leaves.spool"; }
  /// What becomes the leaves: pieces of cells, and those joined to cells.
  std::filesystem::path pieces() const { return folder_ / "pieces.spool"; }
  std::filesystem::path joined() const { return folder_ / "joined.spool"; }
  /// Cells of a level, and parts of the next finer one.
  std::filesystem::path level(int level) const;
  const std::string& text() const { return text_; }
  const std::filesystem::path& path() const { return folder_; }
  /// Whether a spool of this build is there, whole.
  bool has(const std::filesystem::path& spool) const;
  void remove() const;

 private:
  std::filesystem::path folder_;
  std::string text_;
};

/// What of a hierarchy is built on disk, and with what; all of it where nothing is said.
struct DiskTask {
  int threads = 0;
  /// Triangles that are sorted into cells at a time.
  std::size_t piece_triangles = std::size_t{1} << 22;
  MemoryGate* gate = nullptr;      ///< for cells and blocks in flight; none: no limit
  const Region* region = nullptr;  ///< of the finer levels, what one job builds
  /// Where building begins with folder.level(first_level), whose cells do not know their sharers,
  /// instead of folder.leaves().
  std::optional<int> first_level;
};

/// Makes the finest level on disk, of meshes that are given one after the other, in pieces of any
/// size. What a killed build has sorted or joined already is not asked for again.
class DiskLeaves {
 public:
  DiskLeaves(const WorkFolder& folder, const Header& header, std::uint64_t max_pieces,
             const DiskTask& task);
  DiskLeaves(const WorkFolder& folder, const Header& header, std::uint64_t max_pieces, int threads);
  /// Whether meshes have to be added; all of them, then, or none.
  bool wants_meshes() const { return pieces_ != nullptr; }
  void add(const Mesh& mesh);
  /// Writes folder.leaves().
  LeafCounts finish(Progress& progress);

 private:
  void join(Progress& progress) const;

  const WorkFolder& folder_;
  Header header_;
  DiskTask task_;
  LeafMaker maker_;
  std::unique_ptr<SpoolWriter> pieces_;
};

/// What DiskLeaves counted when it made folder.leaves().
LeafCounts counts_of_leaves(const WorkFolder& folder);

/// Builds all levels from the finest (or task.first_level) on, those that are there already left
/// alone, and hands the parts of every level to `parts` as they are stored, encoded. With a region
/// it ends at the region's level, whose cells then are in folder.level(), or in folder.leaves().
std::vector<LevelCounts> build_levels_on_disk(
    const WorkFolder& folder, const Header& header, const BlockOptions& options,
    const DiskTask& task, const std::function<void(const Node&, std::span<const std::byte>)>& parts,
    Progress& progress = no_progress());
std::vector<LevelCounts> build_levels_on_disk(
    const WorkFolder& folder, const Header& header, const BlockOptions& options, int threads,
    const std::function<void(const Node&, std::span<const std::byte>)>& parts,
    Progress& progress = no_progress());

}  // namespace cornice::hlod
