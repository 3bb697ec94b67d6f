// SPDX-License-Identifier: GPL-3.0-or-later
// Files that are dropped on a window or chosen in it: layers, and rasters over the ground.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "terrain-viewer/app/session.h"

namespace cornice::viewer {

/// Folders in place of the hierarchies in them or, where there are none, of their rasters, by name.
/// A folder with neither stays what it is.
std::vector<std::filesystem::path> without_folders(const std::vector<std::filesystem::path>& paths);

/// What came of them.
struct Opened {
  std::vector<std::filesystem::path> hierarchies;  ///< those that became layers
  std::string message;                             ///< one line, never empty
};

/// Hierarchies become layers, one each; photographs together lie over the ground, and so do rasters
/// of other numbers. What cannot be opened changes nothing and is named. layers: files that are
/// layers already. Throws nothing that one file could be the cause of.
Opened open_files(Session& session, const std::vector<std::filesystem::path>& layers,
                  const std::vector<std::filesystem::path>& paths);

}  // namespace cornice::viewer
