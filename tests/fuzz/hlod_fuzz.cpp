// SPDX-License-Identifier: GPL-3.0-or-later
// Whatever the bytes: a .hlod file opens and its cells decode to whole meshes, or InputError is
// thrown. Checksums would stop every mutation, so blocks are also decoded without one.
#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <span>
#include <string>

#include "core/base/error.h"
#include "hlod/file.h"
#include "hlod/file_layout.h"
#include "hlod/select.h"

namespace {

using namespace cornice;
using namespace cornice::hlod;

void require(bool good) {
  if (!good) std::abort();
}

void check(const CellMesh& mesh, const Node& node) {
  require(mesh.vertices.size() == node.vertices && mesh.triangles.size() == node.triangles);
  require(mesh.parents.size() == node.parents);
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint16_t v : triangle) require(v < mesh.vertices.size());
  }
  for (const std::uint16_t p : mesh.parent_of) require(p < mesh.parents.size());
}

/// The first bytes say how many vertices there are and the like; the others are the block.
void fuzz_block(std::span<const std::uint8_t> data) {
  if (data.size() < 8) return;
  Header header;
  header.lattice.root_side = 1024.0;
  header.lattice.finest_level = 3;
  header.attributes = data[0] & 15u;
  header.normal_bits = (data[0] & 16u) != 0 ? 10 : 8;
  Node node;
  node.key.level = data[1] & 3;
  const auto count = [&](std::size_t at) {
    return static_cast<std::uint32_t>(data[at] | data[at + 1] << 8);
  };
  node.vertices = count(2), node.triangles = count(4), node.parents = count(6);
  node.lowest = {-(1 << 29), -(1 << 29), -(1 << 29)};
  node.highest = {1 << 29, 1 << 29, 1 << 29};
  try {
    const CellMesh mesh = decode_cell(std::as_bytes(data.subspan(8)), node, header);
    check(mesh, node);
    // What can be read can be written again.
    check(decode_cell(encode_cell(mesh, header), make_node(mesh, 0, 0), header), node);
  } catch (const InputError&) {
  }
}

/// A node table without its checksum.
void fuzz_nodes(std::span<const std::uint8_t> data) {
  if (data.size() < 2) return;
  Head head;
  head.header.lattice.root_side = 1024.0;
  head.header.lattice.finest_level = 3;
  head.node_count = data[0];
  head.table_offset = head_bytes(head.header) + data[1];
  try {
    const auto nodes = unpack_nodes("table", std::as_bytes(data.subspan(2)), head);
    Selection selection;
    const Tree tree = make_tree(head.header, nodes);
    if (tree.cells.empty()) return;
    const FinePoint eye = tree.cells.front().lowest;
    select(tree, radii_for_eye(tree, 100.0, eye), eye, {}, selection);
  } catch (const InputError&) {
  }
}

void fuzz_file(std::span<const std::uint8_t> data) {
  const int file = memfd_create("input", MFD_CLOEXEC);
  require(file >= 0);
  require(write(file, data.data(), data.size()) == static_cast<ssize_t>(data.size()));
  try {
    const File hierarchy("/proc/self/fd/" + std::to_string(file));
    for (const Node& node : hierarchy.nodes()) check(hierarchy.read(node), node);
  } catch (const InputError&) {
  }
  close(file);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::span<const std::uint8_t> rest(data + 1, size - 1);
  if (data[0] % 4 < 2) fuzz_block(rest);
  if (data[0] % 4 == 2) fuzz_nodes(rest);
  if (data[0] % 4 == 3) fuzz_file(rest);
  return 0;
}
