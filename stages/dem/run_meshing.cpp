// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/cli/log.h"
#include "stages/dem/command.h"
#include "stages/dem/piece_file.h"
#include "stages/dem/pieces.h"

namespace cornice::dem {
namespace {

/// Of the memory, what GDAL may keep of blocks that several windows need.
constexpr std::uint64_t kCacheShare = 4;
constexpr std::uint64_t kMostCache = std::uint64_t{512} << 20;
/// What a process with GDAL, PROJ and its database takes before it has read anything.
constexpr std::uint64_t kBaseBytes = std::uint64_t{64} << 20;

/// Meshes one piece after the other and counts.
class Mesher {
 public:
  Mesher(const Command& command, Survey& survey, StageContext& context)
      : command_(command), survey_(survey), context_(context), lattice_(survey.step()) {
    frame_.crs_text = survey.crs().text();
    Box2d box;
    for (const Tile& tile : survey.tiles()) {
      box.add(survey.east_of(tile.rect.col), survey.north_of(tile.rect.row));
      box.add(survey.east_of(tile.rect.end_col() - 1), survey.north_of(tile.rect.end_row() - 1));
    }
    frame_.frame = {std::round(0.5 * (box.min_x + box.max_x)),
                    std::round(0.5 * (box.min_y + box.max_y)), 0.0};
  }

  void run(const std::vector<Piece>& pieces) {
    context_.progress.begin("tiles", pieces.size());
    for (const Piece& piece : pieces) {
      check_cancelled(context_.progress);
      mesh(piece);
      context_.progress.advance(1);
    }
    context_.progress.end();
    report();
  }

 private:
  void mesh(const Piece& piece) {
    HeightWindow window;
    window.own = piece.own;
    context_.report.step("read", [&] {
      window.heights = survey_.read(HeightWindow::rect_for(piece.own));
      window.taken = survey_.taken(piece.tile, piece.own);
    });
    context_.report.step("mesh", [&] {
      const GridSurface surface(std::move(window), context_.options.threads);
      count(surface);
      if (surface.triangles() > 0) write(piece, surface);
    });
  }

  void count(const GridSurface& surface) {
    empty_pixels_ += surface.empty_pixels();
    if (surface.triangles() == 0) {
      ++empty_;
      return;
    }
    ++meshes_;
    vertices_ += surface.vertices();
    triangles_ += surface.triangles();
    doubled_ += surface.doubled_vertices();
    lowest_ = std::min(lowest_, surface.lowest());
    highest_ = std::max(highest_, surface.highest());
  }

  void write(const Piece& piece, const GridSurface& surface) {
    const auto path = command_.output / (piece.name + "." + command_.format);
    frame_.origin = lattice_.origin_of(survey_, piece.own);
    context_.report.step("write", [&] {
      write_piece(path, surface, lattice_.places_of(survey_, piece.own), frame_,
                  context_.options.threads, context_.progress);
    });
    context_.report.add_output(path);
  }

  void report() {
    if (meshes_ == 0) {
      const Tile& first = survey_.tiles().front();
      throw InputError(first.path.string(),
                       survey_.tiles().size() == 1
                           ? "none of its pixels has a height (no data everywhere); nothing to mesh"
                           : "and the other tiles have no heights (no data everywhere); nothing "
                             "to mesh");
    }
    Report& report = context_.report;
    report.count("meshes", meshes_);
    report.count("empty pieces", empty_);
    report.count("vertices", vertices_);
    report.count("triangles", triangles_);
    report.count("doubled vertices", doubled_);
    report.count("pixels without data", empty_pixels_);
    report.quality("step_m", survey_.step());
    report.quality("lowest_m", static_cast<double>(lowest_));
    report.quality("highest_m", static_cast<double>(highest_));
    if (empty_ > 0) {
      report.warn(std::to_string(empty_) +
                  " tiles or parts of tiles have no data; no mesh of them");
    }
  }

  const Command& command_;
  Survey& survey_;
  StageContext& context_;
  const Lattice lattice_;
  PieceFrame frame_;
  std::uint64_t meshes_ = 0, empty_ = 0, vertices_ = 0, triangles_ = 0, doubled_ = 0;
  std::uint64_t empty_pixels_ = 0;
  float lowest_ = std::numeric_limits<float>::infinity();
  float highest_ = -std::numeric_limits<float>::infinity();
};

/// The pieces to mesh, and a line for every tile that becomes several.
std::vector<Piece> plan(const Command& command, const Survey& survey) {
  std::vector<Piece> pieces;
  for (Piece& piece : cut_into_pieces(survey, command.tile_pixels)) {
    const auto& path = survey.tiles()[piece.tile].path;
    const bool wanted = command.only.empty() || std::find(command.only.begin(), command.only.end(),
                                                          path) != command.only.end();
    if (wanted) pieces.push_back(std::move(piece));
  }
  for (std::size_t i = 0; i < pieces.size();) {
    const std::size_t first = i;
    while (i < pieces.size() && pieces[i].tile == pieces[first].tile) ++i;
    if (i - first < 2) continue;
    const Tile& tile = survey.tiles()[pieces[first].tile];
    log_info(tile.path.filename().string() + ": " + std::to_string(tile.rect.width) + " x " +
             std::to_string(tile.rect.height) + " pixels become " + std::to_string(i - first) +
             " meshes of at most " + std::to_string(command.tile_pixels) + " pixels a side");
  }
  return pieces;
}

/// Keeps GDAL's cache and the largest piece within the memory.
void charge(const Command& command, const Survey& survey, const std::vector<Piece>& pieces,
            MemoryBudget& memory) {
  std::uint64_t pixels = 0;
  for (const Piece& piece : pieces) {
    pixels = std::max(pixels, HeightWindow::rect_for(piece.own).area());
  }
  const std::uint64_t cache = std::min(kMostCache, memory.limit_bytes() / kCacheShare);
  limit_raster_cache(cache);
  memory.charge("GDAL and its cache", kBaseBytes + cache);
  memory.charge("a piece of " + std::to_string(pixels) + " pixels (lower --tile-pixels)",
                survey.window_bytes(pixels) + pixels * GridSurface::kBytesPerPixel +
                    writing_bytes(command.format, pixels));
}

}  // namespace

void run_meshing(const Command& command, StageContext& context) {
  Report& report = context.report;
  for (const auto& tile : command.tiles) report.add_input(tile);
  std::optional<Survey> survey;
  report.step("headers", [&] { survey.emplace(command.tiles, command.survey); });
  for (const std::string& warning : survey->warnings()) report.warn(warning);
  const std::vector<Piece> pieces = plan(command, *survey);
  charge(command, *survey, pieces, context.memory);
  report.count("tiles", survey->tiles().size());
  Mesher(command, *survey, context).run(pieces);
}

}  // namespace cornice::dem
