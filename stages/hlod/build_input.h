// SPDX-License-Identifier: GPL-3.0-or-later
// The meshes of a build: kept in memory as long as building there fits, read piece by piece
// otherwise.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "core/cli/stage.h"
#include "core/io/mesh_stream.h"
#include "hlod/build.h"
#include "hlod/build_memory.h"
#include "stages/hlod/build_jobs.h"

namespace cornice::hlod {

class BuildInput {
 public:
  /// Reads all meshes once, for what has to be known beforehand.
  BuildInput(const BuildCommand& command, const MemoryPlan& plan, StageContext& context);

  const InputSummary& summary() const { return summary_; }
  /// Whether all meshes are in memory, and building there fits.
  bool fits() const { return fits_; }
  /// From now on the meshes are read from their files.
  void drop();
  /// Calls act(mesh) for every mesh, or piece of one, in the order of the input. What was in memory
  /// is gone afterwards.
  void for_each(const std::function<void(const Mesh&)>& act);

 private:
  void read_whole(const std::filesystem::path& tile);
  void read_pieces(const std::filesystem::path& tile);
  std::unique_ptr<MeshStream> open(const std::filesystem::path& tile) const;
  void summarise_more(const Mesh& mesh, const std::filesystem::path& tile);
  void warn_of_coarse_positions() const;

  const BuildCommand& command_;
  MemoryPlan plan_;
  StageContext& context_;
  InputSummary summary_;
  /// The tile whose floats are the coarsest.
  std::filesystem::path coarsest_;
  std::vector<Mesh> meshes_;
  /// Of tiles whose reading would take much work again.
  std::map<std::filesystem::path, std::unique_ptr<MeshStream>> streams_;
  bool fits_ = true;
};

}  // namespace cornice::hlod
