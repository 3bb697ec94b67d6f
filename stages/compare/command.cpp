// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/compare/command.h"

#include <charconv>
#include <cmath>

#include "core/base/error.h"
#include "core/cli/stage.h"

namespace cornice::compare {

std::vector<Option> describe(Command& c) {
  Options& o = c.options;
  const std::string what =
      "mesh (.ply), raster of heights (.tif, .asc) or points (.las, .laz, .ply): a file, a folder "
      "of tiles, or a .txt file that lists them";
  return {
      Option("A", c.a, "the first surface, the reference: " + what).positional().required(),
      Option("B", c.b, "the second: differences are positive where it lies above or outside A")
          .positional()
          .required(),
      output_option(c.output, "folder for rasters, meshes, pictures, tables and index.html"),
      Option("spacing", o.spacing_m, "surfaces are sampled once per square of this side")
          .range(0.01, 1000)
          .unit("m"),
      Option("max-distance", o.max_distance_m,
             "counterparts farther than this are none; as much is read around each tile")
          .range(0.1, 1000)
          .unit("m"),
      Option("step", o.step_m,
             "pixel of the vertical difference; 0: the DEM's, else 0.5, of clouds 1")
          .range(0, 1000)
          .unit("m"),
      Option("tolerances", o.tolerances_m, "completeness is given within each of these")
          .range(0.001, 1000)
          .unit("m"),
      Option("classes", o.classes, "of LAS points; all but noise and virtual points without it")
          .range(0, 255),
      Option("colour-range", o.colour_range_m, "end of the colours; 0: by the differences")
          .range(0, 1000)
          .unit("m"),
      Option("profile", c.profiles, "E1,N1,E2,N2: both surfaces along this line; more by fours")
          .unit("m"),
      Option("versions", c.versions,
             "further meshes or rasters, decimated say, measured against B: error by triangles"),
      Option("meshes", c.meshes, "writes no coloured meshes"),
      Option("heading", c.heading_deg, "looked along in the views; -1: towards the overhangs")
          .range(-1, 360)
          .unit("deg"),
      Option("overhang-angle", o.overhang_deg, "overhang: more than this below the horizon")
          .range(0, 89)
          .unit("deg")
          .advanced(),
      Option("min-overhang", o.min_overhang_m2, "smaller overhangs are not listed")
          .range(0, 1e6)
          .unit("m2")
          .advanced(),
      Option("min-layer-gap", o.min_layer_gap_m, "between two layers of one column")
          .range(0, 1000)
          .unit("m")
          .advanced(),
      Option("normal-scale", o.m3c2.normal_scale_m, "M3C2: diameter of the ball of a normal")
          .range(0.01, 1000)
          .unit("m")
          .group("Two clouds"),
      Option("projection-scale", o.m3c2.projection_scale_m, "M3C2: diameter of the cylinder")
          .range(0.01, 1000)
          .unit("m")
          .group("Two clouds"),
      Option("cylinder-depth", o.m3c2.depth_m, "M3C2: how far the cylinder reaches, either way")
          .range(0.01, 1000)
          .unit("m")
          .group("Two clouds"),
      Option("core-spacing", o.m3c2.spacing_m, "M3C2: one core point per cube of this side")
          .range(0.01, 1000)
          .unit("m")
          .group("Two clouds"),
      Option("registration", o.m3c2.registration_m, "M3C2: error of the clouds' alignment")
          .range(0, 100)
          .unit("m")
          .group("Two clouds"),
  };
}

std::vector<ProfileLine> profile_lines(const std::vector<std::string>& numbers) {
  std::vector<double> values;
  for (const std::string& text : numbers) {
    double value = 0.0;
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    if (error != std::errc() || stop != end || !std::isfinite(value)) {
      throw UsageError("--profile", "takes E1,N1,E2,N2 in metres, but one is \"" + text + "\"");
    }
    values.push_back(value);
  }
  if (values.size() % 4 != 0) {
    throw UsageError("--profile", "takes four numbers a line, E1,N1,E2,N2, but there are " +
                                      std::to_string(values.size()));
  }
  std::vector<ProfileLine> lines;
  for (std::size_t i = 0; i < values.size(); i += 4) {
    lines.push_back({values[i], values[i + 1], values[i + 2], values[i + 3]});
    if (!(lines.back().length() > 0.0)) {
      throw UsageError("--profile", "its line has no length");
    }
  }
  return lines;
}

void report_result(const Result& result, Report& report) {
  for (const std::string& warning : result.warnings) report.warn(warning);
  const Summary vertical = result.vertical.all().summary();
  report.count("pixels", vertical.count);
  report.quality("vertical_rms_m", vertical.rms);
  report.quality("vertical_median_m", vertical.median);
  report.quality("vertical_nmad_m", vertical.nmad);
  double seconds = 0.0;
  std::uint64_t measured = 0;
  for (const Direction& d : result.directions) {
    const std::string name = d.from == Side::kA ? "a_to_b" : "b_to_a";
    report.count("distances", d.measured);
    report.quality(name + "_rms_m", d.statistics.all().summary().rms);
    seconds += d.seconds;
    measured += d.measured;
  }
  if (seconds > 0.0) report.quality("distances_per_s", static_cast<double>(measured) / seconds);
  for (const Side side : kSides) {
    const SideResult& s = result.sides[index_of(side)];
    const std::string name = side == Side::kA ? "_a" : "_b";
    report.count("overhangs" + name, s.overhangs.size());
    report.quality("overhang_m2" + name, s.overhang_m2);
  }
  if (result.m3c2) report.quality("m3c2_significant", result.m3c2->significant);
}

}  // namespace cornice::compare
