// SPDX-License-Identifier: GPL-3.0-or-later
// The bytes of a cell part; docs/formats/hlod.md, "Blocks".
#include <algorithm>
#include <cassert>
#include <string>

#include "core/base/error.h"
#include "hlod/codec_bytes.h"
#include "hlod/codec_fields.h"
#include "hlod/codec_predict.h"
#include "hlod/file.h"
#include "hlod/octahedral.h"

namespace cornice::hlod {
namespace {

constexpr std::uint32_t kBlockVersion = 1;
constexpr std::uint16_t kNoParent = 0xffff;
/// |coordinate| of a point, steps of its level.
constexpr std::int32_t kPositionLimit = 1 << 30;

/// How a vertex names its parent. "Settles": the parent lies at this vertex's coarsened position,
/// and is the first of its children to do so.
enum ParentCode : std::uint8_t {
  kFresh = 0,           ///< the next new parent, settled by this vertex
  kSameAs = 1,          ///< 1, 2, 3: the parent of reference a, b, o
  kFreshElsewhere = 4,  ///< the next new parent, not settled
  kSameAsSettled = 5,   ///< 5, 6, 7: as 1, 2, 3, settled by this vertex
  kFarParent = 8,       ///< named in the list of far parents
  kFarParentSettled = 9,
};

bool in_limits(LatticePoint p, std::int32_t limit) {
  return std::abs(std::int64_t{p.x}) < limit && std::abs(std::int64_t{p.y}) < limit &&
         std::abs(std::int64_t{p.z}) < limit;
}

// ---- Two small codes a byte, the first in the low half.

template <class Code>
std::vector<std::uint8_t> paired(const std::vector<Code>& codes) {
  std::vector<std::uint8_t> bytes((codes.size() + 1) / 2);
  const auto bits = [&](std::size_t i) { return static_cast<unsigned>(codes[i]); };
  for (std::size_t i = 0; i < codes.size() / 2; ++i) {
    bytes[i] = static_cast<std::uint8_t>(bits(2 * i) | bits(2 * i + 1) << 4);
  }
  if (codes.size() % 2 == 1) bytes.back() = static_cast<std::uint8_t>(bits(codes.size() - 1));
  return bytes;
}

template <class Code>
std::vector<Code> read_paired(BlockReader& block, std::size_t count) {
  std::vector<std::uint8_t> bytes((count + 1) / 2);
  block.stream(bytes);
  std::vector<Code> codes(count);
  for (std::size_t i = 0; i < count; ++i) {
    codes[i] = static_cast<Code>(bytes[i / 2] >> (i % 2 * 4) & 15);
  }
  return codes;
}

void write_far(BlockWriter& block, const std::vector<std::uint16_t>& far) {
  write_codes(block, far, 16);
}

std::vector<std::uint16_t> read_far(BlockReader& block, std::size_t count) {
  std::vector<std::uint32_t> codes(count);
  read_codes(block, codes, 16);
  std::vector<std::uint16_t> far(count);
  std::transform(codes.begin(), codes.end(), far.begin(),
                 [](std::uint32_t code) { return static_cast<std::uint16_t>(code); });
  return far;
}

// ---- Positions.

/// Calls code(list, v, coordinate, guess) for the coordinates of a vertex in the order in which
/// they become known, the one along axis() last.
template <std::size_t kAxis, class Code>
void code_vertex(const PositionGuess& guess, std::size_t v, Triple& position, const Code& code) {
  constexpr std::size_t s = (kAxis + 1) % 3, t = (kAxis + 2) % 3;
  code(0, v, position[s], guess.flat(s));
  code(1, v, position[t], guess.flat(t));
  code(2, v, position[kAxis], guess.last<kAxis>(position));
}

/// The same for every vertex but the first; code() stores or fills in the coordinate.
template <class Code>
void for_each_coordinate(std::vector<Triple>& positions, std::span<const SmallTriangle> references,
                         const Code& code) {
  for (std::size_t v = 1; v < positions.size(); ++v) {
    const SmallTriangle& r = references[v];
    const PositionGuess guess(positions[r[0]], positions[r[1]], positions[r[2]]);
    if (guess.axis() == 2) {
      code_vertex<2>(guess, v, positions[v], code);
    } else if (guess.axis() == 1) {
      code_vertex<1>(guess, v, positions[v], code);
    } else {
      code_vertex<0>(guess, v, positions[v], code);
    }
  }
}

void write_positions(BlockWriter& block, std::span<const CellVertex> vertices,
                     std::span<const SmallTriangle> references) {
  if (vertices.empty()) return;
  std::vector<Triple> positions(vertices.size());
  for (std::size_t v = 0; v < vertices.size(); ++v) positions[v] = triple(vertices[v].position);
  for (const std::int32_t c : positions[0]) block.signed_number(c);
  std::array<std::vector<std::uint32_t>, 3> codes;
  for (auto& list : codes) list.resize(vertices.size());
  for_each_coordinate(positions, references,
                      [&](std::size_t list, std::size_t v, std::int32_t value, std::int32_t guess) {
                        codes[list][v] = zigzag(wrapped(value) - wrapped(guess));
                      });
  for (const auto& list : codes) write_codes(block, std::span(list).subspan(1), 32);
}

void read_positions(BlockReader& block, std::span<CellVertex> vertices,
                    std::span<const SmallTriangle> references) {
  if (vertices.empty()) return;
  std::vector<Triple> positions(vertices.size());
  for (std::int32_t& c : positions[0]) c = block.signed_number();
  std::array<std::vector<std::uint32_t>, 3> codes;
  for (auto& list : codes) {
    list.resize(vertices.size());
    read_codes(block, std::span(list).subspan(1), 32);
  }
  for_each_coordinate(
      positions, references,
      [&](std::size_t list, std::size_t v, std::int32_t& value, std::int32_t guess) {
        value = static_cast<std::int32_t>(wrapped(guess) + unzigzag(codes[list][v]));
      });
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    vertices[v].position = {positions[v][0], positions[v][1], positions[v][2]};
  }
}

// ---- Parents. `like` of a parent is the child whose attributes it most likely has: the one that
// settles it, else its first.

std::vector<PackedNormal> normals_of(std::span<const CellVertex> vertices,
                                     std::span<const std::uint16_t> which) {
  std::vector<PackedNormal> normals(which.size());
  std::transform(which.begin(), which.end(), normals.begin(),
                 [&](std::uint16_t v) { return vertices[v].normal; });
  return normals;
}

/// Parents in order of their first child, as a walk over the vertices finds them.
struct ParentPlan {
  // 16 bits for all: what is written as bytes could be a vector's own words.
  std::vector<std::uint16_t> codes;  ///< one per vertex
  std::vector<std::uint16_t> far;
  std::vector<std::uint16_t> order;  ///< order[new number] = old number
  std::vector<std::uint16_t> like;
  std::vector<std::uint16_t> is_settled;
};

/// Codes by which reference has the same parent (3: none), plus 4 where the parent is new, plus 8
/// where the vertex settles it.
constexpr std::array<std::uint8_t, 16> kParentCodes = [] {
  std::array<std::uint8_t, 16> codes{};
  for (std::uint8_t which = 0; which < 4; ++which) {
    codes[which] = static_cast<std::uint8_t>(kSameAs + which);
    codes[which | 4u] = kFreshElsewhere;
    codes[which | 8u] = static_cast<std::uint8_t>(kSameAsSettled + which);
    codes[which | 12u] = kFresh;
  }
  codes[3] = kFarParent;
  codes[3 | 8] = kFarParentSettled;
  return codes;
}();

/// Without branches, for nothing of a vertex can be foretold from the one before it.
ParentPlan plan_parents(const CellMesh& mesh, std::span<const CellVertex> vertices,
                        const WalkResult& walk) {
  const std::size_t vertex_count = vertices.size(), parent_count = mesh.parents.size();
  ParentPlan plan;
  plan.codes.resize(vertex_count);
  plan.far.resize(vertex_count + 1);
  // One more for what is not kept.
  plan.order.resize(parent_count + 1);
  plan.like.resize(parent_count + 1);
  plan.is_settled.resize(parent_count + 1, 0);
  std::vector<std::uint16_t> number(parent_count, kNoParent), parent(vertex_count);
  std::uint32_t known = 0, far = 0;
  for (std::uint32_t v = 0; v < vertex_count; ++v) {
    const std::uint16_t old = mesh.parent_of[walk.order[v]];
    const LatticePoint at = mesh.parents[old].position, near = coarsened(vertices[v].position);
    const unsigned fits = ((at.x ^ near.x) | (at.y ^ near.y) | (at.z ^ near.z)) == 0;
    const unsigned is_new = number[old] == kNoParent;
    const std::uint32_t id = number[old] ^ ((number[old] ^ known) & (0u - is_new));
    number[old] = static_cast<std::uint16_t>(id);
    plan.order[known] = old;
    plan.like[known] = static_cast<std::uint16_t>(v);
    known += is_new;
    const unsigned settles = fits & ~std::uint32_t{plan.is_settled[id]};
    plan.is_settled[id] = static_cast<std::uint16_t>(plan.is_settled[id] | settles);
    plan.like[id] =
        static_cast<std::uint16_t>(plan.like[id] ^ ((plan.like[id] ^ v) & (0u - settles)));
    const SmallTriangle& r = walk.references[v];
    // The vertex before the first is itself, and a new parent is nobody's yet.
    const unsigned not_a = parent[r[0]] != id, not_b = parent[r[1]] != id,
                   not_o = parent[r[2]] != id;
    const unsigned which = not_a + (not_a & not_b) + (not_a & not_b & not_o);
    parent[v] = static_cast<std::uint16_t>(id);
    plan.codes[v] = kParentCodes[which | is_new << 2 | settles << 3];
    plan.far[far] = static_cast<std::uint16_t>(known - 1 - id);
    far += static_cast<unsigned>(which == 3) & ~is_new;
  }
  plan.far.resize(far);
  plan.order.resize(known), plan.like.resize(known), plan.is_settled.resize(known);
  return plan;
}

void write_parents(BlockWriter& block, const CellMesh& mesh, std::span<const CellVertex> vertices,
                   const WalkResult& walk, const Header& header) {
  const ParentPlan plan = plan_parents(mesh, vertices, walk);
  assert(plan.order.size() == mesh.parents.size() && "every parent has a child in the cell");
  block.number(static_cast<std::uint32_t>(plan.far.size()));
  block.stream(paired(plan.codes));
  write_far(block, plan.far);
  std::vector<CellVertex> parents(plan.order.size());
  std::array<std::vector<std::uint32_t>, 3> strays;
  for (std::size_t p = 0; p < parents.size(); ++p) {
    parents[p] = mesh.parents[plan.order[p]];
    if (plan.is_settled[p]) continue;
    const Triple at = triple(parents[p].position);
    const Triple guess = triple(coarsened(vertices[plan.like[p]].position));
    for (std::size_t c = 0; c < 3; ++c) {
      strays[c].push_back(zigzag(wrapped(at[c]) - wrapped(guess[c])));
    }
  }
  for (const auto& list : strays) write_codes(block, list, 32);
  write_normals(block, parents, normals_of(vertices, plan.like), header.normal_bits);
  write_channels_near(block, parents, vertices, plan.like, header.attributes);
}

/// Reads the codes and gives every vertex its parent's number; false where they
/// make no sense.
class ParentReader {
 public:
  ParentReader(CellMesh& mesh, std::span<const SmallTriangle> references, std::size_t parent_count)
      : mesh_(mesh), references_(references), parent_count_(parent_count) {
    mesh_.parent_of.resize(mesh.vertices.size());
    mesh_.parents.resize(parent_count);
    like_.reserve(parent_count);
    is_settled_.reserve(parent_count);
  }

  bool read_numbers(BlockReader& block) {
    const std::size_t far_count = block.number();
    if (far_count > mesh_.vertices.size()) return false;
    const auto codes = read_paired<std::uint8_t>(block, mesh_.vertices.size());
    const std::vector<std::uint16_t> far = read_far(block, far_count);
    std::size_t next_far = 0;
    for (std::size_t v = 0; v < codes.size(); ++v) {
      const std::uint8_t code = codes[v];
      std::size_t id = like_.size();
      bool settles = code == kFresh;
      if (code == kFresh || code == kFreshElsewhere) {
        if (id == parent_count_) return false;
        like_.push_back(static_cast<std::uint16_t>(v));
        is_settled_.push_back(0);
      } else if (code < kFarParent) {
        if (v == 0) return false;
        settles = code >= kSameAsSettled;
        id = mesh_.parent_of[references_[v][code - (settles ? kSameAsSettled : kSameAs)]];
      } else {
        if (code > kFarParentSettled || next_far == far.size() || far[next_far] >= id) return false;
        settles = code == kFarParentSettled;
        id -= 1u + far[next_far++];
      }
      mesh_.parent_of[v] = static_cast<std::uint16_t>(id);
      if (settles && !settle(id, v)) return false;
    }
    return like_.size() == parent_count_ && next_far == far.size();
  }

  void read_positions(BlockReader& block) {
    std::vector<std::size_t> strays;
    for (std::size_t p = 0; p < parent_count_; ++p) {
      mesh_.parents[p].position = coarsened(mesh_.vertices[like_[p]].position);
      if (!is_settled_[p]) strays.push_back(p);
    }
    std::vector<std::uint32_t> codes(strays.size());
    const auto moved = [](std::int32_t from, std::uint32_t code) {
      return static_cast<std::int32_t>(wrapped(from) + unzigzag(code));
    };
    for (std::int32_t LatticePoint::*axis :
         {&LatticePoint::x, &LatticePoint::y, &LatticePoint::z}) {
      read_codes(block, codes, 32);
      for (std::size_t i = 0; i < strays.size(); ++i) {
        std::int32_t& at = mesh_.parents[strays[i]].position.*axis;
        at = moved(at, codes[i]);
      }
    }
  }

  const std::vector<std::uint16_t>& like() const { return like_; }

 private:
  bool settle(std::size_t id, std::size_t v) {
    if (is_settled_[id]) return false;
    is_settled_[id] = 1;
    like_[id] = static_cast<std::uint16_t>(v);
    return true;
  }

  CellMesh& mesh_;
  std::span<const SmallTriangle> references_;
  std::size_t parent_count_;
  std::vector<std::uint16_t> like_;
  std::vector<std::uint8_t> is_settled_;
};

bool read_parents(BlockReader& block, CellMesh& mesh, std::span<const SmallTriangle> references,
                  const Node& node, const Header& header) {
  ParentReader reader(mesh, references, node.parents);
  if (!reader.read_numbers(block) || !block.ok()) return false;
  reader.read_positions(block);
  if (!read_normals(block, mesh.parents, normals_of(mesh.vertices, reader.like()),
                    header.normal_bits)) {
    return false;
  }
  read_channels_near(block, mesh.parents, mesh.vertices, reader.like(), header.attributes);
  return true;
}

// ---- Whole cells.

bool inside(LatticePoint p, const Node& node) {
  return p.x >= node.lowest.x && p.y >= node.lowest.y && p.z >= node.lowest.z &&
         p.x <= node.highest.x && p.y <= node.highest.y && p.z <= node.highest.z;
}

bool lies_in_its_box(const CellMesh& mesh, const Node& node) {
  return std::all_of(mesh.vertices.begin(), mesh.vertices.end(),
                     [&](const CellVertex& v) {
                       return in_limits(v.position, kPositionLimit) && inside(v.position, node);
                     }) &&
         std::all_of(mesh.parents.begin(), mesh.parents.end(), [&](const CellVertex& v) {
           return in_limits(v.position, kPositionLimit / 2) && inside(refined(v.position), node);
         });
}

[[noreturn]] void refuse(const CellKey& key, int part, const std::string& problem) {
  throw InputError(cell_name(key, part), problem + "; the file is damaged, write it anew");
}

bool read_mesh(BlockReader& block, CellMesh& mesh, const Node& node, const Header& header) {
  if (block.number() != kBlockVersion) return false;
  const std::size_t step_count = block.number(), far_count = block.number();
  if (step_count > 6 * std::size_t{node.triangles} + 3 ||
      far_count > 3 * std::size_t{node.triangles}) {
    return false;
  }
  Walk walk;
  walk.steps = read_paired<Step>(block, step_count);
  walk.far = read_far(block, far_count);
  Walked walked;
  if (!block.ok() || !follow_walk(walk, node.triangles, node.vertices, walked)) return false;
  mesh.triangles = std::move(walked.triangles);
  mesh.vertices.resize(node.vertices);
  read_positions(block, mesh.vertices, walked.references);
  if (!block.ok() ||
      !read_normals(block, mesh.vertices,
                    guessed_normals(mesh.vertices, mesh.triangles, header.normal_bits),
                    header.normal_bits)) {
    return false;
  }
  read_channels(block, mesh.vertices, walked.references, header.attributes);
  if (node.key.level > 0 && !read_parents(block, mesh, walked.references, node, header)) {
    return false;
  }
  return block.ok() && block.at_end();
}

}  // namespace

std::vector<std::byte> encode_cell(const CellMesh& mesh, const Header& header) {
  assert(mesh.vertices.size() <= kCellVertexLimit && "split the cell into parts");
  assert(mesh.triangles.size() <= kCellTriangleLimit && "split the cell into parts");
  assert(mesh.key.level == 0 || mesh.parent_of.size() == mesh.vertices.size());
  const WalkResult walk = walk_triangles(mesh.triangles, mesh.vertices.size());
  std::vector<CellVertex> vertices(mesh.vertices.size());
  for (std::size_t v = 0; v < vertices.size(); ++v) vertices[v] = mesh.vertices[walk.order[v]];
  BlockWriter block;
  block.number(kBlockVersion);
  block.number(static_cast<std::uint32_t>(walk.walk.steps.size()));
  block.number(static_cast<std::uint32_t>(walk.walk.far.size()));
  block.stream(paired(walk.walk.steps));
  write_far(block, walk.walk.far);
  write_positions(block, vertices, walk.references);
  // Sums of whole numbers are the same in any order: that in which the
  // triangles came will do.
  const std::vector<PackedNormal> guesses =
      guessed_normals(mesh.vertices, mesh.triangles, header.normal_bits);
  std::vector<PackedNormal> ordered(vertices.size());
  for (std::size_t v = 0; v < vertices.size(); ++v) ordered[v] = guesses[walk.order[v]];
  write_normals(block, vertices, ordered, header.normal_bits);
  write_channels(block, vertices, walk.references, header.attributes);
  if (mesh.key.level > 0) write_parents(block, mesh, vertices, walk, header);
  return block.take();
}

CellMesh decode_cell(std::span<const std::byte> bytes, const Node& node, const Header& header) {
  if (node.vertices > kCellVertexLimit || node.triangles > kCellTriangleLimit ||
      node.parents > node.vertices || (node.key.level == 0 && node.parents > 0)) {
    refuse(node.key, node.part, "has impossible counts");
  }
  CellMesh mesh;
  mesh.key = node.key;
  BlockReader block(bytes);
  if (!read_mesh(block, mesh, node, header)) refuse(node.key, node.part, "cannot be decoded");
  if (!lies_in_its_box(mesh, node)) refuse(node.key, node.part, "does not lie in its box");
  return mesh;
}

}  // namespace cornice::hlod
