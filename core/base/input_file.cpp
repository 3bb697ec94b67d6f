// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/base/input_file.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <string_view>
#include <system_error>

#include "core/base/error.h"

namespace cornice {
namespace {

std::string reason(int error) { return std::generic_category().message(error); }

/// Bytes of the UTF-8 character that `text` begins with; 0 where it begins with none (RFC 3629).
std::size_t first_character(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char lead = byte(0);
  if (lead < 0x80) return 1;
  const std::size_t length = lead < 0xe0 ? 2 : lead < 0xf0 ? 3 : 4;
  if (lead < 0xc2 || lead > 0xf4 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if (byte(i) < 0x80 || byte(i) > 0xbf) return 0;
  }
  const unsigned char second = byte(1);
  const bool is_overlong = (lead == 0xe0 && second < 0xa0) || (lead == 0xf0 && second < 0x90);
  const bool is_no_scalar = (lead == 0xed && second > 0x9f) || (lead == 0xf4 && second > 0x8f);
  return is_overlong || is_no_scalar ? 0 : length;
}

}  // namespace

void check_input_file(const std::filesystem::path& path) {
  const std::string name = path.string();
  struct stat facts {};
  if (stat(name.c_str(), &facts) != 0) {
    throw InputError(name, reason(errno) + "; check the path");
  }
  if (S_ISDIR(facts.st_mode)) throw InputError(name, "is a folder, not a file; give a file in it");
  if (!S_ISREG(facts.st_mode)) {
    throw InputError(name, "is no regular file; write what it gives to a file, and give that");
  }
  if (access(name.c_str(), R_OK) != 0) {
    throw InputError(name, "cannot be opened: " + reason(errno) + "; check its permissions");
  }
}

void check_utf8_name(const std::filesystem::path& path) {
  const std::string name = path.string();
  std::string_view rest = name;
  while (!rest.empty()) {
    const std::size_t length = first_character(rest);
    if (length == 0) throw InputError(name, "has a name that is not UTF-8; rename it");
    rest.remove_prefix(length);
  }
}

}  // namespace cornice
