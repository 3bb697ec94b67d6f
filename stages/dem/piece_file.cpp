// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/dem/piece_file.h"

#include <algorithm>
#include <vector>

#include "core/io/mesh_export.h"
#include "core/io/ordered_work.h"
#include "core/io/output_stream.h"
#include "core/io/ply.h"

namespace cornice::dem {
namespace {

/// Bytes of records made at once: they should still be in the cache when they are written.
constexpr std::int64_t kBlockBytes = 1 << 19;

/// Rows of vertices, then rows of triangles, in blocks.
struct Block {
  bool is_vertices = true;
  std::int64_t begin = 0, end = 0;
};

std::vector<Block> blocks_of(const GridSurface& surface, std::int64_t width) {
  std::vector<Block> blocks;
  const auto add = [&](bool is_vertices, std::int64_t rows, std::int64_t row_bytes) {
    const std::int64_t step =
        std::max<std::int64_t>(1, kBlockBytes / std::max<std::int64_t>(1, row_bytes));
    for (std::int64_t row = 0; row < rows; row += step) {
      blocks.push_back({is_vertices, row, std::min(rows, row + step)});
    }
  };
  // One row more: that of the doubled vertices.
  add(true, surface.vertex_rows() + 1,
      width * static_cast<std::int64_t>(GridSurface::kVertexBytes));
  add(false, surface.triangle_rows(),
      2 * width * static_cast<std::int64_t>(GridSurface::kTriangleBytes));
  return blocks;
}

void make_block(const GridSurface& surface, const VertexPlaces& places, const Block& block,
                std::vector<std::uint8_t>& bytes) {
  if (block.is_vertices) {
    const auto count = surface.vertices_before(block.end) - surface.vertices_before(block.begin);
    bytes.resize(static_cast<std::size_t>(count) * GridSurface::kVertexBytes);
    surface.vertex_records(block.begin, block.end, places, bytes.data());
  } else {
    const auto count = surface.triangles_before(block.end) - surface.triangles_before(block.begin);
    bytes.resize(static_cast<std::size_t>(count) * GridSurface::kTriangleBytes);
    surface.triangle_records(block.begin, block.end, bytes.data());
  }
}

void write_ply(const std::filesystem::path& path, const GridSurface& surface,
               const VertexPlaces& places, const PieceFrame& frame, int threads,
               Progress& progress) {
  OutputStream file(path);
  file.stream() << ply_header_start(frame.origin, frame.crs_text, surface.vertices())
                << "property float x\nproperty float y\nproperty float z\n"
                   "property float nx\nproperty float ny\nproperty float nz\nelement face "
                << surface.triangles() << "\nproperty list uchar int vertex_indices\nend_header\n";
  const std::vector<Block> blocks =
      blocks_of(surface, static_cast<std::int64_t>(places.east.size()));
  std::vector<std::vector<std::uint8_t>> buffers(ordered_slots(threads));
  OrderedWork work;
  work.count = blocks.size();
  work.threads = threads;
  work.fetch = [](std::size_t, std::size_t) {};
  work.work = [&](std::size_t i, std::size_t slot) {
    make_block(surface, places, blocks[i], buffers[slot]);
  };
  work.deliver = [&](std::size_t, std::size_t slot) {
    check_cancelled(progress);
    file.put(buffers[slot]);
    return true;
  };
  run_ordered(work);
  file.check();
  file.commit();
}

}  // namespace

void write_piece(const std::filesystem::path& path, const GridSurface& surface,
                 const VertexPlaces& places, const PieceFrame& frame, int threads,
                 Progress& progress) {
  if (path.extension() == ".ply") {
    write_ply(path, surface, places, frame, threads, progress);
    return;
  }
  Mesh mesh = whole_mesh(surface, places, threads);
  mesh.origin = frame.origin;
  mesh.crs_text = frame.crs_text;
  export_mesh(path, mesh, frame.frame);
}

std::uint64_t writing_bytes(const std::string& format, std::uint64_t pixels) {
  // The mesh (48 bytes a pixel), of GLB twice more while the file is put together.
  constexpr std::uint64_t kStreams = 64u << 20;
  if (format == "ply") return kStreams;
  return kStreams + pixels * (format == "glb" ? 200 : 50);
}

}  // namespace cornice::dem
