// SPDX-License-Identifier: GPL-3.0-or-later
// The kinds of job that cornice-hlod build does: in memory, on disk, one region, joining regions.
// All of them make the same bytes.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/cli/stage.h"
#include "hlod/build.h"

namespace cornice::hlod {

/// What the command line says.
struct BuildCommand {
  std::string action;
  std::vector<std::filesystem::path> tiles;
  std::filesystem::path output;
  std::filesystem::path work;  ///< empty: beside the output
  BuildOptions options;
  int levels = 0;
  bool out_of_core = false;
  bool join = false;
  std::string region;  ///< "I/N" or empty
};

/// Does what the command asks for.
void run_build_job(const BuildCommand& command, StageContext& context);

}  // namespace cornice::hlod
