// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/hlod/build_input.h"

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <utility>

#include "core/io/mesh_file.h"

namespace cornice::hlod {

namespace fs = std::filesystem;
namespace {

/// Metres: floats that are coarser than this say so. Surveys are not better than a centimetre.
constexpr float kCoarse = 0.01f;

}  // namespace

BuildInput::BuildInput(const BuildCommand& command, const MemoryPlan& plan, StageContext& context)
    : command_(command), plan_(plan), context_(context), fits_(!command.out_of_core) {
  std::uint64_t triangles = 0;
  for (const fs::path& tile : command.tiles) triangles += estimated_triangles(tile);
  fits_ = fits_ && triangles * kBytesInMemory < context.memory.limit_bytes();
  context.progress.begin("read", command.tiles.size());
  for (const fs::path& tile : command.tiles) {
    check_cancelled(context.progress);
    context.report.add_input(tile);
    if (fits_) {
      read_whole(tile);
    } else {
      read_pieces(tile);
    }
    context.progress.advance(1);
  }
  context.progress.end();
  warn_of_coarse_positions();
}

void BuildInput::summarise_more(const Mesh& mesh, const fs::path& tile) {
  const float before = summary_.farthest_m;
  summarise(mesh, tile.string(), context_.options.threads, summary_);
  if (summary_.farthest_m > before) coarsest_ = tile;
}

void BuildInput::warn_of_coarse_positions() const {
  const float far = summary_.farthest_m;
  const float step = std::nextafter(far, 2 * far) - far;
  if (step < kCoarse) return;
  char text[240];
  std::snprintf(text, sizeof text,
                ": positions are floats up to %.7g m from their origin, known to %.3g m only; "
                "write them as doubles, or with a comment 'cornice origin E N H'",
                static_cast<double>(far), static_cast<double>(step));
  context_.report.warn(coarsest_.string() + text);
}

void BuildInput::read_whole(const fs::path& tile) {
  Mesh mesh = read_mesh(tile);
  summarise_more(mesh, tile);
  meshes_.push_back(std::move(mesh));
  // Polygons may be more triangles than their number said.
  if (summary_.triangles * kBytesInMemory >= context_.memory.limit_bytes()) drop();
}

void BuildInput::read_pieces(const fs::path& tile) {
  auto stream = open(tile);
  Mesh piece;
  while (stream->next(piece)) {
    check_cancelled(context_.progress);
    summarise_more(piece, tile);
  }
  if (stream->is_spilled()) streams_[tile] = std::move(stream);
}

std::unique_ptr<MeshStream> BuildInput::open(const fs::path& tile) const {
  MeshStreamOptions options;
  options.vertex_bytes = plan_.vertex_bytes;
  options.piece_triangles = plan_.piece_triangles;
  options.scratch = command_.work.empty() ? command_.output.parent_path() : command_.work;
  if (options.scratch.empty()) options.scratch = ".";
  return open_mesh_stream(tile, options);
}

void BuildInput::drop() {
  meshes_ = {};
  fits_ = false;
}

void BuildInput::for_each(const std::function<void(const Mesh&)>& act) {
  context_.progress.begin("sort into cells", command_.tiles.size());
  for (std::size_t i = 0; i < command_.tiles.size(); ++i) {
    check_cancelled(context_.progress);
    if (fits_) {
      act(std::exchange(meshes_[i], {}));
    } else {
      auto& kept = streams_[command_.tiles[i]];
      if (kept == nullptr) kept = open(command_.tiles[i]);
      kept->rewind();
      Mesh piece;
      while (kept->next(piece)) {
        check_cancelled(context_.progress);
        act(piece);
      }
      kept.reset();
    }
    context_.progress.advance(1);
  }
  context_.progress.end();
}

}  // namespace cornice::hlod
