// SPDX-License-Identifier: GPL-3.0-or-later
// What is true of a simulated survey, beside its tiles: docs/formats/truth.md.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/io/las.h"
#include "stages/simulate/defects.h"
#include "stages/simulate/survey_block.h"
#include "stages/simulate/survey_point.h"
#include "stages/simulate/trajectory.h"

namespace cornice::simulate {

/// A line with everything that is true of it over the span of its points (of its whole pass where
/// the tiles hold none).
struct LineTruth {
  SurveyLine line;
  LineTally tally;
  double course_deg = 0.0;   ///< azimuth of the way from first to last point
  double heading_deg = 0.0;  ///< mean azimuth of the nose
  double speed_ms = 0.0;
  double height_m = 0.0;  ///< mean, above the survey's mean ground
  bool is_cross_line = false;
  /// Recorded time (going on above 604800 where a GPS week ends) and position, every 0.1 s.
  struct Node {
    double time_s;
    Vec3d position;
  };
  std::vector<Node> nodes;
};

/// lines.size() == tallies.size().
std::vector<LineTruth> line_truths(const Trajectory& trajectory,
                                   const std::vector<SurveyLine>& lines,
                                   const std::vector<LineTally>& tallies,
                                   const DefectOptions& defects, double mean_ground_m);

/// What all the line files say.
struct LinesHeader {
  std::string crs_text;
  std::string scanner;
  double pulse_rate = 0.0;
  double field_of_view_deg = 0.0;
  std::vector<double> tilt_deg;  ///< per channel
};

/// Both in the layout of docs/formats/flight_lines.md, so that the truth can take the place of an
/// estimate, with further fields. Atomic; throw RunError where the disk is full.
void write_lines_json(const std::filesystem::path& path, const std::vector<LineTruth>& lines,
                      const LinesHeader& header);
void write_lines_geopackage(const std::filesystem::path& path, const std::vector<LineTruth>& lines,
                            const LinesHeader& header);

/// Every pose of the flight, turns included. Atomic.
void write_trajectory_csv(const std::filesystem::path& path, const Trajectory& trajectory,
                          const DefectOptions& defects);

/// The truth of the points of one tile as PLY, row by row.
class TruthPly {
 public:
  /// origin: positions are stored relative to it.
  TruthPly(const std::filesystem::path& path, Vec3d origin, const std::string& crs_text);
  /// Appends the row of a point to `rows`. Thread contract: a function of its arguments.
  static void append_row(const SurveyPoint& point, Vec3d origin, std::vector<char>& rows);
  /// Writes rows. Throws RunError where the disk is full.
  void write(const std::vector<char>& rows);
  void close();

 private:
  std::string header() const;
  void check();

  AtomicFile file_;
  Vec3d origin_;
  std::string crs_text_;
  std::uint64_t count_ = 0;
  std::ofstream stream_;
};

/// The same truth as extra bytes of a point record.
std::vector<ExtraByte> truth_extra_bytes();
std::size_t truth_extra_size();
void append_truth_extra_bytes(const SurveyPoint& point, std::vector<std::uint8_t>& bytes);

}  // namespace cornice::simulate
