// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/full_disk.h"

#include <sched.h>
#include <sys/mount.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <stdexcept>

#include "core/base/error.h"

namespace cornice::test {
namespace {

constexpr int kCannotMount = 77;

bool mount_small_disk(const std::filesystem::path& folder) {
  // Without root's rights a namespace of one's own gives them, where the system allows it.
  if (unshare(CLONE_NEWNS) != 0 && unshare(CLONE_NEWUSER | CLONE_NEWNS) != 0) return false;
  if (mount("none", "/", "", MS_REC | MS_PRIVATE, "") != 0) return false;
  return mount("none", folder.c_str(), "tmpfs", 0, "size=64k") == 0;
}

std::string outcome_of(const std::filesystem::path& folder, const std::function<void()>& body) {
  std::string text;
  try {
    body();
  } catch (const RunError& error) {
    text = error.what();
  }
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    text += "|" + entry.path().filename().string();
  }
  return text;
}

}  // namespace

std::optional<std::string> on_full_disk(const std::filesystem::path& folder,
                                        const std::function<void()>& body) {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) throw std::runtime_error("no pipe");
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("no child process");
  if (child == 0) {
    close(ends[0]);
    if (!mount_small_disk(folder)) _exit(kCannotMount);
    const std::string text = outcome_of(folder, body);
    const bool told = write(ends[1], text.data(), text.size()) == static_cast<ssize_t>(text.size());
    _exit(told ? 0 : 1);
  }
  close(ends[1]);
  std::string text;
  std::array<char, 4096> buffer{};
  for (ssize_t got = 0; (got = read(ends[0], buffer.data(), buffer.size())) > 0;) {
    text.append(buffer.data(), static_cast<std::size_t>(got));
  }
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (WIFEXITED(status) && WEXITSTATUS(status) == kCannotMount) return std::nullopt;
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) throw std::runtime_error("the child died");
  return text;
}

}  // namespace cornice::test
