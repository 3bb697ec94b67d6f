// SPDX-License-Identifier: GPL-3.0-or-later
// Indexed triangle meshes with float positions relative to a double origin.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/vec.h"

namespace cornice {

/// One named attribute with a float or a byte per element.
struct FloatProperty {
  std::string name;
  std::vector<float> values;
};
struct ByteProperty {
  std::string name;
  std::vector<std::uint8_t> values;
};

/// Triangles over vertices. normals is empty or has one unit normal per vertex; every property has
/// one value per vertex.
struct Mesh {
  Vec3d origin;          ///< projected CRS, metres
  std::string crs_text;  ///< as Crs::text()
  std::vector<Vec3f> positions;
  std::vector<Vec3f> normals;
  std::vector<FloatProperty> float_properties;
  std::vector<ByteProperty> byte_properties;
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counter-clockwise seen from outside
};

/// Points with unit normals: what the normals stage writes and the reconstruction reads.
struct OrientedPoints {
  Vec3d origin;
  std::string crs_text;
  std::vector<Vec3f> positions;
  std::vector<Vec3f> normals;
  std::vector<float> quality;  ///< 0..1; empty or one per point
  std::vector<FloatProperty> float_properties;
  std::vector<ByteProperty> byte_properties;
  std::vector<std::uint16_t> line_id;  ///< empty or one per point
};

}  // namespace cornice
