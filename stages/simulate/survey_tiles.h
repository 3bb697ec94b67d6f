// SPDX-License-Identifier: GPL-3.0-or-later
// Tiles in the making: points come in pieces, in order, and go to disk at once.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/memory.h"
#include "core/base/progress.h"
#include "core/io/las.h"
#include "core/points/point_cloud.h"
#include "stages/simulate/survey_point.h"
#include "stages/simulate/truth.h"

namespace cornice::simulate {

/// Where the truth of the points goes.
enum class PointTruth { kPly, kExtraBytes, kNone };

/// One tile to write.
struct TileTarget {
  std::filesystem::path path;        ///< of the tile, final name
  std::filesystem::path truth_path;  ///< of the PLY; empty unless PointTruth::kPly
  Box2d box;
  Vec3d origin;  ///< positions of the truth are relative to it
  std::string crs_text;
  PointTruth truth = PointTruth::kPly;
  LasWriteOptions las;
  bool is_zipped = false;
  bool is_copc = false;
  bool is_unordered = false;  ///< points in spatial order instead of the order they come in
  std::uint64_t seed = 1;     ///< of that order

  /// COPC and unordered tiles need all their points at once and wait for them in a temporary file.
  bool waits_for_all() const { return is_copc || is_unordered; }
};

/// Consecutive points of one tile, made ready on any thread.
struct TilePart {
  std::size_t tile = 0;
  std::vector<SurveyPoint> points;  ///< filled where the tile waits for all points
  PointCloud cloud;                 ///< else these
  std::vector<char> truth_rows;

  std::size_t size() const { return points.size() + cloud.size(); }
};

/// Appends all that a point's record holds but its position and intensity.
void append_attributes(const SurveyPoint& point, PointCloud& cloud);

/// Thread contract: a function of its arguments.
TilePart make_part(const TileTarget& target, std::size_t tile, std::vector<SurveyPoint> points);

/// Writes one tile and its truth. Files appear under their names when close() returns.
/// Thread contract: write_points() and write_truth() may run at the same time, each on one thread.
class TileWriter {
 public:
  explicit TileWriter(const TileTarget& target);
  ~TileWriter();
  TileWriter(const TileWriter&) = delete;
  TileWriter& operator=(const TileWriter&) = delete;

  void write_points(const TilePart& part);
  void write_truth(const TilePart& part);
  /// Charges what it must hold to `memory`.
  void close(MemoryBudget& memory, Progress& progress);

 private:
  struct Waiting;
  void finish_waiting(MemoryBudget& memory, Progress& progress);
  void zip();

  TileTarget target_;
  std::optional<AtomicFile> unzipped_;
  std::unique_ptr<LasWriter> las_;
  std::unique_ptr<TruthPly> ply_;
  std::unique_ptr<Waiting> waiting_;
};

}  // namespace cornice::simulate
