// SPDX-License-Identifier: GPL-3.0-or-later
#include <thread>
#include <vector>

#include "core/base/workers.h"

namespace cornice {

void run_on_workers(std::size_t workers, const std::function<void()>& work) {
  std::vector<std::thread> others;
  for (std::size_t i = 1; i < workers; ++i) others.emplace_back(work);
  work();
  for (std::thread& thread : others) thread.join();
}

}  // namespace cornice
