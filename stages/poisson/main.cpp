// SPDX-License-Identifier: GPL-3.0-or-later
// cornice-poisson: oriented points in; field and border band, or mesh, out.
#include <string>

#include "core/cli/stage.h"
#include "stages/poisson/command.h"

int main(int argc, char** argv) {
  using namespace cornice;
  poisson::Command command;
  const std::string action = argc > 1 ? argv[1] : "";
  if (action == "solve") return run_stage(argc, argv, poisson::solve_stage(command));
  if (action == "extract") return run_stage(argc, argv, poisson::extract_stage(command));
  if (action == "mesh") return run_stage(argc, argv, poisson::mesh_stage(command));
  return run_stage(argc, argv, poisson::choose_stage(command));
}
