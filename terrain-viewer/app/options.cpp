// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/options.h"

#include <cstdio>

#include "core/base/error.h"

namespace cornice::viewer {
namespace {

std::vector<std::pair<std::string, Shading>> shadings() {
  std::vector<std::pair<std::string, Shading>> values;
  for (std::size_t i = 0; i < kShadingNames.size(); ++i)
    values.emplace_back(kShadingNames[i], static_cast<Shading>(i));
  return values;
}

}  // namespace

std::vector<Option> describe(Options& o) {
  return {
      Option("FILE", o.files,
             "hierarchies that cornice-hlod built, .hlod; each is a layer; the window opens the "
             "latest one where there is none")
          .positional(),
      Option("headless", o.headless, "draw pictures without a window or a display"),
      Option("camera", o.camera, "JSON file of a camera; otherwise all is seen"),
      Option("view", o.viewpoint,
             {{"all", Viewpoint::kAll},
              {"overview", Viewpoint::kOverview},
              {"steepest", Viewpoint::kSteepest}},
             "without --camera: all from the south; all from where most of it is seen; the "
             "steepest part from its front; the latter two with the sun from the left, with "
             "--camera as well"),
      Option("save-camera", o.save_camera,
             "with --headless: JSON file for the camera of the picture, for --camera")
          .output(),
      Option("path", o.path, "JSON file of a camera path: one picture for each frame of it"),
      Option("size", o.size, "width and height of the pictures").unit("pixels"),
      Option("output", o.output, "picture, .png or .jpg; with --path frame_%04d.png")
          .short_flag('o')
          .output(),
      Option("error-pixels", o.error_pixels, "by which the surface may be off in the picture")
          .range(0.1, 100)
          .unit("pixels"),
      Option("samples", o.samples, "per pixel, against jagged edges").range(1, 16),
      Option("gpu-memory-mib", o.gpu_memory_mib, "for cells on the GPU")
          .range(16, 65536)
          .unit("MiB"),
      Option("cache-mib", o.cache_mib, "for cells held ready in memory")
          .range(16, 1048576)
          .unit("MiB"),
      Option("loading-threads", o.loading_threads, "that read cells").range(1, 64),
      Option("triangle-budget-m", o.triangle_budget_m, "at most so many are drawn; 0: no limit")
          .range(0, 10000)
          .unit("million triangles"),
      Option("frame-ms", o.frame_ms,
             "a frame may take, in the window and with --stream: the error in the picture grows as "
             "far as that needs; 0: no limit")
          .range(0, 1000)
          .unit("ms"),
      Option("side-by-side", o.side_by_side,
             "the last layer beside the others, seen by one camera; of a single layer what lies "
             "over it beside its own colours"),
      Option("stream", o.streams,
             "with --path: draw what is loaded in time, as the window does, instead of waiting for "
             "all that a picture needs"),
      Option("shading", o.shading, shadings(), "what the ground's colours say"),
      Option("time", o.time, "of the sun, UTC, as 2026-06-21T10:00:00Z"),
      Option("sun-azimuth-deg", o.sun_azimuth_deg,
             "of the sun from grid north, without --time; otherwise 315, or where --view wants it")
          .range(-360, 360)
          .unit("degrees"),
      Option("sun-elevation-deg", o.sun_elevation_deg, "of the sun, without --time")
          .range(-90, 90)
          .unit("degrees"),
      Option("contours-m", o.contour_interval_m, "height between contour lines; 0: none")
          .range(0, 1000)
          .unit("m"),
      Option("snow-line-m", o.snow_line_m, "height from which snow lies; otherwise by latitude")
          .unit("m"),
      Option("tree-line-m", o.tree_line_m, "height from which nothing grows; otherwise by latitude")
          .unit("m"),
      Option("orthophoto", o.orthophoto,
             "georeferenced photographs to lie over the ground, one or the tiles of one"),
      Option("difference", o.difference,
             "raster of differences to lie over the ground in colours: difference.tif of "
             "cornice-compare"),
      Option("difference-range-m", o.difference_range_m,
             "difference that gets the full colour; otherwise what 98 of 100 lie within")
          .above(0)
          .unit("m"),
      Option("drape-memory-mib", o.drape_memory_mib, "for tiles of each such raster on the GPU")
          .range(32, 65536)
          .unit("MiB"),
      Option("edges", o.has_edges, "draw the edges of the triangles"),
      Option("sky", o.has_sky, "draw the sky; black otherwise"),
      Option("legend", o.has_legend, "with --headless: say what the colours mean, in the picture"),
  };
}

PixelSize parse_size(const std::string& text) {
  PixelSize size;
  char rest = 0;
  const int read = std::sscanf(text.c_str(), "%5dx%5d%c", &size.width, &size.height, &rest);
  if (read != 2 || size.width < 1 || size.height < 1 || size.width > 16384 || size.height > 16384)
    throw UsageError("--size", "is \"" + text + "\"; accepted: WIDTHxHEIGHT, 1 to 16384 each");
  return size;
}

}  // namespace cornice::viewer
