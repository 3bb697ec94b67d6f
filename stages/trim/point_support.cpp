// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/trim/point_support.h"

#include <algorithm>
#include <cmath>
#include <flann/flann.hpp>
#include <numbers>

#include "core/base/error.h"
#include "core/base/parallel.h"

namespace cornice::trim {
namespace {

constexpr std::size_t kNeighbours = 8;
constexpr std::size_t kGrain = 4096;

using Index = flann::Index<flann::L2_Simple<float>>;

/// Density around one point; 0 where there are too few points to tell.
float density_at(const Index& index, Vec3f p, std::size_t points) {
  const std::size_t k = std::min(kNeighbours + 1, points);
  if (k < 3) return 0.0f;
  std::size_t ids[kNeighbours + 1];
  float distances[kNeighbours + 1];
  flann::Matrix<std::size_t> id_matrix(ids, 1, k);
  flann::Matrix<float> distance_matrix(distances, 1, k);
  index.knnSearch(flann::Matrix<float>(&p.x, 1, 3), id_matrix, distance_matrix, k,
                  flann::SearchParams(-1, 0.0f));
  const double area = std::numbers::pi * static_cast<double>(distances[k - 1]);
  return area > 0.0 ? static_cast<float>(static_cast<double>(k - 1) / area) : 0.0f;
}

std::vector<float>& property(Mesh& mesh, const char* name) {
  std::erase_if(mesh.float_properties, [&](const auto& p) { return p.name == name; });
  mesh.float_properties.push_back({name, std::vector<float>(mesh.positions.size())});
  return mesh.float_properties.back().values;
}

}  // namespace

void add_support(Mesh& mesh, const OrientedPoints& points, int threads) {
  if (points.positions.empty()) throw InputError("", "there are no points to support the mesh");
  if (!points.crs_text.empty() && !mesh.crs_text.empty() && points.crs_text != mesh.crs_text) {
    throw InputError("", "points of " + points.crs_text + " cannot support a mesh of " +
                             mesh.crs_text + "; give points of the same coordinate system");
  }
  // In the mesh's frame, where vertices are floats already.
  std::vector<Vec3f> local(points.positions.size());
  for (std::size_t i = 0; i < local.size(); ++i) {
    local[i] =
        (points.origin - mesh.origin + points.positions[i].cast<double>()).template cast<float>();
  }
  Index index(flann::Matrix<float>(&local[0].x, local.size(), 3),
              flann::KDTreeSingleIndexParams(15));
  index.buildIndex();
  std::vector<float> support(mesh.positions.size()), density(mesh.positions.size());
  parallel_for(mesh.positions.size(), kGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      Vec3f p = mesh.positions[v];
      std::size_t id = 0;
      float distance_sq = 0.0f;
      flann::Matrix<std::size_t> ids(&id, 1, 1);
      flann::Matrix<float> distances(&distance_sq, 1, 1);
      index.knnSearch(flann::Matrix<float>(&p.x, 1, 3), ids, distances, 1,
                      flann::SearchParams(-1, 0.0f));
      support[v] = std::sqrt(distance_sq);
      density[v] = density_at(index, local[id], local.size());
    }
  });
  property(mesh, "support") = std::move(support);
  property(mesh, "density") = std::move(density);
}

}  // namespace cornice::trim
