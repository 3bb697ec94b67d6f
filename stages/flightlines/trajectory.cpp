// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/flightlines/trajectory.h"

#include <algorithm>
#include <utility>

#include "stages/flightlines/path_solver.h"

namespace cornice::flightlines {
namespace {

/// First-last lines that make a path without the help of angles.
constexpr std::size_t kPairsSuffice = 200;
/// Pulses of each kind that tell signs and scan models apart: in a line, and in each of its bins.
constexpr std::size_t kSketchPulses = 4000;
constexpr std::size_t kSketchPulsesPerBin = 40;

}  // namespace

const char* scan_model_name(ScanModel model) {
  switch (model) {
    case ScanModel::kPlane:
      return "plane";
    case ScanModel::kCone:
      return "cone";
    case ScanModel::kNone:
      break;
  }
  return "none";
}

PathEstimate solve_path(const LinePass& pass, const TrackFit& start, int sign, ScanModel model,
                        const TrajectoryOptions& options, const PathEstimate* warm) {
  TrajectoryOptions sketch = options;
  sketch.most_pulses = std::min(options.most_pulses,
                                std::max(kSketchPulses, kSketchPulsesPerBin * pass.bins.size()));
  PathSolver solver(pass, start, sign, model, sketch);
  if (!solver.is_solvable()) return {};
  if (warm != nullptr && warm->is_valid) solver.start_from(*warm);
  return solver.run();
}

PathEstimate refine_path(const LinePass& pass, const TrackFit& start, int sign,
                         const PathEstimate& sketch, const TrajectoryOptions& options) {
  TrajectoryOptions fine = options;
  fine.node_step_s = std::min(options.node_step_s, options.fine_node_step_s);
  fine.least_scan_rad = std::min(options.least_scan_rad, options.fine_least_scan_rad);
  PathSolver solver(pass, start, sign, sketch.model, fine);
  if (!solver.is_solvable()) return sketch;
  solver.start_from(sketch);
  return solver.run();
}

PathEstimate estimate_path(const LinePass& pass, const TrackFit& start, int sign,
                           const TrajectoryOptions& options) {
  // Beams of a plane or a cone keep to it within this; attitude between nodes takes most of it.
  constexpr double kScanFitsDeg = 0.3;
  // A scan model that first-last lines contradict is wrong, however well it fits single returns.
  constexpr double kPairsSuffer = 1.3;
  PathEstimate best = solve_path(pass, start, sign, ScanModel::kNone, options);
  if (!best.is_valid) return best;
  const bool paired = best.pairs >= kPairsSuffice;
  const PathEstimate* warm = paired ? &best : nullptr;
  const double most_pair = paired ? kPairsSuffer * best.pair_residual + 0.1 : 1e9;
  double least = kScanFitsDeg;
  PathEstimate chosen;
  for (const ScanModel model : {ScanModel::kPlane, ScanModel::kCone}) {
    PathEstimate path = solve_path(pass, start, sign, model, options, warm);
    if (!path.is_valid || path.scan_residual_deg >= least || path.pair_residual > most_pair)
      continue;
    least = path.scan_residual_deg;
    chosen = std::move(path);
  }
  return chosen.is_valid ? chosen : best;
}

}  // namespace cornice::flightlines
