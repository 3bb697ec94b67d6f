// SPDX-License-Identifier: GPL-3.0-or-later
// Reads cells on threads of its own and keeps them within a budget of memory.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hlod/file.h"
#include "terrain-viewer/stream/packed_cell.h"

namespace cornice::viewer {

struct CellStoreOptions {
  int threads = 1;
  std::uint64_t memory_bytes = 512ull << 20;  ///< of packed cells; those in use come on top
};

/// What the store has done so far.
struct CellStoreCounts {
  std::uint64_t cells_read = 0;
  std::uint64_t bytes_read = 0;     ///< from the file
  std::uint64_t memory_bytes = 0;   ///< held now
  std::uint64_t cells_waiting = 0;  ///< wanted and not yet read
  std::uint64_t cells_failed = 0;
};

/// Cells of one file. All functions are for one thread, the one that draws; none waits for the disk
/// but `wait`.
class CellStore {
 public:
  CellStore(std::shared_ptr<const hlod::File> file, const CellStoreOptions& options);
  ~CellStore();
  CellStore(const CellStore&) = delete;
  CellStore& operator=(const CellStore&) = delete;

  /// Rows of the node table to be read, the most urgent first. Takes the place of what was wanted
  /// before; what is being read goes on. Rows that have failed are left out; of those that are held
  /// it counts as their use.
  void want(const std::vector<std::uint32_t>& rows);
  /// The cell where it is held: counts as its use. Empty otherwise.
  std::shared_ptr<const PackedCell> find(std::uint32_t row);
  /// One message for each cell that could not be read since the last call.
  std::vector<std::string> take_failures();
  /// Waits until nothing wanted is left to be read.
  void wait();
  CellStoreCounts counts() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cornice::viewer
