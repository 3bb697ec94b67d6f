// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/hlod_cells.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>

#include "core/base/random.h"
#include "hlod/octahedral.h"
#include "tests/support/meshes.h"

namespace cornice::test {
namespace {

using namespace hlod;

auto rank(const CellVertex& v) {
  return std::tie(v.position.x, v.position.y, v.position.z, v.normal, v.support, v.source, v.colour,
                  v.texture);
}

/// order[new number] = old number.
std::vector<std::uint16_t> sorted_order(const std::vector<CellVertex>& vertices) {
  std::vector<std::uint16_t> order(vertices.size());
  std::iota(order.begin(), order.end(), std::uint16_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::uint16_t a, std::uint16_t b) {
    return rank(vertices[a]) < rank(vertices[b]);
  });
  return order;
}

std::vector<std::uint16_t> inverse(const std::vector<std::uint16_t>& order) {
  std::vector<std::uint16_t> number(order.size());
  for (std::size_t n = 0; n < order.size(); ++n) number[order[n]] = static_cast<std::uint16_t>(n);
  return number;
}

std::vector<CellVertex> taken(const std::vector<CellVertex>& from,
                              const std::vector<std::uint16_t>& order) {
  std::vector<CellVertex> vertices;
  for (const std::uint16_t old : order) vertices.push_back(from[old]);
  return vertices;
}

void make_up_attributes(CellVertex& v, std::uint32_t attributes, CounterRandom& random) {
  if ((attributes & kHasSupport) != 0)
    v.support = static_cast<std::uint16_t>(random.uniform(0.0, 60.0) * random.uniform(0.0, 30.0));
  if ((attributes & kHasSource) != 0)
    v.source = static_cast<std::uint8_t>(random.uniform(0.0, 3.0));
  for (auto& c : v.colour) {
    if ((attributes & kHasColour) != 0) c = static_cast<std::uint8_t>(random.uniform(90.0, 140.0));
  }
  if ((attributes & kHasTexture) == 0) return;
  v.texture = {static_cast<std::uint16_t>(v.position.x & 0xffff),
               static_cast<std::uint16_t>(v.position.y & 0xffff)};
}

}  // namespace

Header sample_header() {
  Header header;
  header.lattice = {{2'600'000.0, 1'200'000.0, 0.0}, 512.0, 3, 14};
  header.attributes = kHasSupport | kHasSource | kHasColour | kHasTexture;
  header.crs_text = "EPSG:2056+5728";
  header.provenance = R"({"program": "test"})";
  return header;
}

CellMesh sample_cell(const Mesh& mesh, const Header& header, CellKey key, std::uint64_t seed) {
  CellMesh cell;
  cell.key = key;
  const double step = header.lattice.step(key.level);
  const auto rounded = [&](float x) { return static_cast<std::int32_t>(std::lround(x / step)); };
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    CounterRandom random(seed, 1, v);
    const Vec3f p = mesh.positions[v];
    CellVertex vertex;
    vertex.position = {rounded(p.x), rounded(p.y), rounded(p.z)};
    vertex.normal = encode_octahedral(mesh.normals[v], header.normal_bits);
    make_up_attributes(vertex, header.attributes, random);
    cell.vertices.push_back(vertex);
  }
  for (const auto& t : mesh.triangles) {
    cell.triangles.push_back({static_cast<std::uint16_t>(t[0]), static_cast<std::uint16_t>(t[1]),
                              static_cast<std::uint16_t>(t[2])});
  }
  if (key.level == 0) return cell;
  // Every fourth vertex or so stays; the others go to a neighbour that does, or to a point nobody
  // in the cell has.
  std::map<std::uint32_t, std::uint16_t> parent_of_kept;
  const auto is_kept = [&](std::size_t v) { return CounterRandom(seed, 2, v).uniform() < 0.3; };
  std::vector<std::int64_t> target(cell.vertices.size(), -1);
  for (const auto& t : cell.triangles) {
    for (std::size_t c = 0; c < 3; ++c) {
      if (is_kept(t[(c + 1) % 3])) target[t[c]] = t[(c + 1) % 3];
    }
  }
  for (std::size_t v = 0; v < cell.vertices.size(); ++v) {
    const bool stray = target[v] < 0 && !is_kept(v);
    const auto at = static_cast<std::uint32_t>(is_kept(v) || stray ? v : target[v]);
    const auto [entry, is_new] =
        parent_of_kept.emplace(at, static_cast<std::uint16_t>(cell.parents.size()));
    if (is_new) {
      CellVertex parent = cell.vertices[at];
      parent.position = coarsened(parent.position);
      if (stray) parent.position.z += 3;
      cell.parents.push_back(parent);
    }
    cell.parent_of.push_back(entry->second);
  }
  return cell;
}

Mesh bumpy_ground(int columns, int rows, std::uint64_t seed) {
  const auto height = [&](double x, double y) {
    return 40.0 + 6.0 * std::sin(0.11 * x) * std::cos(0.07 * y) + 2.0 * std::sin(0.5 * x + 0.3 * y);
  };
  Mesh mesh = grid_mesh(columns, rows, [&](int c, int r) {
    CounterRandom random(seed, static_cast<std::uint64_t>(r), static_cast<std::uint64_t>(c));
    const double x = c + random.uniform(-0.35, 0.35), y = r + random.uniform(-0.35, 0.35);
    return Vec3d{x, y, height(x, y) + 0.02 * random.normal()};
  });
  for (const Vec3f& p : mesh.positions) {
    const double e = 0.1, dx = (height(p.x + e, p.y) - height(p.x - e, p.y)) / (2.0 * e);
    const double dy = (height(p.x, p.y + e) - height(p.x, p.y - e)) / (2.0 * e);
    mesh.normals.push_back(normalized(Vec3d{-dx, -dy, 1.0}).cast<float>());
  }
  return mesh;
}

CellMesh canonical(const CellMesh& mesh) {
  CellMesh result;
  result.key = mesh.key;
  const auto order = sorted_order(mesh.vertices), parent_order = sorted_order(mesh.parents);
  const auto number = inverse(order), parent_number = inverse(parent_order);
  result.vertices = taken(mesh.vertices, order);
  result.parents = taken(mesh.parents, parent_order);
  for (const std::uint16_t old : order) {
    if (!mesh.parent_of.empty()) {
      result.parent_of.push_back(parent_number[mesh.parent_of[old]]);
    }
  }
  for (const auto& t : mesh.triangles) {
    std::array<std::uint16_t, 3> turned{number[t[0]], number[t[1]], number[t[2]]};
    std::rotate(turned.begin(), std::min_element(turned.begin(), turned.end()), turned.end());
    result.triangles.push_back(turned);
  }
  std::sort(result.triangles.begin(), result.triangles.end());
  return result;
}

bool same_mesh(const CellMesh& a, const CellMesh& b) {
  const CellMesh x = canonical(a), y = canonical(b);
  return x.key == y.key && x.vertices == y.vertices && x.parents == y.parents &&
         x.parent_of == y.parent_of && x.triangles == y.triangles;
}

}  // namespace cornice::test
