// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/file_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>

#include "core/base/error.h"
#include "core/base/parallel.h"

namespace cornice::hlod {
namespace {

constexpr std::size_t kExamples = 10;
/// Blocks read at one time: bounds the memory, and keeps every thread busy.
constexpr std::size_t kBatch = 256;

bool is_before(LatticePoint a, LatticePoint b) {
  return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
}

/// What a vertex's position says of its parent.
struct Link {
  LatticePoint own, parent;
  CellKey cell;
};

using Corners = std::array<LatticePoint, 3>;

Corners turned(Corners t) {
  std::rotate(t.begin(), std::min_element(t.begin(), t.end(), is_before), t.end());
  return t;
}
bool is_degenerate(const Corners& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

/// A sum over triangles that does not depend on their order: cells are compared by it.
std::uint64_t mixed(const Corners& corners) {
  std::uint64_t hash = 0x9e3779b97f4a7c15ULL;
  for (const LatticePoint p : turned(corners)) {
    for (const std::int32_t c : {p.x, p.y, p.z}) {
      hash = (hash ^ static_cast<std::uint32_t>(c)) * 0xff51afd7ed558ccdULL;
      hash ^= hash >> 32;
    }
  }
  return hash;
}

/// Triangles of a cell: count and sum.
struct Trace {
  std::uint64_t count = 0, sum = 0;

  void add(const Corners& t) { ++count, sum += mixed(t); }
  friend bool operator==(const Trace&, const Trace&) = default;
};

/// What one block contributes.
struct BlockFacts {
  std::optional<std::string> damage;
  FileCheck counts;
  std::vector<Link> links;
  Trace own, parents;  ///< its triangles, and what becomes of them a level above
};

class BlockChecker {
 public:
  BlockChecker(const Header& header, const CellMesh& mesh, BlockFacts& facts)
      : header_(header), mesh_(mesh), facts_(facts) {
    // Steps of the mesh's level; shares are rounded up as Metric's are.
    side_ = std::int64_t{1} << header.lattice.cell_bits;
    share_ = static_cast<std::int64_t>(std::ceil(header.edge_share * static_cast<double>(side_)));
  }

  void run() {
    for (std::size_t v = 0; v < mesh_.vertices.size(); ++v) check_vertex(v);
    for (const auto& t : mesh_.triangles) check_triangle(t);
  }

 private:
  bool is_octree() const { return header_.partition == Partition::kOctree; }
  LatticePoint parent(std::size_t v) const { return mesh_.parents[mesh_.parent_of[v]].position; }
  void fault(std::uint64_t FileCheck::*count, const std::string& problem) {
    if (facts_.counts.*count == 0) {
      facts_.counts.examples.push_back(cell_name(mesh_.key) + ": " + problem);
    }
    ++(facts_.counts.*count);
  }
  std::int64_t distance(LatticePoint a, LatticePoint b) const {
    const std::int64_t plan =
        std::max(std::abs(std::int64_t{a.x} - b.x), std::abs(std::int64_t{a.y} - b.y));
    return is_octree() ? std::max(plan, std::abs(std::int64_t{a.z} - b.z)) : plan;
  }
  std::int64_t outside(std::int32_t x, std::int32_t index) const {
    const std::int64_t low = index * side_;
    return std::max({std::int64_t{0}, low - x, x - low - side_});
  }

  void check_vertex(std::size_t v) {
    const LatticePoint p = mesh_.vertices[v].position;
    std::int64_t off = std::max(outside(p.x, mesh_.key.i), outside(p.y, mesh_.key.j));
    if (is_octree()) off = std::max(off, outside(p.z, mesh_.key.k));
    if (off > share_) fault(&FileCheck::far_vertices, "a vertex lies too far outside");
    if (mesh_.key.level == 0) return;
    facts_.links.push_back({p, parent(v), mesh_.key});
    if (2 * distance(p, refined(parent(v))) > share_) {
      fault(&FileCheck::far_parents, "a vertex is too far from its parent");
    }
  }

  void check_triangle(const std::array<std::uint16_t, 3>& t) {
    Corners own, up;
    for (std::size_t c = 0; c < 3; ++c) {
      own[c] = mesh_.vertices[t[c]].position;
      if (mesh_.key.level > 0) up[c] = parent(t[c]);
    }
    if (is_degenerate(own)) {
      fault(&FileCheck::degenerate_triangles, "a triangle has two corners at one position");
    }
    for (std::size_t c = 0; c < 3; ++c) {
      if (distance(own[c], own[(c + 1) % 3]) > share_) {
        fault(&FileCheck::long_edges, "an edge is too long");
      }
    }
    facts_.own.add(own);
    if (mesh_.key.level > 0 && !is_degenerate(up)) facts_.parents.add(up);
  }

  const Header& header_;
  const CellMesh& mesh_;
  BlockFacts& facts_;
  std::int64_t side_, share_;
};

BlockFacts facts_of(const File& file, const Node& node) {
  BlockFacts facts;
  try {
    const CellMesh mesh = file.read(node);
    BlockChecker(file.header(), mesh, facts).run();
  } catch (const InputError& error) {
    facts.damage = error.problem();
  }
  facts.counts.cells = node.part == 0 ? 1 : 0;
  facts.counts.triangles = node.triangles;
  facts.counts.vertices = node.vertices;
  return facts;
}

/// Puts the blocks' facts together, finest level first.
class FileChecker {
 public:
  FileChecker(const File& file, int threads, Progress& progress)
      : file_(file), threads_(threads), progress_(progress) {}

  FileCheck run() {
    const auto& nodes = file_.nodes();
    progress_.begin("checking blocks", nodes.size());
    std::size_t end = nodes.size();
    for (int level = file_.header().lattice.finest_level; level >= 0; --level) {
      std::size_t begin = end;
      while (begin > 0 && nodes[begin - 1].key.level == level) --begin;
      check_level(begin, end);
      end = begin;
    }
    check_errors();
    progress_.end();
    return std::move(check_);
  }

 private:
  void example(const std::string& text) {
    if (check_.examples.size() < kExamples) check_.examples.push_back(text);
  }

  void check_level(std::size_t begin, std::size_t end) {
    std::map<CellKey, Trace> own, parents;
    std::vector<Link> links;
    for (std::size_t first = begin; first < end; first += kBatch) {
      check_cancelled(progress_);
      const std::size_t count = std::min(kBatch, end - first);
      std::vector<BlockFacts> facts(count);
      parallel_for(count, 1, threads_, [&](std::size_t from, std::size_t to) {
        for (std::size_t n = from; n < to; ++n) {
          facts[n] = facts_of(file_, file_.nodes()[first + n]);
        }
      });
      for (std::size_t n = 0; n < count; ++n) {
        const CellKey key = file_.nodes()[first + n].key;
        add(facts[n]);
        own[key].count += facts[n].own.count, own[key].sum += facts[n].own.sum;
        if (key.level > 0 && facts[n].parents.count > 0) {
          Trace& above = parents[key.parent()];
          above.count += facts[n].parents.count, above.sum += facts[n].parents.sum;
        }
        links.insert(links.end(), facts[n].links.begin(), facts[n].links.end());
      }
      progress_.advance(count);
    }
    compare_triangles(own);
    from_children_ = std::move(parents);
    check_links(links);
  }

  void add(const BlockFacts& facts) {
    const FileCheck& c = facts.counts;
    check_.cells += c.cells, check_.triangles += c.triangles, check_.vertices += c.vertices;
    check_.far_vertices += c.far_vertices, check_.long_edges += c.long_edges;
    check_.far_parents += c.far_parents, check_.degenerate_triangles += c.degenerate_triangles;
    for (const std::string& text : c.examples) example(text);
    if (!facts.damage) return;
    ++check_.damaged_blocks;
    example(*facts.damage);
  }

  /// The triangles of a cell are those of its children with their vertices at their parents.
  void compare_triangles(const std::map<CellKey, Trace>& own) {
    if (is_finest_) {
      is_finest_ = false;
      return;
    }
    const auto differ = [&](const CellKey& key) {
      ++check_.unlike_triangles;
      example(cell_name(key) + ": its triangles are not its children's");
    };
    for (const auto& [key, trace] : own) {
      const auto found = from_children_.find(key);
      if (!(trace == (found == from_children_.end() ? Trace{} : found->second))) differ(key);
    }
    for (const auto& [key, trace] : from_children_) {
      if (!own.contains(key)) differ(key);
    }
  }

  void check_links(std::vector<Link>& links) {
    std::sort(links.begin(), links.end(),
              [](const Link& a, const Link& b) { return is_before(a.own, b.own); });
    for (std::size_t n = 1; n < links.size(); ++n) {
      if (links[n].own != links[n - 1].own || links[n].parent == links[n - 1].parent) continue;
      ++check_.double_parents;
      example(cell_name(links[n].cell) + ": a vertex has another parent than in " +
              cell_name(links[n - 1].cell));
    }
  }

  /// A cell's error, the largest of its parts', is never below a child's.
  void check_errors() {
    std::map<CellKey, float> errors;
    for (const Node& node : file_.nodes()) {
      float& error = errors.emplace(node.key, 0.0f).first->second;
      error = std::max(error, node.error_m);
    }
    for (const auto& [key, error] : errors) {
      if (key.level == 0) continue;
      const auto parent = errors.find(key.parent());
      if (parent == errors.end() || parent->second >= error) continue;
      ++check_.falling_errors;
      example(cell_name(parent->first) + ": its error is below a child's");
    }
  }

  const File& file_;
  int threads_;
  Progress& progress_;
  FileCheck check_;
  bool is_finest_ = true;
  std::map<CellKey, Trace> from_children_;
};

}  // namespace

FileCheck check_file(const File& file, int threads, Progress& progress) {
  return FileChecker(file, threads, progress).run();
}

}  // namespace cornice::hlod
