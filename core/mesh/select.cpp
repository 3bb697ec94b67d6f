// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/mesh/select.h"

#include <cassert>

namespace cornice {
namespace {

template <class T>
std::vector<T> gather(const std::vector<T>& values, const std::vector<std::uint32_t>& rows) {
  std::vector<T> result;
  if (values.empty()) return result;
  result.reserve(rows.size());
  for (const std::uint32_t row : rows) result.push_back(values[row]);
  return result;
}

}  // namespace

Mesh gather_vertices(const Mesh& mesh, const std::vector<std::uint32_t>& rows) {
  Mesh result;
  result.origin = mesh.origin;
  result.crs_text = mesh.crs_text;
  result.positions = gather(mesh.positions, rows);
  result.normals = gather(mesh.normals, rows);
  for (const FloatProperty& p : mesh.float_properties) {
    result.float_properties.push_back({p.name, gather(p.values, rows)});
  }
  for (const ByteProperty& p : mesh.byte_properties) {
    result.byte_properties.push_back({p.name, gather(p.values, rows)});
  }
  return result;
}

Mesh select_triangles(const Mesh& mesh, const std::vector<std::uint8_t>& keep,
                      std::vector<std::uint32_t>* old_vertices) {
  assert(keep.size() == mesh.triangles.size());
  std::vector<std::uint32_t> to(mesh.positions.size(), kOpenEdge);
  std::size_t kept = 0;
  for (std::size_t t = 0; t < keep.size(); ++t) {
    if (keep[t] == 0) continue;
    ++kept;
    for (const std::uint32_t v : mesh.triangles[t]) to[v] = 0;
  }
  std::vector<std::uint32_t> rows;
  for (std::uint32_t v = 0; v < to.size(); ++v) {
    if (to[v] == kOpenEdge) continue;
    to[v] = static_cast<std::uint32_t>(rows.size());
    rows.push_back(v);
  }
  Mesh result = gather_vertices(mesh, rows);
  result.triangles.reserve(kept);
  for (std::size_t t = 0; t < keep.size(); ++t) {
    const Triangle& c = mesh.triangles[t];
    if (keep[t] != 0) result.triangles.push_back({to[c[0]], to[c[1]], to[c[2]]});
  }
  if (old_vertices != nullptr) *old_vertices = std::move(rows);
  return result;
}

double triangle_area(const Mesh& mesh, const Triangle& t) {
  const Vec3d a = mesh.positions[t[0]].cast<double>();
  return 0.5 * norm(cross(mesh.positions[t[1]].cast<double>() - a,
                          mesh.positions[t[2]].cast<double>() - a));
}

const std::vector<float>* find_float_property(const Mesh& mesh, const char* name) {
  for (const FloatProperty& p : mesh.float_properties) {
    if (p.name == name) return &p.values;
  }
  return nullptr;
}

const std::vector<std::uint8_t>* find_byte_property(const Mesh& mesh, const char* name) {
  for (const ByteProperty& p : mesh.byte_properties) {
    if (p.name == name) return &p.values;
  }
  return nullptr;
}

}  // namespace cornice
