// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/cli/report.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <ctime>
#include <memory>
#include <system_error>

#include "core/base/error.h"
#include "core/base/input_file.h"
#include "core/base/memory.h"
#include "core/cli/log.h"
#include "core/cli/machine.h"
#include "core/cli/version.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kReportVersion = 1;
// Large enough that the reads, not the calls, take the time.
constexpr std::size_t kReadBytes = std::size_t{1} << 20;

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text.data();
}

/// A file descriptor that closes itself.
class OpenFile {
 public:
  explicit OpenFile(const fs::path& path) : file_(open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
    if (file_ < 0) throw InputError(path.string(), std::generic_category().message(errno));
  }
  ~OpenFile() { close(file_); }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  int get() const { return file_; }

 private:
  int file_;
};

bool lists_path(const Json& entries, const std::string& path) {
  return std::any_of(entries.begin(), entries.end(),
                     [&](const Json& entry) { return entry["path"] == path; });
}

std::string plural(std::size_t count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

}  // namespace

std::string file_checksum(const fs::path& path) {
  const OpenFile file(path);
  const std::unique_ptr<XXH3_state_t, XXH_errorcode (*)(XXH3_state_t*)> state(XXH3_createState(),
                                                                              XXH3_freeState);
  if (!state) throw std::bad_alloc();
  XXH3_64bits_reset(state.get());
  std::vector<char> buffer(kReadBytes);
  for (;;) {
    const ssize_t got = read(file.get(), buffer.data(), buffer.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw InputError(path.string(), std::generic_category().message(errno));
    if (got == 0) break;
    XXH3_64bits_update(state.get(), buffer.data(), static_cast<std::size_t>(got));
  }
  std::array<char, 17> text{};
  std::snprintf(text.data(), text.size(), "%016llx",
                static_cast<unsigned long long>(XXH3_64bits_digest(state.get())));
  return text.data();
}

Report::Report(std::string tool, bool with_checksums)
    : tool_(std::move(tool)),
      with_checksums_(with_checksums),
      start_(std::chrono::steady_clock::now()) {
  const Machine machine = this_machine();
  data_ = {{"report_version", kReportVersion},
           {"tool", tool_},
           {"version", version_text()},
           {"outcome", "running"},
           {"exit_code", nullptr},
           {"error", ""},
           {"started", utc_now()},
           {"seconds", 0.0},
           {"peak_memory_bytes", 0},
           {"machine",
            {{"cpu", machine.cpu},
             {"cores", machine.cores},
             {"memory_bytes", machine.memory_bytes},
             {"os", machine.os},
             {"build", build_text()}}},
           {"parameters", Json::object()},
           {"inputs", Json::array()},
           {"outputs", Json::array()},
           {"counts", Json::object()},
           {"steps", Json::array()},
           {"quality", Json::object()},
           {"warnings", Json::array()}};
}

void Report::add_parameter(const std::string& name, const nlohmann::json& value) {
  data_["parameters"][name] = value;
}

void Report::add_input(const fs::path& path) {
  Json& inputs = data_["inputs"];
  if (lists_path(inputs, path.string())) return;
  check_input_file(path);
  Json entry = {{"path", path.string()}, {"bytes", fs::file_size(path)}};
  if (with_checksums_) entry["xxh3"] = file_checksum(path);
  inputs.push_back(std::move(entry));
}

void Report::add_output(const fs::path& path) {
  if (path.empty()) return;
  if (std::find(outputs_.begin(), outputs_.end(), path) == outputs_.end()) outputs_.push_back(path);
}

void Report::count(const std::string& name, std::uint64_t value) {
  Json& counts = data_["counts"];
  counts[name] = (counts.contains(name) ? counts[name].get<std::uint64_t>() : 0) + value;
}

void Report::quality(const std::string& name, const nlohmann::json& value) {
  data_["quality"][name] = value;
}

void Report::warn(const std::string& message) {
  data_["warnings"].push_back(message);
  log_warning(message);
}

void Report::step(const std::string& name, const std::function<void()>& body) {
  Json& steps = data_["steps"];
  std::size_t index = 0;
  while (index < steps.size() && steps[index]["name"] != name) ++index;
  if (index == steps.size()) {
    steps.push_back({{"name", name}, {"runs", 0}, {"seconds", 0.0}, {"peak_memory_bytes", 0}});
  }
  const auto start = std::chrono::steady_clock::now();
  const auto record = [&] {
    nlohmann::ordered_json& entry = data_["steps"][index];
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    entry["runs"] = entry["runs"].get<int>() + 1;
    entry["seconds"] = entry["seconds"].get<double>() + elapsed.count();
    entry["peak_memory_bytes"] = peak_resident_bytes();
  };
  try {
    body();
  } catch (...) {
    // A failed run's report shows where the time went.
    record();
    throw;
  }
  record();
}

void Report::finish(const std::string& outcome, const std::string& error, int exit_code) {
  data_["outcome"] = outcome;
  data_["error"] = error;
  data_["exit_code"] = exit_code;
}

double Report::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

nlohmann::json Report::to_json() const {
  nlohmann::json report = data_;
  report["seconds"] = seconds();
  report["peak_memory_bytes"] = peak_resident_bytes();
  for (const fs::path& path : outputs_) {
    std::error_code error;
    nlohmann::json entry = {{"path", path.string()}};
    if (fs::is_regular_file(path, error)) entry["bytes"] = fs::file_size(path, error);
    if (fs::exists(path, error)) report["outputs"].push_back(std::move(entry));
  }
  return report;
}

std::string Report::summary() const {
  std::string text = plural(data_["inputs"].size(), "input");
  for (const auto& [name, value] : data_["counts"].items()) {
    text += ", " + name + " " + std::to_string(value.get<std::uint64_t>());
  }
  if (!outputs_.empty()) {
    text += " -> " + outputs_.front().string();
    if (outputs_.size() > 1) text += " and " + std::to_string(outputs_.size() - 1) + " more";
  }
  std::array<char, 80> tail{};
  std::snprintf(tail.data(), tail.size(), "; %.1f s, peak memory %.2f GiB", seconds(),
                static_cast<double>(peak_resident_bytes()) / 0x1p30);
  text += tail.data();
  const std::size_t warnings = data_["warnings"].size();
  if (warnings > 0) text += ", " + plural(warnings, "warning");
  return text + " (" + version_text() + ")";
}

}  // namespace cornice
