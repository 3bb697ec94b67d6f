// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/new_file.h"

#include <algorithm>
#include <array>
#include <ctime>
#include <system_error>

namespace cornice::viewer {

std::string unused_stem(const std::filesystem::path& folder, const std::string& stem,
                        const std::vector<std::string>& endings) {
  const auto is_used = [&](const std::string& name) {
    return std::any_of(endings.begin(), endings.end(), [&](const std::string& ending) {
      std::error_code error;
      // Of links themselves: one that leads nowhere is written through, too.
      return std::filesystem::exists(
          std::filesystem::symlink_status(folder / (name + ending), error));
    });
  };
  std::string name = stem;
  for (int n = 2; is_used(name); ++n) name = stem + "-" + std::to_string(n);
  return name;
}

std::string time_stamp() {
  const std::time_t now = std::time(nullptr);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y%m%d-%H%M%S", std::localtime(&now));
  return text.data();
}

}  // namespace cornice::viewer
