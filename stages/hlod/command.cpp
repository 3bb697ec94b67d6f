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

Stage choose_stage() {
  Stage stage;
  stage.name = "hlod";
  stage.description =
      "Hierarchies of levels of detail; the first argument says what to do (cornice-hlod ACTION "
      "--help)";
  stage.examples = {"cornice-hlod build tiles/*.ply -o survey.hlod",
                    "cornice-hlod info survey.hlod"};
  stage.run = [](StageContext&) {
    throw UsageError("cornice-hlod", "which action: build, info, verify or extract?");
  };
  return stage;
}

}  // namespace cornice::hlod
