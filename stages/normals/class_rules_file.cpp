// SPDX-License-Identifier: GPL-3.0-or-later
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <set>

#include "core/base/error.h"
#include "stages/normals/class_filter.h"

namespace cornice::normals {
namespace {

[[noreturn]] void fail(const std::filesystem::path& file, const YAML::Node& node,
                       const std::string& problem) {
  const YAML::Mark mark = node.Mark();
  const std::string line = mark.is_null() ? "" : "line " + std::to_string(mark.line + 1) + ": ";
  throw InputError(file.string(), line + problem);
}

void check_keys(const std::filesystem::path& file, const YAML::Node& map, const std::string& where,
                const std::set<std::string>& known) {
  if (!map.IsMap()) fail(file, map, "\"" + where + "\" must be a map of keys and values");
  for (const auto& entry : map) {
    const auto key = entry.first.as<std::string>();
    if (known.count(key) == 0) fail(file, entry.first, "unknown key \"" + key + "\" in " + where);
  }
}

std::bitset<256> read_classes(const std::filesystem::path& file, const YAML::Node& list,
                              const std::string& where) {
  if (!list || !list.IsSequence()) fail(file, list, "\"" + where + "\" must be a list of classes");
  std::bitset<256> classes;
  for (const YAML::Node& entry : list) {
    int code = -1;
    if (!YAML::convert<int>::decode(entry, code) || code < 0 || code > 255) {
      fail(file, entry, "\"" + where + "\" holds something that is no class of 0 to 255");
    }
    classes.set(static_cast<std::size_t>(code));
  }
  return classes;
}

ClassBand read_band(const std::filesystem::path& file, const YAML::Node& node) {
  check_keys(file, node, "normals.classes", {"up-to-m", "keep"});
  ClassBand band;
  if (const YAML::Node limit = node["up-to-m"]) {
    if (!YAML::convert<double>::decode(limit, band.up_to_m) || band.up_to_m != band.up_to_m) {
      fail(file, limit, "\"up-to-m\" must be a height in metres");
    }
  }
  band.keep = read_classes(file, node["keep"], "keep");
  return band;
}

ClassRules read_rules(const std::filesystem::path& file, const YAML::Node& section) {
  check_keys(file, section, "normals", {"noise", "classes"});
  ClassRules rules;
  if (section["noise"]) rules.noise = read_classes(file, section["noise"], "noise");
  const YAML::Node bands = section["classes"];
  if (!bands || !bands.IsSequence() || bands.size() == 0) {
    fail(file, section, "\"normals.classes\" must be a list of bands with \"keep\"");
  }
  for (const YAML::Node& band : bands) rules.bands.push_back(read_band(file, band));
  const auto unordered = [](const ClassBand& a, const ClassBand& b) {
    return !(a.up_to_m < b.up_to_m);
  };
  if (std::adjacent_find(rules.bands.begin(), rules.bands.end(), unordered) != rules.bands.end()) {
    fail(file, bands, "bands must come by rising \"up-to-m\", the last may have none");
  }
  return rules;
}

}  // namespace

ClassRules read_class_rules(const std::filesystem::path& config) {
  try {
    const YAML::Node root = YAML::LoadFile(config.string());
    if (!root.IsMap() || !root["normals"]) {
      throw InputError(config.string(), "has no section \"normals\" with the classes to keep");
    }
    return read_rules(config, root["normals"]);
  } catch (const YAML::BadFile&) {
    throw InputError(config.string(), "cannot be read");
  } catch (const YAML::Exception& error) {
    throw InputError(config.string(), std::string("is no valid YAML: ") + error.what());
  }
}

}  // namespace cornice::normals
