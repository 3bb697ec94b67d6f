// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/hlod/command_verify.h"

#include <cstdio>
#include <filesystem>
#include <string>

#include "core/base/error.h"
#include "core/cli/stage.h"
#include "hlod/file_check.h"
#include "stages/hlod/command.h"

namespace cornice::hlod {
namespace {

struct VerifyCommand {
  std::string action;
  std::filesystem::path file;
};

void verify(const VerifyCommand& command, StageContext& context) {
  Report& report = context.report;
  report.add_input(command.file);
  const File file(command.file);
  FileCheck check;
  report.step("check",
              [&] { check = check_file(file, context.options.threads, context.progress); });
  report.count("cells", check.cells);
  report.count("triangles", check.triangles);
  report.count("vertices", check.vertices);
  const auto fault = [&](const char* figure, const char* words, std::uint64_t count) {
    report.quality(figure, count);
    if (count > 0) report.warn(std::to_string(count) + " " + words);
  };
  fault("damaged_blocks", "blocks are damaged", check.damaged_blocks);
  fault("double_parents", "vertices have several parents", check.double_parents);
  fault("far_vertices", "vertices lie too far outside of their cells", check.far_vertices);
  fault("long_edges", "edges are too long", check.long_edges);
  fault("far_parents", "vertices are too far from their parents", check.far_parents);
  fault("unlike_triangles", "cells have other triangles than their children become",
        check.unlike_triangles);
  fault("falling_errors", "cells have errors below a child's", check.falling_errors);
  fault("degenerate_triangles", "triangles have two corners at one place",
        check.degenerate_triangles);
  for (const std::string& example : check.examples) report.warn(example);
  if (check.faults() == 0) return;
  throw InputError(command.file.string(),
                   "breaks the format's promises " + std::to_string(check.faults()) +
                       " times; first: " + (check.examples.empty() ? "" : check.examples.front()) +
                       "; build it anew");
}

}  // namespace

int run_verify(int argc, char** argv) {
  VerifyCommand command;
  Stage stage;
  stage.name = "hlod";
  stage.description = "Reads a hierarchy whole and checks all that drawing it relies on";
  stage.options = {action_option(command.action, "verify"),
                   Option("FILE", command.file, "hierarchy, .hlod").positional().required()};
  stage.examples = {"cornice-hlod verify survey.hlod",
                    "cornice-hlod verify survey.hlod --report faults.json"};
  stage.run = [&](StageContext& context) { verify(command, context); };
  return run_stage(argc, argv, std::move(stage));
}

}  // namespace cornice::hlod
