// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/hlod/command.h"

#include "core/base/error.h"
#include "stages/hlod/command_build.h"
#include "stages/hlod/command_extract.h"
#include "stages/hlod/command_info.h"
#include "stages/hlod/command_verify.h"

namespace cornice::hlod {

std::vector<Action> actions() {
  return {{"build", &run_build},
          {"info", &run_info},
          {"verify", &run_verify},
          {"extract", &run_extract}};
}

Option action_option(std::string& word, const std::string& name) {
  return Option("ACTION", word, name).positional().required().words({name});
}

Stage choose_stage(std::string& word) {
  std::vector<std::string> names;
  for (const Action& action : actions()) names.push_back(action.name);
  word.clear();
  Stage stage;
  stage.name = "hlod";
  stage.description = "Hierarchies of levels of detail";
  stage.options = {Option("ACTION", word,
                          "build makes one, info says what is in it, verify checks all of it, "
                          "extract takes a mesh out of it; cornice-hlod ACTION --help says how")
                       .positional()
                       .required()
                       .words(names)};
  stage.examples = {"cornice-hlod build tiles/*.ply -o survey.hlod",
                    "cornice-hlod info survey.hlod"};
  // An action that is known never gets here.
  stage.run = [](StageContext&) { throw UsageError("ACTION", "must come first"); };
  return stage;
}

}  // namespace cornice::hlod
