// SPDX-License-Identifier: GPL-3.0-or-later
// cornice-hlod build: mesh tiles in, one .hlod file out.
#pragma once

namespace cornice::hlod {

int run_build(int argc, char** argv);

}  // namespace cornice::hlod
