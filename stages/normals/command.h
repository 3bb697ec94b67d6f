// SPDX-License-Identifier: GPL-3.0-or-later
// The options of cornice-normals.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/cli/options.h"
#include "core/cli/report.h"
#include "stages/normals/normals.h"
#include "stages/normals/tile_files.h"

namespace cornice::normals {

/// What the neighbourhood of a point is.
enum class Neighbourhoods {
  kCount,    ///< the k nearest points
  kRadius,   ///< all points within the radius
  kDensity,  ///< those within the radius, at least k and at most 4 k
};

/// Everything the command line says.
struct Command {
  TileInput input;
  std::filesystem::path flight_lines;
  std::filesystem::path output;
  std::filesystem::path las;     ///< empty: none
  std::filesystem::path config;  ///< empty: built-in class rules
  std::string product = "auto";
  std::vector<int> classes;  ///< empty: by product
  Neighbourhoods neighbourhoods = Neighbourhoods::kCount;
  int k = 16;
  double radius_m = 1.0;
  Options options;
};

/// Options of `command`, which must stay where it is.
std::vector<Option> describe(Command& command);

/// The neighbour rule that the options mean.
NeighbourRule neighbour_rule(const Command& command);

/// The class rules that the options mean: --classes, else --config, else by product. `name` says
/// which they are.
ClassRules class_rules(const Command& command, std::string& name);

/// Counts of a run, in the report and in words that leave nothing out. `rules` names the class
/// rules.
void report_counts(const Counts& counts, const std::string& rules, Report& report);

}  // namespace cornice::normals
