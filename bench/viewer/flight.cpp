// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/viewer/flight.h"

#include <time.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <thread>

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

FlightResult fly_over(const std::filesystem::path& file, const FlightOptions& options) {
  viewer::GpuCells cells(options.gpu_bytes);
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

  FlightResult result;
  view.seconds = 1.0 / kFramesPerSecond;
  const auto start = std::chrono::steady_clock::now();
  const auto frames = static_cast<int>(options.seconds * kFramesPerSecond);
  for (int frame = 0; frame < frames; ++frame) {
    std::this_thread::sleep_until(start +
                                  std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                                      std::chrono::duration<double>(frame / kFramesPerSecond)));
    view.camera = route.at(frame / kFramesPerSecond);
    view.velocity =
        kFramesPerSecond * (route.at((frame + 1) / kFramesPerSecond).eye - view.camera.eye);
    const auto before = std::chrono::steady_clock::now();
    const double cpu_before = thread_seconds();
    layer.update(view, cells, static_cast<std::uint64_t>(frame) + 2);
    result.cpu_ms.push_back(1e3 * (thread_seconds() - cpu_before));
    result.ms.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - before)
            .count());
    const viewer::LayerCounts& counts = layer.counts();
    result.cells.push_back(counts.cells);
    result.triangles.push_back(static_cast<double>(counts.triangles));
    result.missing.push_back(counts.cells_missing);
    result.uploaded_bytes += static_cast<double>(counts.uploaded_bytes);
    result.gpu_over_budget =
        std::max(result.gpu_over_budget,
                 double(cells.used_bytes()) / static_cast<double>(options.gpu_bytes));
    result.cache_over_budget =
        std::max(result.cache_over_budget,
                 double(counts.store.memory_bytes) / static_cast<double>(options.cache_bytes));
  }
  result.read_bytes = static_cast<double>(layer.counts().store.bytes_read);
  return result;
}

}  // namespace cornice::bench
