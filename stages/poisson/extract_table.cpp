// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/poisson/extract_table.h"

#include <vector>

namespace cornice {
namespace {

constexpr std::uint8_t kNoEdge = 0xff;
constexpr unsigned kConfigurations = 256;
constexpr unsigned kDecisions = 64;

/// The edge between two neighbouring nodes of a cell.
constexpr std::uint8_t edge_between(unsigned a, unsigned b) {
  const unsigned low = a < b ? a : b;
  switch (a ^ b) {
    case 1:
      return static_cast<std::uint8_t>(low >> 1);
    case 2:
      return static_cast<std::uint8_t>(4 + (low & 1) + (low >> 2) * 2);
    default:
      return static_cast<std::uint8_t>(8 + (low & 3));
  }
}

/// One face, walked around: where the sign changes, which edge follows which along the surface.
///
///   - - -      Walked counter-clockwise, the negative part is entered over one edge and left over
///   +\ /+      another; the surface runs from the first to the second. On ambiguous faces either
///   + v +      each negative corner or, where they are joined, each positive one is cut off.
void link_face(const std::array<std::uint8_t, 4>& nodes, unsigned negative, bool joined,
               std::array<std::uint8_t, 12>& next) {
  std::array<bool, 4> is_negative{};
  std::array<std::uint8_t, 4> edge{};  // from node i to node i + 1
  for (unsigned i = 0; i < 4; ++i) {
    is_negative[i] = (negative >> nodes[i] & 1) != 0;
    edge[i] = edge_between(nodes[i], nodes[(i + 1) % 4]);
  }
  for (unsigned i = 0; i < 4; ++i) {
    if (is_negative[i] || !is_negative[(i + 1) % 4]) continue;
    // edge[i] enters the negative part: look for where it is left.
    unsigned leave = (i + 1) % 4;
    while (is_negative[(leave + 1) % 4]) leave = (leave + 1) % 4;
    const bool ambiguous = is_negative[(i + 3) % 4] && !is_negative[(i + 2) % 4];
    next[edge[i]] = edge[ambiguous && joined ? (i + 3) % 4 : leave];
  }
}

CellLoops make_loops(unsigned negative, unsigned joined) {
  std::array<std::uint8_t, 12> next;
  next.fill(kNoEdge);
  for (unsigned f = 0; f < 6; ++f) link_face(kFaceNodes[f], negative, (joined >> f & 1) != 0, next);
  CellLoops cell;
  unsigned used = 0;
  for (std::uint8_t start = 0; start < 12; ++start) {
    if (next[start] == kNoEdge) continue;
    std::uint8_t length = 0;
    for (std::uint8_t e = start; next[e] != kNoEdge; ++length) {
      cell.edges[used++] = e;
      const std::uint8_t following = next[e];
      next[e] = kNoEdge;
      e = following;
    }
    cell.length[cell.loops++] = length;
  }
  return cell;
}

struct Table {
  std::vector<CellLoops> loops;
  std::array<std::uint8_t, kConfigurations> ambiguous{};

  Table() {
    loops.reserve(kConfigurations * kDecisions);
    for (unsigned negative = 0; negative < kConfigurations; ++negative) {
      for (unsigned joined = 0; joined < kDecisions; ++joined) {
        loops.push_back(make_loops(negative, joined));
      }
      for (unsigned f = 0; f < 6; ++f) {
        const auto& n = kFaceNodes[f];
        const auto sign = [&](unsigned i) { return negative >> n[i] & 1; };
        if (sign(0) == sign(2) && sign(1) == sign(3) && sign(0) != sign(1)) {
          ambiguous[negative] = static_cast<std::uint8_t>(ambiguous[negative] | 1u << f);
        }
      }
    }
  }
};

const Table& table() {
  static const Table made;
  return made;
}

}  // namespace

std::uint8_t ambiguous_faces(unsigned negative) { return table().ambiguous[negative]; }

const CellLoops& cell_loops(unsigned negative, unsigned joined) {
  return table().loops[negative * kDecisions + joined];
}

}  // namespace cornice
