// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/info/examine.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <string_view>
#include <system_error>

#include "core/base/error.h"
#include "core/base/input_file.h"

namespace cornice::info {
namespace {

namespace fs = std::filesystem;

enum class Kind { kPoints, kPly, kRaster };

std::string lower_name(const fs::path& path) {
  std::string name = path.filename().string();
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return name;
}

/// By the first bytes; by the name only for what has no such mark, so that a damaged point file is
/// told what is wrong with it as one.
Kind kind_of(const fs::path& path) {
  std::array<char, 4> magic{};
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError(path.string(), "cannot be opened");
  file.read(magic.data(), magic.size());
  const std::string_view start(magic.data(), magic.size());
  const std::string name = lower_name(path);
  if (start == "LASF") return Kind::kPoints;
  if (start.substr(0, 3) == "ply" || name.ends_with(".ply")) return Kind::kPly;
  for (const char* extension : {".las", ".laz", ".zip"}) {
    if (name.ends_with(extension)) return Kind::kPoints;
  }
  return Kind::kRaster;
}

}  // namespace

FileFacts examine(const fs::path& path, const ExamineOptions& options, Progress& progress) {
  check_input_file(path);
  FileFacts file;
  file.path = path;
  switch (kind_of(path)) {
    case Kind::kPoints:
      file.facts = examine_points(path, options, progress);
      break;
    case Kind::kPly:
      file.facts = examine_ply(path, options, progress);
      break;
    case Kind::kRaster:
      file.facts = examine_raster(path, options, progress);
      break;
  }
  file.bytes = fs::file_size(path);
  file.defects = std::visit([](const auto& facts) { return find_defects(facts); }, file.facts);
  return file;
}

}  // namespace cornice::info
