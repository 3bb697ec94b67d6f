// SPDX-License-Identifier: GPL-3.0-or-later
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "core/base/workers.h"

namespace cornice {

void run_on_workers(std::size_t workers, const std::function<void()>& work) {
  // An arena of its own bounds the threads and keeps a waiting thread from picking up unrelated
  // outer work.
  tbb::task_arena arena(static_cast<int>(workers));
  arena.execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, workers, 1),
        [&](const tbb::blocked_range<std::size_t>&) { work(); }, tbb::simple_partitioner());
  });
}

}  // namespace cornice
