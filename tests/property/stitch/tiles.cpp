// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/property/stitch/tiles.h"

#include <cmath>
#include <map>
#include <tuple>

#include "core/base/random.h"
#include "core/io/ply.h"
#include "core/mesh/select.h"

namespace cornice::test {
namespace {

double offset(std::uint64_t tile, std::uint64_t vertex, std::uint64_t axis, double amplitude) {
  return amplitude * CounterRandom(tile, axis, vertex).uniform(-1.0, 1.0);
}

/// A position that floats of all tiles hold exactly.
Vec3d on_grid(Vec3d p) {
  constexpr double kGrid = 1.0 / 4096.0;
  return {std::round(p.x / kGrid) * kGrid, std::round(p.y / kGrid) * kGrid,
          std::round(p.z / kGrid) * kGrid};
}

Mesh cut_tile(const CutPlan& plan, int column, int row) {
  Mesh mesh;
  mesh.origin = plan.origin + Vec3d{column * plan.tile_m, row * plan.tile_m, 4.0 * column - row};
  mesh.crs_text = "EPSG:2056+5728";
  const int cells = plan.cells(column, row);
  const auto tile = static_cast<std::uint64_t>(row * plan.columns + column);
  const std::uint64_t stream = 1000 * plan.seed + tile;
  mesh.float_properties.push_back({"support", {}});
  mesh.byte_properties.push_back({"source", {}});
  for (int j = 0; j <= cells; ++j) {
    for (int i = 0; i <= cells; ++i) {
      const double u = (column + static_cast<double>(i) / cells) * plan.tile_m;
      const double v = (row + static_cast<double>(j) / cells) * plan.tile_m;
      Vec3d p = on_grid(plan.surface(u, v));
      const bool ends_u = i == 0 || i == cells, ends_v = j == 0 || j == cells;
      if (plan.only_corners ? ends_u && ends_v : ends_u || ends_v) {
        const auto vertex = static_cast<std::uint64_t>(j * (cells + 1) + i);
        p += Vec3d{offset(stream, vertex, 0, plan.jitter_m),
                   offset(stream, vertex, 1, plan.jitter_m),
                   offset(stream, vertex, 2, plan.jitter_m)};
      }
      mesh.positions.push_back((plan.origin + p - mesh.origin).cast<float>());
      constexpr double kStep = 1e-4;
      mesh.normals.push_back(
          normalized(cross(plan.surface(u + kStep, v) - plan.surface(u - kStep, v),
                           plan.surface(u, v + kStep) - plan.surface(u, v - kStep)))
              .cast<float>());
      mesh.float_properties[0].values.push_back(static_cast<float>(tile) + 1.0f);
      mesh.byte_properties[0].values.push_back(static_cast<std::uint8_t>(2 * (tile % 2)));
    }
  }
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(j * (cells + 1) + i); };
  for (int j = 0; j < cells; ++j) {
    for (int i = 0; i < cells; ++i) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return mesh;
}

}  // namespace

Vec3d hills(double u, double v) {
  return {u, v, 1.5 * std::sin(0.4 * u) * std::cos(0.3 * v) + 0.1 * u};
}

Vec3d rough_hills(double u, double v) {
  return hills(u, v) + Vec3d{0.0, 0.0, 0.25 * std::sin(5.0 * u + v) * std::cos(6.0 * v - u)};
}

Vec3d leaning_wall(double u, double v) {
  // Between 5 and 11 the wall climbs 8 m and comes back 2 m over the ground below.
  const double s = std::clamp((u - 5.0) / 6.0, 0.0, 1.0);
  const double x = u - 8.0 * (s - std::sin(6.283185307179586 * s) / 6.283185307179586);
  return {x, v + 0.3 * std::sin(0.5 * u), 8.0 * s * s * (3.0 - 2.0 * s) + 0.2 * std::sin(0.7 * v)};
}

std::vector<Mesh> cut_tiles(const CutPlan& plan) {
  std::vector<Mesh> tiles;
  for (int row = 0; row < plan.rows; ++row) {
    for (int column = 0; column < plan.columns; ++column) {
      tiles.push_back(cut_tile(plan, column, row));
    }
  }
  return tiles;
}

void punch_hole(std::vector<Mesh>& tiles, Vec3d middle, double radius_m) {
  for (Mesh& tile : tiles) {
    std::vector<std::uint8_t> keep;
    for (const Triangle& t : tile.triangles) {
      Vec3d sum{};
      for (const std::uint32_t v : t) sum += tile.positions[v].cast<double>();
      const Vec3d from = tile.origin + sum / 3.0 - middle;
      keep.push_back(std::hypot(from.x, from.y) > radius_m);
    }
    tile = select_triangles(tile, keep);
  }
}

Welded weld(const std::vector<Mesh>& tiles) {
  Welded welded;
  std::map<std::tuple<double, double, double>, std::uint32_t> known;
  for (const Mesh& tile : tiles) {
    std::vector<std::uint32_t> to;
    for (const Vec3f& local : tile.positions) {
      const Vec3d p = tile.origin + local.cast<double>();
      const auto [place, is_new] = known.emplace(
          std::tuple{p.x, p.y, p.z}, static_cast<std::uint32_t>(welded.positions.size()));
      if (is_new) welded.positions.push_back(p);
      to.push_back(place->second);
    }
    for (const Triangle& t : tile.triangles) {
      welded.triangles.push_back({to[t[0]], to[t[1]], to[t[2]]});
    }
  }
  return welded;
}

std::vector<std::filesystem::path> write_tiles(const std::filesystem::path& folder,
                                               const std::vector<Mesh>& tiles) {
  std::vector<std::filesystem::path> paths;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    paths.push_back(folder / ("t" + std::to_string(i) + ".ply"));
    write_ply(paths.back(), tiles[i]);
  }
  return paths;
}

}  // namespace cornice::test
