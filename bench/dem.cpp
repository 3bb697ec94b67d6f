// SPDX-License-Identifier: GPL-3.0-or-later
// What a tile of an elevation model takes from file to file: cornice-dem on one tile of a made
// survey of 2 x 2, whose neighbours lend their borders, and the mesh back to a raster.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/bench_json.h"
#include "bench/programs.h"
#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/io/ply.h"
#include "core/io/raster.h"

namespace {

using namespace cornice;
using namespace cornice::bench;
namespace fs = std::filesystem;

constexpr double kTileM = 1000.0;
constexpr double kEast = 2600000.0, kNorth = 1200000.0;

/// Ridges and gullies, in metres.
double mountain(double x, double y) {
  return 2000.0 + 300.0 * std::sin(x / 310.0) * std::cos(y / 270.0) +
         60.0 * std::abs(std::sin(x / 37.0 + y / 53.0)) +
         4.0 * std::sin(x / 5.0) * std::sin(y / 7.0);
}

/// A tile with 2 cm of noise, so that it compresses as a measured one does.
Raster make_tile(int column, int row, double step, std::uint64_t seed, int threads) {
  Raster raster;
  raster.width = raster.height = static_cast<int>(kTileM / step);
  raster.west = kEast + column * kTileM;
  raster.north = kNorth + (row + 1) * kTileM;
  raster.step = step;
  raster.crs = crs_from_text("EPSG:2056+5728");
  const auto side = static_cast<std::size_t>(raster.width);
  raster.values.resize(side * side);
  parallel_for(side, 16, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin * side; i < end * side; ++i) {
      const double x = column * kTileM + (static_cast<double>(i % side) + 0.5) * step;
      const double y = (row + 1) * kTileM - (static_cast<double>(i / side) + 0.5) * step;
      CounterRandom random(seed, static_cast<std::uint64_t>(2 * row + column), i);
      raster.values[i] = static_cast<float>(mountain(x, y) + 0.02 * random.normal());
    }
  });
  return raster;
}

std::string tile_name(int column, int row) {
  return "tile_" + std::to_string(column) + "_" + std::to_string(row);
}

/// Median seconds of the program on the south-western tile, on one thread.
double seconds_of_tile(const ScratchFolder& folder, double step, int runs, const Options& options,
                       Result& result, const std::string& suffix) {
  std::vector<std::string> command{(own_folder() / "cornice-dem").string()};
  for (int row = 0; row < 2; ++row) {
    for (int column = 0; column < 2; ++column) {
      const fs::path path = folder / (tile_name(column, row) + ".tif");
      write_cog(path, make_tile(column, row, step, options.seed, options.threads));
      command.push_back(path.string());
    }
  }
  for (const std::string& word :
       {std::string("--only"), (folder / (tile_name(0, 0) + ".tif")).string(), std::string("-o"),
        (folder / "meshes").string(), std::string("--threads"), std::string("1"),
        std::string("--overwrite"), std::string("--no-progress")}) {
    command.push_back(word);
  }
  std::vector<double> seconds;
  std::uint64_t peak = 0;
  for (int run = 0; run < runs; ++run) {
    const ProgramCost cost = run_program(command, folder / "log.txt");
    seconds.push_back(cost.seconds);
    peak = std::max(peak, cost.peak_resident_bytes);
  }
  const fs::path mesh = folder / "meshes" / (tile_name(0, 0) + ".ply");
  result.figure("triangles_" + suffix, static_cast<double>(read_ply_info(mesh).count("face")));
  result.figure("mesh_mb_" + suffix, static_cast<double>(fs::file_size(mesh)) * 1e-6);
  result.figure("gib_" + suffix, static_cast<double>(peak) * 0x1p-30);
  return median(seconds);
}

/// Median seconds of the way back, on one thread.
double seconds_of_raster(const ScratchFolder& folder, double step, int runs) {
  std::vector<double> seconds;
  for (int run = 0; run < runs; ++run) {
    seconds.push_back(
        run_program({(own_folder() / "cornice-dem").string(), "--from-mesh",
                     (folder / "meshes" / (tile_name(0, 0) + ".ply")).string(), "--step",
                     std::to_string(step), "-o", (folder / "layers.tif").string(), "--threads", "1",
                     "--overwrite", "--no-progress"},
                    folder / "log.txt")
            .seconds);
  }
  return median(seconds);
}

}  // namespace

int main(int argc, char** argv) {
  return run("dem", "Seconds of cornice-dem for a tile of 1 km2, from file to file", argc, argv, {},
             [](const Options& options, Result& result) {
               const ScratchFolder folder("dem");
               const int runs = options.quick ? 2 : 5;
               result.parameter("runs", static_cast<std::int64_t>(runs));
               result.figure("seconds_2m_tile",
                             seconds_of_tile(folder, 2.0, runs, options, result, "2m_tile"));
               result.figure("seconds_2m_raster", seconds_of_raster(folder, 2.0, runs));
               if (options.quick) return;
               result.figure("seconds_05m_tile",
                             seconds_of_tile(folder, 0.5, runs, options, result, "05m_tile"));
               result.figure("seconds_05m_raster", seconds_of_raster(folder, 0.5, runs));
             });
}
