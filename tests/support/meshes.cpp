// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/meshes.h"

#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "core/mesh/topology.h"

namespace cornice::test {

Mesh grid_mesh(int columns, int rows, const std::function<Vec3d(int column, int row)>& surface) {
  Mesh mesh;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      mesh.positions.push_back(surface(column, row).cast<float>());
    }
  }
  for (int row = 0; row + 1 < rows; ++row) {
    for (int column = 0; column + 1 < columns; ++column) {
      const auto a = static_cast<std::uint32_t>(row * columns + column);
      const auto up = static_cast<std::uint32_t>(columns);
      mesh.triangles.push_back({a, a + 1, a + up + 1});
      mesh.triangles.push_back({a, a + up + 1, a + up});
    }
  }
  return mesh;
}

Mesh height_mesh(double x, double y, int cells, double step,
                 const std::function<double(double x, double y)>& height) {
  return grid_mesh(cells + 1, cells + 1, [&](int column, int row) {
    const double px = x + step * column, py = y + step * row;
    return Vec3d{px, py, height(px, py)};
  });
}

Mesh sphere_mesh(double radius, int rounds) {
  const double g = std::numbers::phi;
  std::vector<Vec3d> corners{{-1, g, 0}, {1, g, 0}, {-1, -g, 0}, {1, -g, 0},
                             {0, -1, g}, {0, 1, g}, {0, -1, -g}, {0, 1, -g},
                             {g, 0, -1}, {g, 0, 1}, {-g, 0, -1}, {-g, 0, 1}};
  std::vector<std::array<std::uint32_t, 3>> triangles{
      {0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
      {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
      {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int round = 0; round < rounds; ++round) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [at, fresh] =
          middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(corners.size()));
      if (fresh) corners.push_back(corners[a] + corners[b]);
      return at->second;
    };
    std::vector<std::array<std::uint32_t, 3>> finer;
    for (const auto& t : triangles) {
      const std::uint32_t ab = middle(t[0], t[1]), bc = middle(t[1], t[2]), ca = middle(t[2], t[0]);
      finer.push_back({t[0], ab, ca});
      finer.push_back({t[1], bc, ab});
      finer.push_back({t[2], ca, bc});
      finer.push_back({ab, bc, ca});
    }
    triangles = std::move(finer);
    for (Vec3d& c : corners) c = normalized(c);
  }
  Mesh mesh;
  mesh.triangles = std::move(triangles);
  for (const Vec3d& c : corners) mesh.positions.push_back((normalized(c) * radius).cast<float>());
  return mesh;
}

Mesh overhang_mesh(double length, double width, double depth, double step) {
  // Along the profile x runs forward, back by `depth` in the middle third, and forward again while
  // it climbs: an S lying on its side.
  const int columns = static_cast<int>((length + 4.0 * depth) / step) + 1;
  const int rows = static_cast<int>(width / step) + 1;
  return grid_mesh(columns, rows, [&](int column, int row) {
    const double s = static_cast<double>(column) / (columns - 1);
    const double wave = std::sin(2.0 * std::numbers::pi * s);
    const double x = length * s + 0.5 * (length / std::numbers::pi + depth) * wave;
    const double z = 3.0 * depth / (1.0 + std::exp(-20.0 * (s - 0.5)));
    return Vec3d{x, step * row, z};
  });
}

std::set<std::array<float, 6>> border_edges(const Mesh& mesh) {
  std::set<std::array<float, 6>> edges;
  const auto twins = match_half_edges(mesh.triangles, mesh.positions.size(), 1);
  for (std::uint32_t h = 0; h < twins.size(); ++h) {
    if (twins[h] != kOpenEdge) continue;
    const Vec3f a = mesh.positions[mesh.triangles[h / 3][h % 3]];
    const Vec3f b = mesh.positions[mesh.triangles[h / 3][(h % 3 + 1) % 3]];
    edges.insert({a.x, a.y, a.z, b.x, b.y, b.z});
  }
  return edges;
}

}  // namespace cornice::test
