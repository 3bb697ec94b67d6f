// SPDX-License-Identifier: GPL-3.0-or-later
// The --report file in the making: docs/formats/report.md and docs/report.schema.json.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace cornice {

/// Thread contract: one thread at a time.
class Report {
 public:
  /// tool: "cornice-normals". Checksums cost one pass over every input; without them the report
  /// holds none.
  explicit Report(std::string tool, bool with_checksums = true);
  void add_parameter(const std::string& name, const nlohmann::json& value);
  /// Records path, size and xxh3 checksum of an input; once per path. Throws InputError where it
  /// cannot be read or is a folder.
  void add_input(const std::filesystem::path& path);
  /// Records an output; once per path. Its size is looked up when the report is written.
  void add_output(const std::filesystem::path& path);
  /// Adds to a named count.
  void count(const std::string& name, std::uint64_t value);
  void quality(const std::string& name, const nlohmann::json& value);
  /// Also logged at level warning.
  void warn(const std::string& message);
  /// Runs body as a named, timed step. Steps of one name add up. Steps may nest; the outer one's
  /// time then holds the inner one's.
  void step(const std::string& name, const std::function<void()>& body);
  /// outcome: "done", "failed" or "cancelled"; error: the line shown, empty where done.
  void finish(const std::string& outcome, const std::string& error, int exit_code);
  /// The whole report, with machine, version, seconds per step and peak memory.
  nlohmann::json to_json() const;
  /// "2 inputs, points 1234 -> out.ply; 1.2 s, peak memory 0.10 GiB, 1 warning".
  std::string summary() const;

 private:
  double seconds() const;

  std::string tool_;
  bool with_checksums_;
  std::chrono::steady_clock::time_point start_;
  std::vector<std::filesystem::path> outputs_;
  nlohmann::ordered_json data_;
};

/// xxh3-64 of a file's bytes, 16 hexadecimal digits, read in pieces. Throws InputError.
std::string file_checksum(const std::filesystem::path& path);

}  // namespace cornice
