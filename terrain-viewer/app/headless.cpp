// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/headless.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "core/base/error.h"
#include "terrain-viewer/app/legend.h"
#include "terrain-viewer/app/overlay.h"
#include "terrain-viewer/app/picture.h"
#include "terrain-viewer/app/session.h"
#include "terrain-viewer/app/viewpoint.h"
#include "terrain-viewer/render/offscreen_context.h"
#include "terrain-viewer/scene/camera_file.h"
#include "terrain-viewer/scene/navigation.h"

namespace cornice::viewer {
namespace {

/// The file of frame `frame` of a pattern with one %d or %0Nd; the pattern itself where it has
/// none.
std::filesystem::path frame_name(const std::filesystem::path& pattern, int frame) {
  const std::string text = pattern.filename().string();
  const std::size_t percent = text.find('%');
  if (percent == std::string::npos) return pattern;
  std::size_t end = percent + 1;
  while (end < text.size() && text[end] >= '0' && text[end] <= '9') ++end;
  const int digits = end > percent + 1 ? std::atoi(text.c_str() + percent + 1) : 1;
  if (end >= text.size() || text[end] != 'd' || digits > 12 ||
      text.find('%', end) != std::string::npos)
    throw UsageError("--output", "has a \"%\" that is not one %d or %04d");
  std::array<char, 32> number{};
  std::snprintf(number.data(), number.size(), "%0*d", digits, frame);
  return pattern.parent_path() / (text.substr(0, percent) + number.data() + text.substr(end + 1));
}

/// So that legends can be read in large pictures, too.
int legend_scale(PixelSize size) { return std::max(1, (size.height + 500) / 1000); }

/// Before anything is drawn. Throws UsageError.
void check_ending(const std::filesystem::path& output) {
  const std::string ending = output.extension().string();
  if (ending != ".png" && ending != ".jpg" && ending != ".jpeg")
    throw UsageError("--output", "is \"" + output.string() + "\"; a picture is .png or .jpg");
}

double milliseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

/// Everything that one run draws with.
class Studio {
 public:
  Studio(const Options& options, PixelSize size)
      : size_(size),
        split_{options.side_by_side ? Split::Kind::kSideBySide : Split::Kind::kNone},
        session_(options),
        target_(size.width, size.height, options.samples),
        resolved_(size.width, size.height, 1) {
    if (options.has_legend) overlay_ = std::make_unique<Overlay>(legend_scale(size));
  }

  /// The camera of options without a path, and its light.
  Camera choose_camera(const Options& options) {
    const Camera camera =
        options.camera.empty() ? find_camera(options.viewpoint) : read_camera(options.camera);
    if (options.viewpoint != Viewpoint::kAll && !options.sun_azimuth_deg && options.time.empty())
      session_.style().sun = sun_direction(sun_azimuth_for(camera), options.sun_elevation_deg);
    return camera;
  }

  /// Draws one frame; `seconds` since the one before, 0: waits for all that it needs.
  Picture draw(const Camera& camera, double seconds, Vec3d velocity, Report& report) {
    const auto start = std::chrono::steady_clock::now();
    const FrameCounts counts = session_.draw(target_.framebuffer(), size_.width, size_.height,
                                             camera, seconds, velocity, split_);
    for (const std::string& failure : session_.take_failures())
      report.warn(failure + "; its parent is drawn instead");
    if (seconds == 0.0 && !counts.is_settled) ++unsettled_;
    resolve(target_, resolved_);
    if (overlay_)
      overlay_->draw(resolved_, [&] {
        draw_legends(session_.style(), session_.cover() == Cover::kDifference,
                     session_.level_count(), size_.width / legend_scale(size_));
      });
    Picture picture = read_picture(resolved_);
    select_ms_.push_back(counts.select_ms);
    triangles_.push_back(static_cast<double>(counts.triangles));
    drawn_cells_.push_back(counts.cells);
    if (counts.overdraw > 0.0) overdraw_.push_back(counts.overdraw);
    frame_ms_.push_back(milliseconds_since(start));
    return picture;
  }

  void tell(Report& report) {
    const auto middle = [](std::vector<double> values) {
      std::nth_element(values.begin(),
                       values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                       values.end());
      return values[values.size() / 2];
    };
    report.count("frames", frame_ms_.size());
    report.quality("selection and upload, median, ms", middle(select_ms_));
    report.quality("frame, median, ms", middle(frame_ms_));
    report.quality("frame, slowest, ms", *std::max_element(frame_ms_.begin(), frame_ms_.end()));
    report.quality("triangles, median", middle(triangles_));
    report.quality("cells, median", middle(drawn_cells_));
    if (!overdraw_.empty()) report.quality("overdraw, median", middle(overdraw_));
    report.quality("memory on the GPU, MiB", double(session_.cells().used_bytes()) / 1048576.0);
    report.quality("renderer", gl_description());
    std::uint64_t read = 0;
    for (const auto& layer : session_.layers()) read += layer->counts().store.bytes_read;
    report.count("bytes read", read);
    for (const Drape* drape : {session_.photo(), session_.difference()})
      if (drape != nullptr && !drape->advice().empty()) report.warn(drape->advice());
    if (const std::string missing = session_.missing_values(); !missing.empty())
      report.warn(missing);
    if (unsettled_ > 0)
      report.warn(std::to_string(unsettled_) +
                  " pictures are coarser than asked: a larger --gpu-memory-mib or --cache-mib lets "
                  "them be as fine");
  }

 private:
  Camera find_camera(Viewpoint from) {
    const double shape = double(pane_width(size_.width, split_)) / double(size_.height);
    const SceneBox box = box_of(session_.layers());
    if (from == Viewpoint::kAll) return seeing_all({}, box.lowest, box.highest, shape);
    const std::vector<Facet> facets = facets_of(session_.layers().front()->file());
    return from == Viewpoint::kOverview ? overview(facets, shape) : steepest_view(facets, shape);
  }

  PixelSize size_;
  Split split_;
  OffscreenContext context_;
  Session session_;
  Target target_, resolved_;
  std::unique_ptr<Overlay> overlay_;
  std::uint64_t unsettled_ = 0;
  std::vector<double> select_ms_, frame_ms_, triangles_, drawn_cells_, overdraw_;
};

void draw_path(const Options& options, Studio& studio, Report& report, Progress& progress) {
  const CameraPath path = read_camera_path(options.path);
  if (options.output.filename().string().find('%') == std::string::npos)
    throw UsageError("--output", "needs a %04d for the number of the frame, with --path");
  const int frames = 1 + static_cast<int>(std::floor(path.duration_s() * path.frames_per_second));
  const double step = 1.0 / path.frames_per_second;
  const double first = path.keys.front().time_s;
  progress.begin("frames", static_cast<std::uint64_t>(frames));
  for (int frame = 0; frame < frames; ++frame) {
    const double time = first + frame * step;
    const Camera camera = path.at(time);
    const Vec3d velocity = (path.at(time + step).eye - camera.eye) / step;
    const Picture picture = studio.draw(camera, options.streams ? step : 0.0, velocity, report);
    const std::filesystem::path file = frame_name(options.output, frame);
    write_picture(file, picture);
    progress.advance(1);
    if (!progress.cancelled()) continue;
    report.warn(std::to_string(frame + 1) + " of " + std::to_string(frames) +
                " frames are written, the last is " + file.string());
    throw Cancelled();
  }
  progress.end();
}

}  // namespace

void run_headless(const Options& options, Report& report, Progress& progress) {
  if (options.output.empty())
    throw UsageError("--output", "is missing: where the picture is to go");
  check_ending(options.output);
  if (options.files.empty())
    throw UsageError("FILE", "is missing: which hierarchies to draw, .hlod");
  if (!options.save_camera.empty() && !options.path.empty())
    throw UsageError("--save-camera", "is for one picture; --path asks for many");
  const PixelSize size = parse_size(options.size);
  for (const auto& file : options.files) report.add_input(file);
  std::unique_ptr<Studio> studio;
  report.step("open", [&] { studio = std::make_unique<Studio>(options, size); });
  report.step("draw", [&] {
    if (!options.path.empty()) {
      draw_path(options, *studio, report, progress);
      return;
    }
    const Camera camera = studio->choose_camera(options);
    write_picture(frame_name(options.output, 0), studio->draw(camera, 0.0, {}, report));
    if (!options.save_camera.empty()) write_camera(options.save_camera, camera);
  });
  studio->tell(report);
}

}  // namespace cornice::viewer
