// SPDX-License-Identifier: GPL-3.0-or-later
// The frame of every executable: common options, log, progress, report, exit code.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/progress.h"

namespace CLI {
class App;
}

namespace cornice {

/// Options every stage has (the contract of a stage, ARCHITECTURE.md).
struct CommonOptions {
  int threads = 0;          ///< 0: all cores
  double memory_gib = 0.0;  ///< 0: the machine's
  std::string log_level = "info";
  bool no_progress = false;
  bool overwrite = false;
  std::filesystem::path report;  ///< empty: none
};

/// The --report file in the making: docs/formats/report.md and docs/report.schema.json.
/// Thread contract: one thread at a time.
class Report {
 public:
  explicit Report(std::string tool);
  void add_parameter(const std::string& name, nlohmann::json value);
  /// Records path, size and xxh3 checksum of an input.
  void add_input(const std::filesystem::path& path);
  void add_output(const std::filesystem::path& path);
  void count(const std::string& name, std::uint64_t value);
  void quality(const std::string& name, nlohmann::json value);
  /// Also logged at level warning.
  void warn(const std::string& message);
  /// Runs body as a named, timed step.
  void step(const std::string& name, const std::function<void()>& body);
  /// The whole report, with machine, version, seconds per step and peak memory.
  nlohmann::json to_json() const;

 private:
  std::string tool_;
  nlohmann::json data_;
};

/// What a stage's own code gets.
struct StageContext {
  const CommonOptions& options;
  Report& report;
  Progress& progress;
};

/// Runs one executable: parses argv with `declare`d options on top of the common ones, sets up log
/// and progress, calls `run`, writes the report, and turns exceptions into one line on stderr
/// ("cornice-NAME: error: ...") and the exit code of their kind. SIGINT and SIGTERM cancel through
/// Progress::cancelled() and exit 128+n with no half-written file. Returns the exit code.
int run_stage(int argc, char** argv, const std::string& name, const std::string& description,
              const std::function<void(CLI::App& app)>& declare,
              const std::function<void(StageContext& context)>& run);

/// Throws UsageError where `output` exists and overwriting was not asked for.
void check_output(const std::filesystem::path& output, const CommonOptions& options);

}  // namespace cornice
