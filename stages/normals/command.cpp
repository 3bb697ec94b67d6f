// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/normals/command.h"

#include <limits>
#include <nlohmann/json.hpp>

#include "core/cli/stage.h"

namespace cornice::normals {
namespace {

std::vector<Option> describe_points(Command& c) {
  return {
      Option("product", c.product, "class rules; auto goes by the file's name")
          .words({"auto", "swisssurface3d", "lidarhd", "any"}),
      Option("config", c.config, "YAML file whose section \"normals\" has the class rules"),
      Option("classes", c.classes, "classes to keep at any height, instead of the rules")
          .range(0, 255),
      Option("halo-m", c.input.halo_m, "border read from the neighbours").range(0, 500).unit("m"),
      Option("isolated", c.options.isolated.method,
             {{"radius", IsolatedOptions::Method::kRadius},
              {"statistical", IsolatedOptions::Method::kStatistical},
              {"keep", IsolatedOptions::Method::kNone}},
             "how isolated points are told; statistical looks at every point and is slow"),
      Option("isolated-radius-m", c.options.isolated.radius_m, "a point alone in this is isolated")
          .above(0)
          .unit("m")
          .advanced(),
      Option("isolated-neighbours", c.options.isolated.neighbours,
             "other points within the radius that make company")
          .range(1, 1000)
          .advanced(),
      Option("isolated-deviations", c.options.isolated.deviations,
             "standard deviations beyond which statistical calls a point isolated")
          .above(0)
          .advanced(),
      Option("crs", c.input.crs, "coordinate system instead of the files' own, EPSG:2056+5728"),
  };
}

std::vector<Option> describe_normals(Command& c) {
  return {
      Option("k", c.k, "neighbours of the plane fit, the point included").range(4, 256),
      Option("neighbourhood", c.neighbourhoods,
             {{"count", Neighbourhoods::kCount},
              {"radius", Neighbourhoods::kRadius},
              {"density", Neighbourhoods::kDensity}},
             "the k nearest; all within --radius-m; or those within it, k to 4 k of them"),
      Option("radius-m", c.radius_m, "of the neighbourhood").range(0.01, 100).unit("m"),
      Option("beam", c.options.beam,
             {{"trajectory", BeamSource::kTrajectory},
              {"angles", BeamSource::kAngles},
              {"vertical", BeamSource::kVertical}},
             "the best that beams are taken from"),
      Option("tolerance", c.options.tolerance, "mean |n.b| that settles a point by beams alone")
          .range(0, 1)
          .advanced(),
      Option("least-breadth-m", c.options.least_breadth_m,
             "planes narrower than this are fitted to more points; 0: never")
          .range(0, 10)
          .unit("m")
          .advanced(),
  };
}

}  // namespace

std::vector<Option> describe(Command& c) {
  std::vector<Option> all{
      Option("TILE", c.input.tile, "LAS, LAZ or COPC file").positional().required(),
      Option("neighbours", c.input.neighbours, "the tiles around, for the halo"),
      Option("flightlines", c.flight_lines, "what cornice-flightlines wrote, .gpkg or .json")
          .required(),
      output_option(c.output, "oriented points, .ply").ending(".ply"),
      Option("las", c.las, "also the tile's points as LAS or LAZ, normals as extra bytes").output(),
      Option("keep-halo", c.options.keep_halo, "put out the halo's points, too, marked"),
  };
  for (Option& option : describe_points(c)) all.push_back(option.group("Points"));
  for (Option& option : describe_normals(c)) all.push_back(option.group("Normals"));
  return all;
}

NeighbourRule neighbour_rule(const Command& command) {
  const auto k = static_cast<std::uint32_t>(command.k);
  const auto radius = static_cast<float>(command.radius_m);
  switch (command.neighbourhoods) {
    case Neighbourhoods::kRadius:
      return {1, std::numeric_limits<std::uint32_t>::max(), radius};
    case Neighbourhoods::kDensity:
      return {k, 4 * k, radius};
    case Neighbourhoods::kCount:
      break;
  }
  return {k, k, 0.0f};
}

ClassRules class_rules(const Command& command, std::string& name) {
  if (!command.classes.empty()) {
    name = "--classes";
    return rules_for_classes(command.classes);
  }
  if (!command.config.empty()) {
    name = command.config.string();
    return read_class_rules(command.config);
  }
  name = command.product == "auto" ? rules_for_file(command.input.tile) : command.product;
  return built_in_rules(name);
}

namespace {

nlohmann::json by_class(const std::array<std::size_t, 256>& counts) {
  nlohmann::json object = nlohmann::json::object();
  for (std::size_t code = 0; code < counts.size(); ++code)
    if (counts[code] > 0) object[std::to_string(code)] = counts[code];
  return object;
}

/// Why nothing is left, and what to do where the class rules are the reason.
std::string why_nothing_is_left(const FilterCounts& counts, const std::string& rules) {
  if (counts.other_class == 0 || counts.kept > 0)
    return "no oriented points are left; see the counts";
  std::string there, codes;
  for (std::size_t code = 0; code < counts.dropped_by_class.size(); ++code) {
    if (counts.dropped_by_class[code] == 0) continue;
    there += (there.empty() ? "" : ", ") + std::to_string(counts.dropped_by_class[code]) +
             " of class " + std::to_string(code);
  }
  if (counts.dropped_by_class[0] > 0) codes = "0";
  if (counts.dropped_by_class[1] > 0) codes += codes.empty() ? "1" : ",1";
  if (codes.empty()) codes = "A,B";
  return "no points are left: there are " + there + ", and the class rules (" + rules +
         ") keep none of these; take those of the ground by --classes " + codes +
         ", in a configuration by normals: {classes: [{keep: [" + codes + "]}]}";
}

}  // namespace

void report_counts(const Counts& counts, const std::string& rules, Report& report) {
  report.count("points", counts.put_out);
  report.count("read", counts.read);
  report.count("withheld", counts.filter.withheld);
  report.count("synthetic", counts.filter.synthetic);
  report.count("noise", counts.filter.noise);
  report.count("other class", counts.filter.other_class);
  report.quality("kept by class", by_class(counts.filter.kept_by_class));
  report.quality("left out by class", by_class(counts.filter.dropped_by_class));
  report.count("duplicates", counts.duplicates);
  report.count("isolated", counts.isolated);
  for (const BeamSource source :
       {BeamSource::kTrajectory, BeamSource::kAngles, BeamSource::kVertical}) {
    report.count(std::string("beam from ") + beam_source_name(source),
                 counts.beams_by_source[static_cast<std::size_t>(source)]);
  }
  report.count("without flight line", counts.without_line);
  const auto settled = [&](SettledBy by) {
    return counts.settled_by[static_cast<std::size_t>(by)];
  };
  report.count("settled by beams", settled(SettledBy::kBeams));
  report.count("settled by neighbours", settled(SettledBy::kPropagation));
  report.count("unsettled", settled(SettledBy::kNothing));
  report.count("without plane", settled(SettledBy::kNoPlane));
  report.count("halo left out", counts.halo);
  report.count("rounds of propagation", static_cast<std::uint64_t>(counts.rounds));
  if (counts.without_line > 0) {
    report.warn(std::to_string(counts.without_line) +
                " points belong to no flight line; their beams are taken as vertical");
  }
  if (counts.put_out == 0) report.warn(why_nothing_is_left(counts.filter, rules));
}

}  // namespace cornice::normals
