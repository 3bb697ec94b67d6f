// SPDX-License-Identifier: GPL-3.0-or-later
// Building with the cells on disk, level by level, for what does not fit into memory.
// Li 2024, "Multi-scale simplification and visualization of large 3D models", 3.3.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "hlod/build.h"
#include "hlod/build_spool.h"

namespace cornice::hlod {

/// The folder of one build. What a killed build finished in it is used again by a build of the
/// same text; anything else in it is removed.
class WorkFolder {
 public:
  /// Throws RunError where it cannot be made, or where it holds files that are no build's.
  WorkFolder(std::filesystem::path folder, std::string text);
  std::filesystem::path leaves() const { return folder_ / "leaves.spool"; }
  /// Parts of a level and cells of the next coarser one.
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

/// Makes the finest level on disk, of meshes that are given one after the other.
class DiskLeaves {
 public:
  DiskLeaves(const WorkFolder& folder, const Header& header, std::uint64_t max_pieces, int threads);
  void add(const Mesh& mesh);
  /// Writes folder.leaves().
  LeafCounts finish(Progress& progress);

 private:
  void join(LeafCounts& counts, std::vector<RimVertex>& rim, Progress& progress) const;

  const WorkFolder& folder_;
  Header header_;
  int threads_;
  LeafMaker maker_;
  std::unique_ptr<SpoolWriter> pieces_;
};

/// Builds all levels from folder.leaves() on, those that are there already left alone, and hands
/// the parts of every level to `parts` as they are stored, encoded.
std::vector<LevelCounts> build_levels_on_disk(
    const WorkFolder& folder, const Header& header, const BlockOptions& options, int threads,
    const std::function<void(const Node&, std::span<const std::byte>)>& parts,
    Progress& progress = no_progress());

}  // namespace cornice::hlod
