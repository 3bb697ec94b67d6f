// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/bench_json.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <nlohmann/json.hpp>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/memory.h"
#include "core/cli/machine.h"
#include "core/cli/version.h"

namespace cornice::bench {
namespace {

using Json = nlohmann::ordered_json;

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

Json machine() {
  constexpr double kGiB = 1ull << 30;
  const Machine facts = this_machine();
  return {{"cpu", facts.cpu},
          {"cores", facts.cores},
          {"memory_gib", static_cast<double>(facts.memory_bytes) / kGiB},
          {"system", facts.os},
          {"build", build_text()},
          {"date", utc_now()},
          {"peak_resident_gib", static_cast<double>(peak_resident_bytes()) / kGiB}};
}

Json to_json(const Value& value) {
  return std::visit([](const auto& v) { return Json(v); }, value);
}

}  // namespace

void add_options(CLI::App& app, Options& options) {
  app.add_option("--json", options.json, "write the figures to this file");
  app.add_option("--seed", options.seed, "of everything made at random")->capture_default_str();
  app.add_flag("--quick", options.quick, "a smaller run of the same kind, under a minute");
  app.add_option("--threads", options.threads, "0: all cores")
      ->capture_default_str()
      ->check(CLI::NonNegativeNumber);
}

Result::Result(std::string bench, const Options& options)
    : bench_(std::move(bench)), options_(options) {
  parameter("seed", static_cast<std::int64_t>(options.seed));
  parameter("quick", options.quick);
  parameter("threads", static_cast<std::int64_t>(options.threads));
}

void Result::figure(const std::string& name, double value) { figures_.emplace_back(name, value); }

void Result::parameter(const std::string& name, Value value) {
  parameters_.emplace_back(name, std::move(value));
}

void Result::write() const {
  Json file{{"bench", bench_},
            {"figures", Json::object()},
            {"parameters", Json::object()},
            {"machine", machine()}};
  for (const auto& [name, value] : figures_) {
    if (!std::isfinite(value)) throw RunError(bench_, "figure " + name + " is not a number");
    file["figures"][name] = value;
    std::printf("%-36s %.6g\n", name.c_str(), value);
  }
  for (const auto& [name, value] : parameters_) file["parameters"][name] = to_json(value);
  if (!options_.json.empty()) write_file_atomically(options_.json, file.dump(2) + "\n");
}

int run(const std::string& bench, const std::string& description, int argc, char** argv,
        const std::function<void(CLI::App& app)>& add_own,
        const std::function<void(const Options& options, Result& result)>& body) {
  CLI::App app{description, "bench-" + bench};
  Options options;
  add_options(app, options);
  if (add_own) add_own(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(ExitCode::kUsage);
  }
  try {
    Result result(bench, options);
    body(options, result);
    result.write();
    return 0;
  } catch (const Error& error) {
    std::fprintf(stderr, "bench-%s: error: %s\n", bench.c_str(), error.what());
    return static_cast<int>(error.code());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench-%s: error: %s\n", bench.c_str(), error.what());
    return static_cast<int>(ExitCode::kFailed);
  }
}

double median(std::vector<double> values) {
  assert(!values.empty() && "no values");
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

}  // namespace cornice::bench
