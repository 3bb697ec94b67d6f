// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>

#include "core/io/las.h"
#include "stages/info/examine.h"
#include "stages/info/point_statistics.h"

namespace cornice::info {
namespace {

constexpr std::size_t kChunkPoints = 100'000;

/// True where every side of two boxes agrees to within a step of the stored integers.
bool agree(const Box3d& a, const Box3d& b, Vec3d step) {
  const auto near = [](double p, double q, double tolerance) {
    return std::abs(p - q) <= 1.01 * tolerance;
  };
  return near(a.min.x, b.min.x, step.x) && near(a.max.x, b.max.x, step.x) &&
         near(a.min.y, b.min.y, step.y) && near(a.max.y, b.max.y, step.y) &&
         near(a.min.z, b.min.z, step.z) && near(a.max.z, b.max.z, step.z);
}

}  // namespace

PointFacts examine_points(const std::filesystem::path& path, const ExamineOptions& options,
                          Progress& progress) {
  PointFacts facts;
  LasOpenOptions open;
  open.crs_override = options.crs_text;
  open.require_readable_crs = false;
  facts.header = read_las_info(path, open);
  PointStatistics statistics(facts.header);
  LasReadOptions read;
  read.attributes = kExamined;
  read.threads = options.threads;
  read.keep_readable_part = true;
  const LasReadResult result = stream_las(
      facts.header, read, kChunkPoints,
      [&](PointCloud& chunk, std::uint64_t) { statistics.add(chunk); }, progress);
  facts.readable = result.points_decoded;
  facts.problem = result.problem;
  facts.bounds = result.decoded_bounds;
  facts.bounds_agree =
      facts.bounds.empty() || agree(facts.bounds, facts.header.bounds, facts.header.scale);
  statistics.finish(facts);
  return facts;
}

}  // namespace cornice::info
