// SPDX-License-Identifier: GPL-3.0-or-later
// Work on many threads whose inputs are fetched and whose results are delivered in order.
#pragma once

#include <cstddef>
#include <functional>

namespace cornice {

/// The three steps of item i. `slot` (below `slots`) is where the item's state lives from fetch to
/// deliver; no other item has it meanwhile.
struct OrderedWork {
  std::size_t count = 0;
  int threads = 1;  ///< as an option value: 0 for all cores
  /// Called one at a time in order, by any thread: reads input that has to be read in sequence.
  std::function<void(std::size_t i, std::size_t slot)> fetch;
  /// Called for several items at once.
  std::function<void(std::size_t i, std::size_t slot)> work;
  /// Called in order on the calling thread; false ends the run.
  std::function<bool(std::size_t i, std::size_t slot)> deliver;
};

/// Slots that run_ordered uses with so many threads.
std::size_t ordered_slots(int threads);

/// Runs the work. The first exception in order of the items ends it and is rethrown here, after
/// all threads have ended; everything before it has been delivered.
void run_ordered(const OrderedWork& work);

}  // namespace cornice
