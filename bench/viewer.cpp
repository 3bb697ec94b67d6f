// SPDX-License-Identifier: GPL-3.0-or-later
// The viewer: how soon there is a picture, what a frame costs the thread that draws, how near the
// picture is to that of the full mesh, whether budgets hold.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "bench/bench_json.h"
#include "bench/programs.h"
#include "bench/viewer/flight.h"
#include "bench/viewer/flight_figures.h"
#include "bench/viewer/likeness.h"
#include "bench/viewer/made_hierarchy.h"
#include "terrain-viewer/app/session.h"
#include "terrain-viewer/render/offscreen_context.h"
#include "terrain-viewer/scene/navigation.h"

namespace {

using namespace cornice;
using namespace cornice::bench;
namespace fs = std::filesystem;

struct Own {
  fs::path large, scene, frames;
  FlightOptions flight;
  int flights = 3;
  std::vector<std::string> parts{"open", "flight", "pictures"};
  bool has(const std::string& part) const {
    return std::find(parts.begin(), parts.end(), part) != parts.end();
  }
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
  std::vector<FlightResult> flights;
  for (int i = 0; i < own.flights; ++i) flights.push_back(fly_over(file, own.flight, context));
  flight_figures(flights, result);
  if (!own.frames.empty()) write_frames(own.frames, flights);
}

}  // namespace

int main(int argc, char** argv) {
  Own own;
  return run(
      "viewer", "First picture, frames, likeness and budgets of cornice-viewer", argc, argv,
      [&](CLI::App& app) {
        app.add_option("--large", own.large, "hierarchy to fly over; made there where it is not");
        app.add_option("--scene", own.scene, "hierarchy for pictures; made there where it is not");
        app.add_option("--parts", own.parts, "what is measured; all if not given")
            ->check(CLI::IsMember({"open", "flight", "pictures"}));
        app.add_option("--flight-seconds", own.flight.seconds, "of each flight");
        app.add_option("--frames", own.frames, "file for what each frame took, CSV");
        app.add_flag("--room-in-frames{false}", own.flight.makes_room_ahead,
                     "the thread that draws makes room on the GPU itself, as without a second "
                     "context");
        app.add_option("--flights", own.flights, "how often the same way is flown")
            ->check(CLI::Range(1, 100));
        app.add_option("--flight-error-pixels", own.flight.error_pixels,
                       "error on the screen (0.2: about 1000 cells)");
      },
      [&](const Options& options, Result& result) {
        const ScratchFolder folder("viewer");
        const auto make = [&](fs::path& file, const std::string& name, std::uint64_t triangles) {
          if (file.empty()) file = folder / name;
          if (!fs::exists(file))
            make_hierarchy(file, triangles, folder.path(), options.seed, options.threads);
        };
        if (own.has("open") || own.has("flight"))
          make(own.large, "large.hlod", options.quick ? 2'000'000 : 100'000'000);
        if (own.has("open")) measure_opening(own.large, options, result);
        if (options.quick) own.flight.seconds = 3.0;
        if (own.has("flight")) measure_flight(own.large, own, result);
        if (!own.has("pictures")) return;
        make(own.scene, "scene.hlod", options.quick ? 200'000 : 2'000'000);
        const viewer::OffscreenContext context;
        measure_likeness(own.scene, options.seed, result);
      });
}
