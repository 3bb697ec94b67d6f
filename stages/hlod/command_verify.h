// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace cornice::hlod {

/// cornice hlod verify FILE: reads everything; exit code 3 where a hierarchy is damaged or breaks
/// what viewers rely on.
int run_verify(int argc, char** argv);

}  // namespace cornice::hlod
