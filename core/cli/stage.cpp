// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/cli/stage.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <exception>
#include <new>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <type_traits>
#include <utility>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/write_problem.h"
#include "core/cli/command_line.h"
#include "core/cli/console.h"
#include "core/cli/log.h"
#include "core/cli/signals.h"
#include "core/cli/terminal_progress.h"
#include "core/cli/version.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;

constexpr double kMaxThreads = 1024;
constexpr int kExitBySignal = 128;
constexpr const char* kReportOption = "report";

std::vector<Option> describe(CommonOptions& o) {
  std::vector<Option> options{
      Option("threads", o.threads, "0: all cores; the result is the same with any number")
          .range(0, kMaxThreads)
          .short_flag('j'),
      Option("memory", o.memory_gib, "memory it may use, 0: the machine's").at_least(0).unit("GiB"),
      Option(kReportOption, o.report,
             "writes a JSON report of the run there, replacing an older one"),
      Option("overwrite", o.overwrite, "replaces an output that exists"),
      Option("log-level", o.log_level, "least important lines shown")
          .words({"error", "warning", "info", "debug"})
          .advanced(),
      Option("no-progress", o.no_progress, "shows no progress").advanced()};
  for (Option& option : options) option.group("Common");
  return options;
}

nlohmann::json json_value(const Option& option) {
  return std::visit(
      [&](const auto& field) -> nlohmann::json {
        using Target = std::decay_t<decltype(field)>;
        if constexpr (std::is_same_v<Target, Option::Choice>) {
          return option.value_text();
        } else if constexpr (std::is_same_v<Target, std::optional<double>*>) {
          return *field ? nlohmann::json(**field) : nlohmann::json();
        } else if constexpr (std::is_same_v<Target, fs::path*>) {
          return field->string();
        } else if constexpr (std::is_same_v<Target, std::vector<fs::path>*>) {
          nlohmann::json paths = nlohmann::json::array();
          for (const fs::path& path : *field) paths.push_back(path.string());
          return paths;
        } else {
          return *field;
        }
      },
      option.field());
}

/// What a failure means to the caller.
struct Failure {
  int exit_code = 0;
  std::string line;
};

/// The exception in flight as one line and an exit code. Call inside a catch block.
Failure describe_failure(int signal_number) {
  constexpr int failed = static_cast<int>(ExitCode::kFailed);
  try {
    throw;
  } catch (const Cancelled& error) {
    const bool by_signal = signal_number != 0;
    return {by_signal ? kExitBySignal + signal_number : failed,
            by_signal ? "stopped by signal " + std::to_string(signal_number) +
                            " before it was done; run it again"
                      : std::string(error.what())};
  } catch (const Error& error) {
    return {static_cast<int>(error.code()), error.what()};
  } catch (const std::bad_alloc&) {
    return {failed, "out of memory; give it more, fewer threads or a smaller part"};
  } catch (const fs::filesystem_error& error) {
    const std::string file = error.path1().string();
    return {failed, (file.empty() ? "" : file + ": ") + error.code().message()};
  } catch (const std::exception& error) {
    return {failed, std::string("unexpected: ") + error.what()};
  } catch (...) {
    return {failed, "unexpected failure of unknown kind"};
  }
}

/// The files and folders that an option names.
std::vector<fs::path> paths_of(const Option& option) {
  if (const auto* path = std::get_if<fs::path*>(&option.field())) return {**path};
  if (const auto* paths = std::get_if<std::vector<fs::path>*>(&option.field())) return **paths;
  return {};
}

/// A file that is read must outlive the run, whatever --overwrite says.
void refuse_to_replace_inputs(const fs::path& written, const std::vector<Option>& options) {
  std::error_code ignored;
  if (!fs::is_regular_file(written, ignored)) return;
  for (const Option& option : options) {
    if (option.is_output() || option.name() == kReportOption) continue;
    for (const fs::path& path : paths_of(option)) {
      if (!fs::equivalent(path, written, ignored)) continue;
      throw UsageError(written.string(), "is read by this run; write to another file");
    }
  }
}

/// Throws RunError where a file or folder could not be made at `written`: now rather than after
/// hours of work.
void check_place(const fs::path& written) {
  std::error_code error;
  // A link's target may lie anywhere.
  if (written.empty() || fs::is_symlink(written, error)) return;
  fs::path folder = fs::absolute(written);
  if (!fs::is_directory(folder, error)) folder = folder.parent_path();
  while (folder.has_relative_path() && !fs::exists(folder, error)) folder = folder.parent_path();
  if (!fs::is_directory(folder, error)) {
    throw RunError(written.string(), "cannot create its folder: " + folder.string() + " is a file");
  }
  if (access(folder.c_str(), W_OK | X_OK) != 0) {
    throw RunError(written.string(),
                   "cannot write in " + folder.string() + ": " + write_problem(errno));
  }
}

void prepare_outputs(const std::vector<Option>& options, const CommonOptions& common) {
  refuse_to_replace_inputs(common.report, options);
  check_place(common.report);
  for (const Option& option : options) {
    if (!option.is_output()) continue;
    refuse_to_replace_inputs(*std::get<fs::path*>(option.field()), options);
    const fs::path& path = *std::get<fs::path*>(option.field());
    if (path.empty()) continue;
    check_output(path, common);
    check_place(path);
    remove_stale_partials(path);
  }
}

ProgressStyle progress_style(const CommonOptions& common) {
  if (common.no_progress || common.log_level == "error" || common.log_level == "warning") {
    return ProgressStyle::kNone;
  }
  return console_is_terminal() ? ProgressStyle::kBar : ProgressStyle::kLines;
}

/// Writes the report; a report that cannot be written fails a run that went well.
void write_report(const Report& report, const fs::path& path) {
  if (path.empty()) return;
  const std::string text =
      report.to_json().dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
  write_file_atomically(path, text + "\n");
}

/// Runs the stage's own code with everything set up, and reports how it ended.
int run_prepared(const std::string& tool, Stage& stage, const CommonOptions& common,
                 const SignalWatch& signals) {
  Report report(tool, !common.report.empty());
  for (const Option& option : stage.options)
    report.add_parameter(option.name(), json_value(option));
  std::optional<Failure> failure;
  try {
    TerminalProgress progress(progress_style(common), signals.cancelled());
    MemoryBudget memory(static_cast<std::uint64_t>(common.memory_gib * 0x1p30));
    StageContext context{common, report, progress, memory};
    stage.run(context);
    progress.end();
    for (const Option& option : stage.options) {
      if (option.is_output()) report.add_output(*std::get<fs::path*>(option.field()));
    }
  } catch (...) {
    failure = describe_failure(signals.signal_number());
  }
  const int exit_code = failure ? failure->exit_code : 0;
  const char* ended = exit_code > kExitBySignal ? "cancelled" : "failed";
  report.finish(failure ? ended : "done", failure ? failure->line : "", exit_code);
  if (failure) {
    log_error(failure->line);
  } else {
    log_info(report.summary());
  }
  try {
    write_report(report, common.report);
  } catch (...) {
    if (failure) return exit_code;
    const Failure unwritten = describe_failure(0);
    log_error(unwritten.line);
    return unwritten.exit_code;
  }
  return exit_code;
}

int run_checked(int argc, char** argv, const std::string& tool, Stage& stage) {
  CommonOptions common;
  for (Option& option : describe(common)) stage.options.push_back(std::move(option));
  const HelpPage page{tool, stage.description, stage.examples};
  switch (parse_command_line(argc, argv, stage.options)) {
    case CommandAction::kHelp:
      std::fputs(help_text(page, stage.options, false).c_str(), stdout);
      return 0;
    case CommandAction::kHelpAll:
      std::fputs(help_text(page, stage.options, true).c_str(), stdout);
      return 0;
    case CommandAction::kVersion:
      std::fputs((tool + " " + version_text() + "\n").c_str(), stdout);
      return 0;
    case CommandAction::kRun:
      break;
  }
  set_up_log(tool, common.log_level);
  prepare_outputs(stage.options, common);
  const SignalWatch signals(kSignalGraceSeconds, [&] {
    remove_live_partials();
    console_line(tool + ": error: stopped by a signal in a step that could not be interrupted");
  });
  return run_prepared(tool, stage, common, signals);
}

}  // namespace

void Stage::add(std::vector<Option> more, const std::string& group) {
  for (Option& option : more) options.push_back(std::move(option.group(group)));
}

Option output_option(fs::path& output, const std::string& help) {
  return Option("output", output, help).short_flag('o').required().output();
}

int run_stage(int argc, char** argv, Stage stage) {
  const std::string tool = "cornice-" + stage.name;
  set_up_log(tool, "info");
  try {
    return run_checked(argc, argv, tool, stage);
  } catch (...) {
    const Failure failure = describe_failure(0);
    const bool usage = failure.exit_code == static_cast<int>(ExitCode::kUsage);
    log_error(failure.line + (usage ? " (see " + tool + " --help)" : ""));
    return failure.exit_code;
  }
}

void check_output(const fs::path& output, const CommonOptions& options) {
  if (options.overwrite) return;
  std::error_code error;
  if (!fs::exists(output, error)) return;
  if (fs::is_directory(output, error) && fs::is_empty(output, error)) return;
  throw UsageError(output.string(), "exists already; give --overwrite or another --output");
}

}  // namespace cornice
