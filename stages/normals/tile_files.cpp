// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/normals/tile_files.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/io/ply.h"
#include "core/mesh/mesh.h"

namespace cornice::normals {
namespace {

constexpr std::uint32_t kNotPutOut = std::numeric_limits<std::uint32_t>::max();

std::vector<LasInfo> open_neighbours(const TileInput& input, const LasInfo& tile) {
  std::vector<LasInfo> infos;
  LasOpenOptions open;
  open.crs_override = input.crs;
  for (const std::filesystem::path& path : input.neighbours) {
    std::error_code ignored;
    if (std::filesystem::equivalent(path, input.tile, ignored)) continue;
    LasInfo info = read_las_info(path, open);
    if (!same_crs(info.crs, tile.crs)) {
      throw InputError(path.string(), "has the coordinate system \"" + info.crs.text() +
                                          "\", the tile has \"" + tile.crs.text() +
                                          "\"; give --crs if one of them is wrong");
    }
    infos.push_back(std::move(info));
  }
  return infos;
}

Box2d plan_bounds(const PointCloud& points) {
  Box2d box;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3d p = points.position(i);
    box.add(p.x, p.y);
  }
  return box;
}

void add_warnings(const std::filesystem::path& path, const std::vector<std::string>& from,
                  std::vector<std::string>& to) {
  for (const std::string& line : from) to.push_back(path.filename().string() + ": " + line);
}

ExtraByte extra_byte(const std::string& name, const std::string& description, std::uint8_t type,
                     std::size_t size, std::size_t& offset) {
  ExtraByte entry;
  entry.name = name;
  entry.description = description;
  entry.data_type = type;
  entry.offset = std::exchange(offset, offset + size);
  entry.size = size;
  return entry;
}

/// What is stored for each point behind its own extra bytes.
struct Added {
  std::array<float, 4> normal_and_quality;
  std::uint16_t line_id;
};
constexpr std::size_t kAddedBytes = 4 * sizeof(float) + sizeof(std::uint16_t);

LasWriteOptions write_options(const LasInfo& tile) {
  LasWriteOptions options;
  // Wave packets lie in a file of their own that the copy does not have.
  static constexpr std::array<int, 11> kWithoutWaves{0, 1, 2, 3, 1, 3, 6, 7, 8, 6, 8};
  options.version_minor = 4;
  options.point_format = kWithoutWaves[static_cast<std::size_t>(tile.point_format)];
  options.scale = tile.scale;
  options.offset = tile.offset;
  options.gps_time_type = tile.gps_time_type;
  options.file_source_id = tile.file_source_id;
  options.system_identifier = tile.system_identifier;
  options.generating_software = "cornice-normals";
  options.crs = tile.crs;
  options.extra_bytes = tile.extra_bytes;
  std::size_t offset = tile.extra_stride;
  auto& extra = options.extra_bytes;
  extra.push_back(extra_byte("normal x", "unit normal, out of the ground", 9, 4, offset));
  extra.push_back(extra_byte("normal y", "unit normal, out of the ground", 9, 4, offset));
  extra.push_back(extra_byte("normal z", "unit normal, out of the ground", 9, 4, offset));
  extra.push_back(extra_byte("quality", "of the normal, 0 to 1", 9, 4, offset));
  extra.push_back(extra_byte("flight line", "id; 0 where unknown", 3, 2, offset));
  return options;
}

void append_extra_bytes(PointCloud& chunk, const std::vector<Added>& added) {
  const std::size_t old_stride = chunk.extra_stride, stride = old_stride + kAddedBytes;
  std::vector<std::uint8_t> bytes(chunk.size() * stride);
  for (std::size_t i = 0; i < chunk.size(); ++i) {
    std::uint8_t* to = bytes.data() + i * stride;
    if (old_stride > 0) std::memcpy(to, chunk.extra_bytes.data() + i * old_stride, old_stride);
    to += old_stride;
    std::memcpy(to, added[i].normal_and_quality.data(), 4 * sizeof(float));
    std::memcpy(to + 4 * sizeof(float), &added[i].line_id, sizeof(std::uint16_t));
  }
  chunk.extra_stride = stride;
  chunk.extra_bytes = std::move(bytes);
}

}  // namespace

std::uint64_t promised_points(const TileInput& input) {
  // What a cut or damaged file promises is nothing to go by.
  const auto require_whole = [](const LasInfo& info) {
    if (!info.data_problem.empty()) throw InputError(info.path.string(), info.data_problem);
  };
  LasOpenOptions open;
  open.crs_override = input.crs;
  const LasInfo tile = read_las_info(input.tile, open);
  require_whole(tile);
  const Box2d window = tile.bounds.plan().grown(input.halo_m);
  auto total = static_cast<double>(tile.point_count);
  for (const LasInfo& info : open_neighbours(input, tile)) {
    const Box2d box = info.bounds.plan();
    if (!box.intersects(window)) continue;
    require_whole(info);
    const double width = std::min(box.max_x, window.max_x) - std::max(box.min_x, window.min_x);
    const double height = std::min(box.max_y, window.max_y) - std::max(box.min_y, window.min_y);
    const double share = width * height / std::max(box.width() * box.height(), 1e-9);
    total += static_cast<double>(info.point_count) * std::min(share, 1.0);
  }
  return static_cast<std::uint64_t>(total);
}

TilePoints read_tile(const TileInput& input, int threads, Progress& progress) {
  TilePoints result;
  LasOpenOptions open;
  open.crs_override = input.crs;
  result.info = read_las_info(input.tile, open);
  if (!result.info.crs.empty() && result.info.crs.metres_per_unit == 0.0) {
    throw InputError(input.tile.string(), "is in degrees (" + result.info.crs.text() +
                                              "); reproject it to metres first");
  }
  const std::vector<LasInfo> neighbours = open_neighbours(input, result.info);
  LasReadOptions read;
  read.attributes = kAttributes;
  read.threads = threads;
  LasReadResult tile = read_las(result.info, read, progress);
  result.points = std::move(tile.points);
  result.tile_points = result.points.size();
  add_warnings(input.tile, result.info.warnings, result.warnings);
  add_warnings(input.tile, tile.warnings, result.warnings);
  if (result.points.empty()) return result;
  const Box2d window = plan_bounds(result.points).grown(input.halo_m);
  read.window = window;
  read.origin = result.points.origin;
  for (const LasInfo& info : neighbours) {
    if (!info.bounds.plan().intersects(window)) continue;
    LasReadResult halo = read_las(info, read, progress);
    result.points.append(halo.points);
    add_warnings(info.path, info.warnings, result.warnings);
    add_warnings(info.path, halo.warnings, result.warnings);
  }
  return result;
}

void write_oriented_ply(const std::filesystem::path& path, Result&& result,
                        const std::string& crs_text) {
  OrientedPoints points;
  points.origin = result.origin;
  points.crs_text = crs_text;
  points.positions = std::move(result.positions);
  points.normals = std::move(result.normals);
  points.quality = std::move(result.quality);
  points.line_id = std::move(result.line_id);
  if (!result.intensity.empty() || points.positions.empty()) {
    points.float_properties.push_back(
        {"intensity", std::vector<float>(result.intensity.begin(), result.intensity.end())});
  }
  points.byte_properties.push_back({"class", std::move(result.classification)});
  if (!result.halo.empty()) points.byte_properties.push_back({"halo", std::move(result.halo)});
  write_ply(path, points);
}

std::uint64_t write_oriented_las(const std::filesystem::path& path, const LasInfo& tile,
                                 const Result& result, int threads, Progress& progress) {
  std::vector<std::uint32_t> place(tile.point_count, kNotPutOut);
  for (std::uint32_t r = 0; r < result.source.size(); ++r) {
    if (result.source[r] < place.size()) place[result.source[r]] = r;
  }
  LasWriter writer(path, write_options(tile));
  LasReadOptions read;
  read.attributes = Attribute::kAll;
  read.threads = threads;
  constexpr std::size_t kChunk = 1u << 18;
  stream_las(
      tile, read, kChunk,
      [&](PointCloud& chunk, std::uint64_t first) {
        std::vector<std::uint8_t> keep(chunk.size(), 0);
        std::vector<Added> added;
        for (std::size_t i = 0; i < chunk.size(); ++i) {
          const std::uint32_t r = place[first + i];
          if (r == kNotPutOut) continue;
          keep[i] = 1;
          const Vec3f n = result.normals[r];
          added.push_back({{n.x, n.y, n.z, result.quality[r]}, result.line_id[r]});
        }
        chunk.filter(keep);
        chunk.wave_packet.clear();
        append_extra_bytes(chunk, added);
        writer.write(chunk);
      },
      progress);
  writer.close();
  return writer.points_written();
}

}  // namespace cornice::normals
