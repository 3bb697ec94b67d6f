// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>
#include <cstdio>

#include "core/io/las.h"
#include "core/io/las_decode.h"

namespace cornice {
namespace {

Vec3d coordinates(const LasInfo& info, Vec3<std::int32_t> stored) {
  return {stored.x * info.scale.x + info.offset.x, stored.y * info.scale.y + info.offset.y,
          stored.z * info.scale.z + info.offset.z};
}

std::string box_text(const Box3d& box) {
  char text[256];
  std::snprintf(text, sizeof text, "x %.10g to %.10g, y %.10g to %.10g, z %.10g to %.10g",
                box.min.x, box.max.x, box.min.y, box.max.y, box.min.z, box.max.z);
  return text;
}

/// Compares the header's bounds with the points; a step of the stored integers is rounding.
void check_bounds(const LasPass& pass, LasReadResult& result) {
  const LasInfo& info = pass.info();
  const Box3d& header = info.bounds;
  const Box3d& found = result.decoded_bounds;
  if (found.empty()) return;
  const bool all_decoded = pass.is_whole_file() && result.problem.empty();
  const auto differs = [&](double low, double high, double found_low, double found_high,
                           double step) {
    const double tolerance = 1.01 * step;
    if (!(found_low >= low - tolerance && found_high <= high + tolerance)) return true;
    return all_decoded && (found_low > low + tolerance || found_high < high - tolerance);
  };
  if (differs(header.min.x, header.max.x, found.min.x, found.max.x, info.scale.x) ||
      differs(header.min.y, header.max.y, found.min.y, found.max.y, info.scale.y) ||
      differs(header.min.z, header.max.z, found.min.z, found.max.z, info.scale.z)) {
    result.warnings.push_back("the header's bounds (" + box_text(header) +
                              ") are not those of the points (" + box_text(found) + ")");
  }
}

void conclude(const LasPass& pass, const DecodeSummary& summary, LasReadResult& result) {
  result.points_decoded = summary.decoded;
  result.problem = summary.problem;
  if (!summary.bounds.empty()) {
    result.decoded_bounds.add(coordinates(pass.info(), summary.bounds.min));
    result.decoded_bounds.add(coordinates(pass.info(), summary.bounds.max));
  }
  check_bounds(pass, result);
}

}  // namespace

LasReadResult read_las(const LasInfo& info, const LasReadOptions& options, Progress& progress) {
  LasPass pass(info, options);
  LasReadResult result;
  result.points.origin = pass.origin();
  resize_points(result.points, 0, info, pass.attributes());
  DecodeSummary summary;
  if (pass.has_known_places()) {
    resize_points(result.points, static_cast<std::size_t>(pass.points()), info, pass.attributes(),
                  options.threads);
    summary = pass.decode_to(result.points, progress);
    resize_points(result.points, static_cast<std::size_t>(summary.decoded), info,
                  pass.attributes());
  } else {
    summary = pass.decode_blocks(
        [&](PointCloud& block, std::uint64_t) { result.points.append(block); }, progress);
  }
  conclude(pass, summary, result);
  return result;
}

LasReadResult stream_las(const LasInfo& info, const LasReadOptions& options,
                         std::size_t chunk_points,
                         const std::function<void(PointCloud& chunk, std::uint64_t first)>& sink,
                         Progress& progress) {
  LasPass pass(info, options);
  PointCloud waiting;
  std::uint64_t first = 0;
  const auto flush = [&] {
    if (!waiting.empty()) sink(waiting, first);
    waiting = PointCloud{};
  };
  const DecodeSummary summary = pass.decode_blocks(
      [&](PointCloud& block, std::uint64_t block_first) {
        if (waiting.size() + block.size() > chunk_points) flush();
        if (waiting.empty()) {
          waiting = std::move(block);
          first = block_first;
        } else {
          waiting.append(block);
        }
        if (waiting.size() >= chunk_points) flush();
      },
      progress);
  flush();
  LasReadResult result;
  conclude(pass, summary, result);
  return result;
}

}  // namespace cornice
