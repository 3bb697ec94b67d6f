// SPDX-License-Identifier: GPL-3.0-or-later
// What cornice-hlod does with files. Every action is a stage of its own, with its own options.
#pragma once

#include <string>
#include <vector>

#include "core/cli/stage.h"

namespace cornice::hlod {

/// An action's name and its main function: argv[1] is the name.
struct Action {
  std::string name;
  int (*run)(int argc, char** argv);
};

/// All of them, in the order of the help text.
std::vector<Action> actions();

/// For a command line without an action: its help, its version, or what is wrong. `word` is what
/// stands in place of the action.
Stage choose_stage(std::string& word);

/// The action's name as the first, positional argument, so that the rest of argv parses.
Option action_option(std::string& word, const std::string& name);

}  // namespace cornice::hlod
