// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/stitch/apply.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/mesh/quality.h"
#include "core/mesh/select.h"

namespace cornice::stitch {
namespace {

constexpr double kThin_deg = 10.0;
constexpr int kMendSweeps = 4;

/// A vertex `share` of the way from a to b, at `at`.
std::uint32_t add_vertex(Mesh& mesh, std::uint32_t a, std::uint32_t b, float share, Vec3f at) {
  const auto v = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.push_back(at);
  if (!mesh.normals.empty()) {
    mesh.normals.push_back(
        normalized(mesh.normals[a] * (1.0f - share) + mesh.normals[b] * share));
  }
  for (FloatProperty& p : mesh.float_properties) {
    p.values.push_back(p.values[a] * (1.0f - share) + p.values[b] * share);
  }
  for (ByteProperty& p : mesh.byte_properties) p.values.push_back(p.values[share < 0.5f ? a : b]);
  return v;
}

void insert_vertices(Mesh& mesh, const TilePlan& plan, std::set<std::uint32_t>& changed) {
  const std::size_t before = mesh.triangles.size();
  for (std::size_t t = 0; t < before; ++t) {
    // A triangle with two such edges is cut by one after the other.
    std::vector<std::size_t> parts{t};
    const Triangle corners = mesh.triangles[t];
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = corners[k], b = corners[(k + 1) % 3];
      const auto found = plan.insert.find({a, b});
      if (found == plan.insert.end()) continue;
      std::size_t part = parts[0];
      for (const std::size_t p : parts) {
        const Triangle& c = mesh.triangles[p];
        for (int i = 0; i < 3; ++i) part = c[i] == a && c[(i + 1) % 3] == b ? p : part;
      }
      const Triangle cut = mesh.triangles[part];
      int at = 0;
      while (cut[at] != a) ++at;
      const std::uint32_t apex = cut[(at + 2) % 3];
      std::uint32_t last = a;
      const float way = norm(mesh.positions[b] - mesh.positions[a]);
      std::size_t slot = part;
      for (const Vec3d& place : found->second) {
        const Vec3f p = (place - mesh.origin).cast<float>();
        const float share =
            way > 0.0f ? std::clamp(norm(p - mesh.positions[a]) / way, 0.0f, 1.0f) : 0.5f;
        const std::uint32_t v = add_vertex(mesh, a, b, share, p);
        changed.insert(v);
        mesh.triangles[slot] = {last, v, apex};
        slot = mesh.triangles.size();
        mesh.triangles.push_back({});
        parts.push_back(slot);
        last = v;
      }
      mesh.triangles[slot] = {last, b, apex};
    }
  }
}

double worst_angle(const Mesh& mesh, const Triangle& t, Vec3d up) {
  const Vec3d a = mesh.positions[t[0]].cast<double>(), b = mesh.positions[t[1]].cast<double>(),
              c = mesh.positions[t[2]].cast<double>();
  const double angle = smallest_angle_deg(a, b, c);
  return dot(cross(b - a, c - a), up) < 0.0 ? -angle : angle;
}

bool has_edge(const Mesh& mesh, const std::vector<std::uint32_t>& twins, std::uint32_t start,
              std::uint32_t other) {
  // Round the fan of start(h), both ways.
  std::uint32_t h = start;
  do {
    const Triangle& t = mesh.triangles[h / 3];
    if (t[(h + 1) % 3] == other || t[(h + 2) % 3] == other) return true;
    h = twins[previous_half_edge(h)];
  } while (h < kNoTwin && h != start);
  for (h = twins[start]; h < kNoTwin; h = twins[next_half_edge(h)]) {
    const std::uint32_t out = next_half_edge(h);
    if (out == start) break;
    const Triangle& t = mesh.triangles[out / 3];
    if (t[(out + 1) % 3] == other || t[(out + 2) % 3] == other) return true;
    h = out;
    if (twins[h] >= kNoTwin) break;
    h = twins[h];
    h = previous_half_edge(h);
  }
  return false;
}

std::uint64_t mend(Mesh& mesh, const std::set<std::uint32_t>& changed, int threads) {
  std::uint64_t turned = 0;
  for (int sweep = 0; sweep < kMendSweeps; ++sweep) {
    const auto twins = match_half_edges(mesh.triangles, mesh.positions.size(), threads);
    std::vector<std::uint8_t> touched(mesh.triangles.size(), 0);
    std::uint64_t now = 0;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      const Triangle c = mesh.triangles[t];
      if (touched[t] != 0) continue;
      if (std::none_of(c.begin(), c.end(), [&](auto v) { return changed.count(v) > 0; })) continue;
      for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
        const std::uint32_t g = twins[h];
        if (g >= kNoTwin || touched[g / 3] != 0) continue;
        const Triangle o = mesh.triangles[g / 3];
        const std::uint32_t a = c[h % 3], b = c[(h + 1) % 3], p = c[(h + 2) % 3],
                            q = o[(g + 2) % 3];
        if (p == q) continue;
        const Vec3d pa = mesh.positions[a].cast<double>(), pb = mesh.positions[b].cast<double>(),
                    pp = mesh.positions[p].cast<double>(), pq = mesh.positions[q].cast<double>();
        const Vec3d up = cross(pb - pq, pp - pa);  // twice the area of the four corners
        const double before = std::min(worst_angle(mesh, c, -up), worst_angle(mesh, o, -up));
        const double with_sign = std::min(worst_angle(mesh, c, up), worst_angle(mesh, o, up));
        const Vec3d side = std::max(before, with_sign) == before ? -up : up;
        const double present = std::max(before, with_sign);
        if (present >= kThin_deg) continue;
        const Triangle one{a, q, p}, two{q, b, p};
        const double after =
            std::min(worst_angle(mesh, one, side), worst_angle(mesh, two, side));
        if (after <= present + 1e-6 || has_edge(mesh, twins, previous_half_edge(h), q)) continue;
        mesh.triangles[t] = one;
        mesh.triangles[g / 3] = two;
        touched[t] = touched[g / 3] = 1;
        for (const std::uint32_t k : {next_half_edge(h), previous_half_edge(h), next_half_edge(g),
                                      previous_half_edge(g)}) {
          if (twins[k] < kNoTwin) touched[twins[k] / 3] = 1;
        }
        ++now;
        break;
      }
    }
    turned += now;
    if (now == 0) break;
  }
  return turned;
}

}  // namespace

ApplyCounts apply_plan(Mesh& mesh, const TilePlan& plan, int threads) {
  ApplyCounts counts;
  if (plan.empty()) return counts;
  std::set<std::uint32_t> changed;
  for (const auto& [v, to] : plan.move) {
    mesh.positions[v] = (to - mesh.origin).cast<float>();
    changed.insert(v);
  }
  std::vector<std::uint32_t> onto(mesh.positions.size());
  for (std::uint32_t v = 0; v < onto.size(); ++v) onto[v] = v;
  for (const auto& [v, to] : plan.collapse) onto[v] = to, changed.insert(to);
  const auto last = [&](std::uint32_t v) {
    while (onto[v] != v) v = onto[v];
    return v;
  };
  for (Triangle& t : mesh.triangles) t = {last(t[0]), last(t[1]), last(t[2])};
  const std::size_t before = mesh.triangles.size();
  std::erase_if(mesh.triangles, [](const Triangle& t) {
    return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
  });
  counts.dropped_triangles = before - mesh.triangles.size();
  insert_vertices(mesh, plan, changed);
  counts.turned_edges = mend(mesh, changed, threads);
  mesh = select_triangles(mesh, std::vector<std::uint8_t>(mesh.triangles.size(), 1));
  return counts;
}

}  // namespace cornice::stitch
