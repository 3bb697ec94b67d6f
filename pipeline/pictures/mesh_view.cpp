// SPDX-License-Identifier: GPL-3.0-or-later
// A depth buffer over triangles, in drawn pixels.
#include "pipeline/pictures/mesh_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "pipeline/pictures/colours.h"

namespace cornice::pictures {
namespace {

const Vec3f kLight = normalized(Vec3f{-0.5f, 0.5f, 0.7071f});
const Vec3f kFill = normalized(Vec3f{0.3f, -0.9f, 0.3f});
constexpr Rgb kGround{205, 200, 190};
constexpr Rgb kTurnedOver{220, 60, 60};

/// A vertex in drawn pixels: x to the right, y down, z away from the viewer.
struct Corner {
  Vec3d at;
  Vec3f normal;
  float support = 0.0f;
};

struct Canvas {
  int width = 0;
  int height = 0;
  std::vector<float> depth;
  Picture picture;
};

const FloatProperty* find_support(const Mesh& mesh) {
  for (const FloatProperty& property : mesh.float_properties)
    if (property.name == "support") return &property;
  return nullptr;
}

/// The sun, a weak light from across it and from above, so that walls in the shade show their form.
Rgb lit_colour(Rgb base, Vec3f normal) {
  const Vec3f n = normalized(normal);
  const float sun = std::max(0.0f, dot(n, kLight));
  const float fill = std::max(0.0f, dot(n, kFill));
  return shaded(base, 0.3f + 0.08f * n.z + 0.72f * sun + 0.22f * fill);
}

/// Fills one triangle; `turned` says that its back is towards the viewer.
void fill(Canvas& canvas, const std::array<Corner, 3>& corners, MeshColour colour, bool turned) {
  const Vec3d &a = corners[0].at, &b = corners[1].at, &c = corners[2].at;
  const double area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
  if (area == 0.0) return;
  const int left = std::max(0, static_cast<int>(std::floor(std::min({a.x, b.x, c.x}))));
  const int right =
      std::min(canvas.width - 1, static_cast<int>(std::ceil(std::max({a.x, b.x, c.x}))));
  const int top = std::max(0, static_cast<int>(std::floor(std::min({a.y, b.y, c.y}))));
  const int bottom =
      std::min(canvas.height - 1, static_cast<int>(std::ceil(std::max({a.y, b.y, c.y}))));
  for (int y = top; y <= bottom; ++y) {
    for (int x = left; x <= right; ++x) {
      const double px = x + 0.5, py = y + 0.5;
      const double wb = ((px - a.x) * (c.y - a.y) - (c.x - a.x) * (py - a.y)) / area;
      const double wc = ((b.x - a.x) * (py - a.y) - (px - a.x) * (b.y - a.y)) / area;
      const double wa = 1.0 - wb - wc;
      if (wa < 0.0 || wb < 0.0 || wc < 0.0) continue;
      const auto depth = static_cast<float>(wa * a.z + wb * b.z + wc * c.z);
      const std::size_t at = static_cast<std::size_t>(y) * canvas.width + x;
      if (depth >= canvas.depth[at]) continue;
      canvas.depth[at] = depth;
      const auto fa = static_cast<float>(wa), fb = static_cast<float>(wb),
                 fc = static_cast<float>(wc);
      const Vec3f normal = corners[0].normal * fa + corners[1].normal * fb + corners[2].normal * fc;
      const float support =
          corners[0].support * fa + corners[1].support * fb + corners[2].support * fc;
      Rgb base = colour == MeshColour::kSupport ? support_colour(support) : kGround;
      if (turned) base = kTurnedOver;
      canvas.picture.pixels[at] = lit_colour(base, normal);
    }
  }
}

void draw(Canvas& canvas, const Mesh& mesh, Vec3f shift, const Axes& axes, const Frame& frame,
          MeshColour colour) {
  const FloatProperty* support = find_support(mesh);
  for (const auto& triangle : mesh.triangles) {
    std::array<Corner, 3> corners;
    const Vec3f face = cross(mesh.positions[triangle[1]] - mesh.positions[triangle[0]],
                             mesh.positions[triangle[2]] - mesh.positions[triangle[0]]);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = triangle[k];
      corners[k].at = frame.place(seen(axes, mesh.positions[v] + shift));
      corners[k].normal = mesh.normals.empty() ? face : mesh.normals[v];
      corners[k].support = support == nullptr ? 0.0f : support->values[v];
    }
    fill(canvas, corners, colour, dot(face.cast<double>(), axes.forward) > 0.0);
  }
}

}  // namespace

std::array<std::uint8_t, 3> support_colour(float support_m) {
  if (!(support_m > 0.5f)) return kGround;
  // 0 at 0.5 m, 1 at 10 m.
  const float share = std::min(1.0f, std::log(support_m / 0.5f) / std::log(20.0f));
  const auto channel = [](float value) { return static_cast<std::uint8_t>(std::lround(value)); };
  return {channel(245.0f - 25.0f * share), channel(215.0f - 180.0f * share),
          channel(90.0f - 60.0f * share)};
}

Picture mesh_picture(const std::vector<Mesh>& meshes, const View& view, MeshColour colour) {
  const Axes axes = axes_of(view);
  Box3d box;
  for (const Mesh& mesh : meshes) {
    const Vec3f shift = (mesh.origin - meshes.front().origin).cast<float>();
    for (const auto& triangle : mesh.triangles)
      for (const std::uint32_t v : triangle) box.add(seen(axes, mesh.positions[v] + shift));
  }
  if (box.empty()) throw UsageError("FILE", "no triangles to draw");
  const Frame frame = frame_of(view, box);
  Canvas canvas;
  canvas.width = frame.width;
  canvas.height = frame.height;
  canvas.depth.assign(frame.pixels(), std::numeric_limits<float>::infinity());
  canvas.picture = {canvas.width, canvas.height, {}};
  canvas.picture.pixels.assign(frame.pixels(), Rgb{255, 255, 255});
  for (const Mesh& mesh : meshes) {
    const Vec3f shift = (mesh.origin - meshes.front().origin).cast<float>();
    draw(canvas, mesh, shift, axes, frame, colour);
  }
  return reduced(canvas.picture);
}

}  // namespace cornice::pictures
