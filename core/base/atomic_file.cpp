// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/base/atomic_file.h"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <string>
#include <system_error>
#include <vector>

#include "core/base/error.h"
#include "core/base/write_problem.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMark = ".partial";

struct LivePartials {
  std::mutex mutex;
  std::vector<fs::path> paths;
};

LivePartials& live_partials() {
  static LivePartials live;
  return live;
}

/// Host name without dots or anything else that the temporary name's syntax uses.
std::string host_key() {
  char name[256] = {};
  if (gethostname(name, sizeof name - 1) != 0 || name[0] == '\0') return "localhost";
  std::string key(name);
  for (char& c : key) {
    const bool plain =
        (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '-';
    if (!plain) c = '_';
  }
  return key;
}

fs::path folder_of(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

/// Where the bytes go in the end: a symbolic link's target instead of the link.
fs::path resolved(const fs::path& target) {
  std::error_code error;
  if (!fs::is_symlink(target, error)) return target;
  fs::path real = fs::weakly_canonical(target, error);
  return error ? target : real;
}

fs::path partial_name(const fs::path& target) {
  static std::atomic<unsigned> counter{0};
  std::string name = "." + target.filename().string() + "." + host_key() + "." +
                     std::to_string(getpid()) + "-" + std::to_string(counter++);
  name += kMark;
  name += target.extension().string();
  return folder_of(target) / name;
}

/// Removes `partial` and what libraries put beside it under its name (journals, .aux.xml).
void remove_with_companions(const fs::path& partial) noexcept {
  try {
    std::error_code error;
    const std::string name = partial.filename().string();
    const std::string stem = name.substr(0, name.rfind(kMark) + kMark.size());
    std::vector<fs::path> found;
    for (fs::directory_iterator it(folder_of(partial), error), end; !error && it != end;
         it.increment(error)) {
      if (it->path().filename().string().starts_with(stem)) found.push_back(it->path());
    }
    for (const fs::path& path : found) fs::remove_all(path, error);
  } catch (...) {
    unlink(partial.c_str());
  }
}

void forget(const fs::path& partial) {
  LivePartials& live = live_partials();
  const std::lock_guard lock(live.mutex);
  std::erase(live.paths, partial);
}

/// Flushes a file or folder. Returns 0 or the error number.
int flush(const fs::path& path, int flags) {
  const int file = open(path.c_str(), flags | O_CLOEXEC);
  if (file < 0) return errno;
  int error = fsync(file) == 0 ? 0 : errno;
  // Some network file systems cannot flush a folder; the rename is then as safe as they make it.
  if (error == EINVAL || error == ENOTSUP) error = 0;
  if (close(file) != 0 && error == 0) error = errno;
  return error;
}

/// Process id in ".NAME.HOST.PID-N.partial.EXT"; 0 where the name is not of this form, of another
/// host, or not of `target_name` (any where that is empty).
pid_t owner_of(const std::string& name, const std::string& target_name) {
  const std::size_t mark = name.rfind(kMark);
  if (name.empty() || name[0] != '.' || mark == std::string::npos) return 0;
  if (!target_name.empty() && !name.starts_with("." + target_name + ".")) return 0;
  const std::string_view head = std::string_view(name).substr(0, mark);
  const std::size_t pid_at = head.rfind('.');
  if (pid_at == std::string_view::npos) return 0;
  if (!head.substr(0, pid_at).ends_with("." + host_key())) return 0;
  pid_t pid = 0;
  const char* last = head.data() + head.size();
  const auto [end, error] = std::from_chars(head.data() + pid_at + 1, last, pid);
  if (error != std::errc() || end == last || *end != '-' || pid <= 0) return 0;
  return pid;
}

}  // namespace

AtomicFile::AtomicFile(fs::path target) : target_(resolved(target)) {
  std::error_code error;
  const fs::path folder = folder_of(target_);
  fs::create_directories(folder, error);
  if (error && !fs::is_directory(folder)) {
    throw RunError(target_.string(), "cannot create its folder: " + error.message());
  }
  const fs::file_status status = fs::status(target_, error);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    throw RunError(target_.string(), "exists and is no regular file; give another output name");
  }
  if (access(folder.c_str(), W_OK | X_OK) != 0) {
    throw RunError(target_.string(), "cannot write in its folder: " + write_problem(errno));
  }
  partial_ = partial_name(target_);
  LivePartials& live = live_partials();
  const std::lock_guard lock(live.mutex);
  live.paths.push_back(partial_);
}

AtomicFile::~AtomicFile() {
  if (committed_) return;
  forget(partial_);
  remove_with_companions(partial_);
}

void AtomicFile::commit() {
  if (const int error = flush(partial_, O_RDONLY); error != 0) {
    throw RunError(target_.string(), "cannot be written: " + write_problem(error));
  }
  if (std::rename(partial_.c_str(), target_.c_str()) != 0) {
    throw RunError(target_.string(), "cannot be renamed to: " + write_problem(errno));
  }
  committed_ = true;
  forget(partial_);
  // The file is whole from here on; a folder that cannot be flushed only delays the name.
  flush(folder_of(target_), O_RDONLY | O_DIRECTORY);
}

void write_file_atomically(const fs::path& target, std::string_view contents) {
  AtomicFile file(target);
  const int descriptor = open(file.path().c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor < 0) throw RunError(target.string(), "cannot be created: " + write_problem(errno));
  int error = 0;
  while (!contents.empty() && error == 0) {
    const ssize_t written = write(descriptor, contents.data(), contents.size());
    if (written >= 0) {
      contents.remove_prefix(static_cast<std::size_t>(written));
    } else if (errno != EINTR) {
      error = errno;
    }
  }
  if (close(descriptor) != 0 && error == 0) error = errno;
  if (error != 0) throw RunError(target.string(), "cannot be written: " + write_problem(error));
  file.commit();
}

int remove_stale_partials(const fs::path& target) {
  std::error_code error;
  const fs::path real = resolved(target);
  const bool whole_folder = fs::is_directory(real, error);
  const fs::path folder = whole_folder ? real : folder_of(real);
  const std::string target_name = whole_folder ? std::string() : real.filename().string();
  std::vector<fs::path> stale;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const pid_t pid = owner_of(it->path().filename().string(), target_name);
    if (pid != 0 && kill(pid, 0) != 0 && errno == ESRCH) stale.push_back(it->path());
  }
  int removed = 0;
  for (const fs::path& path : stale) {
    if (fs::remove_all(path, error) > 0 && !error) ++removed;
  }
  return removed;
}

void remove_live_partials() noexcept {
  LivePartials& live = live_partials();
  // A thread that holds the lock for good must not keep this one from ending.
  std::unique_lock lock(live.mutex, std::try_to_lock);
  for (const fs::path& path : live.paths) remove_with_companions(path);
}

}  // namespace cornice
