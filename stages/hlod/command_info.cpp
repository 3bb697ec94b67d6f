// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/hlod/command_info.h"

#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/cli/stage.h"
#include "hlod/file.h"
#include "stages/hlod/command.h"

namespace cornice::hlod {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct InfoCommand {
  std::string action;
  fs::path file;
  bool json = false;
};

std::vector<std::string> attribute_names(std::uint32_t attributes) {
  std::vector<std::string> names{"normal"};
  if ((attributes & kHasSupport) != 0) names.emplace_back("support");
  if ((attributes & kHasSource) != 0) names.emplace_back("source");
  if ((attributes & kHasColour) != 0) names.emplace_back("colour");
  if ((attributes & kHasTexture) != 0) names.emplace_back("texture");
  return names;
}

const char* partition_name(Partition partition) {
  return partition == Partition::kOctree ? "octree" : "quadtree";
}

Json provenance_json(const std::string& text) {
  const Json json = Json::parse(text, nullptr, false);
  return json.is_discarded() ? Json(text) : json;
}

Json facts(const fs::path& path, const File& file) {
  const Header& h = file.header();
  const Lattice& lattice = h.lattice;
  const Box3d& box = file.bounds();
  Json json = {
      {"file", path.string()},
      {"bytes", file.bytes()},
      {"crs", h.crs_text},
      {"partition", partition_name(h.partition)},
      {"levels", lattice.finest_level + 1},
      {"origin", {lattice.origin.x, lattice.origin.y, lattice.origin.z}},
      {"root_side_m", lattice.root_side},
      {"cell_bits", lattice.cell_bits},
      {"edge_share", h.edge_share},
      {"normal_bits", h.normal_bits},
      {"attributes", attribute_names(h.attributes)},
      {"bounds",
       {{"min", {box.min.x, box.min.y, box.min.z}}, {"max", {box.max.x, box.max.y, box.max.z}}}}};
  std::uint64_t triangles = 0;
  Json rows = Json::array();
  for (std::size_t l = 0; l < file.levels().size(); ++l) {
    const LevelStatistics& s = file.levels()[l];
    const int level = static_cast<int>(l);
    triangles += s.triangles;
    rows.push_back({{"level", level},
                    {"cell_side_m", lattice.cell_side(level)},
                    {"step_m", lattice.step(level)},
                    {"cells", s.cells},
                    {"triangles", s.triangles},
                    {"vertices", s.vertices},
                    {"bytes", s.bytes},
                    {"error_max_m", s.error_max_m},
                    {"error_mean_m", s.error_mean_m}});
  }
  const std::uint64_t finest = file.levels().back().triangles;
  json["parts"] = file.nodes().size();
  json["triangles"] = triangles;
  json["triangles_finest"] = finest;
  json["bytes_per_finest_triangle"] =
      finest == 0 ? Json(nullptr)
                  : Json(static_cast<double>(file.bytes()) / static_cast<double>(finest));
  json["level"] = std::move(rows);
  json["provenance"] = provenance_json(h.provenance);
  return json;
}

std::string line(const char* name, const std::string& value) {
  std::string text = name;
  text.resize(14, ' ');
  return text + value + "\n";
}

template <class... Values>
std::string formatted(const char* format, Values... values) {
  std::vector<char> text(static_cast<std::size_t>(std::snprintf(nullptr, 0, format, values...)) +
                         1);
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
}

std::string words(const Json& list) {
  std::string text;
  for (const auto& entry : list) text += (text.empty() ? "" : ", ") + entry.get<std::string>();
  return text;
}

std::string screen(const Json& f) {
  const auto number = [](const Json& value) { return value.get<double>(); };
  const auto count = [](const Json& value) { return value.get<unsigned long long>(); };
  const Json &low = f["bounds"]["min"], &high = f["bounds"]["max"];
  const std::string crs = f["crs"].get<std::string>();
  std::string text = f["file"].get<std::string>() + "\n";
  text += line("hierarchy", formatted("%s, %llu levels, %llu cell parts",
                                      f["partition"].get<std::string>().c_str(), count(f["levels"]),
                                      count(f["parts"])));
  text += line("crs", crs.empty() ? "none" : crs);
  text += line("from",
               formatted("E %.2f N %.2f H %.2f", number(low[0]), number(low[1]), number(low[2])));
  text += line(
      "to", formatted("E %.2f N %.2f H %.2f", number(high[0]), number(high[1]), number(high[2])));
  text += line("vertices", words(f["attributes"]) + formatted("; normals of %llu bits a component",
                                                              count(f["normal_bits"])));
  text += line("triangles", formatted("%llu, %llu of them at the finest level",
                                      count(f["triangles"]), count(f["triangles_finest"])));
  const Json& share = f["bytes_per_finest_triangle"];
  text += line("bytes",
               formatted("%llu", count(f["bytes"])) +
                   (share.is_null() ? "" : formatted(", %.2f for each of those", number(share))));
  text += "level  cell side m      cells    triangles        bytes  error m: mean      max\n";
  for (const Json& l : f["level"]) {
    text += formatted("%5llu %12.3f %10llu %12llu %12llu %14.4f %8.4f\n", count(l["level"]),
                      number(l["cell_side_m"]), count(l["cells"]), count(l["triangles"]),
                      count(l["bytes"]), number(l["error_mean_m"]), number(l["error_max_m"]));
  }
  return text;
}

void show(const InfoCommand& command, StageContext& context) {
  context.report.add_input(command.file);
  const File file(command.file);
  const Json json = facts(command.file, file);
  context.report.count("cell parts", file.nodes().size());
  const std::string text = command.json ? json.dump(2) + "\n" : screen(json);
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0) {
    throw RunError("standard output", "cannot be written");
  }
}

}  // namespace

int run_info(int argc, char** argv) {
  InfoCommand command;
  Stage stage;
  stage.name = "hlod";
  stage.description = "Says what is in a hierarchy of levels of detail";
  stage.options = {action_option(command.action, "info"),
                   Option("FILE", command.file, "hierarchy, .hlod").positional().required(),
                   Option("json", command.json, "JSON for machines instead of text")};
  stage.examples = {"cornice-hlod info survey.hlod", "cornice-hlod info survey.hlod --json"};
  stage.run = [&](StageContext& context) { show(command, context); };
  return run_stage(argc, argv, std::move(stage));
}

}  // namespace cornice::hlod
