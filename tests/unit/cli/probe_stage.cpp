// SPDX-License-Identifier: GPL-3.0-or-later
// A stage that does what the tests of the frame ask of it: fails in a given way, or takes its time.
#include <chrono>
#include <filesystem>
#include <limits>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/cli/stage.h"

namespace {

enum class End { kWell, kInput, kRun, kMemory, kFiles, kUnknown };

struct ProbeOptions {
  int count = 3;
  double width_m = 1.5;
  End end = End::kWell;
  bool deaf = false;
  bool trim = true;
  std::filesystem::path mark;
};

std::vector<cornice::Option> describe(ProbeOptions& o) {
  using cornice::Option;
  return {Option("count", o.count, "steps of work").range(0, 100000),
          Option("width-m", o.width_m, "width of the work").range(0.5, 10).unit("m"),
          Option("end", o.end,
                 {{"well", End::kWell},
                  {"input", End::kInput},
                  {"run", End::kRun},
                  {"memory", End::kMemory},
                  {"files", End::kFiles},
                  {"unknown", End::kUnknown}},
                 "how it ends"),
          Option("deaf", o.deaf, "does not look whether it is to stop").advanced(),
          Option("trim", o.trim, "trims"),
          Option("mark", o.mark, "file written when the work has begun").advanced()};
}

void fail(End end) {
  switch (end) {
    case End::kWell:
      return;
    case End::kInput:
      throw cornice::InputError("a.laz", "is\nnot LAS");
    case End::kRun:
      throw cornice::RunError("a.ply", "the disk is full");
    case End::kMemory:
      throw std::bad_alloc();
    case End::kFiles:
      throw std::filesystem::filesystem_error("odd", "b.ply",
                                              std::make_error_code(std::errc::io_error));
    case End::kUnknown:
      throw 7;
  }
}

void work(const ProbeOptions& options, cornice::Progress& progress) {
  progress.begin("probe", static_cast<std::uint64_t>(options.count));
  for (int i = 0; i < options.count; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    if (!options.deaf) check_cancelled(progress);
    progress.advance(1);
  }
  progress.end();
}

}  // namespace

int main(int argc, char** argv) {
  ProbeOptions options;
  std::filesystem::path input;
  std::filesystem::path output;
  cornice::Stage stage;
  stage.name = "probe";
  stage.description = "Does what the tests of the frame ask of it";
  stage.options = {cornice::Option("FILE", input, "any file").positional().required(),
                   cornice::output_option(output, "copy of its name")};
  stage.add(describe(options), "Probe");
  stage.examples = {"cornice-probe a.txt -o b.txt", "cornice-probe a.txt -o b.txt --end input"};
  stage.run = [&](cornice::StageContext& context) {
    context.report.add_input(input);
    cornice::AtomicFile file(output);
    cornice::write_file_atomically(file.path(), input.string());
    if (!options.mark.empty()) cornice::write_file_atomically(options.mark, "at work");
    context.report.step("work", [&] { work(options, context.progress); });
    context.report.count("steps", static_cast<std::uint64_t>(options.count));
    context.report.quality("not_a_number", std::numeric_limits<double>::quiet_NaN());
    if (options.width_m > 9.0) context.report.warn("rather wide");
    fail(options.end);
    file.commit();
  };
  return cornice::run_stage(argc, argv, std::move(stage));
}
