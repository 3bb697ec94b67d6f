// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/golden/viewer/stage.h"

#include <cmath>

#include "terrain-viewer/app/picture.h"
#include "tests/property/viewer/crater.h"
#include "tests/support/hierarchy.h"
#include "tests/unit/drape/made_raster.h"

namespace cornice::viewer {
namespace {

/// Rings around the crater's middle.
double ring(const Vec3f& p) {
  return std::hypot(double(p.x) - 0.5 * kCraterM, double(p.y) - 0.5 * kCraterM);
}

std::uint8_t byte(double value) { return static_cast<std::uint8_t>(std::lround(value)); }

Mesh with_attributes(Mesh mesh) {
  mesh.crs_text = "EPSG:2056+5728";
  FloatProperty support{"support", {}};
  ByteProperty source{"source", {}}, red{"red", {}}, green{"green", {}}, blue{"blue", {}};
  for (const Vec3f& p : mesh.positions) {
    support.values.push_back(static_cast<float>(1.2 + 1.1 * std::sin(0.06 * ring(p))));
    source.values.push_back(ring(p) < 50.0 ? 2 : double(p.x) < 80.0 ? 1 : 0);
    red.values.push_back(byte(127.5 + 100.0 * std::sin(0.05 * double(p.x))));
    green.values.push_back(byte(127.5 + 100.0 * std::sin(0.05 * double(p.y))));
    blue.values.push_back(90);
  }
  mesh.float_properties.push_back(std::move(support));
  for (ByteProperty* p : {&source, &red, &green, &blue})
    mesh.byte_properties.push_back(std::move(*p));
  return mesh;
}

/// Of what is seen from above, 3 m apart, 2 m lower and without the small bumps: another surface of
/// the same place, which lies above and below the first in turns.
Mesh elevation_model(const Mesh& fine) {
  Mesh mesh = fine;
  for (Vec3f& p : mesh.positions)
    p.z += static_cast<float>(2.5 * std::sin(0.12 * double(p.x)) * std::sin(0.1 * double(p.y)));
  return mesh;
}

void write_photo(const std::filesystem::path& path) {
  const Vec3d origin = crater_origin();
  test::MadeRaster raster{120, 120, 3};
  raster.transform = {origin.x, 2.0, 0.0, origin.y + 240.0, 0.0, -2.0};
  test::make_tiff(path, raster, [](int band, int column, int row) {
    const bool is_dark = (column / 12 + row / 12) % 2 == 0;
    return (is_dark ? 60.0 : 200.0) + (band == 0 ? 0.4 * column : band == 1 ? 0.4 * row : -20.0);
  });
}

Camera camera_of_all() {
  const Vec3d origin = crater_origin();
  Camera camera;
  camera.field_of_view_deg = 42.0;
  return looking_at(camera, origin + Vec3d{-40.0, -130.0, 250.0},
                    origin + Vec3d{128.0, 112.0, 20.0});
}

}  // namespace

Stage::Stage() {
  const Mesh crater = with_attributes(crater_mesh());
  hlod::BuildOptions options;
  options.triangles_per_cell = 1500;
  test::write_hierarchy(folder_ / "crater.hlod", crater, options);
  test::write_hierarchy(folder_ / "model.hlod", elevation_model(crater), options);
  write_photo(folder_ / "photo.tif");
}

Picture Stage::draw(const View& view, const Change& change) {
  Options options;
  options.files = {folder_ / "crater.hlod"};
  if (view.has_second_layer) options.files.push_back(folder_ / "model.hlod");
  if (view.has_photo) options.orthophoto = {folder_ / "photo.tif"};
  options.gpu_memory_mib = options.cache_mib = options.drape_memory_mib = 64.0;
  options.shading = view.shading;
  options.error_pixels = view.error_pixels;
  options.contour_interval_m = view.contour_interval_m;
  // Both lines go through the picture.
  options.snow_line_m = 1870.0;
  options.tree_line_m = 1815.0;
  Session session(options);
  Camera camera = camera_of_all();
  if (change) change(session, camera);
  const Target drawn(kWidth, kHeight, options.samples), shown(kWidth, kHeight, 1);
  session.draw(drawn.framebuffer(), kWidth, kHeight, camera, 0.0, {}, {view.split, 0.55 * kWidth});
  resolve(drawn, shown);
  return read_picture(shown);
}

}  // namespace cornice::viewer
