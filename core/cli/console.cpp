// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/cli/console.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <mutex>

namespace cornice {
namespace {

struct Console {
  std::mutex mutex;
  std::string bar;
};

Console& console() {
  static Console instance;
  return instance;
}

void put(const std::string& text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

}  // namespace

bool console_is_terminal() {
  const char* term = std::getenv("TERM");
  return isatty(STDERR_FILENO) == 1 && (term == nullptr || std::strcmp(term, "dumb") != 0);
}

int console_width() {
  winsize size{};
  const bool known = ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return known ? size.ws_col : 80;
}

void console_line(const std::string& line) {
  std::string clean = line;
  for (char& c : clean) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  }
  Console& state = console();
  const std::lock_guard lock(state.mutex);
  const std::string clear = state.bar.empty() ? "" : "\r\x1b[K";
  put(clear + clean + "\n" + state.bar);
}

void console_bar(const std::string& text) {
  Console& state = console();
  const std::lock_guard lock(state.mutex);
  if (text.empty() && state.bar.empty()) return;
  put("\r\x1b[K" + text);
  state.bar = text;
}

}  // namespace cornice
