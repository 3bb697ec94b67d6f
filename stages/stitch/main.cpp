// SPDX-License-Identifier: GPL-3.0-or-later
// cornice-stitch: mesh tiles of a survey in, tiles that share their border vertices out.
#include <memory>

#include "core/base/error.h"
#include "core/cli/stage.h"
#include "stages/stitch/command.h"
#include "stages/stitch/output.h"

namespace {

using namespace cornice;

void check(const stitch::Command& command, const stitch::Survey& survey, Report& report) {
  stitch::SeamReport seams;
  report.step("check", [&] { seams = stitch::check_survey(survey, command.options); });
  stitch::report_seams(seams, report);
  if (seams.faults() > 0) {
    throw InputError("", "the tiles do not make one surface: " + std::to_string(seams.faults()) +
                             " faults; stitch them, or raise --tolerance-m");
  }
}

void run(stitch::Command& command, StageContext& context) {
  Report& report = context.report;
  command.options.threads = context.options.threads;
  stitch::check_command(command);
  for (const auto& tile : command.tiles) report.add_input(tile);
  context.memory.charge("two tiles", 2 * stitch::bytes_of_largest(command.tiles));
  stitch::Survey survey;
  report.step("borders", [&] {
    survey = stitch::learn_survey(command.tiles, command.options, context.progress);
  });
  stitch::report_survey(survey, report);
  if (command.check) return check(command, survey, report);
  const std::unique_ptr<stitch::Output> output = stitch::open_output(command, survey);
  stitch::StitchResult result;
  report.step("stitch", [&] {
    result = stitch::stitch_survey(
        survey, command.options,
        [&](const std::filesystem::path& path, stitch::EditedTile& tile) {
          output->add(path, tile);
        },
        context.progress);
  });
  report.step("finish", [&] { output->finish(); });
  stitch::report_stitching(result, report);
}

}  // namespace

int main(int argc, char** argv) {
  stitch::Command command;
  Stage stage;
  stage.name = "stitch";
  stage.description = "Makes the mesh tiles of a survey share the vertices of their borders";
  stage.options = stitch::describe(command);
  stage.examples = {"cornice-stitch tiles/*.ply -o stitched",
                    "cornice-stitch tiles/*.ply -o survey.ply --tolerance-m 0.5"};
  stage.run = [&](StageContext& context) { run(command, context); };
  return run_stage(argc, argv, std::move(stage));
}
