// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/viewer/likeness.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "terrain-viewer/app/picture.h"
#include "terrain-viewer/app/session.h"
#include "terrain-viewer/scene/navigation.h"

namespace cornice::bench {
namespace {

constexpr int kWidth = 1280, kHeight = 720, kSamples = 4;
constexpr int kFiner = 4;  ///< of the pictures that are averaged down
constexpr double kErrorPixels = 2.0, kFinest = 0.001;
/// Half the distance between samples of a pixel that has four.
constexpr double kShiftPixels = 0.25;

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

/// All of the scene, from four sides.
std::vector<viewer::Camera> whole_views(const viewer::SceneBox& box) {
  const viewer::Camera from_south =
      viewer::seeing_all({}, box.lowest, box.highest, double{kWidth} / kHeight);
  const Vec3d middle = 0.5 * (box.lowest + box.highest);
  std::vector<viewer::Camera> views;
  for (const double turn_deg : {0.0, 90.0, 180.0, 270.0})
    views.push_back(viewer::orbit(from_south, middle, turn_deg, 0.0));
  return views;
}

/// Looking up by so many pixels in the middle of the picture: all rows move alike, or nearly so.
viewer::Camera shifted(viewer::Camera camera, double pixels) {
  const double half = 0.5 * camera.field_of_view_deg * std::numbers::pi / 180.0;
  const double per_pixel = std::tan(half) / (0.5 * kHeight);
  camera.pitch_deg += std::atan(pixels * per_pixel) * 180.0 / std::numbers::pi;
  return camera;
}

/// Each pixel the mean of kFiner x kFiner, as samples of a pixel are averaged.
Picture averaged(const Picture& fine) {
  Picture picture{kWidth, kHeight, {}};
  picture.pixels.resize(std::size_t{kWidth} * kHeight);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (std::size_t c = 0; c < 3; ++c) {
        int sum = 0;
        for (int v = 0; v < kFiner; ++v)
          for (int u = 0; u < kFiner; ++u)
            sum += fine.pixels[static_cast<std::size_t>((kFiner * y + v) * fine.width + kFiner * x +
                                                        u)][c];
        picture.pixels[static_cast<std::size_t>(y * kWidth + x)][c] =
            static_cast<std::uint8_t>((sum + kFiner * kFiner / 2) / (kFiner * kFiner));
      }
  return picture;
}

/// Of pixels with ground, by the channel that differs most, of 255. Sky, which is always the same,
/// does not count.
class Difference {
 public:
  void add(const Picture& a, const Picture& b, const std::vector<bool>& has_ground) {
    double of_view = 0.0, pixels = 0.0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) {
      if (!has_ground[i]) continue;
      int apart = 0;
      for (std::size_t c = 0; c < 3; ++c)
        apart = std::max(apart, std::abs(int{a.pixels[i][c]} - int{b.pixels[i][c]}));
      of_view += apart;
      within_ += apart <= 16 ? 1.0 : 0.0;
      pixels += 1.0;
    }
    sum_ += of_view;
    pixels_ += pixels;
    if (pixels > 0.0) worst_ = std::max(worst_, of_view / pixels);
  }
  double pixels() const { return pixels_; }
  double mean() const { return sum_ / pixels_ / 255.0; }
  double worst() const { return worst_ / 255.0; }  ///< of a picture's means
  double share_within_16() const { return within_ / pixels_; }

 private:
  double sum_ = 0.0, pixels_ = 0.0, within_ = 0.0, worst_ = 0.0;
};

/// Draws pictures of both kinds.
class Easel {
 public:
  explicit Easel(const std::filesystem::path& file)
      : session_(options_for(file)),
        drawn_(kWidth, kHeight, kSamples),
        resolved_(kWidth, kHeight, 1),
        fine_(kFiner * kWidth, kFiner * kHeight, 1) {}

  viewer::SceneBox box() { return viewer::box_of(session_.layers()); }

  Picture draw(const viewer::Camera& camera, double error_pixels) {
    session_.error_pixels() = error_pixels;
    triangles_ = session_.draw(drawn_.framebuffer(), kWidth, kHeight, camera, 0.0, {}).triangles;
    viewer::resolve(drawn_, resolved_);
    return viewer::read_picture(resolved_);
  }
  /// Of the same triangles.
  Picture draw_averaged(const viewer::Camera& camera, double error_pixels) {
    session_.error_pixels() = kFiner * error_pixels;
    session_.draw(fine_.framebuffer(), fine_.width(), fine_.height(), camera, 0.0, {});
    return averaged(viewer::read_picture(fine_));
  }
  /// By pixel of the last picture that was not averaged, whether there is ground in it.
  std::vector<bool> ground() {
    glBlitNamedFramebuffer(drawn_.framebuffer(), resolved_.framebuffer(), 0, 0, kWidth, kHeight, 0,
                           0, kWidth, kHeight, GL_DEPTH_BUFFER_BIT, GL_NEAREST);
    std::vector<float> depths(std::size_t{kWidth} * kHeight);
    glGetTextureImage(resolved_.depth(), 0, GL_DEPTH_COMPONENT, GL_FLOAT,
                      static_cast<GLsizei>(depths.size() * sizeof(float)), depths.data());
    std::vector<bool> has_ground;
    has_ground.reserve(depths.size());
    // OpenGL's first row is the lowest.
    for (std::size_t y = kHeight; y-- > 0;)
      for (std::size_t x = 0; x < kWidth; ++x) has_ground.push_back(depths[y * kWidth + x] > 0.0f);
    return has_ground;
  }
  /// Of the last picture that was not averaged.
  double triangles() const { return static_cast<double>(triangles_); }

 private:
  static viewer::Options options_for(const std::filesystem::path& file) {
    viewer::Options options;
    options.files = {file};
    return options;
  }
  viewer::Session session_;
  viewer::Target drawn_, resolved_, fine_;
  std::uint64_t triangles_ = 0;
};

/// Figures whose names begin with `name`.
void compare_views(Easel& easel, const std::vector<viewer::Camera>& views, const std::string& name,
                   Result& result) {
  Difference of_pictures, of_averaged, of_shifted;
  double chosen = 0.0, finest = 0.0, all = 0.0;
  for (const viewer::Camera& camera : views) {
    const Picture picture = easel.draw(camera, kErrorPixels);
    chosen += easel.triangles();
    const Picture truth = easel.draw(camera, kFinest);
    finest += easel.triangles();
    const std::vector<bool> ground = easel.ground();
    of_pictures.add(picture, truth, ground);
    of_shifted.add(easel.draw(shifted(camera, kShiftPixels), kFinest), truth, ground);
    of_averaged.add(easel.draw_averaged(camera, kErrorPixels), easel.draw_averaged(camera, kFinest),
                    ground);
    all += static_cast<double>(ground.size());
  }
  result.figure(name + "_ground_share", of_pictures.pixels() / all);
  result.figure(name + "_mean_error", of_pictures.mean());
  result.figure(name + "_mean_error_worst", of_pictures.worst());
  result.figure(name + "_share_within_16", of_pictures.share_within_16());
  result.figure(name + "_mean_error_supersampled", of_averaged.mean());
  result.figure(name + "_share_within_16_supersampled", of_averaged.share_within_16());
  result.figure(name + "_mean_error_shifted", of_shifted.mean());
  result.figure(name + "_share_within_16_shifted", of_shifted.share_within_16());
  result.figure(name + "_triangles_share", chosen / finest);
}

}  // namespace

void measure_likeness(const std::filesystem::path& file, std::uint64_t seed, Result& result) {
  Easel easel(file);
  compare_views(easel, scene_views(easel.box(), seed), "picture", result);
  compare_views(easel, whole_views(easel.box()), "far_picture", result);
}

}  // namespace cornice::bench
