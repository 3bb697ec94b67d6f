// SPDX-License-Identifier: GPL-3.0-or-later
// What a hierarchy costs when space is split in other ways: quadtree, octree, kd-trees at the
// middle, at the median and into 3, 4 and 5 parts of equal count. Splitting, then from the leaves
// up: children joined, simplified to the size of one of them, kept on disk meanwhile.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "bench/bench_json.h"
#include "bench/programs.h"
#include "bench/value_noise.h"
#include "core/base/error.h"
#include "core/io/ply.h"
#include "hlod/simplify.h"

namespace {

using namespace cornice;
using namespace cornice::bench;

/// Leaves are split until they hold no more: what 16 bits index with room.
constexpr std::size_t kLeafTriangles = 16384;
constexpr int kDeepest = 48;

struct Kind {
  const char* name;
  int halved_axes;  ///< 2: quadtree, 3: octree, 0: one axis, the longest
  int parts;        ///< of equal count; 0: two, cut in the middle
};
constexpr std::array<Kind, 7> kKinds{{{"quadtree", 2, 0},
                                      {"octree", 3, 0},
                                      {"kd", 0, 0},
                                      {"kd_median", 0, 2},
                                      {"kd_3", 0, 3},
                                      {"kd_4", 0, 4},
                                      {"kd_5", 0, 5}}};

/// Ground of 1 m steps with a cliff across it, so that density in plan differs.
Mesh made_ground(std::size_t triangles, std::uint64_t seed) {
  const auto side = static_cast<std::size_t>(std::sqrt(static_cast<double>(triangles) / 2)) + 1;
  Mesh mesh;
  for (std::size_t row = 0; row < side; ++row) {
    for (std::size_t column = 0; column < side; ++column) {
      const auto x = static_cast<double>(column), y = static_cast<double>(row);
      double z = 200 / (1 + std::exp(-(x - 0.5 * static_cast<double>(side) - 0.2 * y) / 4));
      double amplitude = 120, wavelength = 500;
      for (std::uint64_t octave = 0; octave < 7; ++octave) {
        z += amplitude * value_noise(x / wavelength, y / wavelength, seed + octave, 12);
        amplitude *= 0.45, wavelength /= 2.03;
      }
      mesh.positions.push_back(Vec3d{x, y, z}.cast<float>());
    }
  }
  for (std::size_t row = 0; row + 1 < side; ++row) {
    for (std::size_t column = 0; column + 1 < side; ++column) {
      const auto a = static_cast<std::uint32_t>(row * side + column);
      const auto up = a + static_cast<std::uint32_t>(side);
      mesh.triangles.push_back({a, a + 1, up + 1});
      mesh.triangles.push_back({a, up + 1, up});
    }
  }
  return mesh;
}

/// Tiles as one mesh.
Mesh read_tiles(const std::vector<std::filesystem::path>& tiles) {
  Mesh all;
  for (const std::filesystem::path& path : tiles) {
    const Mesh tile = read_ply_mesh(path);
    if (all.positions.empty()) all.origin = tile.origin;
    const Vec3d shift = tile.origin - all.origin;
    const auto first = static_cast<std::uint32_t>(all.positions.size());
    for (const Vec3f& p : tile.positions) {
      all.positions.push_back((p.cast<double>() + shift).cast<float>());
    }
    for (const Triangle& t : tile.triangles) {
      all.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    }
  }
  return all;
}

struct Node {
  std::size_t begin = 0, end = 0;  ///< of the triangles in their order
  int depth = 0;
  Vec3f low, high;  ///< what quadtrees and octrees halve
  std::vector<std::size_t> children;
  std::uint64_t record = 0, record_bytes = 0;  ///< its mesh on disk
};

/// A tree over the triangles of a mesh.
class Tree {
 public:
  Tree(const Mesh& mesh, const Kind& kind) : mesh_(mesh), kind_(kind) {
    order_.resize(mesh.triangles.size());
    for (std::uint32_t t = 0; t < order_.size(); ++t) order_[t] = t;
    Node root;
    root.end = order_.size();
    root.low = root.high = mesh.positions.front();
    for (const Vec3f& p : mesh.positions) {
      for (int k = 0; k < 3; ++k) {
        axis(root.low, k) = std::min(axis(root.low, k), axis(p, k));
        axis(root.high, k) = std::max(axis(root.high, k), axis(p, k));
      }
    }
    // Cells are squares or cubes, as in the hierarchy.
    const Vec3f size = root.high - root.low;
    const float side = std::max({size.x, size.y, kind.halved_axes == 3 ? size.z : 0.0f}) * 1.0001f;
    if (kind.halved_axes > 0) root.high = root.low + Vec3f{side, side, side};
    nodes_.push_back(root);
    for (std::size_t n = 0; n < nodes_.size(); ++n) {
      const bool splits =
          nodes_[n].end - nodes_[n].begin > kLeafTriangles && nodes_[n].depth < kDeepest;
      if (splits) split(n);
    }
  }

  std::vector<Node>& nodes() { return nodes_; }
  const std::vector<std::uint32_t>& order() const { return order_; }

 private:
  static float& axis(Vec3f& v, int k) { return k == 0 ? v.x : k == 1 ? v.y : v.z; }
  static float axis(const Vec3f& v, int k) { return k == 0 ? v.x : k == 1 ? v.y : v.z; }

  /// Three times the barycentre.
  Vec3f centre(std::uint32_t t) const {
    const Triangle& c = mesh_.triangles[t];
    return mesh_.positions[c[0]] + mesh_.positions[c[1]] + mesh_.positions[c[2]];
  }

  void split(std::size_t n) {
    if (kind_.halved_axes > 0) return halve_axes(n);
    const auto begin = order_.begin() + static_cast<std::ptrdiff_t>(nodes_[n].begin);
    const auto end = order_.begin() + static_cast<std::ptrdiff_t>(nodes_[n].end);
    Vec3f low = centre(*begin), high = low;
    for (auto t = begin; t != end; ++t) {
      const Vec3f c = centre(*t);
      for (int k = 0; k < 3; ++k) {
        axis(low, k) = std::min(axis(low, k), axis(c, k));
        axis(high, k) = std::max(axis(high, k), axis(c, k));
      }
    }
    const Vec3f size = high - low;
    const int longest = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    if (kind_.parts == 0) {
      const float middle = 0.5f * (axis(low, longest) + axis(high, longest));
      const auto cut = std::partition(
          begin, end, [&](std::uint32_t t) { return axis(centre(t), longest) < middle; });
      add_child(n, nodes_[n].begin, static_cast<std::size_t>(cut - order_.begin()));
      add_child(n, static_cast<std::size_t>(cut - order_.begin()), nodes_[n].end);
      return;
    }
    const std::size_t count = nodes_[n].end - nodes_[n].begin;
    const auto parts = static_cast<std::size_t>(kind_.parts);
    auto from = begin;
    for (std::size_t part = 1; part <= parts; ++part) {
      const auto to = begin + static_cast<std::ptrdiff_t>(count * part / parts);
      if (to != end) {
        std::nth_element(from, to, end, [&](std::uint32_t a, std::uint32_t b) {
          return std::pair(axis(centre(a), longest), a) < std::pair(axis(centre(b), longest), b);
        });
      }
      add_child(n, static_cast<std::size_t>(from - order_.begin()),
                static_cast<std::size_t>(to - order_.begin()));
      from = to;
    }
  }

  void halve_axes(std::size_t n) {
    const Node node = nodes_[n];
    const Vec3f middle = 0.5f * (node.low + node.high);
    const auto place = [&](std::uint32_t t) {
      const Vec3f c = centre(t);
      int p = 0;
      for (int k = 0; k < kind_.halved_axes; ++k) p |= (axis(c, k) >= 3 * axis(middle, k)) << k;
      return p;
    };
    std::array<std::size_t, 9> begins{};
    for (std::size_t i = node.begin; i < node.end; ++i) ++begins[place(order_[i]) + 1];
    for (std::size_t p = 0; p < 8; ++p) begins[p + 1] += begins[p];
    std::vector<std::uint32_t> sorted(node.end - node.begin);
    std::array<std::size_t, 9> next = begins;
    for (std::size_t i = node.begin; i < node.end; ++i) {
      sorted[next[place(order_[i])]++] = order_[i];
    }
    std::copy(sorted.begin(), sorted.end(),
              order_.begin() + static_cast<std::ptrdiff_t>(node.begin));
    for (int p = 0; p < 8; ++p) {
      const std::size_t child = nodes_.size();
      if (!add_child(n, node.begin + begins[p], node.begin + begins[p + 1])) continue;
      for (int k = 0; k < 3; ++k) {
        axis(nodes_[child].low, k) = (p >> k & 1) != 0 ? axis(middle, k) : axis(node.low, k);
        axis(nodes_[child].high, k) = (p >> k & 1) != 0 ? axis(node.high, k) : axis(middle, k);
      }
    }
  }

  bool add_child(std::size_t n, std::size_t begin, std::size_t end) {
    if (begin == end) return false;
    Node child;
    child.begin = begin, child.end = end, child.depth = nodes_[n].depth + 1;
    nodes_[n].children.push_back(nodes_.size());
    nodes_.push_back(child);
    return true;
  }

  const Mesh& mesh_;
  const Kind& kind_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;  ///< parents before their children
};

/// Meshes of nodes on disk, as vertices with their numbers and triangles.
class Records {
 public:
  explicit Records(const std::filesystem::path& path)
      : file_(path, std::ios::binary | std::ios::in | std::ios::out | std::ios::trunc) {}

  void write(Node& node, const std::vector<std::uint32_t>& vertices, const Mesh& mesh,
             const std::vector<Triangle>& triangles) {
    std::vector<Vec3f> positions;
    for (const std::uint32_t v : vertices) positions.push_back(mesh.positions[v]);
    const std::array<std::uint64_t, 2> counts{vertices.size(), triangles.size()};
    node.record = end_;
    file_.seekp(static_cast<std::streamoff>(end_));
    put(counts.data(), sizeof counts);
    put(vertices.data(), vertices.size() * sizeof(std::uint32_t));
    put(positions.data(), positions.size() * sizeof(Vec3f));
    put(triangles.data(), triangles.size() * sizeof(Triangle));
    node.record_bytes = end_ - node.record;
    live_ += node.record_bytes;
    peak_ = std::max(peak_, live_);
  }
  /// Appends the triangles, by the numbers of the mesh, and gives the record's room back.
  void take(const Node& node, std::vector<Triangle>& triangles) {
    file_.seekg(static_cast<std::streamoff>(node.record));
    std::array<std::uint64_t, 2> counts{};
    get(counts.data(), sizeof counts);
    std::vector<std::uint32_t> vertices(counts[0]);
    std::vector<Vec3f> positions(counts[0]);
    std::vector<Triangle> own(counts[1]);
    get(vertices.data(), vertices.size() * sizeof(std::uint32_t));
    get(positions.data(), positions.size() * sizeof(Vec3f));
    get(own.data(), own.size() * sizeof(Triangle));
    for (const Triangle& t : own) {
      triangles.push_back({vertices[t[0]], vertices[t[1]], vertices[t[2]]});
    }
    live_ -= node.record_bytes;
  }
  std::uint64_t peak() const { return peak_; }

 private:
  void put(const void* from, std::size_t bytes) {
    file_.write(static_cast<const char*>(from), static_cast<std::streamsize>(bytes));
    if (!file_) throw RunError("", "the scratch folder is full");
    end_ += bytes;
  }
  void get(void* to, std::size_t bytes) {
    file_.read(static_cast<char*>(to), static_cast<std::streamsize>(bytes));
  }

  std::fstream file_;
  std::uint64_t end_ = 0, live_ = 0, peak_ = 0;
};

/// Seconds of this process's processor so far: others may be busy.
double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// From the leaves up.
class Hierarchy {
 public:
  Hierarchy(const Mesh& mesh, Tree& tree, bool in_plan, const std::filesystem::path& scratch)
      : mesh_(mesh), tree_(tree), in_plan_(in_plan), records_(scratch) {
    first_.assign(mesh.positions.size(), ~std::size_t{0});
    last_.assign(mesh.positions.size(), 0);
    for (std::size_t i = 0; i < tree.order().size(); ++i) {
      for (const std::uint32_t v : mesh.triangles[tree.order()[i]]) {
        first_[v] = std::min(first_[v], i);
        last_[v] = std::max(last_[v], i);
      }
    }
    local_.assign(mesh.positions.size(), hlod::kNone);
  }

  void build() {
    std::vector<Node>& nodes = tree_.nodes();
    for (Node& node : nodes) {
      if (node.children.empty()) write_leaf(node);
    }
    for (std::size_t n = nodes.size(); n-- > 0;) {
      if (!nodes[n].children.empty()) write_parent(nodes[n]);
    }
  }

  std::uint64_t triangles = 0;  ///< of all nodes
  std::uint64_t locked = 0, leaf_vertices = 0;
  std::uint64_t disk() const { return records_.peak(); }

 private:
  void write_leaf(Node& node) {
    std::vector<Triangle> own;
    for (std::size_t i = node.begin; i < node.end; ++i) {
      own.push_back(mesh_.triangles[tree_.order()[i]]);
    }
    const std::vector<std::uint32_t> vertices = make_local(own);
    leaf_vertices += vertices.size();
    for (const std::uint32_t v : vertices) locked += is_outside(node, v);
    triangles += own.size();
    records_.write(node, vertices, mesh_, own);
  }

  void write_parent(Node& node) {
    std::vector<Triangle> all;
    for (const std::size_t child : node.children) records_.take(tree_.nodes()[child], all);
    std::vector<std::uint32_t> vertices = make_local(all);
    hlod::SimplifyMesh block;
    for (const std::uint32_t v : vertices) {
      block.positions.push_back(mesh_.positions[v] - mesh_.positions[vertices.front()]);
      block.locked.push_back(is_outside(node, v));
    }
    block.triangles = std::move(all);
    const std::size_t target = block.triangles.size() / node.children.size();
    if (node.children.size() > 1) {
      simplifier_.run(block, {.target_triangles = target, .in_plan = in_plan_});
      std::erase_if(block.triangles, [](const Triangle& t) { return t[0] == hlod::kNone; });
    }
    triangles += block.triangles.size();
    for (Triangle& t : block.triangles) t = {vertices[t[0]], vertices[t[1]], vertices[t[2]]};
    vertices = make_local(block.triangles);
    records_.write(node, vertices, mesh_, block.triangles);
  }

  bool is_outside(const Node& node, std::uint32_t vertex) const {
    return first_[vertex] < node.begin || last_[vertex] >= node.end;
  }

  /// Names vertices by first use; returns their numbers in the mesh.
  std::vector<std::uint32_t> make_local(std::vector<Triangle>& own) {
    std::vector<std::uint32_t> vertices;
    for (Triangle& t : own) {
      for (std::uint32_t& v : t) {
        if (local_[v] == hlod::kNone) {
          local_[v] = static_cast<std::uint32_t>(vertices.size());
          vertices.push_back(v);
        }
        v = local_[v];
      }
    }
    for (const std::uint32_t v : vertices) local_[v] = hlod::kNone;
    return vertices;
  }

  const Mesh& mesh_;
  Tree& tree_;
  bool in_plan_;
  Records records_;
  hlod::Simplifier simplifier_;
  std::vector<std::size_t> first_, last_;  ///< places in the order of a vertex's triangles
  std::vector<std::uint32_t> local_;
};

struct Own {
  std::vector<std::filesystem::path> meshes;
  std::string only;
};

/// One way to split, in a process of its own for its peak of memory; figures to standard output.
void measure_one(const Mesh& mesh, const Kind& kind, const std::filesystem::path& scratch) {
  const double start = cpu_seconds();
  Tree tree(mesh, kind);
  const double split = cpu_seconds() - start;
  Hierarchy hierarchy(mesh, tree, kind.halved_axes == 2, scratch);
  hierarchy.build();
  const double all = cpu_seconds() - start;
  double leaves = 0, sum = 0, squares = 0, depths = 0, shallowest = 1e9, deepest = 0;
  for (const Node& node : tree.nodes()) {
    if (!node.children.empty()) continue;
    const auto count = static_cast<double>(node.end - node.begin);
    leaves += 1, sum += count, squares += count * count, depths += node.depth;
    shallowest = std::min<double>(shallowest, node.depth);
    deepest = std::max<double>(deepest, node.depth);
  }
  const double mean = sum / leaves;
  const auto say = [](const char* name, double value) {
    std::cout << name << ' ' << value << '\n';
  };
  say("split_s", split);
  say("all_s", all);
  say("leaves", leaves);
  say("leaf_triangles_mean", mean);
  say("leaf_triangles_deviation", std::sqrt(std::max(0.0, squares / leaves - mean * mean)));
  say("leaf_depth_mean", depths / leaves);
  say("leaf_depth_min", shallowest);
  say("leaf_depth_max", deepest);
  say("border_vertices_share",
      static_cast<double>(hierarchy.locked) / static_cast<double>(hierarchy.leaf_vertices));
  say("triangles_ratio", static_cast<double>(hierarchy.triangles) / sum);
  say("disk_peak_mib", static_cast<double>(hierarchy.disk()) / 0x1p20);
}

void measure(const Options& options, const Own& own, Result& result) {
  const ScratchFolder folder("partition");
  const auto mesh_of = [&] {
    if (!own.meshes.empty()) return read_tiles(own.meshes);
    return made_ground(options.quick ? 300'000 : 5'000'000, options.seed);
  };
  if (!own.only.empty()) {
    const auto kind = std::find_if(kKinds.begin(), kKinds.end(),
                                   [&](const Kind& k) { return own.only == k.name; });
    measure_one(mesh_of(), *kind, folder / "records");
    return;
  }
  result.parameter("leaf_triangles", static_cast<std::int64_t>(kLeafTriangles));
  result.parameter("mesh",
                   own.meshes.empty() ? std::string("made") : own.meshes[0].filename().string());
  for (const Kind& kind : kKinds) {
    std::vector<std::string> words{own_folder() / "bench-partition", "--only", kind.name, "--seed",
                                   std::to_string(options.seed)};
    if (options.quick) words.push_back("--quick");
    if (!own.meshes.empty()) words.push_back("--mesh");
    for (const auto& mesh : own.meshes) words.push_back(mesh.string());
    const ProgramCost cost = run_program(words, folder / "log");
    std::ifstream log(folder / "log");
    for (std::string line; std::getline(log, line);) {
      std::istringstream text(line);
      std::string name;
      double value = 0;
      if (text >> name >> value) result.figure(std::string(kind.name) + "_" + name, value);
    }
    result.figure(std::string(kind.name) + "_memory_peak_mib",
                  static_cast<double>(cost.peak_resident_bytes) / 0x1p20);
  }
}

}  // namespace

int main(int argc, char** argv) {
  Own own;
  std::vector<std::string> names;
  for (const Kind& kind : kKinds) names.emplace_back(kind.name);
  return run(
      "partition", "Ways to split space for a hierarchy: time, balance, disk and memory", argc,
      argv,
      [&](CLI::App& app) {
        app.add_option("--mesh", own.meshes, "PLY meshes, tiles of one, instead of a made one");
        app.add_option("--only", own.only, "one way alone, its figures as lines")
            ->check(CLI::IsMember(names));
      },
      [&](const Options& options, Result& result) { measure(options, own, result); });
}
