// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/stitch/output.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/io/mesh_export.h"
#include "core/io/output_stream.h"
#include "core/io/ply.h"
#include "core/mesh/select.h"
#include "stages/stitch/merged_ply.h"

namespace cornice::stitch {
namespace {

namespace fs = std::filesystem;

/// One file per tile.
class TileFolder : public Output {
 public:
  TileFolder(fs::path folder, std::string format, Vec3d frame)
      : folder_(std::move(folder)), format_(std::move(format)), frame_(frame) {}

  void add(const fs::path& path, EditedTile& tile) override {
    export_mesh(folder_ / (path.stem().string() + "." + format_), tile.mesh, frame_);
  }

 private:
  fs::path folder_;
  std::string format_;
  Vec3d frame_;
};

class OnePly : public Output {
 public:
  OnePly(const fs::path& path, const Survey& survey, Vec3d origin, double largest_m)
      : ply_(path, origin, survey.crs_text, largest_m, survey.borders.vertex_count()) {}
  void add(const fs::path&, EditedTile& tile) override { ply_.add(tile); }
  void finish() override { ply_.commit(); }

 private:
  MergedPly ply_;
};

/// Vertices of tiles that come one after the other, those that tiles share once.
class SharedRows {
 public:
  explicit SharedRows(std::uint32_t class_count) : class_row_(class_count, kNone) {}

  /// New rows of a tile's vertices; `added` gets those that no tile before it has.
  std::vector<std::uint32_t> number(const EditedTile& tile, std::vector<std::uint32_t>& added) {
    std::vector<std::uint32_t> to(tile.mesh.positions.size());
    auto shared = tile.shared.begin();
    for (std::uint32_t row = 0; row < to.size(); ++row) {
      std::uint32_t fresh = kNone;
      std::uint32_t& known = shared != tile.shared.end() && shared->first == row
                                 ? class_row_[(shared++)->second]
                                 : fresh;
      if (known == kNone) {
        if (count_ == kNone) throw RunError("", "one mesh holds at most 2^32 - 1 vertices");
        known = count_++;
        added.push_back(row);
      }
      to[row] = known;
    }
    return to;
  }

 private:
  std::vector<std::uint32_t> class_row_;
  std::uint32_t count_ = 0;
};

/// One OBJ file: the vertices of a tile, then its triangles, then the next tile.
class OneObj : public Output {
 public:
  OneObj(const fs::path& path, const Survey& survey, Vec3d frame)
      : file_(path), rows_(survey.borders.vertex_count()), frame_(frame) {
    file_.stream() << obj_comments(frame, survey.crs_text);
  }

  void add(const fs::path& path, EditedTile& tile) override {
    const Mesh& mesh = tile.mesh;
    if (mesh.triangles.empty()) return;
    if (is_first_) with_normals_ = !mesh.normals.empty();
    is_first_ = false;
    if (with_normals_ && mesh.normals.empty()) {
      throw InputError(path.string(), "has no normals, but tiles before it have");
    }
    std::vector<std::uint32_t> added;
    const std::vector<std::uint32_t> to = rows_.number(tile, added);
    for (const std::uint32_t row : added) {
      file_.stream() << obj_vector("v", mesh.origin - frame_ + mesh.positions[row].cast<double>());
      if (with_normals_) file_.stream() << obj_vector("vn", mesh.normals[row].cast<double>());
    }
    for (const auto& t : mesh.triangles) {
      file_.stream() << obj_face({to[t[0]] + 1ull, to[t[1]] + 1ull, to[t[2]] + 1ull},
                                 with_normals_);
    }
    file_.check();
  }
  void finish() override { file_.commit(); }

 private:
  OutputStream file_;
  SharedRows rows_;
  Vec3d frame_;
  bool is_first_ = true, with_normals_ = false;
};

/// One GLB file, which has to be put together in memory.
class OneGlb : public Output {
 public:
  OneGlb(fs::path path, const Survey& survey, Vec3d frame)
      : path_(std::move(path)), rows_(survey.borders.vertex_count()) {
    mesh_.origin = frame;
    mesh_.crs_text = survey.crs_text;
  }

  void add(const fs::path& path, EditedTile& tile) override {
    const Mesh& from = tile.mesh;
    if (from.triangles.empty()) return;
    std::vector<std::uint32_t> added;
    const std::vector<std::uint32_t> to = rows_.number(tile, added);
    const Mesh part = gather_vertices(from, added);
    if (mesh_.triangles.empty()) {
      mesh_.float_properties = gather_vertices(from, {}).float_properties;
      mesh_.byte_properties = gather_vertices(from, {}).byte_properties;
    } else if (part.normals.empty() != mesh_.normals.empty()) {
      throw InputError(path.string(), "only some tiles have normals; stitch into .ply");
    }
    for (const Vec3f& p : part.positions) {
      mesh_.positions.push_back((from.origin - mesh_.origin + p.cast<double>()).cast<float>());
    }
    mesh_.normals.insert(mesh_.normals.end(), part.normals.begin(), part.normals.end());
    for (FloatProperty& p : mesh_.float_properties) {
      append(p.values, find_float_property(part, p.name.c_str()));
    }
    for (ByteProperty& p : mesh_.byte_properties) {
      append(p.values, find_byte_property(part, p.name.c_str()));
    }
    for (const auto& t : from.triangles) mesh_.triangles.push_back({to[t[0]], to[t[1]], to[t[2]]});
  }
  void finish() override { export_mesh(path_, mesh_); }

 private:
  /// 0 for vertices without the attribute.
  template <class T>
  void append(std::vector<T>& values, const std::vector<T>* more) {
    if (more != nullptr) values.insert(values.end(), more->begin(), more->end());
    values.resize(mesh_.positions.size());
  }

  fs::path path_;
  Mesh mesh_;
  SharedRows rows_;
};

/// Whole metres in the middle of the survey, at its lowest: the origin of one mesh.
Vec3d survey_origin(const Survey& survey) {
  if (survey.box.empty()) return {};
  const Vec3d middle = (survey.box.min + survey.box.max) * 0.5;
  return {std::round(middle.x), std::round(middle.y), std::floor(survey.box.min.z)};
}

double largest_from(const Survey& survey, Vec3d origin) {
  if (survey.box.empty()) return 0.0;
  const Vec3d low = survey.box.min - origin, high = survey.box.max - origin;
  return std::max({std::abs(low.x), std::abs(low.y), std::abs(low.z), std::abs(high.x),
                   std::abs(high.y), std::abs(high.z)});
}

}  // namespace

std::unique_ptr<Output> open_output(const Command& command, const Survey& survey) {
  const std::string extension = command.mesh_extension();
  const Vec3d origin = survey_origin(survey);
  if (extension.empty()) {
    return std::make_unique<TileFolder>(command.output, command.format, origin);
  }
  if (extension == ".obj") return std::make_unique<OneObj>(command.output, survey, origin);
  if (extension == ".glb") return std::make_unique<OneGlb>(command.output, survey, origin);
  return std::make_unique<OnePly>(command.output, survey, origin, largest_from(survey, origin));
}

std::uint64_t bytes_of_largest(const std::vector<fs::path>& tiles) {
  // The mesh, its edges and the twins of its half-edges.
  constexpr std::uint64_t kBytesPerTriangle = 80;
  std::uint64_t most = 0;
  for (const fs::path& tile : tiles) {
    most = std::max(most, read_ply_info(tile).count("face") * kBytesPerTriangle);
  }
  return most;
}

}  // namespace cornice::stitch
