// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/property/poisson_extract/fields.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/base/random.h"

namespace cornice::test {
namespace {

void append_brick(FieldLevel& level, BrickKey brick, int l, const Function& function) {
  const double scale = std::ldexp(1.0, l);
  level.bricks.push_back(brick);
  for (int k = 0; k < kBrickSide; ++k) {
    for (int j = 0; j < kBrickSide; ++j) {
      for (int i = 0; i < kBrickSide; ++i) {
        level.values.push_back(function(scale * (kBrickSide * brick.x + i),
                                        scale * (kBrickSide * brick.y + j),
                                        scale * (kBrickSide * brick.z + k)));
      }
    }
  }
}

}  // namespace

Field sampled_adaptively(const Function& function, const BrickBox& box, int levels,
                         const std::function<bool(int level, BrickKey brick)>& keep,
                         double step_m) {
  std::vector<FieldLevel> made(static_cast<std::size_t>(levels));
  for (int l = 0; l < levels; ++l) {
    // One brick more at the far sides, so that the coarsest level is closed on the whole box.
    const int more = l == levels - 1 ? 1 : 0;
    for (int x = box.first.x >> l; x <= (box.last.x >> l) + more; ++x) {
      for (int y = box.first.y >> l; y <= (box.last.y >> l) + more; ++y) {
        for (int z = box.first.z >> l; z <= (box.last.z >> l) + more; ++z) {
          if (l < levels - 1 && !keep(l, {x, y, z})) continue;
          append_brick(made[static_cast<std::size_t>(l)], {x, y, z}, l, function);
        }
      }
    }
  }
  return Field({step_m}, std::move(made));
}

Field sampled(const Function& function, const BrickBox& box, double step_m) {
  return sampled_adaptively(
      function, box, 1, [](int, BrickKey) { return true; }, step_m);
}

Function white_noise(std::uint64_t seed) {
  return [seed](double x, double y, double z) {
    const auto item = static_cast<std::uint64_t>((std::llround(x) & 0x1fffff) << 42 |
                                                 (std::llround(y) & 0x1fffff) << 21 |
                                                 (std::llround(z) & 0x1fffff));
    return static_cast<float>(CounterRandom(seed, 7, item).uniform(-1, 1));
  };
}

Function smooth_noise(std::uint64_t seed, double wavelength, int waves) {
  struct Wave {
    Vec3d k;
    double phase, amplitude;
  };
  std::vector<Wave> all;
  for (int w = 0; w < waves; ++w) {
    CounterRandom random(seed, 11, static_cast<std::uint64_t>(w));
    const Vec3d direction = normalized(Vec3d{random.normal(), random.normal(), random.normal()});
    const double length = wavelength * random.uniform(0.7, 2.0);
    all.push_back({direction * (2 * std::numbers::pi / length), random.uniform(0, 6.3),
                   random.uniform(0.5, 1.0)});
  }
  return [all](double x, double y, double z) {
    double sum = 0.0;
    for (const Wave& w : all) sum += w.amplitude * std::sin(dot(w.k, Vec3d{x, y, z}) + w.phase);
    return static_cast<float>(sum);
  };
}

ExtractOptions window_options(LatticeBox window, int threads, double weld) {
  ExtractOptions options;
  options.window = window;
  options.threads = threads;
  options.weld = weld;
  return options;
}

void expect_sound(const Surface& surface, const Lattice& lattice, const LatticeBox& window) {
  const Mesh& mesh = surface.mesh;
  ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
  const TopologyReport topology = check_topology(mesh.triangles, mesh.positions.size(), 2);
  EXPECT_EQ(topology.non_manifold_edges, 0u);
  EXPECT_EQ(topology.non_manifold_vertices, 0u);
  EXPECT_EQ(topology.degenerate_triangles, 0u);
  EXPECT_EQ(topology.isolated_vertices, 0u);
  const double unit = lattice.step_m / kUnitsPerStep;
  std::size_t off_lattice = 0, not_unit = 0, outside = 0;
  const double width = (window.x1 - window.x0) * lattice.step_m;
  const double depth = (window.y1 - window.y0) * lattice.step_m;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const Vec3d p = mesh.positions[v].cast<double>();
    for (const double c : {p.x, p.y, p.z}) off_lattice += std::round(c / unit) * unit != c;
    outside += p.x < 0 || p.x > width || p.y < 0 || p.y > depth;
    not_unit += !(std::abs(norm(mesh.normals[v]) - 1.0f) < 1e-5f);
  }
  EXPECT_EQ(off_lattice, 0u);
  EXPECT_EQ(outside, 0u);
  EXPECT_EQ(not_unit, 0u);
  const auto twins = match_half_edges(mesh.triangles, mesh.positions.size(), 2);
  std::size_t open_inside = 0;
  for (std::uint32_t h = 0; h < twins.size(); ++h) {
    if (twins[h] != kOpenEdge) continue;
    const Vec3f a = mesh.positions[mesh.triangles[h / 3][h % 3]];
    const Vec3f b = mesh.positions[mesh.triangles[h / 3][(h + 1) % 3]];
    const auto both_at = [](float u, float v, double plane) { return u == plane && v == plane; };
    open_inside += !(both_at(a.x, b.x, 0.0) || both_at(a.x, b.x, width) || both_at(a.y, b.y, 0.0) ||
                     both_at(a.y, b.y, depth));
  }
  EXPECT_EQ(open_inside, 0u);
}

}  // namespace cornice::test
