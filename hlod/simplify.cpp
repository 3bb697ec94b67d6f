// SPDX-License-Identifier: GPL-3.0-or-later
// Garland & Heckbert 1997, "Surface simplification using quadric error metrics". There is no heap:
// sweeps over the vertices in memory order collapse what costs less than a bound that rises from
// sweep to sweep, and no vertex goes in the sweep in which its surroundings changed.
#include "hlod/simplify.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <utility>

namespace cornice::hlod {
namespace {

constexpr float kNever = std::numeric_limits<float>::infinity();
/// Numbers of one vector register that every machine has.
constexpr int kLanes = 4;
using Floats [[gnu::vector_size(16)]] = float;
using Words [[gnu::vector_size(16)]] = std::int32_t;

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
/// What a guessed cost is multiplied with: low guesses are evaluated early, at a cost in time.
constexpr float kGuessShare = 0.12f;
/// Part of the remaining vertices that one sweep may take.
constexpr double kSweepShare = 0.6;
/// Every so many vertices stand for all where costs are counted.
constexpr std::size_t kCostStride = 4;
/// Corners after and before a triangle's corner.
constexpr std::array<std::uint32_t, 3> kNext{1, 2, 0}, kPrevious{2, 0, 1};

}  // namespace

void VertexFans::assign(std::size_t vertex_count, const std::vector<Triangle>& triangles) {
  fans_.assign(vertex_count, {});
  for (const Triangle& t : triangles) {
    for (const std::uint32_t v : t) ++fans_[v].capacity;
  }
  std::uint32_t place = 0;
  for (Fan& fan : fans_) {
    fan.first = place;
    place += fan.capacity;
  }
  pool_.resize(place);
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    for (const std::uint32_t v : triangles[t]) {
      Fan& fan = fans_[v];
      pool_[fan.first + fan.count++] = t;
    }
  }
}

void VertexFans::remove(std::uint32_t vertex, std::uint32_t triangle) {
  Fan& fan = fans_[vertex];
  std::uint32_t* const begin = pool_.data() + fan.first;
  // To the end whatever is found: which of the few it is cannot be foretold.
  std::uint32_t place = 0;
  for (std::uint32_t i = 0; i < fan.count; ++i) place = begin[i] == triangle ? i : place;
  assert(begin[place] == triangle && "a triangle is in the fans of its vertices");
  begin[place] = begin[--fan.count];
}

void VertexFans::add(std::uint32_t vertex, std::span<const std::uint32_t> triangles) {
  Fan& fan = fans_[vertex];
  const auto more = static_cast<std::uint32_t>(triangles.size());
  if (fan.count + more > fan.capacity) {
    const auto moved = static_cast<std::uint32_t>(pool_.size());
    fan.capacity = fan.count + more + 2;
    pool_.resize(pool_.size() + fan.capacity);
    std::copy_n(pool_.data() + fan.first, fan.count, pool_.data() + moved);
    fan.first = moved;
  }
  std::copy_n(triangles.data(), more, pool_.data() + fan.first + fan.count);
  fan.count += more;
}

/// The triangles round a vertex u: triangle i is (u, next[i], prev[i]), u its corner[i]. Vectors
/// are filled up with the last triangle again.
struct Simplifier::Ring {
  int size = 0, vectors = 0;
  std::array<std::uint32_t, kMaxRing> triangle, corner, next, prev;
  /// Coordinates relative to u.
  std::array<Floats, kMaxRing / kLanes> nx, ny, nz, px, py, pz, cost;

  /// A next vertex that is no previous one: where an open chain of triangles begins; or -1.
  int first() const {
    for (int i = 0; i < size; ++i) {
      if (std::find(prev.begin(), prev.begin() + size, next[i]) == prev.begin() + size) return i;
    }
    return -1;
  }
  /// A previous vertex that is no next one: where an open chain ends; or -1.
  int last() const {
    for (int i = 0; i < size; ++i) {
      if (std::find(next.begin(), next.begin() + size, prev[i]) == next.begin() + size) return i;
    }
    return -1;
  }
  float& cost_at(int i) { return reinterpret_cast<float*>(cost.data())[i]; }
  Vec3f next_at(int i) const {
    const std::size_t v = i / kLanes, lane = i % kLanes;
    return {nx[v][lane], ny[v][lane], nz[v][lane]};
  }
};

void Simplifier::run(SimplifyMesh& mesh, const SimplifyOptions& options) {
  mesh_ = &mesh;
  options_ = options;
  prepare();
  for (std::uint32_t u = 0; u < mesh.positions.size(); ++u) guess(u);
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
    if (mesh_->locked[u] != 0 || fans_.of(u).size() >= kMaxRing || fans_.of(u).empty()) continue;
    gather(u, ring);
    const int first = ring.first();
    const int start = std::max(first, 0);
    int steps = 1;
    std::uint32_t at = ring.prev[start], passed = 1u << start;
    for (; steps < ring.size; ++steps) {
      int following = -1;
      for (int i = 0; i < ring.size; ++i) following = ring.next[i] == at ? i : following;
      if (following < 0 || (passed >> following & 1) != 0) break;
      passed |= 1u << following;
      at = ring.prev[following];
    }
    const bool closed = at == ring.next[start];
    if (steps != ring.size || closed != (first < 0) || (closed && ring.size < 3)) continue;
    // A chain may also end at its own middle.
    if (!closed && ring.last() < 0) continue;
    kinds_[u] = closed ? Kind::kInside : Kind::kBorder;
  }
  add_border_quadrics();
}

void Simplifier::add_border_quadrics() {
  const std::vector<Vec3f>& p = mesh_->positions;
  Ring ring;
  for (std::uint32_t u = 0; u < kinds_.size(); ++u) {
    if (kinds_[u] != Kind::kBorder) continue;
    gather(u, ring);
    const int first = ring.first(), last = ring.last();
    const auto add = [&](int triangle, std::uint32_t end) {
      const Vec3f edge = p[end] - p[u];
      const Vec3f n =
          cross(edge, cross(p[ring.next[triangle]] - p[u], p[ring.prev[triangle]] - p[u]));
      const float square = dot(n, n);
      if (square == 0) return;
      const float w = kBorderWeight * dot(edge, edge) / square;
      Quadric& q = quadrics_[u];
      q.xx += w * n.x * n.x, q.yy += w * n.y * n.y, q.zz += w * n.z * n.z;
      q.xy += w * n.x * n.y, q.xz += w * n.x * n.z, q.yz += w * n.y * n.z;
    };
    add(first, ring.next[first]);
    add(last, ring.prev[last]);
  }
}

void Simplifier::gather(std::uint32_t u, Ring& ring) const {
  const std::span<const std::uint32_t> fan = fans_.of(u);
  ring.size = static_cast<int>(fan.size());
  for (int i = 0; i < ring.size; ++i) {
    const Triangle& t = mesh_->triangles[fan[i]];
    // Without branches: which corner it is cannot be foretold.
    const std::uint32_t corner = (t[1] == u) + 2u * (t[2] == u);
    ring.triangle[i] = fan[i];
    ring.corner[i] = corner;
    ring.next[i] = t[kNext[corner]];
    ring.prev[i] = t[kPrevious[corner]];
  }
}

void Simplifier::locate(std::uint32_t u, Ring& ring) const {
  const Vec3f* const p = mesh_->positions.data();
  const Vec3f at = p[u];
  for (int i = ring.size; i % kLanes != 0; ++i) {
    ring.next[i] = ring.next[ring.size - 1];
    ring.prev[i] = ring.prev[ring.size - 1];
  }
  ring.vectors = (ring.size + kLanes - 1) / kLanes;
  for (int v = 0; v < ring.vectors; ++v) {
    const std::uint32_t* const n = &ring.next[v * kLanes];
    const std::uint32_t* const q = &ring.prev[v * kLanes];
    ring.nx[v] = Floats{p[n[0]].x, p[n[1]].x, p[n[2]].x, p[n[3]].x} - at.x;
    ring.ny[v] = Floats{p[n[0]].y, p[n[1]].y, p[n[2]].y, p[n[3]].y} - at.y;
    ring.nz[v] = Floats{p[n[0]].z, p[n[1]].z, p[n[2]].z, p[n[3]].z} - at.z;
    ring.px[v] = Floats{p[q[0]].x, p[q[1]].x, p[q[2]].x, p[q[3]].x} - at.x;
    ring.py[v] = Floats{p[q[0]].y, p[q[1]].y, p[q[2]].y, p[q[3]].y} - at.y;
    ring.pz[v] = Floats{p[q[0]].z, p[q[1]].z, p[q[2]].z, p[q[3]].z} - at.z;
  }
}

/// Cost of becoming each next vertex of the ring.
void Simplifier::price(std::uint32_t u, Ring& ring) const {
  const Quadric& q = quadrics_[u];
  const float length_weight = kLengthWeight * q.area;
  for (int v = 0; v < ring.vectors; ++v) {
    const Floats x = ring.nx[v], y = ring.ny[v], z = ring.nz[v];
    const Floats ax = q.xx * x + q.xy * y + q.xz * z + 2 * q.bx;
    const Floats ay = q.xy * x + q.yy * y + q.yz * z + 2 * q.by;
    const Floats az = q.xz * x + q.yz * y + q.zz * z + 2 * q.bz;
    const Floats plane = x * ax + y * ay + z * az + q.c;
    const Words above = plane > Floats{};
    ring.cost[v] = (above ? plane : Floats{}) + length_weight * (x * x + y * y + z * z);
  }
  if (mesh_->further.empty()) return;
  for (int i = 0; i < ring.size; ++i) {
    float square = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const float d = mesh_->further[ring.next[i]][k] - mesh_->further[u][k];
      square += d * d;
    }
    ring.cost_at(i) += q.area * square;
  }
}

/// Whether a triangle of the ring would turn over, or lose its area, with u at the ring's target-th
/// next vertex.
bool Simplifier::folds(int target, const Ring& ring) const {
  const Vec3f at = ring.next_at(target);
  const float tx = at.x, ty = at.y, tz = at.z;
  const auto name = static_cast<std::int32_t>(ring.next[target]);
  const Words in_plan = Words{} - static_cast<std::int32_t>(options_.in_plan);
  Words bad{};
  for (int v = 0; v < ring.vectors; ++v) {
    const Floats nx = ring.nx[v], ny = ring.ny[v], nz = ring.nz[v];
    const Floats px = ring.px[v], py = ring.py[v], pz = ring.pz[v];
    const Floats ox = ny * pz - nz * py, oy = nz * px - nx * pz, oz = nx * py - ny * px;
    const Floats ax = nx - tx, ay = ny - ty, az = nz - tz;
    const Floats bx = px - tx, by = py - ty, bz = pz - tz;
    const Floats mx = ay * bz - az * by, my = az * bx - ax * bz, mz = ax * by - ay * bx;
    const Floats along = ox * mx + oy * my + oz * mz;
    const Floats old_square = ox * ox + oy * oy + oz * oz;
    const Floats squares = old_square * (mx * mx + my * my + mz * mz);
    Words next, prev;
    std::memcpy(&next, &ring.next[v * kLanes], sizeof next);
    std::memcpy(&prev, &ring.prev[v * kLanes], sizeof prev);
    const Words gone = (next == name) | (prev == name);
    const Words turns_little = (along > 0) & (along * along > kTurnCosineSq * squares);
    const Words turned = (old_square > 0) & ~turns_little;
    const Words down = in_plan & (oz > 0) & ~(mz > 0);
    bad |= ~gone & (turned | down);
  }
  return (bad[0] | bad[1] | bad[2] | bad[3]) != 0;
}

/// A cost before anything is looked at, so that vertices that stay are never evaluated: for a step
/// as long as the fan is wide, along the surface in any direction. With the eigenvalues a >= b >= c
/// of A, trace^2 - |A|^2 is 2 (ab + ac + bc), about 2a (b + c); a is about the area.
void Simplifier::guess(std::uint32_t u) {
  if (kinds_[u] == Kind::kFixed) return;
  const Quadric& q = quadrics_[u];
  const float trace = q.xx + q.yy + q.zz;
  const float square =
      q.xx * q.xx + q.yy * q.yy + q.zz * q.zz + 2 * (q.xy * q.xy + q.xz * q.xz + q.yz * q.yz);
  const float bent = trace > 0 ? std::max(trace * trace - square, 0.0f) / trace : 0.0f;
  costs_[u] = kGuessShare * bent * q.area;
  touched_[u] = kNone;
}

/// Finds what u should become and what that costs; `ring` is left as gather() leaves it.
void Simplifier::evaluate(std::uint32_t u, bool check_link, Ring& ring) {
  touched_[u] = 0;
  costs_[u] = kNever;
  if (kinds_[u] == Kind::kFixed || fans_.of(u).size() >= kMaxRing || fans_.of(u).empty()) return;
  gather(u, ring);
  const int size = ring.size;
  if (kinds_[u] == Kind::kBorder) {
    // A border vertex may only move along the border. The one end of the chain is a next vertex
    // anyway, the other is made one: of a triangle without area, which folds() passes over.
    const int first = ring.first(), last = ring.last();
    if (first < 0 || last < 0) return;
    ring.next[size] = ring.prev[size] = ring.prev[last];
    ring.size = size + 1;
    locate(u, ring);
    price(u, ring);
    for (int i = 0; i < size; ++i) ring.cost_at(i) = i == first ? ring.cost_at(i) : kNever;
  } else {
    locate(u, ring);
    price(u, ring);
  }
  choose(u, check_link, ring);
  ring.size = size;
}

/// Takes the cheapest of the ring's next vertices that u may become.
void Simplifier::choose(std::uint32_t u, bool check_link, Ring& ring) {
  const float error_bound = options_.max_error * options_.max_error * quadrics_[u].area;
  const float reach = options_.reach - reached_[u];
  for (int tries = 0; tries < ring.size; ++tries) {
    int best = 0;
    float cost = ring.cost_at(0);
    for (int i = 1; i < ring.size; ++i) {
      const float other = ring.cost_at(i);
      best = other < cost ? i : best;
      cost = std::min(other, cost);
    }
    if (!(cost <= error_bound) || cost == kNever) return;
    const Vec3f d = ring.next_at(best);
    const float plan = std::max(std::abs(d.x), std::abs(d.y));
    const float far = options_.in_plan ? plan : std::max(plan, std::abs(d.z));
    if (far <= reach && !folds(best, ring) && (!check_link || allowed(u, ring.next[best], ring))) {
      costs_[u] = cost;
      targets_[u] = ring.next[best];
      return;
    }
    ring.cost_at(best) = kNever;
  }
}

/// Whether u may become `target` as far as the neighbours' connections go: the two may share no
/// neighbours but those of the triangles that go, and no triangle may come to be there twice. An
/// edge that is new between two locked vertices may be there already in the next block.
bool Simplifier::allowed(std::uint32_t u, std::uint32_t target, const Ring& ring) {
  ++epoch_;
  std::array<std::uint32_t, kMaxRing + 1> opposite;
  opposite[0] = opposite[1] = kNone;
  std::size_t shared = 0;
  for (int i = 0; i < ring.size; ++i) {
    const std::uint32_t next = ring.next[i], prev = ring.prev[i];
    marks_[next] = marks_[prev] = epoch_;
    const bool is_next = next == target, is_prev = prev == target;
    opposite[shared] = is_next ? prev : (is_prev ? next : opposite[shared]);
    shared += (is_next | is_prev) & (next != prev);
  }
  if (shared == 0 || shared > 2) return false;
  if (shared == 1) opposite[1] = kNone;
  // Nobody may be left without a triangle: the last of a part of the surface stay.
  for (std::size_t k = 0; k < shared; ++k) {
    if (fans_.of(opposite[k]).size() < 2) return false;
  }
  if (fans_.of(target).size() == shared && fans_.of(u).size() == shared) return false;
  marks_[target] = 0;
  bool meets = false;
  for (const std::uint32_t t : fans_.of(target)) {
    const Triangle& triangle = mesh_->triangles[t];
    const std::size_t corner = (triangle[1] == target) + 2 * (triangle[2] == target);
    const std::uint32_t next = triangle[kNext[corner]], prev = triangle[kPrevious[corner]];
    const bool next_met = marks_[next] == epoch_, prev_met = marks_[prev] == epoch_;
    const bool has_u = (next == u) | (prev == u);
    meets |= next_met & (next != opposite[0]) & (next != opposite[1]);
    meets |= prev_met & (prev != opposite[0]) & (prev != opposite[1]);
    meets |= next_met & prev_met & !has_u;
  }
  if (meets) return false;
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

/// u becomes its target, `ring` being what gather() found. False where that may not be; u then has
/// another target, or none.
bool Simplifier::collapse(std::uint32_t u, Ring& ring) {
  if (!allowed(u, targets_[u], ring)) {
    evaluate(u, true, ring);
    return false;
  }
  const std::uint32_t target = targets_[u];
  std::array<std::uint32_t, kMaxRing> kept;
  std::size_t kept_count = 0;
  for (int i = 0; i < ring.size; ++i) {
    const std::uint32_t next = ring.next[i], prev = ring.prev[i];
    for (const std::uint32_t v : {next, prev}) {
      touched_[v] = sweep_;
      // What could not go before may be able to now.
      if (costs_[v] == kNever && kinds_[v] != Kind::kFixed) costs_[v] = 0;
    }
    const bool gone = (next == target) | (prev == target);
    kept[kept_count] = ring.triangle[i];
    kept_count += !gone;
    mesh_->triangles[ring.triangle[i]][ring.corner[i]] = target;
    if (!gone) continue;
    fans_.remove(target, ring.triangle[i]);
    fans_.remove(next == target ? prev : next, ring.triangle[i]);
    mesh_->triangles[ring.triangle[i]] = {kNone, kNone, kNone};
    --live_;
  }
  fans_.add(target, {kept.data(), kept_count});
  add_quadric(u, target);
  parents_[u] = target;
  costs_[u] = kNever;
  targets_[u] = kNone;
  return true;
}

/// The target's quadric takes on that of u, moved to the target's own place.
void Simplifier::add_quadric(std::uint32_t u, std::uint32_t target) {
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
}

/// Cost that as many vertices are below as the next sweep should take, to an eighth of a power of
/// two; kNever where nothing is left.
float Simplifier::threshold() {
  std::array<std::uint32_t, 2048> counts{};
  std::size_t candidates = 0;
  const std::size_t stride = costs_.size() < 1000 ? 1 : kCostStride;
  for (std::size_t v = 0; v < costs_.size(); v += stride) {
    if (costs_[v] == kNever) continue;
    ++counts[std::bit_cast<std::uint32_t>(costs_[v]) >> 20];
    ++candidates;
  }
  if (candidates == 0) return stride == 1 ? kNever : std::numeric_limits<float>::max();
  const std::size_t wanted = (live_ - options_.target_triangles + 1) / 2 / stride + 1;
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
  Ring ring;
  for (std::uint32_t u = 0; u < costs_.size() && live_ > options_.target_triangles; ++u) {
    if (!(costs_[u] <= bound) || touched_[u] == sweep_) continue;
    if (touched_[u] != 0) {
      evaluate(u, false, ring);
      if (!(costs_[u] <= bound)) continue;
    } else {
      gather(u, ring);
    }
    collapsed += collapse(u, ring);
  }
  return collapsed;
}

}  // namespace cornice::hlod
