// SPDX-License-Identifier: GPL-3.0-or-later
// Everything is done for all lanes at once, in loops without branches over the lanes.
#include "stages/normals/bend_fit.h"

#include <array>
#include <cmath>
#include <cstring>

#include "core/base/clones.h"
#include "stages/normals/faces.h"

namespace cornice::normals {
namespace {

/// All lanes: one register of AVX-512, two of AVX, four of SSE. The sums fit the registers of the
/// first alone.
using Floats = float __attribute__((vector_size(kLanes * sizeof(float))));

/// Standard deviations of what is expected: of a point from the ground along its normal, of the
/// slope against the plane, of the height at the point.
constexpr float kNoise_m = 0.025f, kSlope = 0.2f, kHeight_m = 1.0f;
/// Bounds of the curvature (1/m) that is expected, as a standard deviation.
constexpr float kLeastBend = 0.1f, kMostBend = 0.5f;
/// At a distance of a metre ground leaves its parabola by this share of its bend, and farther away
/// with the third power of the distance.
constexpr float kBeyond = 0.25f;
/// A neighbour farther from the plane than this, and more the farther it lies from the point, is of
/// another face: its excess counts as noise.
constexpr float kOff_m = 0.12f, kOffPerMetre = 0.5f;

/// Neighbourhoods less rough and narrower than both keep the plane's normal: ground of range noise
/// alone, and so dense that it hardly bends within them.
constexpr float kRough_m = 0.035f, kBroad_m = 0.3f;

/// 1, u, v, u²/2, u v, v²/2.
constexpr std::size_t kTerms = 6;

/// What was taken of a neighbourhood as one face of a blade may be few points, chosen for lying on
/// a plane: they say nothing about bends.
constexpr std::uint32_t kLeastPoints = 2 * kTerms;

bool may_bend(const NeighbourBlock& block, const PlaneBlock& planes, std::size_t lane) {
  return (planes.spread_m[lane] > kRough_m || planes.breadth_m[lane] > kBroad_m) &&
         block.sizes()[lane] >= kLeastPoints && !may_mix_faces(planes.plane(lane));
}

/// Weighted sums over the neighbours, of u^i v^j with i + j <= 4, and of those up to 2 with the
/// height above the plane.
enum Sum : std::size_t {
  kOne,
  kU,
  kV,
  kUU,
  kUV,
  kVV,
  kUUU,
  kUUV,
  kUVV,
  kVVV,
  kUUUU,
  kUUUV,
  kUUVV,
  kUVVV,
  kVVVV,
  kH,
  kUH,
  kVH,
  kUUH,
  kUVH,
  kVVH,
  kSums
};
/// Each lane's normal and two directions across it and each other.
struct Frame {
  Floats nx, ny, nz, ux, uy, uz, vx, vy, vz;
};

[[gnu::always_inline]] inline void load(Floats& lanes, const float* from) {
  std::memcpy(&lanes, from, sizeof lanes);
}

/// T. Duff et al., "Building an orthonormal basis, revisited", 2017.
[[gnu::always_inline]] inline void make_frame(const PlaneBlock& planes, Frame& f) {
  load(f.nx, planes.normal_x.data()), load(f.ny, planes.normal_y.data());
  load(f.nz, planes.normal_z.data());
  const Floats none = {};
  const Floats sign = f.nz < none ? none - 1.0f : none + 1.0f;
  const Floats a = -1.0f / (sign + f.nz), b = f.nx * f.ny * a;
  f.ux = 1.0f + sign * f.nx * f.nx * a, f.uy = sign * b, f.uz = -sign * f.nx;
  f.vx = b, f.vy = sign + f.ny * f.ny * a, f.vz = -f.ny;
}

/// Squares of the curvatures that explain how far each neighbourhood lies off its plane, noise
/// apart: in a disk whose coordinates have a standard deviation of b, z = c u²/2 leaves its plane
/// by c b²/2 (rms).
[[gnu::always_inline]] inline void expect_bends(const PlaneBlock& planes, Floats& bend_sq) {
  Floats spread, breadth;
  load(spread, planes.spread_m.data()), load(breadth, planes.breadth_m.data());
  constexpr float kLeastSq = kLeastBend * kLeastBend, kMostSq = kMostBend * kMostBend;
  const Floats b_sq = breadth * breadth;
  const Floats off_sq = 4.0f * (spread * spread - kNoise_m * kNoise_m);
  // Lanes without a plane have neither spread nor breadth, and get the least.
  const Floats b_4 = b_sq * b_sq, none = {};
  const Floats least = kLeastSq + none, most = kMostSq + none;
  bend_sq = off_sq > kLeastSq * b_4 ? off_sq / b_4 : least;
  bend_sq = bend_sq < most ? bend_sq : most;
}

[[gnu::always_inline]] inline void sum_rows(const NeighbourBlock& block, const Frame& f,
                                            const Floats& bend_sq, Floats (&s)[kSums]) {
  constexpr float kNoiseSq = kNoise_m * kNoise_m;
  constexpr float kOffSq = kOff_m * kOff_m, kPerMetreSq = kOffPerMetre * kOffPerMetre;
  const Floats beyond_sq = kBeyond * kBeyond * bend_sq;
  Floats size;
  for (std::size_t l = 0; l < kLanes; ++l) size[l] = static_cast<float>(block.sizes()[l]);
  const Floats none = {};
  for (std::size_t row = 0; row < block.rows(); ++row) {
    const std::size_t at = row * kLanes;
    Floats x, y, z;
    load(x, block.dx() + at), load(y, block.dy() + at), load(z, block.dz() + at);
    const Floats u = f.ux * x + f.uy * y + f.uz * z, v = f.vx * x + f.vy * y + f.vz * z,
                 h = f.nx * x + f.ny * y + f.nz * z;
    const Floats uu = u * u, uv = u * v, vv = v * v, away = uu + vv, hh = h * h;
    const Floats excess = hh - kOffSq - kPerMetreSq * (away + hh);
    const Floats variance =
        kNoiseSq + beyond_sq * away * away * away + (excess > none ? excess : none);
    // Rows that only fill a lane up weigh nothing.
    const Floats w = size > static_cast<float>(row) ? 1.0f / variance : none;
    const Floats wu = w * u, wv = w * v, wuu = w * uu, wuv = w * uv, wvv = w * vv;
    s[kOne] += w, s[kU] += wu, s[kV] += wv, s[kUU] += wuu, s[kUV] += wuv, s[kVV] += wvv;
    s[kUUU] += wuu * u, s[kUUV] += wuu * v, s[kUVV] += wvv * u, s[kVVV] += wvv * v;
    s[kUUUU] += wuu * uu, s[kUUUV] += wuu * uv, s[kUUVV] += wuu * vv;
    s[kUVVV] += wvv * uv, s[kVVVV] += wvv * vv;
    s[kH] += w * h, s[kUH] += wu * h, s[kVH] += wv * h;
    s[kUUH] += wuu * h, s[kUVH] += wuv * h, s[kVVH] += wvv * h;
  }
}

/// Normal equations with the prior: the lower triangles of symmetric matrices, right sides.
struct Equations {
  Floats a[kTerms][kTerms];
  Floats b[kTerms];
};

[[gnu::always_inline]] inline void set_equations(const Floats (&s)[kSums], const Floats& bend_sq,
                                                 Equations& e) {
  constexpr float kSlopePrior = 1.0f / (kSlope * kSlope),
                  kHeightPrior = 1.0f / (kHeight_m * kHeight_m);
  const Floats bend_prior = 1.0f / bend_sq;
  e.a[0][0] = s[kOne] + kHeightPrior;
  e.a[1][0] = s[kU], e.a[1][1] = s[kUU] + kSlopePrior;
  e.a[2][0] = s[kV], e.a[2][1] = s[kUV], e.a[2][2] = s[kVV] + kSlopePrior;
  e.a[3][0] = 0.5f * s[kUU], e.a[3][1] = 0.5f * s[kUUU], e.a[3][2] = 0.5f * s[kUUV];
  e.a[3][3] = 0.25f * s[kUUUU] + bend_prior;
  e.a[4][0] = s[kUV], e.a[4][1] = s[kUUV], e.a[4][2] = s[kUVV];
  e.a[4][3] = 0.5f * s[kUUUV], e.a[4][4] = s[kUUVV] + bend_prior;
  e.a[5][0] = 0.5f * s[kVV], e.a[5][1] = 0.5f * s[kUVV], e.a[5][2] = 0.5f * s[kVVV];
  e.a[5][3] = 0.25f * s[kUUVV], e.a[5][4] = 0.5f * s[kUVVV];
  e.a[5][5] = 0.25f * s[kVVVV] + bend_prior;
  e.b[0] = s[kH], e.b[1] = s[kUH], e.b[2] = s[kVH];
  e.b[3] = 0.5f * s[kUUH], e.b[4] = s[kUVH], e.b[5] = 0.5f * s[kVVH];
}

/// Coefficients in place of the right sides, by a = L D L^T, but for the first, which nobody asks
/// for. The prior keeps D away from 0.
[[gnu::always_inline]] inline void solve(Equations& e) {
  Floats per_d[kTerms];
  for (std::size_t c = 0; c < kTerms; ++c) {
    for (std::size_t k = 0; k < c; ++k) {
      const Floats scaled = e.a[c][k];  // of L, times D
      e.a[c][k] = scaled * per_d[k];
      e.a[c][c] -= scaled * e.a[c][k];
      e.b[c] -= e.a[c][k] * e.b[k];
    }
    per_d[c] = 1.0f / e.a[c][c];
    for (std::size_t r = c + 1; r < kTerms; ++r) {
      for (std::size_t k = 0; k < c; ++k) e.a[r][c] -= e.a[r][k] * e.a[c][k];
    }
  }
  for (std::size_t c = kTerms; c-- > 1;) {
    e.b[c] *= per_d[c];
    for (std::size_t r = c + 1; r < kTerms; ++r) e.b[c] -= e.a[r][c] * e.b[r];
  }
}

}  // namespace

CORNICE_WIDE_CLONES
std::array<Vec3f, kLanes> bent_normals(const NeighbourBlock& block, const PlaneBlock& planes) {
  std::array<Vec3f, kLanes> normals;
  bool any = false;
  for (std::size_t l = 0; l < kLanes; ++l) {
    normals[l] = planes.plane(l).normal;
    any = any || may_bend(block, planes, l);
  }
  if (!any) return normals;
  Frame f;
  Floats bend_sq, sums[kSums] = {};
  Equations e;
  make_frame(planes, f);
  expect_bends(planes, bend_sq);
  sum_rows(block, f, bend_sq, sums);
  set_equations(sums, bend_sq, e);
  solve(e);
  const Floats du = e.b[1], dv = e.b[2], square = 1.0f + du * du + dv * dv;
  const Floats x = f.nx - du * f.ux - dv * f.vx, y = f.ny - du * f.uy - dv * f.vy,
               z = f.nz - du * f.uz - dv * f.vz;
  for (std::size_t l = 0; l < block.lanes(); ++l) {
    if (!may_bend(block, planes, l)) continue;
    const float scale = 1.0f / std::sqrt(square[l]);
    normals[l] = {x[l] * scale, y[l] * scale, z[l] * scale};
  }
  return normals;
}

}  // namespace cornice::normals
