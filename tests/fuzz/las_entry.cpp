// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/fuzz/las_entry.h"

#include <cstdio>
#include <cstdlib>
#include <string>

#include "core/base/error.h"
#include "core/io/copc_hierarchy.h"
#include "core/io/las_chunks.h"
#include "core/io/las_header.h"
#include "core/io/lax_reader.h"

namespace cornice::test {
namespace {

void require(bool holds, const char* promise) {
  if (holds) return;
  std::fprintf(stderr, "broken promise: %s\n", promise);
  std::abort();
}

void check_info(const LasInfo& info, std::size_t bytes) {
  require(info.point_format >= 0 && info.point_format <= 10, "the point format is known");
  require(info.record_bytes == las_base_record_bytes(info.point_format) + info.extra_stride,
          "records are their fields and the extra bytes");
  require(info.point_data_offset <= info.point_data_end && info.point_data_end <= bytes,
          "the points lie in the file");
  std::size_t held = 0;
  for (const LasVlr& vlr : info.vlrs) held += vlr.data.size();
  require(held <= bytes, "records are no larger than the file");
  for (const ExtraByte& field : info.extra_bytes) {
    require(field.size > 0 && field.offset + field.size <= info.extra_stride,
            "extra bytes lie in the record");
  }
  require(info.scale.x > 0 && info.scale.y > 0 && info.scale.z > 0, "scales are positive");
}

void check_plan(const LasInfo& info, const ChunkPlan& plan, std::size_t bytes) {
  std::uint64_t points = 0;
  std::uint64_t end = info.point_data_offset;
  for (const PointChunk& chunk : plan.chunks) {
    require(chunk.offset >= end && chunk.bytes <= bytes && chunk.offset <= bytes - chunk.bytes,
            "chunks lie in the file, one behind the other");
    require(chunk.points > 0 && chunk.first == points, "points follow each other");
    points += chunk.points;
    end = chunk.offset + chunk.bytes;
  }
  require(points <= info.point_count, "no more points than announced");
  require(points == info.point_count || !plan.problem.empty(), "missing points are a problem");
}

}  // namespace

bool parse_hostile_bytes(std::span<const std::uint8_t> bytes) {
  lax_intervals_in(bytes, {0.0, 0.0, 100.0, 100.0}, 1000);
  MemorySource source(bytes);
  try {
    const LasInfo info = parse_las(source, "fuzz");
    check_info(info, bytes.size());
    ChunkPlan plan = plan_chunks(source, info);
    check_plan(info, plan, bytes.size());
    const std::size_t before = plan.chunks.size();
    const bool used = keep_copc_chunks_in(source, info, {0.0, 0.0, 100.0, 100.0}, plan);
    require(plan.chunks.size() <= before && (used || plan.chunks.size() == before),
            "a window only drops chunks");
    return true;
  } catch (const InputError& error) {
    require(std::string(error.what()).find('\n') == std::string::npos, "errors have one line");
    return false;
  }
}

}  // namespace cornice::test
