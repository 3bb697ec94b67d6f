// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/flightlines/options.h"

namespace cornice::flightlines {

std::vector<Option> describe_options(SurveyOptions& o) {
  return {
      Option("crs", o.crs, "replaces the CRS of the files, such as EPSG:2056+5728"),
      Option("keep-readable", o.keep_readable, "takes what a damaged file holds before the damage"),
      Option("overlaps", o.overlaps, "measures the height mismatch of overlapping lines"),
      Option("gap-s", o.split.gap_s, "silence that may end a pass").range(0.1, 60).unit("s"),
      Option("longest-gap-s", o.split.longest_gap_s, "silence that always ends a pass")
          .range(1, 3600)
          .unit("s"),
      Option("speed-ms", o.trajectory.speed_ms, "expected speed over ground, +- 30")
          .range(10, 150)
          .unit("m/s"),
      Option("node-step-s", o.trajectory.fine_node_step_s, "step of the path while it is estimated")
          .range(0.02, 0.25)
          .unit("s")
          .advanced(),
      Option("attitude-walk-deg", o.trajectory.attitude_walk_deg,
             "change of the scanner's axis in one second")
          .range(0.01, 20)
          .unit("degrees")
          .advanced(),
      Option("velocity-walk-ms", o.trajectory.velocity_walk_ms, "change of velocity in one second")
          .range(0.01, 10)
          .unit("m/s")
          .advanced(),
      Option("most-error-share", o.accept.most_error_share,
             "horizontal standard error of an accepted path, over flying height")
          .range(0.001, 0.2)
          .advanced(),
  };
}

}  // namespace cornice::flightlines
