// SPDX-License-Identifier: GPL-3.0-or-later
// Whether a hierarchy keeps what selection and morphing rely on.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "hlod/file.h"

namespace cornice::hlod {

/// Counts of what breaks a promise of the format; a sound file has none.
struct FileCheck {
  std::uint64_t cells = 0, triangles = 0, vertices = 0;
  std::uint64_t damaged_blocks = 0;    ///< checksum, codec, box
  std::uint64_t double_parents = 0;    ///< vertices with other parents in other cells
  std::uint64_t far_vertices = 0;      ///< further than s0 cell sides outside of their cell
  std::uint64_t long_edges = 0;        ///< beyond s0 cell sides
  std::uint64_t far_parents = 0;       ///< beyond half of that from their vertex
  std::uint64_t unlike_triangles = 0;  ///< cells whose triangles are not what becomes of their
  ///< children's when vertices go to their parents
  std::uint64_t falling_errors = 0;        ///< cells with an error below a child's
  std::uint64_t degenerate_triangles = 0;  ///< two corners at one position
  std::vector<std::string> examples;       ///< "cell 3/1/2/0 part 1: ...", the first few

  std::uint64_t faults() const {
    return damaged_blocks + double_parents + far_vertices + long_edges + far_parents +
           unlike_triangles + falling_errors + degenerate_triangles;
  }
};

/// Reads every block, level by level. Memory: about 70 bytes per vertex of two levels.
FileCheck check_file(const File& file, int threads, Progress& progress = no_progress());

}  // namespace cornice::hlod
