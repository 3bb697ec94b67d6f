// SPDX-License-Identifier: GPL-3.0-or-later
// OpenMesh's own mesh drops faces that make an edge non-manifold; its readers, which hand vertices
// and faces to an importer, do not. They read coordinates as floats and pass over what they cannot
// read: both is made up for by a look at the file before.
#include "core/io/mesh_import.h"

#include <OpenMesh/Core/IO/IOManager.hh>
#include <OpenMesh/Core/IO/importer/BaseImporter.hh>
// Each header holds an instance that registers its reader.
#include <OpenMesh/Core/IO/reader/OBJReader.hh>
#include <OpenMesh/Core/IO/reader/STLReader.hh>
#include <OpenMesh/Core/System/omstream.hh>
#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/io/mesh_text.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;
namespace om = OpenMesh;

/// Takes what a reader finds.
class Importer : public om::IO::BaseImporter {
 public:
  explicit Importer(const fs::path& path) : path_(path) {}

  om::VertexHandle add_vertex(const om::Vec3f& p) override {
    return add({double{p[0]}, double{p[1]}, double{p[2]}});
  }
  om::VertexHandle add_vertex(const om::Vec3d& p) override { return add({p[0], p[1], p[2]}); }
  om::VertexHandle add_vertex() override { return add({}); }
  void set_point(om::VertexHandle v, const om::Vec3f& p) override {
    if (has(v)) positions_[at(v)] = {double{p[0]}, double{p[1]}, double{p[2]}};
  }

  om::FaceHandle add_face(const VHandles& corners) override {
    for (const om::VertexHandle v : corners) {
      if (!has(v)) {
        throw InputError(path_.string(), "face " + std::to_string(faces_ + 1) + " names vertex " +
                                             std::to_string(v.idx() + 1) + ", and there are " +
                                             std::to_string(positions_.size()) +
                                             "; repair the mesh");
      }
    }
    for (std::size_t i = 2; i < corners.size(); ++i) {
      triangles_.push_back({index(corners[0]), index(corners[i - 1]), index(corners[i])});
    }
    return om::FaceHandle(static_cast<int>(faces_++));
  }

  void set_normal(om::VertexHandle v, const om::Vec3f& n) override {
    put(normals_, v, Vec3f{n[0], n[1], n[2]});
  }
  void set_normal(om::VertexHandle v, const om::Vec3d& n) override {
    set_normal(
        v, om::Vec3f(static_cast<float>(n[0]), static_cast<float>(n[1]), static_cast<float>(n[2])));
  }
  void set_color(om::VertexHandle v, const om::Vec3uc& c) override {
    put(colours_, v, std::array<std::uint8_t, 3>{c[0], c[1], c[2]});
  }
  void set_color(om::VertexHandle v, const om::Vec4uc& c) override {
    set_color(v, om::Vec3uc(c[0], c[1], c[2]));
  }
  void set_color(om::VertexHandle v, const om::Vec3f& c) override {
    const auto byte = [](float share) {
      return static_cast<std::uint8_t>(std::clamp(share, 0.0f, 1.0f) * 255.0f + 0.5f);
    };
    set_color(v, om::Vec3uc(byte(c[0]), byte(c[1]), byte(c[2])));
  }
  void set_color(om::VertexHandle v, const om::Vec4f& c) override {
    set_color(v, om::Vec3f(c[0], c[1], c[2]));
  }
  void set_texcoord(om::VertexHandle v, const om::Vec2f& t) override {
    put(textures_, v, std::array<float, 2>{t[0], t[1]});
  }
  void set_texcoord(om::VertexHandle v, const om::Vec3f& t) override {
    set_texcoord(v, om::Vec2f(t[0], t[1]));
  }

  size_t n_vertices() const override { return positions_.size(); }
  size_t n_faces() const override { return faces_; }
  size_t n_edges() const override { return 0; }

  // Half-edges, statuses, faces' colours and texture: of no use here.
  om::HalfedgeHandle add_edge(om::VertexHandle, om::VertexHandle) override {
    return om::HalfedgeHandle();
  }
  om::FaceHandle add_face(om::HalfedgeHandle) override { return om::FaceHandle(); }
  void add_face_texcoords(om::FaceHandle, om::VertexHandle,
                          const std::vector<om::Vec2f>&) override {}
  void add_face_texcoords(om::FaceHandle, om::VertexHandle,
                          const std::vector<om::Vec3f>&) override {}
  void set_face_texindex(om::FaceHandle, int) override {}
  void set_halfedge(om::VertexHandle, om::HalfedgeHandle) override {}
  void set_status(om::VertexHandle, const om::Attributes::StatusInfo&) override {}
  void set_next(om::HalfedgeHandle, om::HalfedgeHandle) override {}
  void set_face(om::HalfedgeHandle, om::FaceHandle) override {}
  void request_face_texcoords2D() override {}
  void set_texcoord(om::HalfedgeHandle, const om::Vec2f&) override {}
  void set_texcoord(om::HalfedgeHandle, const om::Vec3f&) override {}
  void set_status(om::HalfedgeHandle, const om::Attributes::StatusInfo&) override {}
  void set_color(om::EdgeHandle, const om::Vec3uc&) override {}
  void set_color(om::EdgeHandle, const om::Vec4uc&) override {}
  void set_color(om::EdgeHandle, const om::Vec3f&) override {}
  void set_color(om::EdgeHandle, const om::Vec4f&) override {}
  void set_status(om::EdgeHandle, const om::Attributes::StatusInfo&) override {}
  void set_normal(om::FaceHandle, const om::Vec3f&) override {}
  void set_normal(om::FaceHandle, const om::Vec3d&) override {}
  void set_color(om::FaceHandle, const om::Vec3uc&) override {}
  void set_color(om::FaceHandle, const om::Vec4uc&) override {}
  void set_color(om::FaceHandle, const om::Vec3f&) override {}
  void set_color(om::FaceHandle, const om::Vec4f&) override {}
  void set_status(om::FaceHandle, const om::Attributes::StatusInfo&) override {}
  void add_texture_information(int, std::string) override {}

  ImportedMesh take() {
    ImportedMesh result;
    if (is_whole(normals_)) result.mesh.normals = std::move(normals_.values);
    if (is_whole(colours_)) {
      for (std::size_t k = 0; k < 3; ++k) {
        ByteProperty property{std::array{"red", "green", "blue"}[k], {}};
        for (const auto& c : colours_.values) property.values.push_back(c[k]);
        result.mesh.byte_properties.push_back(std::move(property));
      }
    }
    if (is_whole(textures_)) {
      for (std::size_t k = 0; k < 2; ++k) {
        FloatProperty property{std::array{"u", "v"}[k], {}};
        for (const auto& t : textures_.values) property.values.push_back(t[k]);
        result.mesh.float_properties.push_back(std::move(property));
      }
    }
    result.mesh.triangles = std::move(triangles_);
    result.positions = std::move(positions_);
    return result;
  }

 private:
  /// Values of vertices, as far as they came.
  template <class T>
  struct Values {
    std::vector<T> values;
    std::vector<bool> known;
    std::size_t count = 0;
    bool agree = true;  ///< no vertex got two different ones, as at seams of a texture
  };

  template <class T>
  void put(Values<T>& to, om::VertexHandle v, const T& value) {
    if (!has(v)) return;
    to.values.resize(std::max(to.values.size(), positions_.size()));
    to.known.resize(to.values.size());
    if (to.known[at(v)] && !(to.values[at(v)] == value)) to.agree = false;
    to.count += !to.known[at(v)];
    to.known[at(v)] = true;
    to.values[at(v)] = value;
  }
  template <class T>
  bool is_whole(const Values<T>& values) const {
    return values.agree && values.count > 0 && values.count == positions_.size();
  }

  bool has(om::VertexHandle v) const { return v.is_valid() && at(v) < positions_.size(); }
  static std::size_t at(om::VertexHandle v) { return static_cast<std::size_t>(v.idx()); }
  static std::uint32_t index(om::VertexHandle v) { return static_cast<std::uint32_t>(v.idx()); }
  om::VertexHandle add(const Vec3d& p) {
    positions_.push_back(p);
    return om::VertexHandle(static_cast<int>(positions_.size()) - 1);
  }

  fs::path path_;
  std::vector<Vec3d> positions_;
  std::vector<std::array<std::uint32_t, 3>> triangles_;
  Values<Vec3f> normals_;
  Values<std::array<std::uint8_t, 3>> colours_;
  Values<std::array<float, 2>> textures_;
  std::size_t faces_ = 0;
};

}  // namespace

bool can_import_meshes() { return true; }

ImportedMesh import_mesh(const fs::path& path, const std::string& extension) {
  if (extension == ".off") return read_off(path);
  const bool is_obj = extension == ".obj";
  std::vector<Vec3d> exact;
  if (is_obj) {
    exact = scan_obj(path);
  } else {
    check_stl(path);
  }
  omerr().disable();  // what is wrong is said by an exception
  Importer importer(path);
  om::IO::Options options;
  options += om::IO::Options::VertexNormal;
  options += om::IO::Options::VertexColor;
  options += om::IO::Options::VertexTexCoord;
  const bool done = om::IO::IOManager().read(path.string(), importer, options);
  ImportedMesh result = importer.take();
  if (!done || (is_obj && result.positions.size() != exact.size())) {
    throw InputError(path.string(), "cannot be read by OpenMesh, which found " +
                                        std::to_string(result.positions.size()) +
                                        " vertices; save the mesh as .ply");
  }
  if (is_obj) result.positions = std::move(exact);
  return result;
}

}  // namespace cornice
