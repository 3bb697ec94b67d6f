// SPDX-License-Identifier: GPL-3.0-or-later
// What a bench needs to run other programs: a folder for their files, and the run itself.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace cornice::bench {

/// A folder of this process's own; gone with the object.
class ScratchFolder {
 public:
  /// "<in>/cornice-bench-<name>-<process>", made empty.
  explicit ScratchFolder(const std::string& name,
                         const std::filesystem::path& in = std::filesystem::temp_directory_path());
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

/// The folder that this executable lies in, beside which the stages are built.
std::filesystem::path own_folder();

/// What a run took.
struct ProgramCost {
  double seconds = 0.0;                   ///< of wall-clock time
  double cpu_seconds = 0.0;               ///< of all its threads; a busy machine changes it less
  std::uint64_t peak_resident_bytes = 0;  ///< looked at every 10 ms
};

/// Runs arguments[0], a path or a name on PATH, with the rest as its arguments, and waits. All it
/// says goes to the file `log`. Throws RunError with the log's last line where the program cannot
/// be started or does not exit with 0.
ProgramCost run_program(const std::vector<std::string>& arguments,
                        const std::filesystem::path& log);

}  // namespace cornice::bench
