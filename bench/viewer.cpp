// SPDX-License-Identifier: GPL-3.0-or-later
// The viewer: how soon there is a picture, what a frame costs the thread that draws, how near the
// picture is to that of the full mesh, whether budgets hold.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "bench/bench_json.h"
#include "bench/programs.h"
#include "bench/viewer/flight.h"
#include "bench/viewer/made_hierarchy.h"
#include "core/base/random.h"
#include "terrain-viewer/app/picture.h"
#include "terrain-viewer/app/session.h"
#include "terrain-viewer/render/offscreen_context.h"
#include "terrain-viewer/scene/navigation.h"

namespace {

using namespace cornice;
using namespace cornice::bench;
namespace fs = std::filesystem;

struct Own {
  fs::path large, scene;
  FlightOptions flight;
};

std::uint64_t finest_triangles(const hlod::File& file) { return file.levels().back().triangles; }

/// From nothing to the first picture, as the program does it: a context, the shaders, the file.
void measure_opening(const fs::path& file, const Options& options, Result& result) {
  std::vector<double> all, of_file;
  std::uint64_t triangles = 0;
  for (int run = 0; run < (options.quick ? 2 : 5); ++run) {
    double context_s = 0.0;
    all.push_back(seconds_of([&] {
      std::unique_ptr<viewer::OffscreenContext> context;
      context_s = seconds_of([&] { context = std::make_unique<viewer::OffscreenContext>(); });
      viewer::Options view;
      view.files = {file};
      viewer::Session session(view);
      viewer::Target target(1280, 720, 1);
      const viewer::SceneBox box = viewer::box_of(session.layers());
      session.draw(target.framebuffer(), 1280, 720,
                   viewer::seeing_all({}, box.lowest, box.highest, 1280.0 / 720.0), 1.0 / 60.0, {});
      glFinish();
      triangles = finest_triangles(session.layers().front()->file());
    }));
    of_file.push_back(all.back() - context_s);
  }
  result.figure("open_triangles", static_cast<double>(triangles));
  result.figure("open_s", median(all));
  result.figure("open_without_context_s", median(of_file));
  if (triangles > 95'000'000 && triangles < 120'000'000) result.figure("open_s_100m", median(all));
}

void measure_flight(const fs::path& file, const Own& own, Result& result) {
  const viewer::OffscreenContext context;
  const FlightResult flight = fly_over(file, own.flight);
  const auto worst = [](const std::vector<double>& values) {
    return *std::max_element(values.begin(), values.end());
  };
  result.figure("render_thread_ms_median", median(flight.ms));
  result.figure("render_thread_ms_worst", worst(flight.ms));
  result.figure("worst_over_median", worst(flight.ms) / median(flight.ms));
  result.figure("render_thread_cpu_ms_median", median(flight.cpu_ms));
  result.figure("worst_over_median_cpu", worst(flight.cpu_ms) / median(flight.cpu_ms));
  result.figure("flight_cells_median", median(flight.cells));
  result.figure("flight_triangles_median", median(flight.triangles));
  result.figure("flight_cells_missing_most", worst(flight.missing));
  const auto waiting = static_cast<double>(
      std::count_if(flight.missing.begin(), flight.missing.end(), [](double n) { return n > 0; }));
  result.figure("flight_frames_waiting_share", waiting / static_cast<double>(flight.ms.size()));
  result.figure("flight_uploaded_mb", 1e-6 * flight.uploaded_bytes);
  result.figure("flight_read_mb", 1e-6 * flight.read_bytes);
  result.figure("gpu_bytes_over_budget", flight.gpu_over_budget);
  result.figure("cache_bytes_over_budget", flight.cache_over_budget);
}

/// Over the ground, in it, and along it; from 40 to 400 m away.
std::vector<viewer::Camera> scene_views(const viewer::SceneBox& box, std::uint64_t seed) {
  std::vector<viewer::Camera> views;
  for (std::uint64_t i = 0; i < 6; ++i) {
    CounterRandom random(seed, 21, i);
    const Vec3d extent = box.highest - box.lowest;
    viewer::Camera camera;
    camera.eye =
        box.lowest + Vec3d{random.uniform(0.3, 0.7) * extent.x, random.uniform(0.3, 0.7) * extent.y,
                           extent.z + random.uniform(-60.0, 150.0)};
    camera.heading_deg = random.uniform(0.0, 360.0);
    camera.pitch_deg = random.uniform(-50.0, -15.0);
    camera.field_of_view_deg = 50.0;
    views.push_back(camera);
  }
  return views;
}

/// Pictures for an error of 2 pixels against those of the finest mesh alone.
void measure_likeness(const fs::path& file, const Options& options, Result& result) {
  const viewer::OffscreenContext context;
  viewer::Options view;
  view.files = {file};
  viewer::Session session(view);
  viewer::Target drawn(1280, 720, 4), resolved(1280, 720, 1);
  double sum = 0.0, pixels = 0.0, within = 0.0, chosen = 0.0, finest = 0.0, worst = 0.0;
  for (const viewer::Camera& camera : scene_views(viewer::box_of(session.layers()), options.seed)) {
    const auto picture = [&](double error_pixels, double& triangles) {
      session.error_pixels() = error_pixels;
      triangles += double(session.draw(drawn.framebuffer(), 1280, 720, camera, 0.0, {}).triangles);
      viewer::resolve(drawn, resolved);
      return viewer::read_picture(resolved);
    };
    const Picture a = picture(2.0, chosen), b = picture(0.001, finest);
    double of_view = 0.0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) {
      int apart = 0;
      for (std::size_t c = 0; c < 3; ++c)
        apart = std::max(apart, std::abs(int{a.pixels[i][c]} - int{b.pixels[i][c]}));
      of_view += apart;
      within += apart <= 16 ? 1.0 : 0.0;
    }
    sum += of_view;
    pixels += double(a.pixels.size());
    worst = std::max(worst, of_view / double(a.pixels.size()));
  }
  result.figure("picture_mean_error", sum / pixels / 255.0);
  result.figure("picture_mean_error_worst", worst / 255.0);
  result.figure("picture_share_within_16", within / pixels);
  result.figure("picture_triangles_share", chosen / finest);
}

}  // namespace

int main(int argc, char** argv) {
  Own own;
  return run(
      "viewer", "First picture, frames, likeness and budgets of cornice-viewer", argc, argv,
      [&](CLI::App& app) {
        app.add_option("--large", own.large, "hierarchy to fly over; made there where it is not");
        app.add_option("--scene", own.scene, "hierarchy for pictures; made there where it is not");
        app.add_option("--flight-error-pixels", own.flight.error_pixels,
                       "error on the screen (0.5: about 1000 cells)");
      },
      [&](const Options& options, Result& result) {
        const ScratchFolder folder("viewer");
        if (own.large.empty()) own.large = folder / "large.hlod";
        if (!fs::exists(own.large))
          result.figure("make_s", seconds_of([&] {
                          make_hierarchy(own.large, options.quick ? 2'000'000 : 100'000'000,
                                         folder.path(), options.seed, options.threads);
                        }));
        measure_opening(own.large, options, result);
        if (options.quick) own.flight.seconds = 5.0;
        measure_flight(own.large, own, result);
        if (own.scene.empty()) own.scene = folder / "scene.hlod";
        if (!fs::exists(own.scene))
          make_hierarchy(own.scene, options.quick ? 200'000 : 2'000'000, folder.path(),
                         options.seed, options.threads);
        measure_likeness(own.scene, options, result);
      });
}
