// SPDX-License-Identifier: GPL-3.0-or-later
// What every bench-<name> shares: its options, and the JSON file it writes (bench/README.md).
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace CLI {
class App;
}

namespace cornice::bench {

/// The options of every bench. A bench adds its own to the same CLI::App.
struct Options {
  std::filesystem::path json;  ///< --json: where the figures go; empty: standard output only
  std::uint64_t seed = 1;      ///< --seed: of everything that is made at random
  bool quick = false;          ///< --quick: a smaller run of the same kind, under a minute
  int threads = 2;             ///< --threads: 0 for all cores
};

/// Adds --json, --seed, --quick and --threads.
void add_options(CLI::App& app, Options& options);

using Value = std::variant<bool, std::int64_t, double, std::string>;

/// Collects figures and parameters; write() makes the JSON file and prints a table.
class Result {
 public:
  Result(std::string bench, const Options& options);
  /// A number that was measured. Throws RunError from write() where it is not finite.
  void figure(const std::string& name, double value);
  /// What it was measured with.
  void parameter(const std::string& name, Value value);
  /// {"bench", "figures", "parameters", "machine"} to options.json, a table to standard output.
  void write() const;

 private:
  std::string bench_;
  Options options_;
  std::vector<std::pair<std::string, double>> figures_;
  std::vector<std::pair<std::string, Value>> parameters_;
};

/// Runs a bench: parses the options (exit code 2 where they are wrong), calls `body`, prints errors
/// as the stages do. `add_own` may be empty. Returns the exit code.
int run(const std::string& bench, const std::string& description, int argc, char** argv,
        const std::function<void(CLI::App& app)>& add_own,
        const std::function<void(const Options& options, Result& result)>& body);

/// Middle value, or the mean of the two middle ones. `values` must not be empty.
double median(std::vector<double> values);

/// Wall-clock seconds of one call.
template <class F>
double seconds_of(F&& call) {
  const auto start = std::chrono::steady_clock::now();
  std::forward<F>(call)();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace cornice::bench
