// SPDX-License-Identifier: GPL-3.0-or-later
// Garland & Heckbert 1997, "Surface simplification using quadric error metrics". There is no heap:
// sweeps over the vertices in memory order collapse what costs less than a bound that rises from
// sweep to sweep, and no vertex goes in the sweep in which its surroundings changed.
#include "hlod/simplify.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <utility>

namespace cornice::hlod {
namespace {

constexpr float kNever = std::numeric_limits<float>::infinity();
/// A vertex with more triangles stays: its ring would not fit the fixed arrays.
constexpr int kMaxRing = 32;
/// Planes through open edges, upright on the surface, count so much more than the surface's own:
/// an outline shows more than a dent of its size.
constexpr float kBorderWeight = 10.0f;
/// Part of a collapsed edge's squared length that counts as squared distance: where the ground is
/// flat, short edges go first and triangles stay in shape. 0.01 rad of tilt weigh as much.
constexpr float kLengthWeight = 1e-4f;
/// Cosine of the largest turn of a triangle's normal, squared.
constexpr float kTurnCosineSq = 0.06f;
/// Part of the remaining vertices that one sweep may take.
constexpr double kSweepShare = 0.3;

}  // namespace

void VertexFans::assign(std::size_t vertex_count, const std::vector<Triangle>& triangles) {
  count_.assign(vertex_count, 0);
  for (const Triangle& t : triangles) {
    for (const std::uint32_t v : t) ++count_[v];
  }
  capacity_ = count_;
  first_.resize(vertex_count);
  std::uint32_t place = 0;
  for (std::size_t v = 0; v < vertex_count; ++v) {
    first_[v] = place;
    place += count_[v];
    count_[v] = 0;
  }
  pool_.resize(place);
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    for (const std::uint32_t v : triangles[t]) pool_[first_[v] + count_[v]++] = t;
  }
}

void VertexFans::remove(std::uint32_t vertex, std::uint32_t triangle) {
  std::uint32_t* const begin = pool_.data() + first_[vertex];
  std::uint32_t* const end = begin + count_[vertex];
  std::uint32_t* const found = std::find(begin, end, triangle);
  assert(found != end && "a triangle is in the fans of its vertices");
  *found = end[-1];
  --count_[vertex];
}

void VertexFans::add(std::uint32_t vertex, std::span<const std::uint32_t> triangles) {
  const auto more = static_cast<std::uint32_t>(triangles.size());
  if (count_[vertex] + more > capacity_[vertex]) {
    const auto moved = static_cast<std::uint32_t>(pool_.size());
    capacity_[vertex] = count_[vertex] + more + 2;
    pool_.resize(pool_.size() + capacity_[vertex]);
    std::copy_n(pool_.data() + first_[vertex], count_[vertex], pool_.data() + moved);
    first_[vertex] = moved;
  }
  std::copy_n(triangles.data(), more, pool_.data() + first_[vertex] + count_[vertex]);
  count_[vertex] += more;
}

/// The triangles round a vertex u: triangle i is (u, next[i], prev[i]). Coordinates are relative to
/// u, one array each, so that the loops over them are done several at a time.
struct Simplifier::Ring {
  int size = 0;
  std::array<std::uint32_t, kMaxRing> triangle, next, prev;
  alignas(64) std::array<float, kMaxRing> nx, ny, nz, px, py, pz;
  std::array<float, kMaxRing> cost;
};

void Simplifier::run(SimplifyMesh& mesh, const SimplifyOptions& options) {
  mesh_ = &mesh;
  options_ = options;
  prepare();
  for (std::uint32_t u = 0; u < mesh.positions.size(); ++u) evaluate(u, false);
  int idle = 0;
  while (live_ > options_.target_triangles && idle < 2) {
    const float bound = threshold();
    if (bound == kNever) break;
    idle = sweep(bound) == 0 ? idle + 1 : 0;
  }
  for (std::uint32_t u = 0; u < parents_.size(); ++u) {
    std::uint32_t top = u;
    while (parents_[top] != top) top = parents_[top];
    for (std::uint32_t v = u; v != top;) v = std::exchange(parents_[v], top);
  }
}

void Simplifier::prepare() {
  const std::size_t count = mesh_->positions.size();
  live_ = mesh_->triangles.size();
  sweep_ = epoch_ = 0;
  fans_.assign(count, mesh_->triangles);
  quadrics_.assign(count, {});
  kinds_.resize(count);
  dirty_.assign(count, 0);
  costs_.assign(count, kNever);
  reached_.assign(count, 0);
  targets_.assign(count, kNone);
  touched_.assign(count, 0);
  marks_.assign(count, 0);
  parents_.resize(count);
  for (std::uint32_t v = 0; v < count; ++v) parents_[v] = v;
  add_plane_quadrics();
  areas_.resize(count);
  for (std::size_t v = 0; v < count; ++v) areas_[v] = quadrics_[v].area;
  classify();
}

void Simplifier::add_plane_quadrics() {
  const std::vector<Vec3f>& p = mesh_->positions;
  for (const Triangle& t : mesh_->triangles) {
    const Vec3f n = cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]);
    const float length = norm(n);
    if (length == 0) continue;
    const float w = 0.5f / length;
    const Vec3f m = w * n;
    for (const std::uint32_t v : t) {
      Quadric& q = quadrics_[v];
      q.xx += m.x * n.x, q.yy += m.y * n.y, q.zz += m.z * n.z;
      q.xy += m.x * n.y, q.xz += m.x * n.z, q.yz += m.y * n.z;
      q.area += 0.5f * length;
    }
  }
}

/// Follows the fan from triangle to triangle: one closed cycle is inside, one open chain is border.
void Simplifier::classify() {
  Ring ring;
  for (std::uint32_t u = 0; u < kinds_.size(); ++u) {
    kinds_[u] = Kind::kFixed;
    if (mesh_->locked[u] != 0 || fans_.of(u).size() > kMaxRing || fans_.of(u).empty()) continue;
    gather(u, ring);
    const auto begin = ring.next.begin(), end = begin + ring.size;
    int open = -1, opens = 0;
    for (int i = 0; i < ring.size; ++i) {
      // Of a chain, the first triangle's next vertex is no triangle's previous one.
      const auto found = std::find(ring.prev.begin(), ring.prev.begin() + ring.size, ring.next[i]);
      if (found == ring.prev.begin() + ring.size) open = i, ++opens;
    }
    if (opens > 1) continue;
    int steps = 1;
    const int start = opens == 1 ? open : 0;
    for (int at = start; steps <= ring.size; ++steps) {
      const auto following = std::find(begin, end, ring.prev[at]);
      if (following == end || following - begin == start) break;
      at = static_cast<int>(following - begin);
    }
    if (steps != ring.size || (opens == 0 && ring.size < 3)) continue;
    kinds_[u] = opens == 1 ? Kind::kBorder : Kind::kInside;
  }
  add_border_quadrics();
}

void Simplifier::add_border_quadrics() {
  const std::vector<Vec3f>& p = mesh_->positions;
  Ring ring;
  for (std::uint32_t u = 0; u < kinds_.size(); ++u) {
    if (kinds_[u] != Kind::kBorder) continue;
    gather(u, ring);
    for (int i = 0; i < ring.size; ++i) {
      const auto add = [&](std::uint32_t v) {
        const Vec3f edge = p[v] - p[u];
        const Vec3f n = cross(edge, cross(p[ring.next[i]] - p[u], p[ring.prev[i]] - p[u]));
        const float square = dot(n, n);
        if (square == 0) return;
        const float w = kBorderWeight * dot(edge, edge) / square;
        Quadric& q = quadrics_[u];
        q.xx += w * n.x * n.x, q.yy += w * n.y * n.y, q.zz += w * n.z * n.z;
        q.xy += w * n.x * n.y, q.xz += w * n.x * n.z, q.yz += w * n.y * n.z;
      };
      const auto ends = ring.size;
      if (std::find(ring.prev.begin(), ring.prev.begin() + ends, ring.next[i]) ==
          ring.prev.begin() + ends) {
        add(ring.next[i]);
      }
      if (std::find(ring.next.begin(), ring.next.begin() + ends, ring.prev[i]) ==
          ring.next.begin() + ends) {
        add(ring.prev[i]);
      }
    }
  }
}

void Simplifier::gather(std::uint32_t u, Ring& ring) const {
  const std::span<const std::uint32_t> fan = fans_.of(u);
  ring.size = static_cast<int>(fan.size());
  for (int i = 0; i < ring.size; ++i) {
    const Triangle& t = mesh_->triangles[fan[i]];
    const int corner = t[0] == u ? 0 : (t[1] == u ? 1 : 2);
    ring.triangle[i] = fan[i];
    ring.next[i] = t[corner == 2 ? 0 : corner + 1];
    ring.prev[i] = t[corner == 0 ? 2 : corner - 1];
  }
}

void Simplifier::locate(std::uint32_t u, Ring& ring) const {
  const Vec3f at = mesh_->positions[u];
  for (int i = 0; i < ring.size; ++i) {
    const Vec3f n = mesh_->positions[ring.next[i]] - at, p = mesh_->positions[ring.prev[i]] - at;
    ring.nx[i] = n.x, ring.ny[i] = n.y, ring.nz[i] = n.z;
    ring.px[i] = p.x, ring.py[i] = p.y, ring.pz[i] = p.z;
  }
}

/// Cost of becoming each next vertex of the ring.
void Simplifier::price(std::uint32_t u, Ring& ring) const {
  const Quadric& q = quadrics_[u];
  const float length_weight = kLengthWeight * q.area;
  for (int i = 0; i < ring.size; ++i) {
    const float x = ring.nx[i], y = ring.ny[i], z = ring.nz[i];
    const float ax = q.xx * x + q.xy * y + q.xz * z;
    const float ay = q.xy * x + q.yy * y + q.yz * z;
    const float az = q.xz * x + q.yz * y + q.zz * z;
    const float plane = x * ax + y * ay + z * az + 2 * (q.bx * x + q.by * y + q.bz * z) + q.c;
    ring.cost[i] = std::max(plane, 0.0f) + length_weight * (x * x + y * y + z * z);
  }
  if (mesh_->further.empty()) return;
  for (int i = 0; i < ring.size; ++i) {
    float square = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const float d = mesh_->further[ring.next[i]][k] - mesh_->further[u][k];
      square += d * d;
    }
    ring.cost[i] += q.area * square;
  }
}

/// Whether a triangle of the ring would turn over, or lose its area, with u at the ring's target-th
/// next vertex.
bool Simplifier::folds(int target, const Ring& ring) const {
  const float tx = ring.nx[target], ty = ring.ny[target], tz = ring.nz[target];
  const std::uint32_t name = ring.next[target];
  int bad = 0;
  for (int i = 0; i < ring.size; ++i) {
    const float nx = ring.nx[i], ny = ring.ny[i], nz = ring.nz[i];
    const float px = ring.px[i], py = ring.py[i], pz = ring.pz[i];
    const float ox = ny * pz - nz * py, oy = nz * px - nx * pz, oz = nx * py - ny * px;
    const float ax = nx - tx, ay = ny - ty, az = nz - tz;
    const float bx = px - tx, by = py - ty, bz = pz - tz;
    const float mx = ay * bz - az * by, my = az * bx - ax * bz, mz = ax * by - ay * bx;
    const float along = ox * mx + oy * my + oz * mz;
    const float old_square = ox * ox + oy * oy + oz * oz;
    const float squares = old_square * (mx * mx + my * my + mz * mz);
    const int gone = (ring.next[i] == name) | (ring.prev[i] == name);
    const int turned =
        (old_square > 0) & (!(along > 0) | !(along * along > kTurnCosineSq * squares));
    const int down = options_.in_plan & (oz > 0) & !(mz > 0);
    bad |= (1 - gone) & (turned | down);
  }
  return bad != 0;
}

void Simplifier::evaluate(std::uint32_t u, bool check_link) {
  dirty_[u] = 0;
  costs_[u] = kNever;
  if (kinds_[u] == Kind::kFixed || fans_.of(u).size() > kMaxRing || fans_.of(u).empty()) return;
  Ring ring;
  gather(u, ring);
  locate(u, ring);
  if (kinds_[u] == Kind::kBorder) {
    // A border vertex may only move along the border. The one end of the chain is a next vertex
    // anyway, the other is made one: a triangle without area that folds() passes over.
    int first = -1, last = -1;
    const auto ends = ring.size;
    for (int i = 0; i < ends; ++i) {
      const auto next = ring.next.begin(), prev = ring.prev.begin();
      if (std::find(prev, prev + ends, ring.next[i]) == prev + ends) first = i;
      if (std::find(next, next + ends, ring.prev[i]) == next + ends) last = i;
    }
    if (first < 0 || last < 0 || ends + 1 > kMaxRing) return;
    ring.next[ends] = ring.prev[ends] = ring.prev[last];
    ring.nx[ends] = ring.px[ends] = ring.px[last];
    ring.ny[ends] = ring.py[ends] = ring.py[last];
    ring.nz[ends] = ring.pz[ends] = ring.pz[last];
    ring.size = ends + 1;
    price(u, ring);
    for (int i = 0; i < ends; ++i) ring.cost[i] = i == first ? ring.cost[i] : kNever;
  } else {
    price(u, ring);
  }
  const float error_bound = options_.max_error * options_.max_error * quadrics_[u].area;
  const float reach = options_.reach - reached_[u];
  for (int tries = 0; tries < ring.size; ++tries) {
    const int best = static_cast<int>(
        std::min_element(ring.cost.begin(), ring.cost.begin() + ring.size) - ring.cost.begin());
    if (!(ring.cost[best] <= error_bound) || ring.cost[best] == kNever) return;
    const float plan = std::max(std::abs(ring.nx[best]), std::abs(ring.ny[best]));
    const float far = options_.in_plan ? plan : std::max(plan, std::abs(ring.nz[best]));
    if (far <= reach && !folds(best, ring) && (!check_link || allowed(u, ring.next[best], ring))) {
      costs_[u] = ring.cost[best];
      targets_[u] = ring.next[best];
      return;
    }
    ring.cost[best] = kNever;
  }
}

/// Whether u may become `target` as far as the neighbours' connections go: the two may share no
/// neighbours but those of the triangles that go, and no triangle may come to be there twice. An
/// edge that is new between two locked vertices may be there already in the next block.
bool Simplifier::allowed(std::uint32_t u, std::uint32_t target, const Ring& ring) {
  ++epoch_;
  std::array<std::uint32_t, 2> opposite{kNone, kNone};
  std::size_t shared = 0;
  for (int i = 0; i < ring.size; ++i) {
    marks_[ring.next[i]] = marks_[ring.prev[i]] = epoch_;
    if (ring.next[i] == ring.prev[i]) continue;
    if (ring.next[i] != target && ring.prev[i] != target) continue;
    if (shared == 2) return false;
    opposite[shared++] = ring.next[i] == target ? ring.prev[i] : ring.next[i];
  }
  // Nobody may be left without a triangle: the last of a part of the surface stay.
  for (std::size_t k = 0; k < shared; ++k) {
    if (fans_.of(opposite[k]).size() < 2) return false;
  }
  if (fans_.of(target).size() == shared && fans_.of(u).size() == shared) return false;
  marks_[target] = 0;
  const auto may_meet = [&](std::uint32_t v) {
    return marks_[v] != epoch_ || v == opposite[0] || v == opposite[1];
  };
  for (const std::uint32_t t : fans_.of(target)) {
    const Triangle& triangle = mesh_->triangles[t];
    int in_ring = 0;
    bool has_u = false;
    for (const std::uint32_t v : triangle) {
      if (v == u) has_u = true;
      if (v == u || v == target) continue;
      if (!may_meet(v)) return false;
      in_ring += marks_[v] == epoch_;
    }
    if (!has_u && in_ring == 2) return false;
  }
  if (mesh_->locked[target] == 0) return true;
  for (int i = 0; i < ring.size; ++i) {
    for (const std::uint32_t v : {ring.next[i], ring.prev[i]}) {
      if (v != target && mesh_->locked[v] != 0 && v != opposite[0] && v != opposite[1]) {
        return false;
      }
    }
  }
  return true;
}

bool Simplifier::collapse(std::uint32_t u) {
  Ring ring;
  gather(u, ring);
  if (!allowed(u, targets_[u], ring)) {
    evaluate(u, true);
    return false;
  }
  const std::uint32_t target = targets_[u];
  std::array<std::uint32_t, kMaxRing> kept;
  std::size_t kept_count = 0;
  for (int i = 0; i < ring.size; ++i) {
    Triangle& t = mesh_->triangles[ring.triangle[i]];
    for (const std::uint32_t v : {ring.next[i], ring.prev[i]}) {
      touched_[v] = sweep_;
      dirty_[v] = 1;
      // What could not go before may be able to now.
      if (costs_[v] == kNever && kinds_[v] != Kind::kFixed) costs_[v] = 0;
    }
    if (ring.next[i] == target || ring.prev[i] == target) {
      fans_.remove(target, ring.triangle[i]);
      fans_.remove(ring.next[i] == target ? ring.prev[i] : ring.next[i], ring.triangle[i]);
      t = {kNone, kNone, kNone};
      --live_;
    } else {
      std::replace(t.begin(), t.end(), u, target);
      kept[kept_count++] = ring.triangle[i];
    }
  }
  fans_.add(target, {kept.data(), kept_count});
  const Vec3f d = mesh_->positions[target] - mesh_->positions[u];
  const float plan = std::max(std::abs(d.x), std::abs(d.y));
  const float far = options_.in_plan ? plan : std::max(plan, std::abs(d.z));
  reached_[target] = std::max(reached_[target], reached_[u] + far);
  const Quadric& from = quadrics_[u];
  Quadric& to = quadrics_[target];
  const Vec3f a{from.xx * d.x + from.xy * d.y + from.xz * d.z,
                from.xy * d.x + from.yy * d.y + from.yz * d.z,
                from.xz * d.x + from.yz * d.y + from.zz * d.z};
  to.c += dot(d, a) + 2 * (from.bx * d.x + from.by * d.y + from.bz * d.z) + from.c;
  to.bx += a.x + from.bx, to.by += a.y + from.by, to.bz += a.z + from.bz;
  to.xx += from.xx, to.yy += from.yy, to.zz += from.zz;
  to.xy += from.xy, to.xz += from.xz, to.yz += from.yz;
  to.area += from.area;
  parents_[u] = target;
  costs_[u] = kNever;
  targets_[u] = kNone;
  return true;
}

/// Cost that as many vertices are below as the next sweep should take, to an eighth of a power of
/// two; kNever where nothing is left.
float Simplifier::threshold() {
  std::array<std::uint32_t, 2048> counts{};
  std::size_t candidates = 0;
  for (const float cost : costs_) {
    if (cost == kNever) continue;
    ++counts[std::bit_cast<std::uint32_t>(cost) >> 20];
    ++candidates;
  }
  if (candidates == 0) return kNever;
  const std::size_t wanted = (live_ - options_.target_triangles + 1) / 2;
  const auto share = static_cast<std::size_t>(kSweepShare * static_cast<double>(candidates)) + 1;
  std::size_t sum = 0;
  for (std::uint32_t bin = 0; bin < counts.size(); ++bin) {
    sum += counts[bin];
    if (sum >= std::min(wanted, share)) {
      return std::nextafter(std::bit_cast<float>((bin + 1) << 20), 0.0f);
    }
  }
  return kNever;
}

/// Collapses what costs no more than the bound, in order of memory. Returns how many.
std::size_t Simplifier::sweep(float bound) {
  ++sweep_;
  std::size_t collapsed = 0;
  for (std::uint32_t u = 0; u < costs_.size() && live_ > options_.target_triangles; ++u) {
    if (!(costs_[u] <= bound) || touched_[u] == sweep_) continue;
    if (dirty_[u] != 0) {
      evaluate(u, false);
      if (!(costs_[u] <= bound)) continue;
    }
    collapsed += collapse(u);
  }
  return collapsed;
}

}  // namespace cornice::hlod
