// SPDX-License-Identifier: GPL-3.0-or-later
// cornice-hlod: mesh tiles in, one .hlod file out; what is in such a file.
#include <string>

#include "core/cli/stage.h"
#include "stages/hlod/command.h"

int main(int argc, char** argv) {
  using namespace cornice;
  std::string word = argc > 1 ? argv[1] : "";
  for (const hlod::Action& action : hlod::actions()) {
    if (word == action.name) return action.run(argc, argv);
  }
  return run_stage(argc, argv, hlod::choose_stage(word));
}
