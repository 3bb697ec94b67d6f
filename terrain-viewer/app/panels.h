// SPDX-License-Identifier: GPL-3.0-or-later
// What lies over the picture: read-outs, legend, scale, layers, frame times, help (Dear ImGui).
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "terrain-viewer/app/camera_memory.h"
#include "terrain-viewer/app/session.h"
#include "terrain-viewer/app/swipe_line.h"
#include "terrain-viewer/scene/camera.h"

namespace cornice::viewer {

/// Bytes a second, over the last second.
class Rate {
 public:
  void add(double bytes, double seconds) {
    bytes_ += bytes;
    seconds_ += seconds;
    if (seconds_ < 1.0) return;
    mb_per_s_ = bytes_ / seconds_ * 1e-6;
    bytes_ = seconds_ = 0.0;
  }
  double mb_per_s() const { return mb_per_s_; }

 private:
  double bytes_ = 0.0, seconds_ = 0.0, mb_per_s_ = 0.0;
};

/// Shown panels and what they are about.
struct PanelState {
  bool shows_help = false, shows_frames = false, shows_layers = true;
  bool asks_place = false;
  std::array<char, 96> place{};
  Split::Kind split = Split::Kind::kNone;
  SwipeLine line;                             ///< of Split::Kind::kSwipe
  std::string read_out = "sky";               ///< what is under the cursor
  double depth_m = 1000.0;                    ///< along the line of sight, for the scale bar
  std::vector<std::filesystem::path> recent;  ///< files opened lately
  std::string message;                        ///< last line of the log
  std::string message_of_place;               ///< why the place asked for is none
  Rate uploads, reads;
  int picture_scale = 1;  ///< of F12's pictures: times the window's width and height
  double speed_ms = 0.0;
  bool walks = false;
  std::vector<Bookmark> bookmarks;
  std::array<float, 240> frame_ms{};
  std::size_t frame_at = 0;
};

/// What a panel was asked for.
struct PanelResult {
  std::optional<Camera> go;
  std::optional<std::filesystem::path> open;
};

/// width, height: of the window, in ImGui's units. ground: height in plan, asked where a place
/// without a height is gone to.
PanelResult draw_panels(PanelState& state, Session& session, const Camera& camera, int width,
                        int height, const FrameCounts& counts, const Ground& ground);

}  // namespace cornice::viewer
