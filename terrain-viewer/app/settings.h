// SPDX-License-Identifier: GPL-3.0-or-later
// What the window remembers from one start to the next: $XDG_CONFIG_HOME/cornice/viewer.json.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "terrain-viewer/app/camera_memory.h"
#include "terrain-viewer/app/options.h"

namespace cornice::viewer {

struct Settings {
  PixelSize window{1280, 720};
  Shading shading = Shading::kNatural;
  double contour_interval_m = 0.0;
  double error_pixels = 2.0;
  double frame_ms = 0.0;
  bool has_edges = false;
  bool shows_layers = true, shows_frames = false;
  std::vector<std::filesystem::path> recent;  ///< the latest first, absolute

  /// Bookmarks of the scene whose first layer is `file`.
  struct Marked {
    std::filesystem::path file;  ///< absolute
    Bookmark bookmark;
  };
  std::vector<Marked> marked;

  static constexpr std::size_t kMostRecent = 12, kMostMarked = 500;
  /// The file becomes the latest; kMostRecent are kept.
  void opened(const std::filesystem::path& file);
  std::vector<Bookmark> bookmarks_of(const std::filesystem::path& file) const;
  /// In place of those that the file had; the oldest beyond kMostMarked are forgotten.
  void set_bookmarks(const std::filesystem::path& file, const std::vector<Bookmark>& bookmarks);
};

/// Where settings are kept; empty where neither XDG_CONFIG_HOME nor HOME says so.
std::filesystem::path settings_path();

/// What a file holds; defaults where it is not there. A file that is damaged, and values that make
/// no sense, count as not there: `problem` says so in one line, empty otherwise. Never throws.
struct SettingsRead {
  Settings settings;
  std::string problem;
};
SettingsRead read_settings(const std::filesystem::path& path);

/// Written whole or not at all. Throws RunError.
void write_settings(const std::filesystem::path& path, const Settings& settings);

/// Makes them the defaults of the options for a window, before the command line is read.
void apply(const Settings& settings, Options& options);

}  // namespace cornice::viewer
