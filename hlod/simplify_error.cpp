// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/simplify_error.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "core/base/clones.h"

namespace cornice::hlod {
namespace {

constexpr std::size_t kLanes = 8;
/// Vertices round which a nearer foot is looked for.
constexpr std::size_t kLookLimit = 24;
/// A foot that is farther off than this part of the way to the parent may not be the nearest.
constexpr float kFarFoot = 0.1f;
/// So many vertices ahead of the one whose feet are found, its memory is asked for, and so many
/// ahead that of its neighbours.
constexpr std::size_t kFarAhead = 12, kAhead = 5;
/// So many edges ahead of the one that is looked at, the link that it will need is asked for.
constexpr std::size_t kEdgesAhead = 8;
/// Low bits of a squared distance that say which triangle it is of, and whether beyond its rim.
constexpr std::int32_t kFootBits = 15;

float segment_distance(Vec3f p, Vec3f a, Vec3f b) {
  const Vec3f d = b - a;
  const float square = dot(d, d);
  const float s = square > 0 ? std::clamp(dot(p - a, d) / square, 0.0f, 1.0f) : 0.0f;
  return norm(p - (a + s * d));
}

CORNICE_INLINE void gather_vectors(const Float4* points, const std::uint32_t* names,
                                   VectorLanes& to) {
  gather_points(points, names, to.x, to.y, to.z);
}

}  // namespace

void StepError::prepare(const Simplifier& simplifier, std::span<const Float4> fine,
                        std::span<const Triangle> original, std::span<const std::uint8_t> shared) {
  simplifier_ = &simplifier;
  fine_ = fine;
  original_ = original;
  const std::size_t count = fine.size();
  feet_.resize(count);
  first_.assign(count, kNone);
  next_.resize(count);
  within_.resize(count);
  for (std::uint32_t v = 0; v < count; ++v) {
    within_[v] = simplifier.is_inside(v) && (shared.empty() || shared[v] == 0);
    const std::uint32_t parent = simplifier.parents()[v];
    feet_[v] = {{v, v, v}, 0};
    if (parent != v) next_[v] = std::exchange(first_[parent], v);
  }
  taken_.clear();
  for (std::uint32_t v = 0; v < count; ++v) {
    if (first_[v] != kNone) taken_.push_back(v);
  }
  find_all_feet();
}

CORNICE_CLONES void StepError::find_all_feet() {
  const std::size_t count = taken_.size();
  const VertexLinks& links = simplifier_->links();
  const Float4* const places = simplifier_->places().data();
  const std::size_t last = fine_.size() - 1;
  for (std::size_t i = 0; i < count; ++i) {
    links.prefetch(taken_[std::min(i + kFarAhead, count - 1)]);
    const Link& near = links.of(taken_[std::min(i + kAhead, count - 1)]);
    // Of what is no vertex, the last is asked for.
    for (std::size_t k = 0; k < 6; ++k) {
      __builtin_prefetch(places + std::min<std::size_t>(near.at[k], last));
    }
    find_feet(taken_[i]);
  }
}

/// Coordinates of what lies round a vertex are taken once: each is the next triangle's, too.
CORNICE_INLINE void StepError::gather_ring(std::uint32_t vertex, const Link& link, Fan& fan) const {
  Int8 names;
  load_lanes(link.at, names);
  // What fills the lanes up is the side between the last triangle and the first, which it goes by.
  const Int8 is_triangle = kLaneNumbers < static_cast<std::int32_t>(link.count());
  const auto first = static_cast<std::int32_t>(link.at[0]);
  const auto second = static_cast<std::int32_t>(link.at[1]);
  names = is_triangle ? names : Int8{} + first;
  store_lanes(fan.next.data(), names);
  const Int8 following = CORNICE_SHUFFLE8(names, names, 1, 2, 3, 4, 5, 6, 7, 8);
  store_lanes(fan.prev.data(), is_triangle ? following : Int8{} + second);
  const Float4* const places = simplifier_->places().data();
  const Float4 at = places[vertex];
  FanLanes& lanes = fan.lanes.front();
  VectorLanes next;
  gather_vectors(places, fan.next.data(), next);
  next.x -= at[0], next.y -= at[1], next.z -= at[2];
  lanes.next = next;
  one_on(next.x, next.x, lanes.prev.x);
  one_on(next.y, next.y, lanes.prev.y);
  one_on(next.z, next.z, lanes.prev.z);
  measure_fan(lanes);
}

CORNICE_INLINE void StepError::gather(std::uint32_t vertex, Fan& fan) const {
  const VertexLinks& links = simplifier_->links();
  const Link& link = links.of(vertex);
  fan.is_ring = !link.is_loose() && link.is_closed() && link.count() <= kLanes;
  const std::size_t triangles = fan.is_ring ? kLanes : links.triangle_count(vertex);
  fan.lanes.resize((triangles + kLanes - 1) / kLanes);
  const std::size_t filled = fan.lanes.size() * kLanes;
  if (fan.next.size() < filled) fan.next.resize(filled), fan.prev.resize(filled);
  if (fan.is_ring) return gather_ring(vertex, link, fan);
  std::size_t count = 0;
  links.for_each_arc(vertex, [&](std::uint32_t from, std::uint32_t to) {
    fan.next[count] = from, fan.prev[count] = to, ++count;
  });
  for (; count < filled; ++count) fan.next[count] = fan.next[0], fan.prev[count] = fan.prev[0];
  const Float4* const places = simplifier_->places().data();
  const Float4 at = places[vertex];
  const VectorLanes middle{Float8{} + at[0], Float8{} + at[1], Float8{} + at[2]};
  for (std::size_t f = 0; f < fan.lanes.size(); ++f) {
    FanLanes& lanes = fan.lanes[f];
    VectorLanes next, prev;
    gather_vectors(places, &fan.next[f * kLanes], next);
    gather_vectors(places, &fan.prev[f * kLanes], prev);
    subtract(next, middle, lanes.next), subtract(prev, middle, lanes.prev);
    measure_fan(lanes);
  }
}

/// The foot of a point, relative to the vertex in the fan's middle, if it is nearer than what there
/// is. Its distance is squared.
CORNICE_INLINE void StepError::foot_in(const Fan& fan, std::uint32_t middle, Vec3f point,
                                       Foot& foot) const {
  for (std::size_t f = 0; f < fan.lanes.size(); ++f) {
    Float8 square;
    Int8 is_beyond, bits;
    distances_to_fan(fan.lanes[f], point, square, is_beyond);
    // Floats from 0 on are ordered as their bits are; with the lane in the lowest the least is
    // found without guessing which it is. They are rounded up where they serve as distances.
    load_lanes(&square, bits);
    const std::int32_t least =
        least_of_lanes((bits & ~kFootBits) | (2 * kLaneNumbers) | (is_beyond & 1));
    const auto nearest = std::bit_cast<float>(least | kFootBits);
    if (!(nearest < std::abs(foot.distance))) continue;
    const std::size_t place = f * kLanes + static_cast<std::size_t>(least & kFootBits) / 2;
    foot.corners = {middle, fan.next[place], fan.prev[place]};
    foot.distance = (least & 1) != 0 ? -nearest : nearest;
  }
}

/// Feet of all that became one vertex.
CORNICE_INLINE void StepError::find_feet(std::uint32_t parent) {
  gather(parent, fan_);
  const Float4 at = simplifier_->places()[parent];
  for (std::uint32_t v = first_[parent]; v != kNone; v = next_[v]) {
    const Vec3f way = vector_of(fine_[v] - at);
    const float way_square = dot(way, way);
    Foot foot{{parent, parent, parent}, std::numeric_limits<float>::infinity()};
    foot_in(fan_, parent, way, foot);
    if (foot.is_point()) foot.distance = way_square;
    const bool may_be_nearer =
        foot.distance < 0 ||
        (!foot.is_point() && foot.distance > kFarFoot * kFarFoot * way_square &&
         !(simplifier_->is_in_plan() && is_nearest_in_plan(fan_, way, foot.distance)));
    feet_[v] = {foot.corners, std::sqrt(std::abs(foot.distance))};
    if (may_be_nearer) look_round(v);
    if (simplifier_->is_border(v))
      feet_[v].distance = std::max(feet_[v].distance, border_distance(v));
  }
}

/// Whether the way to anything beyond the fan's rim would be longer in plan alone than to the foot.
CORNICE_INLINE bool StepError::is_nearest_in_plan(const Fan& fan, Vec3f point, float square) const {
  if (!fan.is_ring) return false;
  const VectorLanes &next = fan.lanes.front().next, &prev = fan.lanes.front().prev;
  const Float8 ox = prev.x - next.x, oy = prev.y - next.y;
  const Float8 x = point.x - next.x, y = point.y - next.y;
  Float8 per_outer = ox * ox + oy * oy;
  invert(per_outer);
  Float8 place = (x * ox + y * oy) * per_outer;
  clamp_share(place);
  const Float8 dx = x - place * ox, dy = y - place * oy;
  return or_of_lanes(dx * dx + dy * dy < square) == 0;
}

/// Looks for a nearer foot round the foot's triangle, and on as long as there is one.
CORNICE_INLINE void StepError::look_round(std::uint32_t vertex) {
  Foot foot = feet_[vertex];
  foot.distance *= foot.distance;
  std::array<std::uint32_t, kLookLimit> seen{foot.corners[0]};
  std::size_t count = 1;
  for (bool is_nearer = true; is_nearer && count < seen.size();) {
    is_nearer = false;
    const Triangle corners = foot.corners;
    for (const std::uint32_t corner : corners) {
      if (std::find(seen.begin(), seen.begin() + count, corner) != seen.begin() + count) continue;
      if (count == seen.size()) break;
      seen[count++] = corner;
      gather(corner, farther_);
      const float before = foot.distance;
      foot_in(farther_, corner, vector_of(fine_[vertex] - simplifier_->places()[corner]), foot);
      foot.distance = std::abs(foot.distance);
      is_nearer |= foot.distance < before;
    }
  }
  feet_[vertex] = {foot.corners, std::sqrt(foot.distance)};
}

/// From a vertex that was on the border to the border next to its parent: a concave border that is
/// cut short lies inside the coarse surface, but the coarse surface then lies outside of the fine.
float StepError::border_distance(std::uint32_t vertex) const {
  const std::uint32_t parent = simplifier_->parents()[vertex];
  float nearest = norm(fine(vertex) - coarse(parent));
  simplifier_->links().for_each_arc(parent, [&](std::uint32_t from, std::uint32_t to) {
    const Triangle triangle{parent, from, to};
    for (std::size_t e = 0; e < 3; ++e) {
      if (across(triangle, e) != kNone) continue;
      nearest = std::min(nearest, segment_distance(fine(vertex), coarse(triangle[e]),
                                                   coarse(triangle[e == 2 ? 0 : e + 1])));
    }
  });
  return nearest;
}

void StepError::Crossings::add(std::uint32_t from, std::uint32_t to, const Triangle& over) {
  a[count] = from, b[count] = to, p[count] = over[0], q[count] = over[1], r[count] = over[2];
  ++count;
}

/// For as many edges, and for those that fill the last lanes up.
void StepError::Crossings::make_room(std::size_t more) {
  if (a.size() >= count + more + kLanes) return;
  for (std::vector<std::uint32_t>* names : {&a, &b, &p, &q, &r})
    names->resize(count + more + kLanes);
}

void StepError::Crossings::fill_up() {
  for (std::size_t i = count; i < (count + kLanes - 1) / kLanes * kLanes; ++i) {
    a[i] = a[0], b[i] = b[0], p[i] = p[0], q[i] = q[0], r[i] = r[0];
  }
}

/// The edges of a range, without those that are met again from their other side. For which it is
/// cannot be foretold, so there are no branches, here as below.
void StepError::list_edges(std::size_t begin, std::size_t end) {
  if (edges_.size() <= 3 * (end - begin)) edges_.resize(3 * (end - begin) + 1);
  Edge* edge = edges_.data();
  const std::uint8_t* const within = within_.data();
  for (std::size_t i = begin; i < end; ++i) {
    const Triangle& t = original_[i];
    for (std::size_t e = 0; e < 3; ++e) {
      const std::uint32_t from = t[e], to = t[e == 2 ? 0 : e + 1];
      const bool is_again = (from > to) & ((within[from] | within[to]) != 0);
      edge->a = std::min(from, to), edge->b = from ^ to ^ edge->a;
      edge += !is_again;
    }
  }
  edge_count_ = static_cast<std::size_t>(edge - edges_.data());
}

/// Takes the edges apart: those that pass over one coarse edge, others, and those with both feet on
/// one triangle, which pass over none. Every vertex has an edge, so all distances are seen here.
void StepError::find_crossings() {
  // Places of the corners that two triangles share, by their bits.
  constexpr std::array<std::uint8_t, 8> kFirst{0, 0, 1, 0, 2, 0, 1, 0};
  constexpr std::array<std::uint8_t, 8> kSecond{0, 0, 0, 1, 0, 2, 2, 0};
  constexpr unsigned kTwo = 1u << 3 | 1u << 5 | 1u << 6;
  once_.count = 0;
  once_.make_room(edge_count_);
  std::uint32_t *const to_a = once_.a.data(), *const to_b = once_.b.data();
  std::uint32_t *const to_p = once_.p.data(), *const to_q = once_.q.data();
  const Foot* const feet = feet_.data();
  Edge* const edges = edges_.data();
  std::size_t count = 0, others = 0;
  Int4 most{};  // bits of floats from 0 on are ordered as these are; the others mean nothing
  for (std::size_t i = 0; i < edge_count_; ++i) {
    const std::uint32_t a = edges[i].a, b = edges[i].b;
    Int4 of_a, of_b;
    load_lanes(feet + a, of_a);
    load_lanes(feet + b, of_b);
    most = of_a > most ? of_a : most;
    most = of_b > most ? of_b : most;
    Int4 shared = (of_a == of_b) | (of_a == CORNICE_SHUFFLE4(of_b, of_b, 1, 2, 0, 3)) |
                  (of_a == CORNICE_SHUFFLE4(of_b, of_b, 2, 0, 1, 3));
    shared &= Int4{1, 2, 4, 0};
    shared |= CORNICE_SHUFFLE4(shared, shared, 2, 3, 0, 1);
    shared |= CORNICE_SHUFFLE4(shared, shared, 1, 0, 3, 2);
    const auto bits = static_cast<unsigned>(shared[0]);
    const auto first_of_b = static_cast<std::uint32_t>(of_b[0]);
    const bool ends = of_b[0] == of_b[1];
    const bool passes = !((bits == 7) | (ends & (bits != 0)));
    const bool is_once = passes & ((kTwo >> bits & 1) != 0);
    const Triangle& corners = feet[a].corners;
    const std::uint32_t p = corners[kFirst[bits]], q = corners[kSecond[bits]];
    const std::uint32_t low = std::min(p, q);
    to_a[count] = a, to_b[count] = b, to_p[count] = low, to_q[count] = p ^ q ^ low;
    count += is_once;
    edges[others] = {a, b, ends ? first_of_b : p};
    others += passes & !is_once;
  }
  once_.count = count;
  edge_count_ = others;
  error_ = std::max(error_, std::bit_cast<float>(static_cast<std::int32_t>(most[3])));
}

/// Of an edge whose feet are not on triangles with a common edge.
void StepError::pass(const Edge& edge) {
  const bool is_turned = feet_[edge.b].is_point();
  const std::uint32_t a = is_turned ? edge.b : edge.a, b = is_turned ? edge.a : edge.b;
  const bool found = feet_[a].is_point() ? pass_from_point(a, b) : pass_between(edge);
  if (!found) pass_farther(a, b);
}

/// By way of one triangle between those of the feet.
bool StepError::pass_between(const Edge& edge) {
  const auto [a, b, p] = edge;
  const Foot &from = feet_[a], &to = feet_[b];
  if (!to.has(p)) return false;
  const Link& link = simplifier_->links().of(p);
  if (link.is_loose()) {
    bool found = false;
    simplifier_->links().for_each_arc(p, [&](std::uint32_t next, std::uint32_t prev) {
      const bool on = from.has(next) && to.has(prev), back = from.has(prev) && to.has(next);
      if (!found && (on || back)) {
        twice_.add(edge.a, edge.b, {edge.middle, on ? next : prev, on ? prev : next});
      }
      found = found || on || back;
    });
    return found;
  }
  const std::uint32_t of_from = places_in(link, from.corners);
  const std::uint32_t of_to = places_in(link, to.corners);
  const std::uint32_t on = one_place_on(link, of_from) & of_to;
  const std::uint32_t back = one_place_on(link, of_to) & of_from;
  if ((on | back) == 0) return false;
  const auto place = first_place(on != 0 ? on : back);
  const std::uint32_t prev = link.at[place];
  const std::uint32_t next = link.at[place == 0 ? link.count() - 1 : place - 1];
  twice_.add(a, b, {p, on != 0 ? next : prev, on != 0 ? prev : next});
  return true;
}

/// Round the vertex that lies between the feet; where that may be the farthest of all, another way
/// is looked for later.
void StepError::pass_farther(std::uint32_t a, std::uint32_t b) {
  const Foot &from = feet_[a], &to = feet_[b];
  float least = std::numeric_limits<float>::infinity();
  if (!to.is_point()) {
    for (const std::uint32_t middle : to.corners) {
      if (from.is_point() || from.has(middle)) least = std::min(least, go_round(a, b, middle));
      if (least <= error_) return;
    }
  }
  far_.push_back({least, a, b});
}

/// From a vertex a that stays, over the third edge of one of its triangles.
bool StepError::pass_from_point(std::uint32_t a, std::uint32_t b) {
  const Foot& to = feet_[b];
  // An edge between two vertices that stay does, too, where the surface is a manifold.
  if (to.is_point() && (within_[a] | within_[b]) != 0) return true;
  const std::uint32_t at = feet_[a].corners[0];
  const Link& link = simplifier_->links().of(at);
  if (link.is_loose()) {
    bool found = false;
    simplifier_->links().for_each_arc(at, [&](std::uint32_t next, std::uint32_t prev) {
      const bool reaches =
          to.is_point() ? to.has(next) || to.has(prev) : to.has(next) && to.has(prev);
      if (reaches && !found && !to.is_point()) once_.add(a, b, {next, prev, next});
      found = found || reaches;
    });
    return found;
  }
  const std::uint32_t places = places_in(link, to.corners);
  if (to.is_point()) return places != 0;
  const std::uint32_t both = one_place_on(link, places) & places;
  if (both == 0) return false;
  const auto place = first_place(both);
  const std::uint32_t next = link.at[place == 0 ? link.count() - 1 : place - 1];
  once_.add(a, b, {next, link.at[place], next});
  return true;
}

/// Another way is looked for later where one of those that were measured is the farthest of all.
void StepError::settle(const Crossings& crossings, std::size_t first, const Float8& square) {
  for (std::size_t i = 0; i < kLanes; ++i) {
    const float distance = std::sqrt(square[i]);
    if (distance > error_)
      far_.push_back({distance, crossings.a[first + i], crossings.b[first + i]});
  }
}

CORNICE_CLONES void StepError::settle_crossings() {
  once_.fill_up(), twice_.fill_up();
  const Float4* const places = simplifier_->places().data();
  const float error = error_;
  VectorLanes a, b, p, q;
  Float8 square;
  for (std::size_t i = 0; i < once_.count; i += kLanes) {
    gather_vectors(fine_.data(), &once_.a[i], a), gather_vectors(fine_.data(), &once_.b[i], b);
    gather_vectors(places, &once_.p[i], p), gather_vectors(places, &once_.q[i], q);
    pass_over_segments(a, b, p, q, square);
    if (or_of_lanes(square > error * error) != 0) settle(once_, i, square);
  }
  for (std::size_t i = 0; i < twice_.count; i += kLanes) {
    gather_vectors(fine_.data(), &twice_.a[i], a), gather_vectors(fine_.data(), &twice_.b[i], b);
    gather_vectors(places, &twice_.p[i], p), gather_vectors(places, &twice_.q[i], q);
    Float8 first;
    pass_over_segments(a, b, p, q, first);
    gather_vectors(places, &twice_.r[i], q);
    pass_over_segments(a, b, p, q, square);
    square = square > first ? square : first;
    if (or_of_lanes(square > error * error) != 0) settle(twice_, i, square);
  }
}

void StepError::begin_part() {
  error_ = 0;
  far_.clear();
}

void StepError::add(std::size_t begin, std::size_t end) {
  list_edges(begin, end);
  find_crossings();
  twice_.count = 0;
  once_.make_room(edge_count_), twice_.make_room(edge_count_);
  const VertexLinks& links = simplifier_->links();
  for (std::size_t i = 0; i < edge_count_; ++i) {
    links.prefetch(edges_[std::min(i + kEdgesAhead, edge_count_ - 1)].middle);
    pass(edges_[i]);
  }
  settle_crossings();
}

/// The farthest first: where the way that is found is nearly as long, no other has to be looked at.
float StepError::end_part() {
  std::sort(far_.begin(), far_.end(), [](const Far& a, const Far& b) {
    return std::tie(b.distance, a.a, a.b) < std::tie(a.distance, b.a, b.b);
  });
  for (const Far& far : far_) {
    if (far.distance <= error_) break;
    error_ = std::max(error_, std::min(far.distance, search(far.a, far.b)));
  }
  return error_;
}

}  // namespace cornice::hlod
