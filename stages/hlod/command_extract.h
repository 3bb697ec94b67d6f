// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace cornice::hlod {

/// cornice hlod extract FILE -o MESH: one level, or what an eye sees, as PLY, OBJ or GLB.
int run_extract(int argc, char** argv);

}  // namespace cornice::hlod
