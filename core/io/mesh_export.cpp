// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/io/mesh_export.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#define TINYGLTF_NO_INCLUDE_JSON
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_IMPLEMENTATION
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <tiny_gltf.h>
#pragma GCC diagnostic pop

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/write_problem.h"
#include "core/io/ply.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path) {
  throw RunError(path.string(), "cannot be written: " + write_problem(errno));
}

void write_obj(const fs::path& path, const Mesh& mesh, Vec3d frame) {
  AtomicFile file(path);
  errno = 0;
  std::ofstream out(file.path(), std::ios::binary);
  out << obj_comments(frame, mesh.crs_text);
  for (const Vec3f& p : mesh.positions)
    out << obj_vector("v", mesh.origin - frame + p.cast<double>());
  for (const Vec3f& n : mesh.normals) out << obj_vector("vn", n.cast<double>());
  for (const auto& t : mesh.triangles) {
    out << obj_face({t[0] + 1ull, t[1] + 1ull, t[2] + 1ull}, !mesh.normals.empty());
  }
  out.close();
  if (!out) fail(path);
  file.commit();
}

/// Appends raw values as a buffer view; returns its number.
template <class T>
int add_view(tinygltf::Model& model, const std::vector<T>& values, int target) {
  std::vector<unsigned char>& data = model.buffers[0].data;
  tinygltf::BufferView view;
  view.buffer = 0;
  view.byteOffset = data.size();
  view.byteLength = values.size() * sizeof(T);
  view.target = target;
  data.resize(data.size() + view.byteLength);
  if (view.byteLength > 0) {
    std::memcpy(data.data() + view.byteOffset, values.data(), view.byteLength);
  }
  model.bufferViews.push_back(view);
  return static_cast<int>(model.bufferViews.size()) - 1;
}

int add_accessor(tinygltf::Model& model, int view, std::size_t count, int component, int type) {
  tinygltf::Accessor accessor;
  accessor.bufferView = view;
  accessor.count = count;
  accessor.componentType = component;
  accessor.type = type;
  model.accessors.push_back(accessor);
  return static_cast<int>(model.accessors.size()) - 1;
}

/// glTF is y up: east, up, south.
std::vector<Vec3f> y_up(const std::vector<Vec3f>& vectors) {
  std::vector<Vec3f> turned;
  turned.reserve(vectors.size());
  for (const Vec3f& v : vectors) turned.push_back({v.x, v.z, -v.y});
  return turned;
}

tinygltf::Value numbers(Vec3d v) {
  return tinygltf::Value(
      tinygltf::Value::Array{tinygltf::Value(v.x), tinygltf::Value(v.y), tinygltf::Value(v.z)});
}

/// "_SUPPORT" for "support": names of a program's own attributes start with a low line.
std::string attribute_name(const std::string& property) {
  std::string name = "_";
  for (const char c : property) {
    name += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  }
  return name;
}

void add_attributes(tinygltf::Model& model, const Mesh& mesh, tinygltf::Primitive& primitive) {
  const auto add = [&](const std::string& name, const std::vector<float>& values) {
    primitive.attributes[attribute_name(name)] =
        add_accessor(model, add_view(model, values, TINYGLTF_TARGET_ARRAY_BUFFER), values.size(),
                     TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_SCALAR);
  };
  for (const FloatProperty& p : mesh.float_properties) add(p.name, p.values);
  // Bytes would have to start at multiples of four.
  for (const ByteProperty& p : mesh.byte_properties) {
    add(p.name, std::vector<float>(p.values.begin(), p.values.end()));
  }
}

tinygltf::Node mesh_node(const Mesh& mesh, Vec3d frame) {
  tinygltf::Node node;
  node.mesh = 0;
  const Vec3d shift = mesh.origin - frame;
  node.translation = {shift.x, shift.z, -shift.y};
  tinygltf::Value::Object extras;
  extras["origin"] = numbers(mesh.origin);
  extras["frame"] = numbers(frame);
  extras["crs"] = tinygltf::Value(mesh.crs_text);
  node.extras = tinygltf::Value(extras);
  return node;
}

tinygltf::Model to_gltf(const Mesh& mesh, Vec3d frame) {
  tinygltf::Model model;
  model.asset.version = "2.0";
  model.asset.generator = "cornice";
  tinygltf::Scene scene;
  if (!mesh.triangles.empty()) {
    model.buffers.emplace_back();
    const std::vector<Vec3f> positions = y_up(mesh.positions);
    tinygltf::Primitive primitive;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    const int points =
        add_accessor(model, add_view(model, positions, TINYGLTF_TARGET_ARRAY_BUFFER),
                     positions.size(), TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3);
    std::array<double, 3> low, high;
    low.fill(std::numeric_limits<double>::infinity());
    high.fill(-std::numeric_limits<double>::infinity());
    for (const Vec3f& p : positions) {
      const double at[3] = {p.x, p.y, p.z};
      for (std::size_t k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], at[k]), high[k] = std::max(high[k], at[k]);
      }
    }
    tinygltf::Accessor& bounds = model.accessors[static_cast<std::size_t>(points)];
    bounds.minValues.assign(low.begin(), low.end());
    bounds.maxValues.assign(high.begin(), high.end());
    primitive.attributes["POSITION"] = points;
    if (!mesh.normals.empty()) {
      primitive.attributes["NORMAL"] =
          add_accessor(model, add_view(model, y_up(mesh.normals), TINYGLTF_TARGET_ARRAY_BUFFER),
                       mesh.normals.size(), TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3);
    }
    add_attributes(model, mesh, primitive);
    primitive.indices = add_accessor(
        model, add_view(model, mesh.triangles, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER),
        3 * mesh.triangles.size(), TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TYPE_SCALAR);
    tinygltf::Mesh shape;
    shape.primitives.push_back(primitive);
    model.meshes.push_back(shape);
    model.nodes.push_back(mesh_node(mesh, frame));
    scene.nodes.push_back(0);
  }
  model.scenes.push_back(scene);
  model.defaultScene = 0;
  return model;
}

void write_glb(const fs::path& path, const Mesh& mesh, Vec3d frame) {
  // Lengths in the file have 32 bits.
  const std::uint64_t vertex_bytes =
      (mesh.normals.empty() ? 12 : 24) +
      4 * (mesh.float_properties.size() + mesh.byte_properties.size());
  const std::uint64_t bytes =
      mesh.positions.size() * vertex_bytes + mesh.triangles.size() * 12 + 65536;
  if (bytes > std::numeric_limits<std::uint32_t>::max()) {
    throw RunError(path.string(),
                   "would exceed the 4 GiB that a .glb may have; write .ply or .obj");
  }
  AtomicFile file(path);
  std::ofstream out(file.path(), std::ios::binary);
  const tinygltf::Model model = to_gltf(mesh, frame);
  tinygltf::TinyGLTF writer;
  errno = 0;
  if (!writer.WriteGltfSceneToStream(&model, out, false, true)) fail(path);
  out.close();
  if (!out) fail(path);
  file.commit();
}

}  // namespace

std::string obj_comments(Vec3d frame, const std::string& crs_text) {
  std::array<char, 160> line{};
  std::snprintf(line.data(), line.size(), "# cornice origin %.17g %.17g %.17g\n", frame.x, frame.y,
                frame.z);
  std::string crs = crs_text;
  std::replace(crs.begin(), crs.end(), '\n', ' ');
  return std::string(line.data()) + (crs.empty() ? "" : "# cornice crs " + crs + "\n");
}

std::string obj_vector(const char* word, Vec3d v) {
  std::array<char, 160> line{};
  std::snprintf(line.data(), line.size(), "%s %.4f %.4f %.4f\n", word, v.x, v.y, v.z);
  return line.data();
}

std::string obj_face(const std::array<std::uint64_t, 3>& corners, bool with_normals) {
  std::string line = "f";
  for (const std::uint64_t corner : corners) {
    const std::string number = std::to_string(corner);
    line += " " + number;
    if (with_normals) line += "//" + number;
  }
  return line + "\n";
}

bool is_mesh_extension(const fs::path& path) {
  const std::string ext = path.extension().string();
  return ext == ".ply" || ext == ".obj" || ext == ".glb";
}

void export_mesh(const fs::path& path, const Mesh& mesh, Vec3d frame) {
  const std::string ext = path.extension().string();
  if (ext == ".ply") return write_ply(path, mesh);
  if (ext == ".obj") return write_obj(path, mesh, frame);
  if (ext == ".glb") return write_glb(path, mesh, frame);
  throw UsageError("--output", "'" + path.string() + "' is no mesh file; use .ply, .obj or .glb");
}

void export_mesh(const fs::path& path, const Mesh& mesh) { export_mesh(path, mesh, mesh.origin); }

}  // namespace cornice
