// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/property/viewer/crater.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "terrain-viewer/app/picture.h"
#include "tests/support/hierarchy.h"
#include "tests/support/meshes.h"

namespace cornice::viewer {
namespace {

constexpr double kMiddle = 0.5 * kCraterM;

double rise(double x) { return 1.0 / (1.0 + std::exp(-x)); }

double ground(double u, double v) {
  const double r = std::hypot(u - kMiddle, v - kMiddle);
  const double rim = 70.0 * rise((r - 100.0) / 5.0);
  const double cliff = 25.0 * rise((u - kMiddle - 12.0 * std::sin(0.05 * v)) / 1.0);
  return rim + cliff + 3.0 * std::sin(0.07 * u + 0.3) * std::cos(0.06 * v) +
         0.5 * std::sin(0.9 * u) * std::sin(0.7 * v);
}

/// Where the cliff rises, its upper part is pulled back over its foot by up to 5 m.
Vec3d crater(int column, int row) {
  constexpr double kStep = 0.75;
  const double u = kStep * column, v = kStep * row;
  const double across = u - kMiddle - 12.0 * std::sin(0.05 * v);
  const double pulled = 5.0 * rise(2.0 * across) * std::exp(-std::pow(across / 12.0, 2.0));
  return {u - pulled, v, ground(u, v)};
}

}  // namespace

Vec3d crater_origin() { return {2'600'000.0, 1'200'000.0, 1800.0}; }

Mesh crater_mesh() {
  Mesh mesh = test::grid_mesh(321, 321, crater);
  mesh.origin = crater_origin();
  return mesh;
}

void write_crater(const std::filesystem::path& path, hlod::Partition partition) {
  hlod::BuildOptions options;
  options.partition = partition;
  options.triangles_per_cell = 1500;
  test::write_hierarchy(path, crater_mesh(), options);
}

Camera crater_camera(double t) {
  const double angle = 2.0 * std::numbers::pi * t;
  const double x = kMiddle + 55.0 * std::sin(angle), y = kMiddle + 45.0 * std::sin(2.0 * angle);
  Camera camera;
  // Over all that is near, on top of the cliff too.
  double highest = -1e9;
  for (int east = -12; east <= 12; east += 2)
    for (int north = -4; north <= 4; north += 2)
      highest = std::max(highest, ground(x + east, y + north));
  camera.eye = crater_origin() + Vec3d{x, y, highest + 6.0 + 4.0 * std::sin(5.0 * angle)};
  camera.heading_deg = std::fmod(90.0 + 720.0 * t, 360.0);
  camera.pitch_deg = -32.0 + 8.0 * std::sin(7.0 * angle);
  camera.field_of_view_deg = 50.0;
  return camera;
}

CraterStudio::CraterStudio(const std::filesystem::path& file, int width, int height,
                           const Budgets& budgets)
    : cells_(budgets.gpu_bytes, budgets.page_bytes),
      layer_(file, 0, {budgets.threads, budgets.cache_bytes}, cells_),
      target_(width, height, 1) {}

LayerView CraterStudio::view(const Camera& camera, double error_pixels) const {
  LayerView view;
  view.camera = camera;
  view.width = target_.width();
  view.height = target_.height();
  view.error_pixels = error_pixels;
  return view;
}

Picture CraterStudio::draw(const DrawList& list, const Camera& camera) {
  Style style;
  style.shading = Shading::kPlain;
  style.haze_range_m = 0.0;
  renderer_.begin(target_.framebuffer(), target_.width(), target_.height(), camera, style,
                  &kMagenta);
  renderer_.draw(list, cells_, style);
  return read_picture(target_);
}

bool CraterStudio::settle(const Camera& camera, double error_pixels) {
  return layer_.settle(view(camera, error_pixels), cells_, ++frame_);
}

void CraterStudio::update(const Camera& camera, double error_pixels, double seconds) {
  LayerView now = view(camera, error_pixels);
  now.seconds = seconds;
  layer_.update(now, cells_, ++frame_);
}

DrawList without_morphing(const DrawList& list) {
  DrawList own = list;
  for (hlod::MorphBand& band : own.bands) band.band = 0;
  return own;
}

}  // namespace cornice::viewer
