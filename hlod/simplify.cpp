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

#include "core/base/clones.h"

namespace cornice::hlod {
namespace {

/// Cost of what may go again when something near it goes.
constexpr float kRefused = std::numeric_limits<float>::infinity();
/// Cost of what stays for good, or is gone: neither below nor equal to any number.
constexpr float kNever = std::numeric_limits<float>::quiet_NaN();
/// State::touched of a cost that is a guess.
constexpr std::uint32_t kGuessed = 0xffffffffu;

constexpr std::int32_t kLanes = 8;
/// Low bits of a cost that tell which vertex of a link it belongs to.
constexpr std::int32_t kPlaceBits = 15;
constexpr std::int32_t kRefusedBits = 0x7f800000;
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
/// Vertices that a sweep looks at for each that is too many: about half of them have a neighbour
/// that goes before them.
constexpr double kSpareTimes = 1.6;
/// Every so many vertices stand for all where costs are counted.
constexpr std::size_t kCostStride = 4;
/// So many candidates ahead of the one that is looked at, its memory is asked for, and so many
/// ahead that of its neighbours.
constexpr std::size_t kFarAhead = 12, kAhead = 5;

}  // namespace

/// The vertices round a vertex u, coordinates relative to u, in lanes of eight. Triangle i is
/// (u, at[i], at[i + 1]).
struct alignas(32) Simplifier::Ring {
  std::uint32_t count, triangles;
  bool is_closed;
  int vectors;
  /// In order, then in order again, then filled up.
  alignas(32) std::array<std::uint32_t, 3 * 16> at;
  std::array<Float8, 2> x, y, z;
  std::array<Int8, 2> cost;  ///< bits of floats not below 0, the place in the lowest four
  /// Per triangle: from at[i] to at[i + 1]; the normal.
  std::array<Float8, 2> ex, ey, ez, nx, ny, nz;

  /// The other vertices that u and at[place] do not have round them both: [begin, end) of at.
  std::pair<std::uint32_t, std::uint32_t> others(std::uint32_t place) const {
    if (is_closed) return {place + 2, place + count - 1};
    return place == 0 ? std::pair{2u, count} : std::pair{0u, count - 2};
  }
  std::uint32_t before(std::uint32_t place) const {
    if (is_closed) return at[place + count - 1];
    return place == 0 ? Link::kEmpty : at[place - 1];
  }
  std::uint32_t after(std::uint32_t place) const {
    return is_closed || place == 0 ? at[place + 1] : Link::kEmpty;
  }
};

void Simplifier::run(SimplifyMesh& mesh, const SimplifyOptions& options) {
  collapse_edges(mesh, options);
  [[maybe_unused]] std::size_t left = 0;
  for (Triangle& t : mesh.triangles) {
    const std::uint32_t a = parents_[t[0]], b = parents_[t[1]], c = parents_[t[2]];
    const bool is_gone = (a == b) | (b == c) | (c == a);
    const std::uint32_t none = is_gone ? kNone : 0;
    t = {a | none, b | none, c | none};
    left += !is_gone;
  }
  assert(left == live_ && "collapses take away what they count");
}

void Simplifier::collapse_edges(const SimplifyMesh& mesh, const SimplifyOptions& options) {
  mesh_ = &mesh;
  options_ = options;
  prepare();
  int idle = 0;
  while (live_ > options_.target_triangles && idle < 2) {
    const float bound = threshold();
    if (bound == kRefused) break;
    idle = sweep(bound) == 0 ? idle + 1 : 0;
  }
  // Whatever a vertex became went later, or not at all.
  for (auto u = gone_.rbegin(); u != gone_.rend(); ++u) parents_[*u] = parents_[parents_[*u]];
}

void Simplifier::prepare() {
  const std::size_t count = mesh_->positions.size();
  live_ = mesh_->triangles.size();
  sweep_ = 0;
  links_.assign(count, mesh_->triangles);
  places_.resize(count);
  for (std::size_t v = 0; v < count; ++v) {
    const Vec3f p = mesh_->positions[v];
    places_[v] = Float4{p.x, p.y, p.z, 0};
  }
  quadrics_.assign(count, {});
  states_.resize(count);
  kinds_.resize(count);
  areas_.resize(count);
  targets_.resize(count);
  candidates_.resize(count);
  gone_.clear();
  gone_.reserve(count);
  parents_.resize(count);
  for (std::uint32_t v = 0; v < count; ++v) parents_[v] = v;
  add_plane_quadrics();
  classify();
}

void Simplifier::add_plane_quadrics() {
  for (const Triangle& t : mesh_->triangles) {
    const Float4 a = places_[t[1]] - places_[t[0]], b = places_[t[2]] - places_[t[0]];
    const Float4 a_yzx = CORNICE_SHUFFLE4(a, a, 1, 2, 0, 3);
    const Float4 b_yzx = CORNICE_SHUFFLE4(b, b, 1, 2, 0, 3);
    const Float4 n_zxy = a * b_yzx - a_yzx * b;
    const Float4 n = CORNICE_SHUFFLE4(n_zxy, n_zxy, 1, 2, 0, 3);
    const Float4 square = n * n;
    const float length = std::sqrt(square[0] + square[1] + square[2]);
    const float w = length > 0 ? 0.5f / length : 0.0f;
    // (x, x, y, length) times (y, z, z, length): the area comes out as the last.
    const Float4 longer{n[0], n[1], n[2], length};
    const Float4 squares = w * square;
    const Float4 products = w * (CORNICE_SHUFFLE4(longer, longer, 0, 0, 1, 3) *
                                 CORNICE_SHUFFLE4(longer, longer, 1, 2, 2, 3));
    for (const std::uint32_t v : t) {
      quadrics_[v].squares += squares;
      quadrics_[v].products += products;
    }
  }
}

void Simplifier::classify() {
  for (std::uint32_t u = 0; u < kinds_.size(); ++u) {
    areas_[u] = quadrics_[u].products[3];
    kinds_[u] = Kind::kFixed;
    states_[u] = {kNever, 0};
    if (mesh_->locked[u] != 0) continue;
    const Fan fan = links_.fan(u);
    if (fan == Fan::kNone) continue;
    kinds_[u] = fan == Fan::kClosed ? Kind::kInside : Kind::kBorder;
    if (fan == Fan::kOpen && !links_.of(u).is_loose()) add_border_quadric(u);
    states_[u] = {guess(u), kGuessed};
  }
}

/// Planes through the two open edges of a border vertex.
void Simplifier::add_border_quadric(std::uint32_t u) {
  const std::vector<Vec3f>& p = mesh_->positions;
  const Link& link = links_.of(u);
  const std::uint32_t last = link.count() - 1;
  const auto add = [&](std::uint32_t end, std::uint32_t next, std::uint32_t previous) {
    const Vec3f edge = p[end] - p[u];
    const Vec3f n = cross(edge, cross(p[next] - p[u], p[previous] - p[u]));
    const float square = dot(n, n);
    if (square == 0) return;
    const float w = kBorderWeight * dot(edge, edge) / square;
    Quadric& q = quadrics_[u];
    q.squares += Float4{w * n.x * n.x, w * n.y * n.y, w * n.z * n.z, 0};
    q.products += Float4{w * n.x * n.y, w * n.x * n.z, w * n.y * n.z, 0};
  };
  add(link.at[0], link.at[0], link.at[1]);
  add(link.at[last], link.at[last - 1], link.at[last]);
}

/// A cost before anything is looked at, so that vertices that stay are never evaluated: for a step
/// as long as the fan is wide, along the surface in any direction. With the eigenvalues a >= b >= c
/// of A, trace^2 - |A|^2 is 2 (ab + ac + bc), about 2a (b + c); a is about the area.
float Simplifier::guess(std::uint32_t u) const {
  const Quadric& q = quadrics_[u];
  const Float4 s = q.squares, m = q.products;
  const float trace = s[0] + s[1] + s[2];
  const float square =
      s[0] * s[0] + s[1] * s[1] + s[2] * s[2] + 2 * (m[0] * m[0] + m[1] * m[1] + m[2] * m[2]);
  const float bent = trace > 0 ? std::max(trace * trace - square, 0.0f) / trace : 0.0f;
  return kGuessShare * bent * m[3];
}

CORNICE_INLINE void Simplifier::gather(std::uint32_t u, Ring& ring) const {
  const Link& link = links_.of(u);
  const auto count = static_cast<std::int32_t>(link.count());
  ring.count = link.count();
  ring.is_closed = link.is_closed();
  ring.triangles = ring.count - !ring.is_closed;
  ring.vectors = count > kLanes ? 2 : 1;
  const auto filling = static_cast<std::int32_t>(ring.is_closed ? link.at[0] : link.at[count - 1]);
  const Int8 fill = Int8{} + filling;
  Int8 low, high;
  load_lanes(link.at, low);
  load_lanes(link.at + 8, high);
  const Int8 low_filled = kLaneNumbers < count ? low : fill;
  const Int8 high_filled = kLaneNumbers + 8 < count ? high : fill;
  store_lanes(ring.at.data(), low_filled);
  store_lanes(ring.at.data() + 8, high_filled);
  store_lanes(ring.at.data() + count, low_filled);
  store_lanes(ring.at.data() + count + 8, high_filled);
}

CORNICE_INLINE void Simplifier::locate(std::uint32_t u, Ring& ring) const {
  const Float4 at = places_[u];
  for (int v = 0; v < ring.vectors; ++v) {
    gather_points(places_.data(), &ring.at[v * kLanes], ring.x[v], ring.y[v], ring.z[v]);
    ring.x[v] -= at[0];
    ring.y[v] -= at[1];
    ring.z[v] -= at[2];
  }
  for (int v = 0; v < ring.vectors; ++v) {
    const int w = ring.vectors - 1 - v;
    const Float8 x = ring.x[v], y = ring.y[v], z = ring.z[v];
    Float8 px, py, pz;
    one_on(x, ring.x[w], px);
    one_on(y, ring.y[w], py);
    one_on(z, ring.z[w], pz);
    ring.ex[v] = px - x, ring.ey[v] = py - y, ring.ez[v] = pz - z;
    ring.nx[v] = y * pz - z * py, ring.ny[v] = z * px - x * pz, ring.nz[v] = x * py - y * px;
  }
}

/// Costs of becoming each vertex of the ring.
CORNICE_INLINE void Simplifier::price(std::uint32_t u, Ring& ring) const {
  const Quadric& q = quadrics_[u];
  const Float4 s = q.squares, m = q.products, r = q.rest;
  const float length_weight = kLengthWeight * m[3];
  const auto count = static_cast<std::int32_t>(ring.count);
  for (int v = 0; v < ring.vectors; ++v) {
    const Float8 x = ring.x[v], y = ring.y[v], z = ring.z[v];
    const Float8 ax = s[0] * x + m[0] * y + m[1] * z + 2 * r[0];
    const Float8 ay = m[0] * x + s[1] * y + m[2] * z + 2 * r[1];
    const Float8 az = m[1] * x + m[2] * y + s[2] * z + 2 * r[2];
    const Float8 plane = x * ax + y * ay + z * az + r[3];
    const Int8 above = plane > Float8{};
    const Float8 cost = (above ? plane : Float8{}) + length_weight * (x * x + y * y + z * z);
    const Int8 place = kLaneNumbers + kLanes * v;
    Int8 bits;
    load_lanes(&cost, bits);
    bits = (bits & ~kPlaceBits) | place;
    // Along the border alone, at one of the two ends of the fan.
    const Int8 open = Int8{} - static_cast<std::int32_t>(!ring.is_closed);
    const Int8 possible = (place < count) & (~open | (place == 0) | (place == count - 1));
    ring.cost[v] = possible ? bits : Int8{} + kRefusedBits;
  }
  if (!mesh_->further.empty()) price_further(u, ring);
}

/// Adds what colours or textures cost.
void Simplifier::price_further(std::uint32_t u, Ring& ring) const {
  for (std::uint32_t i = 0; i < ring.count; ++i) {
    float square = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const float d = mesh_->further[ring.at[i]][k] - mesh_->further[u][k];
      square += d * d;
    }
    Int8& lanes = ring.cost[i / kLanes];
    const std::int32_t bits = lanes[i % kLanes];
    if (bits == kRefusedBits) continue;
    const float cost = std::bit_cast<float>(bits) + quadrics_[u].products[3] * square;
    lanes[i % kLanes] =
        (std::bit_cast<std::int32_t>(cost) & ~kPlaceBits) | static_cast<std::int32_t>(i);
  }
}

/// Whether a triangle of the ring would turn over, or lose its area, with u at the ring's place,
/// which is (tx, ty, tz) from u.
CORNICE_INLINE bool Simplifier::folds(float tx, float ty, float tz, std::uint32_t place,
                                      const Ring& ring) const {
  const Int8 in_plan = Int8{} - static_cast<std::int32_t>(options_.in_plan);
  const auto first = static_cast<std::int32_t>(place);
  const auto second = static_cast<std::int32_t>(place == 0 ? ring.count - 1 : place - 1);
  const auto triangles = static_cast<std::int32_t>(ring.triangles);
  Int8 bad{};
  for (int v = 0; v < ring.vectors; ++v) {
    const Float8 nx = ring.nx[v], ny = ring.ny[v], nz = ring.nz[v];
    const Float8 ex = ring.ex[v], ey = ring.ey[v], ez = ring.ez[v];
    // (p - t) x (q - t) = p x q - t x (q - p).
    const Float8 mx = nx - (ty * ez - tz * ey);
    const Float8 my = ny - (tz * ex - tx * ez);
    const Float8 mz = nz - (tx * ey - ty * ex);
    const Float8 along = nx * mx + ny * my + nz * mz;
    const Float8 old_square = nx * nx + ny * ny + nz * nz;
    const Float8 squares = old_square * (mx * mx + my * my + mz * mz);
    const Int8 turns_little = (along > 0) & (along * along > kTurnCosineSq * squares);
    const Int8 turned = (old_square > 0) & ~turns_little;
    const Int8 down = in_plan & (nz > 0) & ~(mz > 0);
    const Int8 triangle = kLaneNumbers + kLanes * v;
    const Int8 gone = (triangle == first) | (triangle == second) | (triangle >= triangles);
    bad |= ~gone & (turned | down);
  }
  return or_of_lanes(bad) != 0;
}

/// Distance from a vertex to one that it may become.
CORNICE_INLINE float Simplifier::way(float x, float y, float z) const {
  const float plan = std::max(std::abs(x), std::abs(y));
  return options_.in_plan ? plan : std::max(plan, std::abs(z));
}

/// Whether the ring's vertex may become at[place] as far as the neighbours' connections go: the two
/// may share no neighbours but those of the triangles that go, and no triangle may come to be there
/// twice. An edge that is new between two locked vertices may be there already in the next block.
CORNICE_INLINE bool Simplifier::allowed(std::uint32_t place, const Ring& ring) const {
  const std::uint32_t target = ring.at[place];
  const auto [begin, end] = ring.others(place);
  if (links_.has_any(target, {&ring.at[begin], end - begin})) return false;
  const std::uint32_t before = ring.before(place), after = ring.after(place);
  const Link& link = links_.of(target);
  if (ring.is_closed) {
    // In a tight link the two are next to each other only where there is one more vertex.
    if (link.is_loose() ? links_.has_triangle(target, before, after)
                        : link.is_closed() && link.count() == 3) {
      return false;
    }
  } else if (ring.triangles == 1 && links_.triangle_count(target) == 1) {
    return false;
  }
  // Nobody may be left without a triangle: the last of a part of the surface stay.
  if (before != Link::kEmpty && links_.triangle_count(before) < 2) return false;
  if (after != Link::kEmpty && links_.triangle_count(after) < 2) return false;
  if (mesh_->locked[target] == 0) return true;
  for (std::uint32_t i = begin; i < end; ++i) {
    if (mesh_->locked[ring.at[i]] != 0) return false;
  }
  return true;
}

/// Finds what u should become and what that costs; `ring` is of u then. Whether there is anything.
CORNICE_INLINE bool Simplifier::evaluate(std::uint32_t u, bool check_links, Ring& ring) {
  states_[u] = {kRefused, 0};
  if (links_.of(u).is_loose() && !links_.tighten(u)) return false;
  gather(u, ring);
  locate(u, ring);
  price(u, ring);
  const float error_bound = options_.max_error * options_.max_error * quadrics_[u].products[3];
  const float reach = options_.reach - places_[u][3];
  for (;;) {
    Int8 least = ring.cost[0];
    if (ring.vectors == 2) least = ring.cost[1] < least ? ring.cost[1] : least;
    const std::int32_t bits = least_of_lanes(least);
    if (bits == kRefusedBits) return false;
    const float cost = std::bit_cast<float>(bits & ~kPlaceBits);
    if (!(cost <= error_bound)) return false;
    const auto place = static_cast<std::uint32_t>(bits & kPlaceBits);
    const std::size_t of = place / kLanes, lane = place % kLanes;
    const float x = ring.x[of][lane], y = ring.y[of][lane], z = ring.z[of][lane];
    if (way(x, y, z) <= reach && !folds(x, y, z, place, ring) &&
        (!check_links || allowed(place, ring))) {
      states_[u].cost = cost;
      targets_[u] = place;
      return true;
    }
    const Int8 refused = Int8{} + kRefusedBits;
    ring.cost[0] = ring.cost[0] == bits ? refused : ring.cost[0];
    ring.cost[1] = ring.cost[1] == bits ? refused : ring.cost[1];
  }
}

/// u becomes its target, `ring` being what gather() found. False where that may not be.
CORNICE_INLINE bool Simplifier::collapse(std::uint32_t u, Ring& ring) {
  const std::uint32_t place = targets_[u], target = ring.at[place];
  if (!allowed(place, ring)) return false;
  for (int i = 0; i < kLanes * ring.vectors; ++i) {
    // Those that fill the ring up are of it, too. What could not go before may be able to now.
    State& state = states_[ring.at[i]];
    state = {state.cost == kRefused ? 0.0f : state.cost, sweep_};
  }
  const auto [begin, end] = ring.others(place);
  for (std::uint32_t i = begin; i < end; ++i) links_.rename(ring.at[i], u, target);
  const std::uint32_t before = ring.before(place), after = ring.after(place);
  if (before != Link::kEmpty) links_.erase(before, u, target);
  if (after != Link::kEmpty) links_.erase(after, u, target);
  links_.merge(target, u, {&ring.at[begin], end - begin}, after, before);
  live_ -= ring.is_closed ? 2 : 1;
  add_quadric(u, target);
  parents_[u] = target;
  states_[u].cost = kNever;
  gone_.push_back(u);
  return true;
}

/// The target's quadric takes on that of u, moved to the target's own place.
CORNICE_INLINE void Simplifier::add_quadric(std::uint32_t u, std::uint32_t target) {
  const Float4 d = places_[target] - places_[u];
  places_[target][3] = std::max(places_[target][3], places_[u][3] + way(d[0], d[1], d[2]));
  const Quadric& from = quadrics_[u];
  Quadric& to = quadrics_[target];
  const Float4 s = from.squares, m = from.products, r = from.rest;
  const Vec3f a{s[0] * d[0] + m[0] * d[1] + m[1] * d[2], m[0] * d[0] + s[1] * d[1] + m[2] * d[2],
                m[1] * d[0] + m[2] * d[1] + s[2] * d[2]};
  const float c =
      (d[0] * a.x + d[1] * a.y + d[2] * a.z) + 2 * (r[0] * d[0] + r[1] * d[1] + r[2] * d[2]);
  to.squares += s;
  to.products += m;
  to.rest += r + Float4{a.x, a.y, a.z, c};
}

/// Cost that as many vertices are below as the next sweep should take, to an eighth of a power of
/// two; kRefused where nothing is left.
float Simplifier::threshold() {
  std::array<std::uint32_t, 2048> counts{};
  const std::size_t stride = states_.size() < 1000 ? 1 : kCostStride;
  for (std::size_t v = 0; v < states_.size(); v += stride) {
    ++counts[std::bit_cast<std::uint32_t>(states_[v].cost) >> 20];
  }
  // Behind the largest number lie those that are refused or never go.
  constexpr std::uint32_t kEnd = std::bit_cast<std::uint32_t>(kRefused) >> 20;
  std::size_t candidates = 0;
  for (std::uint32_t bin = 0; bin < kEnd; ++bin) candidates += counts[bin];
  if (candidates == 0) return stride == 1 ? kRefused : std::numeric_limits<float>::max();
  const double too_many = static_cast<double>(live_ - options_.target_triangles + 1) / 2;
  const auto wanted =
      static_cast<std::size_t>(kSpareTimes * too_many / static_cast<double>(stride)) + 1;
  const auto share = static_cast<std::size_t>(kSweepShare * static_cast<double>(candidates)) + 1;
  std::size_t sum = 0;
  for (std::uint32_t bin = 0; bin < kEnd; ++bin) {
    sum += counts[bin];
    if (sum >= std::min(wanted, share)) {
      return std::nextafter(std::bit_cast<float>((bin + 1) << 20), 0.0f);
    }
  }
  return kRefused;
}

/// Asks for the memory that candidates after the i-th will need.
CORNICE_INLINE void Simplifier::prefetch(std::size_t i, std::size_t count) const {
  const std::uint32_t far = candidates_[std::min(i + kFarAhead, count - 1)];
  links_.prefetch(far);
  __builtin_prefetch(&quadrics_[far]);
  __builtin_prefetch(&quadrics_[far].rest);
  const std::uint32_t near = candidates_[std::min(i + kAhead, count - 1)];
  const Link& link = links_.of(near);
  // Of what is no vertex, the last is asked for.
  const auto last = static_cast<std::uint32_t>(places_.size()) - 1;
  for (std::size_t k = 0; k < 6; ++k) {
    const std::uint32_t v = std::min(link.at[k], last);
    links_.prefetch(v);
    __builtin_prefetch(places_.data() + v);
    __builtin_prefetch(states_.data() + v);
  }
}

/// Collapses what costs no more than the bound, in order of memory. Returns how many.
CORNICE_CLONES std::size_t Simplifier::sweep(float bound) {
  ++sweep_;
  std::size_t count = 0;
  const State* const states = states_.data();
  std::uint32_t* const candidates = candidates_.data();
  const auto vertex_count = static_cast<std::uint32_t>(states_.size());
  for (std::uint32_t u = 0; u < vertex_count; ++u) {
    candidates[count] = u;
    count += states[u].cost <= bound;
  }
  std::size_t collapsed = 0;
  Ring ring;
  for (std::size_t i = 0; i < count && live_ > options_.target_triangles; ++i) {
    prefetch(i, count);
    const std::uint32_t u = candidates_[i];
    if (states_[u].touched == sweep_) continue;
    if (states_[u].touched != 0) {
      if (!evaluate(u, false, ring) || !(states_[u].cost <= bound)) continue;
    } else {
      gather(u, ring);
    }
    if (collapse(u, ring)) {
      ++collapsed;
    } else {
      evaluate(u, true, ring);
    }
  }
  return collapsed;
}

}  // namespace cornice::hlod
