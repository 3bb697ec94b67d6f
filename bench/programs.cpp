// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/programs.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <fstream>
#include <thread>

#include "core/base/error.h"

namespace cornice::bench {
namespace {

namespace fs = std::filesystem;

/// The last line that is not blank.
std::string last_line(const fs::path& log) {
  std::ifstream file(log);
  std::string last;
  for (std::string line; std::getline(file, line);) {
    if (line.find_first_not_of(" \t\r") != std::string::npos) last = line;
  }
  return last;
}

/// The most that a running process has held; 0 once it has ended. The kernel's own account of ended
/// children counts what their parent held when it started them.
std::uint64_t peak_of(pid_t process) {
  std::ifstream status("/proc/" + std::to_string(process) + "/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmHWM:")) return std::stoull(line.substr(6)) * 1024;
  }
  return 0;
}

std::string how_it_ended(int status) {
  if (WIFSIGNALED(status)) return "was ended by signal " + std::to_string(WTERMSIG(status));
  return "failed with exit code " + std::to_string(WEXITSTATUS(status));
}

pid_t start(const std::vector<std::string>& arguments, const fs::path& log) {
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  posix_spawn_file_actions_t files;
  ::posix_spawn_file_actions_init(&files);
  ::posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, log.c_str(),
                                     O_WRONLY | O_CREAT | O_TRUNC, 0644);
  ::posix_spawn_file_actions_adddup2(&files, STDOUT_FILENO, STDERR_FILENO);
  pid_t child = -1;
  const int failed = ::posix_spawnp(&child, argv[0], &files, nullptr, argv.data(), ::environ);
  ::posix_spawn_file_actions_destroy(&files);
  if (failed != 0)
    throw RunError(arguments.front(), std::string("cannot be started: ") + std::strerror(failed));
  return child;
}

}  // namespace

ScratchFolder::ScratchFolder(const std::string& name, const fs::path& in)
    : path_(in / ("cornice-bench-" + name + "-" + std::to_string(::getpid()))) {
  fs::remove_all(path_);
  fs::create_directories(path_);
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

fs::path own_folder() { return fs::read_symlink("/proc/self/exe").parent_path(); }

ProgramCost run_program(const std::vector<std::string>& arguments, const fs::path& log) {
  using Clock = std::chrono::steady_clock;
  ProgramCost cost;
  const auto begin = Clock::now();
  const pid_t child = start(arguments, log);
  int status = 0;
  pid_t ended = 0;
  rusage used{};
  while ((ended = ::wait4(child, &status, WNOHANG, &used)) == 0) {
    cost.peak_resident_bytes = std::max(cost.peak_resident_bytes, peak_of(child));
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  cost.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  if (ended < 0) throw RunError(arguments.front(), "cannot be waited for");
  for (const timeval& time : {used.ru_utime, used.ru_stime})
    cost.cpu_seconds += static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  if (status != 0) {
    const std::string said = last_line(log);
    throw RunError(arguments.front(),
                   how_it_ended(status) + (said.empty() ? "" : "; it said: " + said));
  }
  return cost;
}

}  // namespace cornice::bench
