// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "core/geo/file_crs.h"
#include "core/io/ply.h"
#include "stages/compare/part_cache.h"
#include "stages/compare/source_kinds.h"

namespace cornice::compare {
namespace {

/// Border vertices of neighbouring files that are as near as this are one: rounding of floats
/// relative to two origins.
constexpr float kWeldM = 5e-4f;

bool overlaps(const Box2d& box, Vec3f a, Vec3f b, Vec3f c) {
  const auto [low_x, high_x] = std::minmax({a.x, b.x, c.x});
  const auto [low_y, high_y] = std::minmax({a.y, b.y, c.y});
  return static_cast<double>(high_x) >= box.min_x && static_cast<double>(low_x) <= box.max_x &&
         static_cast<double>(high_y) >= box.min_y && static_cast<double>(low_y) <= box.max_y;
}

class MeshSource : public Source {
 public:
  MeshSource(SourceFacts facts, std::uint64_t cache_bytes, int threads)
      : cache_(cache_bytes), threads_(threads) {
    facts_ = std::move(facts);
    std::uint64_t empty = 0;
    for (const std::filesystem::path& file : facts_.files) {
      const PlyInfo info = read_ply_info(file);
      if (!info.crs_text.empty()) join_crs(facts_, file, crs_of_file(file, info.crs_text));
      paths_.push_back(file);
      parts_.push_back({file.stem().string(), {}});
      const std::shared_ptr<const Surface> surface = part(parts_.size() - 1);
      facts_.vertices += surface->positions.size();
      facts_.triangles += surface->triangles.size();
      if (surface->triangles.empty()) {
        ++empty;
        paths_.pop_back();
        parts_.pop_back();
        continue;
      }
      const Box2d box = plan_box(*surface);
      parts_.back().box = box;
      facts_.box.add(box.min_x, box.min_y);
      facts_.box.add(box.max_x, box.max_y);
    }
    if (parts_.empty()) throw InputError(facts_.title, "is a mesh without triangles");
    if (empty > 0) {
      facts_.warnings.push_back(facts_.title + ": " + std::to_string(empty) +
                                " tiles have no triangles");
    }
  }

  std::shared_ptr<const Surface> part(std::size_t index) override {
    return cache_.get(
        index, [&] { return read(paths_[index]); },
        [](const Surface& surface) { return static_cast<std::uint64_t>(surface.bytes()); });
  }

  Surface region(const Box2d& box, Vec3d origin) override {
    Surface surface;
    surface.origin = origin;
    std::vector<std::uint32_t> piece;
    std::uint32_t pieces = 0;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      if (!parts_[i].box.intersects(box)) continue;
      add(*part(i), box, surface);
      piece.resize(surface.positions.size(), pieces++);
    }
    if (pieces > 1) weld_borders(surface, piece, kWeldM, threads_);
    return surface;
  }

  std::vector<Box2d> coverage(const Box2d& near) const override {
    std::vector<Box2d> boxes;
    for (const Part& part : parts_) {
      if (part.box.intersects(near)) boxes.push_back(part.box);
    }
    return boxes;
  }

 private:
  static Box2d plan_box(const Surface& surface) {
    Box2d box;
    for (const Triangle& t : surface.triangles) {
      for (const std::uint32_t v : t) {
        box.add(surface.origin.x + static_cast<double>(surface.positions[v].x),
                surface.origin.y + static_cast<double>(surface.positions[v].y));
      }
    }
    return box;
  }

  static std::shared_ptr<const Surface> read(const std::filesystem::path& path) {
    Mesh mesh = read_ply_mesh(path);
    auto surface = std::make_shared<Surface>();
    Box3d box;
    for (const Vec3f p : mesh.positions) box.add(mesh.origin + p.cast<double>());
    surface->origin =
        box.empty() ? mesh.origin : frame_of(box.plan(), 0.5 * (box.min.z + box.max.z));
    for (Vec3f& p : mesh.positions)
      p = (mesh.origin + p.cast<double>() - surface->origin).cast<float>();
    surface->positions = std::move(mesh.positions);
    surface->triangles = std::move(mesh.triangles);
    surface->normals = vertex_normals(surface->positions, surface->triangles);
    surface->curvature = vertex_curvature(*surface);
    return surface;
  }

  /// Appends the triangles of `from` that reach into the box, and their vertices.
  static void add(const Surface& from, const Box2d& box, Surface& to) {
    const Vec3d shift = from.origin - to.origin;
    const Box2d local{box.min_x - from.origin.x, box.min_y - from.origin.y,
                      box.max_x - from.origin.x, box.max_y - from.origin.y};
    constexpr std::uint32_t kNone = 0xffffffffu;
    std::vector<std::uint32_t> number(from.positions.size(), kNone);
    for (const Triangle& t : from.triangles) {
      const Vec3f a = from.positions[t[0]], b = from.positions[t[1]], c = from.positions[t[2]];
      if (!overlaps(local, a, b, c)) continue;
      Triangle copy = t;
      for (std::uint32_t& v : copy) {
        if (number[v] == kNone) {
          number[v] = static_cast<std::uint32_t>(to.positions.size());
          to.positions.push_back((from.positions[v].cast<double>() + shift).cast<float>());
        }
        v = number[v];
      }
      to.triangles.push_back(copy);
    }
  }

  std::vector<std::filesystem::path> paths_;
  PartCache<Surface> cache_;
  int threads_;
};

}  // namespace

std::unique_ptr<Source> open_meshes(SourceFacts facts, std::uint64_t cache_bytes, int threads) {
  return std::make_unique<MeshSource>(std::move(facts), cache_bytes, threads);
}

}  // namespace cornice::compare
