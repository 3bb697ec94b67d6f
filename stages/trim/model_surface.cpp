// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/trim/model_surface.h"

#include <cmath>

#include "core/base/parallel.h"

namespace cornice::trim {
namespace {

constexpr std::size_t kGrain = std::size_t{1} << 14;

}  // namespace

std::vector<std::uint8_t> find_model_surface(const Mesh& mesh, const ElevationModel& model,
                                             double tolerance_m, int threads) {
  std::vector<std::uint8_t> on_model(mesh.positions.size(), 0);
  parallel_for(on_model.size(), kGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      if (!mesh.normals.empty() && !(mesh.normals[v].z > 0.0f)) continue;
      const Vec3d at = mesh.origin + mesh.positions[v].cast<double>();
      const auto ground = model.at(at.x, at.y);
      if (!ground) continue;
      on_model[v] = std::abs(at.z - ground->height_m) * ground->normal.z <= tolerance_m;
    }
  });
  return on_model;
}

Box2d plan_box(const Mesh& mesh) {
  Box2d box;
  for (const Vec3f& p : mesh.positions) {
    box.add(mesh.origin.x + static_cast<double>(p.x), mesh.origin.y + static_cast<double>(p.y));
  }
  return box;
}

}  // namespace cornice::trim
