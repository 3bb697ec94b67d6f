// SPDX-License-Identifier: GPL-3.0-or-later
// Vector layers of points, lines and tables in a GeoPackage, written through GDAL.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "core/base/vec.h"
#include "core/geo/crs.h"

namespace cornice {

using FieldValue = std::variant<std::int64_t, double, std::string>;
struct Field {
  std::string name;
  FieldValue value;
};
using Fields = std::vector<Field>;

enum class GeometryKind { kNone, kPointZ, kPointZM, kLineStringZM, kPolygon };

/// A corner of a geometry; m (GPS time) and z count where the kind has them.
struct GeometryPoint {
  Vec3d position;
  double m = 0.0;
};

/// A GeoPackage in the making: written beside its name, which it gets from finish. The same content
/// gives the same bytes. Layers are written one after the other. Every function throws RunError
/// where GDAL cannot write.
class GeoPackage {
 public:
  GeoPackage(const std::filesystem::path& path, const Crs& crs);
  ~GeoPackage();
  GeoPackage(const GeoPackage&) = delete;
  GeoPackage& operator=(const GeoPackage&) = delete;

  /// Ends the layer before and makes one with the names and types of `sample`.
  void begin_layer(const std::string& name, GeometryKind kind, const Fields& sample);
  /// Adds a feature with one value for each field of the layer. Without points it has no geometry;
  /// a polygon is one ring, closed or not.
  void add(const Fields& fields, const std::vector<GeometryPoint>& points = {});
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cornice
