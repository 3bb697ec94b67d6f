// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/stitch/shared.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "core/mesh/select.h"

namespace cornice::stitch {
namespace {

/// Mean of an attribute over the places of a class. `values_of` gives a tile's column, or nullptr.
template <class Value, class Sum, class ValuesOf>
std::vector<Sum> mean_by_class(const Borders& borders, const Plan& plan, ValuesOf values_of) {
  std::vector<Sum> means(plan.class_count());
  for (std::uint32_t c = 0; c < plan.class_count(); ++c) {
    Sum sum{}, tile_sum{};
    double tiles = 0.0, tile_places = 0.0;
    for (std::uint32_t i = plan.first[c]; i < plan.first[c + 1]; ++i) {
      const Place& p = plan.places[i];
      const std::vector<Value>* values = values_of(borders.tiles[p.tile]);
      if (values == nullptr || values->empty()) continue;
      const std::uint32_t first = borders.first_vertex[p.tile];
      const Value& a = (*values)[p.a - first];
      const Value& b = (*values)[p.b - first];
      if constexpr (std::is_same_v<Value, Vec3f>) {
        tile_sum += a.template cast<double>() * (1.0 - p.t) + b.template cast<double>() * p.t;
      } else {
        // Equal ends first: infinity minus infinity is no number.
        tile_sum += a == b ? static_cast<double>(a)
                           : static_cast<double>(a) * (1.0 - p.t) + static_cast<double>(b) * p.t;
      }
      tile_places += 1.0;
      if (i + 1 < plan.first[c + 1] && plan.places[i + 1].tile == p.tile) continue;
      sum += tile_sum / tile_places;
      tiles += 1.0;
      tile_sum = {};
      tile_places = 0.0;
    }
    if (tiles > 0.0) means[c] = sum / tiles;
  }
  return means;
}

/// Codes have no mean: what is known worst of a vertex holds for all tiles.
constexpr const char* kCode = "source";

std::vector<std::uint8_t> largest_by_class(const Borders& borders, const Plan& plan,
                                           const char* name) {
  std::vector<std::uint8_t> largest(plan.class_count(), 0);
  for (std::uint32_t c = 0; c < plan.class_count(); ++c) {
    for (std::uint32_t i = plan.first[c]; i < plan.first[c + 1]; ++i) {
      const Place& p = plan.places[i];
      const std::vector<std::uint8_t>* values =
          find_byte_property(borders.tiles[p.tile].vertices, name);
      if (values == nullptr || values->empty()) continue;
      const std::uint32_t first = borders.first_vertex[p.tile];
      if (p.t < 1.0) largest[c] = std::max(largest[c], (*values)[p.a - first]);
      if (p.t > 0.0) largest[c] = std::max(largest[c], (*values)[p.b - first]);
    }
  }
  return largest;
}

std::set<std::string> float_names(const Borders& borders) {
  std::set<std::string> names;
  for (const Border& tile : borders.tiles) {
    for (const FloatProperty& p : tile.vertices.float_properties) names.insert(p.name);
  }
  return names;
}
std::set<std::string> byte_names(const Borders& borders) {
  std::set<std::string> names;
  for (const Border& tile : borders.tiles) {
    for (const ByteProperty& p : tile.vertices.byte_properties) names.insert(p.name);
  }
  return names;
}

}  // namespace

SharedAttributes share_attributes(const Borders& borders, const Plan& plan) {
  SharedAttributes shared;
  for (const Vec3d n : mean_by_class<Vec3f, Vec3d>(
           borders, plan, [](const Border& tile) { return &tile.vertices.normals; })) {
    shared.normals.push_back(normalized(n).cast<float>());
  }
  for (const std::string& name : float_names(borders)) {
    const std::vector<double> means = mean_by_class<float, double>(
        borders, plan,
        [&](const Border& tile) { return find_float_property(tile.vertices, name.c_str()); });
    shared.floats.push_back({name, std::vector<float>(means.begin(), means.end())});
  }
  for (const std::string& name : byte_names(borders)) {
    if (name == kCode) {
      shared.bytes.push_back({name, largest_by_class(borders, plan, kCode)});
      continue;
    }
    shared.bytes.push_back({name, {}});
    for (const double mean : mean_by_class<std::uint8_t, double>(
             borders, plan,
             [&](const Border& tile) { return find_byte_property(tile.vertices, name.c_str()); })) {
      shared.bytes.back().values.push_back(static_cast<std::uint8_t>(std::lround(mean)));
    }
  }
  return shared;
}

}  // namespace cornice::stitch
