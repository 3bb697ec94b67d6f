// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/hierarchy.h"

#include <utility>
#include <vector>

namespace cornice::test {

void write_hierarchy(const std::filesystem::path& path, const Mesh& mesh,
                     const hlod::BuildOptions& options) {
  hlod::InputSummary input;
  hlod::summarise(mesh, "made up", 1, input);
  const hlod::Header header = hlod::plan_header(input, options);
  hlod::LeafMaker maker(header, options.max_pieces, 1);
  std::vector<std::vector<hlod::BuildCell>> pieces;
  pieces.push_back(maker.pieces(mesh));
  hlod::LeafCounts counts = maker.counts();
  hlod::FileWriter writer(path, header);
  hlod::build_levels(hlod::finish_leaves(std::move(pieces), header, 1, counts), header,
                     options.block, 1, [&](const hlod::FinishedPart& part) {
                       writer.add(part.node, encode_cell(part.mesh, header));
                     });
  writer.finish();
}

}  // namespace cornice::test
