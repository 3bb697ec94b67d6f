// SPDX-License-Identifier: GPL-3.0-or-later
// Parallel loops whose result does not depend on the number of threads: the work is cut into
// chunks by size alone, and reductions run in chunk order.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace cornice {

/// Number of threads meant by an option value: n itself, or every core of this process's
/// affinity mask where n is 0.
int thread_count(int threads_option);

/// Calls body(begin, end) for consecutive ranges [begin, end) that cover [0, count), each of
/// `grain` items but the last, on up to `threads` threads (0: all cores). The first exception (by
/// range order) is rethrown after all running ranges have ended.
/// Ranges depend on count and grain only, so a body that writes only its own items gives the same
/// bytes with any number of threads.
void parallel_for(std::size_t count, std::size_t grain, int threads,
                  const std::function<void(std::size_t begin, std::size_t end)>& body);

/// map(begin, end) for each range as above, in parallel; then reduce(accumulator, part) in range
/// order on the calling thread. Bit-identical for any number of threads, floating point included.
template <class T, class Map, class Reduce>
T parallel_reduce(std::size_t count, std::size_t grain, int threads, T init, Map map,
                  Reduce reduce) {
  if (grain == 0) grain = 1;
  std::vector<T> parts((count + grain - 1) / grain);
  parallel_for(count, grain, threads,
               [&](std::size_t begin, std::size_t end) { parts[begin / grain] = map(begin, end); });
  for (T& part : parts) reduce(init, part);
  return init;
}

}  // namespace cornice
