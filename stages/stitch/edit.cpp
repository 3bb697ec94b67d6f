// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/stitch/edit.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <tuple>

#include "core/mesh/select.h"
#include "core/mesh/topology.h"
#include "stages/stitch/mend.h"

namespace cornice::stitch {
namespace {

/// One tile while it is edited.
class Editor {
 public:
  Editor(Mesh& mesh, std::uint32_t number, const Borders& borders, const Plan& plan,
         const SharedAttributes& shared)
      : mesh_(mesh),
        border_(borders.tiles[number]),
        first_vertex_(borders.first_vertex[number]),
        first_edge_(borders.first_edge[number]),
        plan_(plan),
        shared_(shared) {}

  /// Moves the vertices that are there and adds those that are not.
  void place_vertices(const std::vector<std::uint32_t>& places) {
    const std::vector<std::uint32_t> class_of = classes_of(places);
    for (const std::uint32_t i : places) {
      const Place& place = plan_.places[i];
      if (place.edge != kNone) add_vertex(place, class_of[i - places.front()]);
    }
    for (const std::uint32_t i : places) {
      const Place& place = plan_.places[i];
      if (place.edge != kNone) continue;
      const std::uint32_t row = border_.rows[place.a - first_vertex_];
      take_class(row, class_of[i - places.front()]);
    }
  }

  /// Splits the triangles of edges that got vertices, joins the ends of edges that shrink to a
  /// point.
  void change_triangles() {
    split_triangles();
    const std::vector<std::uint32_t> into = collapsed_rows();
    if (into.empty()) return;
    for (Triangle& t : mesh_.triangles) {
      for (std::uint32_t& v : t) v = into[v];
    }
    std::erase_if(mesh_.triangles,
                  [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
  }

  /// Class of each vertex; kNone where no other tile has it.
  const std::vector<std::uint32_t>& row_classes() const { return row_class_; }
  /// Vertices that moved or are new.
  const std::vector<std::uint32_t>& changed_rows() const { return changed_; }

 private:
  /// Class of each place of this tile, in the order of `places`... by position in Plan::places.
  std::vector<std::uint32_t> classes_of(const std::vector<std::uint32_t>& places) {
    row_class_.assign(mesh_.positions.size(), kNone);
    if (places.empty()) return {};
    std::vector<std::uint32_t> found(places.back() - places.front() + 1, kNone);
    std::uint32_t c = static_cast<std::uint32_t>(
        std::upper_bound(plan_.first.begin(), plan_.first.end(), places.front()) -
        plan_.first.begin() - 1);
    for (const std::uint32_t i : places) {
      while (plan_.first[c + 1] <= i) ++c;
      found[i - places.front()] = c;
    }
    return found;
  }

  void take_class(std::uint32_t row, std::uint32_t c) {
    row_class_[row] = c;
    if (plan_.is_exact[c] == 0) {
      mesh_.positions[row] = (plan_.positions[c] - mesh_.origin).cast<float>();
      changed_.push_back(row);
    }
    if (!mesh_.normals.empty() && shared_.normals[c] != Vec3f{}) {
      mesh_.normals[row] = shared_.normals[c];
    }
    for (FloatProperty& p : mesh_.float_properties) {
      for (const FloatProperty& from : shared_.floats) {
        if (from.name == p.name) p.values[row] = from.values[c];
      }
    }
    for (ByteProperty& p : mesh_.byte_properties) {
      for (const ByteProperty& from : shared_.bytes) {
        if (from.name == p.name) p.values[row] = from.values[c];
      }
    }
  }

  void add_vertex(const Place& place, std::uint32_t c) {
    const auto row = static_cast<std::uint32_t>(mesh_.positions.size());
    mesh_.positions.emplace_back();
    // A copy of an end first, for what the class does not know.
    const std::uint32_t end = border_.rows[place.a - first_vertex_];
    if (!mesh_.normals.empty()) mesh_.normals.push_back(Vec3f(mesh_.normals[end]));
    for (FloatProperty& p : mesh_.float_properties) p.values.push_back(float{p.values[end]});
    for (ByteProperty& p : mesh_.byte_properties) p.values.push_back(std::uint8_t{p.values[end]});
    row_class_.push_back(c);
    take_class(row, c);
    const std::uint32_t half_edge = border_.edges[place.edge - first_edge_].half_edge;
    added_.push_back({half_edge, place.t, row});
  }

  void split_triangles() {
    std::sort(added_.begin(), added_.end(), [](const Added& a, const Added& b) {
      return std::tie(a.half_edge, a.t, a.row) < std::tie(b.half_edge, b.t, b.row);
    });
    for (std::size_t i = 0; i < added_.size();) {
      const std::uint32_t t = added_[i].half_edge / 3;
      std::array<std::vector<std::uint32_t>, 3> on_edge;
      for (; i < added_.size() && added_[i].half_edge / 3 == t; ++i) {
        on_edge[added_[i].half_edge % 3].push_back(added_[i].row);
      }
      split(t, on_edge);
    }
  }

  /// The triangle as fans: its first edge with new vertices is seen from the corner opposite.
  ///
  ///         r            p, x1, r keeps the place of the triangle and its edge r-p,
  ///       / | \ \.       the last part has its edge q-r
  ///      p--x1-x2-q
  void split(std::uint32_t t, std::array<std::vector<std::uint32_t>, 3> on_edge) {
    std::uint32_t k = 0;
    while (k < 3 && on_edge[k].empty()) ++k;
    if (k == 3) return;
    const Triangle old = mesh_.triangles[t];
    const std::uint32_t r = old[(k + 2) % 3];
    std::vector<std::uint32_t> along{old[k]};
    along.insert(along.end(), on_edge[k].begin(), on_edge[k].end());
    along.push_back(old[(k + 1) % 3]);
    mesh_.triangles[t] = {along[0], along[1], r};
    for (std::size_t i = 1; i + 1 < along.size(); ++i) {
      mesh_.triangles.push_back({along[i], along[i + 1], r});
    }
    const auto last = static_cast<std::uint32_t>(mesh_.triangles.size() - 1);
    split(last, {std::vector<std::uint32_t>{}, std::move(on_edge[(k + 1) % 3]), {}});
    split(t, {std::vector<std::uint32_t>{}, {}, std::move(on_edge[(k + 2) % 3])});
  }

  /// New row of each vertex; empty where nothing collapses.
  std::vector<std::uint32_t> collapsed_rows() {
    std::vector<std::uint32_t> into;
    for (const BorderEdge& edge : border_.edges) {
      std::uint32_t a = border_.rows[edge.from], b = border_.rows[edge.to];
      if (row_class_[a] == kNone || row_class_[a] != row_class_[b]) continue;
      if (into.empty()) {
        into.resize(mesh_.positions.size());
        std::iota(into.begin(), into.end(), 0u);
      }
      while (into[a] != a) a = into[a];
      while (into[b] != b) b = into[b];
      into[std::max(a, b)] = std::min(a, b);
    }
    for (std::uint32_t v = 0; v < into.size(); ++v) into[v] = into[into[v]];
    for (std::uint32_t& row : changed_) row = into.empty() ? row : into[row];
    return into;
  }

  struct Added {
    std::uint32_t half_edge;
    double t;
    std::uint32_t row;
  };
  Mesh& mesh_;
  const Border& border_;
  const std::uint32_t first_vertex_, first_edge_;
  const Plan& plan_;
  const SharedAttributes& shared_;
  std::vector<std::uint32_t> row_class_;
  std::vector<std::uint32_t> changed_;
  std::vector<Added> added_;
};

/// Drops vertices that lost their triangles, but not those that never had any.
void drop_unused(Mesh& mesh, std::vector<std::uint32_t>& row_class,
                 const std::vector<std::uint8_t>& was_used) {
  std::vector<std::uint8_t> used(mesh.positions.size(), 0);
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t v : t) used[v] = 1;
  }
  std::vector<std::uint32_t> rows, to(used.size(), kNone), classes;
  for (std::uint32_t v = 0; v < used.size(); ++v) {
    if (used[v] == 0 && (v >= was_used.size() || was_used[v] != 0)) continue;
    to[v] = static_cast<std::uint32_t>(rows.size());
    rows.push_back(v);
    classes.push_back(row_class[v]);
  }
  if (rows.size() == used.size()) return;
  Mesh kept = gather_vertices(mesh, rows);
  kept.triangles = std::move(mesh.triangles);
  for (Triangle& t : kept.triangles) {
    for (std::uint32_t& v : t) v = to[v];
  }
  mesh = std::move(kept);
  row_class = std::move(classes);
}

}  // namespace

std::vector<std::vector<std::uint32_t>> places_by_tile(const Borders& borders, const Plan& plan) {
  std::vector<std::vector<std::uint32_t>> places(borders.tiles.size());
  for (std::uint32_t i = 0; i < plan.places.size(); ++i) places[plan.places[i].tile].push_back(i);
  return places;
}

EditedTile edit_tile(Mesh tile, std::uint32_t number, const Borders& borders, const Plan& plan,
                     const std::vector<std::uint32_t>& places, const SharedAttributes& shared) {
  EditedTile edited;
  edited.mesh = std::move(tile);
  Mesh& mesh = edited.mesh;
  Editor editor(mesh, number, borders, plan, shared);
  std::vector<std::uint8_t> was_used(mesh.positions.size(), 0);
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t v : t) was_used[v] = 1;
  }
  editor.place_vertices(places);
  std::vector<std::uint32_t> classes = editor.row_classes();
  if (!editor.changed_rows().empty()) {
    editor.change_triangles();
    edited.flipped_edges = mend_triangles(mesh, editor.changed_rows());
    classes = editor.row_classes();
    drop_unused(mesh, classes, was_used);
  }
  for (std::uint32_t v = 0; v < classes.size(); ++v) {
    if (classes[v] != kNone) edited.shared.emplace_back(v, classes[v]);
  }
  return edited;
}

}  // namespace cornice::stitch
