// SPDX-License-Identifier: GPL-3.0-or-later
// What golden pictures are of: a crater whose vertices have all attributes, the same ground as an
// elevation model would have it, and a photograph.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/io/raster.h"
#include "terrain-viewer/app/options.h"
#include "terrain-viewer/app/session.h"
#include "terrain-viewer/render/offscreen_context.h"
#include "tests/support/temporary_folder.h"

namespace cornice::viewer {

/// One golden picture.
struct View {
  std::string name;
  Shading shading = Shading::kNatural;
  /// The finest mesh, so that no change of simplifying or choosing is one of the picture.
  double error_pixels = 0.02;
  double contour_interval_m = 0.0;
  bool has_second_layer = false;
  bool has_photo = false;
  Split::Kind split = Split::Kind::kNone;
};

/// Changes something that must be seen.
using Change = std::function<void(Session& session, Camera& camera)>;

/// Files and OpenGL for all pictures of a test program.
class Stage {
 public:
  Stage();
  static constexpr int kWidth = 320, kHeight = 200;
  Picture draw(const View& view, const Change& change = {});

 private:
  test::TemporaryFolder folder_;
  OffscreenContext context_;
};

}  // namespace cornice::viewer
