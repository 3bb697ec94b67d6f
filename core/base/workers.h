// SPDX-License-Identifier: GPL-3.0-or-later
// What parallel loops run on. One of two sources is compiled: with TBB's pool, or with threads of
// its own where the thread sanitizer watches, which does not see how TBB hands work over.
#pragma once

#include <cstddef>
#include <functional>

namespace cornice {

/// Calls work() `workers` times (1 or more), at once as far as there are threads, and returns when
/// all calls have. `work` must not throw.
void run_on_workers(std::size_t workers, const std::function<void()>& work);

}  // namespace cornice
