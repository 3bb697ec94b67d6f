// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/viewer/flight.h"

#include <sys/resource.h>
#include <time.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <numbers>
#include <string>
#include <thread>
#include <utility>

#include "terrain-viewer/render/layer.h"

namespace cornice::bench {
namespace {

using viewer::Camera;

constexpr double kFramesPerSecond = 60.0;

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Field `steal` of the first line of /proc/stat (proc(5)); 0 where there is none.
std::int64_t stolen_ticks() {
  std::ifstream stat("/proc/stat");
  std::string name;
  std::int64_t value = 0;
  stat >> name;
  for (int field = 0; field < 8; ++field)
    if (!(stat >> value)) return 0;
  return value;
}

rusage thread_usage() {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return usage;
}

/// Calls `update` and says what that took.
template <class Update>
FlightFrame measure(Update&& update) {
  FlightFrame frame;
  const rusage usage_before = thread_usage();
  const auto before = std::chrono::steady_clock::now();
  const double cpu_before = thread_seconds();
  update();
  frame.cpu_ms = 1e3 * (thread_seconds() - cpu_before);
  frame.ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - before).count();
  const rusage usage = thread_usage();
  frame.page_faults = usage.ru_minflt - usage_before.ru_minflt;
  frame.waits = usage.ru_nvcsw - usage_before.ru_nvcsw;
  frame.displaced = usage.ru_nivcsw - usage_before.ru_nivcsw;
  return frame;
}

/// On a curve of three loops round the middle of the ground, in the upper part of its heights,
/// looking ahead and down.
class Route {
 public:
  Route(const viewer::Layer& layer, double speed_ms)
      : middle_(0.5 * (layer.lowest() + layer.highest())),
        half_(0.35 * (layer.highest() - layer.lowest())),
        // The curve's mean speed for angles that rise by one a second.
        turn_per_s_(speed_ms / (2.2 * std::hypot(half_.x, half_.y))) {}

  Camera at(double seconds) const {
    const auto place = [&](double t) {
      return middle_ + Vec3d{half_.x * std::sin(2.0 * t), half_.y * std::sin(3.0 * t + 0.5),
                             half_.z * (0.6 + 0.2 * std::sin(5.0 * t))};
    };
    const double t = turn_per_s_ * seconds;
    const Vec3d eye = place(t), way = place(t + 1e-3) - eye;
    Camera camera;
    camera.eye = eye;
    camera.heading_deg = std::atan2(way.x, way.y) * 180.0 / std::numbers::pi;
    camera.pitch_deg = -15.0;
    camera.field_of_view_deg = 50.0;
    return camera;
  }

 private:
  Vec3d middle_, half_;
  double turn_per_s_;
};

}  // namespace

FlightResult fly_over(const std::filesystem::path& file, const FlightOptions& options,
                      const viewer::OffscreenContext& context) {
  viewer::GpuCells cells(options.gpu_bytes);
  if (options.makes_room_ahead)
    if (auto second = context.second()) cells.make_ahead(std::move(second));
  viewer::CellStoreOptions store;
  store.threads = 1;
  store.memory_bytes = options.cache_bytes;
  viewer::Layer layer(file, 0, store, cells);
  const Route route(layer, options.speed_ms);
  viewer::LayerView view;
  view.width = 1280;
  view.height = 720;
  view.error_pixels = options.error_pixels;
  view.camera = route.at(0.0);
  layer.settle(view, cells, 1);
  const std::uint64_t waited_for_before = cells.waited_for_bytes();

  FlightResult result;
  std::int64_t stolen_before = stolen_ticks();
  view.seconds = 1.0 / kFramesPerSecond;
  const auto period = std::chrono::duration_cast<std::chrono::steady_clock::duration>(
      std::chrono::duration<double>(1.0 / kFramesPerSecond));
  auto next = std::chrono::steady_clock::now();
  const auto frames = static_cast<int>(options.seconds * kFramesPerSecond);
  for (int frame = 0; frame < frames; ++frame) {
    std::this_thread::sleep_until(next);
    // Never sooner than that after the frame before: a flight that was held up goes on where it
    // was, instead of making up for it faster than cells can be read.
    next = std::max(next, std::chrono::steady_clock::now()) + period;
    view.camera = route.at(frame / kFramesPerSecond);
    view.velocity =
        kFramesPerSecond * (route.at((frame + 1) / kFramesPerSecond).eye - view.camera.eye);
    FlightFrame measured =
        measure([&] { layer.update(view, cells, static_cast<std::uint64_t>(frame) + 2); });
    const viewer::LayerCounts& counts = layer.counts();
    measured.cells = counts.cells;
    measured.triangles = counts.triangles;
    measured.missing = counts.cells_missing;
    measured.uploaded_bytes = counts.uploaded_bytes;
    const std::int64_t stolen = stolen_ticks();
    measured.stolen_ticks = stolen - stolen_before;
    stolen_before = stolen;
    result.frames.push_back(measured);
    result.gpu_over_budget =
        std::max(result.gpu_over_budget,
                 double(cells.allocated_bytes()) / static_cast<double>(options.gpu_bytes));
    result.cache_over_budget =
        std::max(result.cache_over_budget,
                 double(counts.store.memory_bytes) / static_cast<double>(options.cache_bytes));
  }
  result.waited_for_mb = 1e-6 * static_cast<double>(cells.waited_for_bytes() - waited_for_before);
  result.read_bytes = static_cast<double>(layer.counts().store.bytes_read);
  return result;
}

}  // namespace cornice::bench
