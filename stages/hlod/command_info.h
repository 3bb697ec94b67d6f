// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace cornice::hlod {

/// cornice hlod info FILE: what is in a hierarchy, on standard output. Reads head and node table.
int run_info(int argc, char** argv);

}  // namespace cornice::hlod
