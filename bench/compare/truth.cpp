// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/compare/truth.h"

#include "core/io/ply.h"
#include "core/io/raster.h"
#include "core/mesh/select.h"
#include "core/mesh/triangle_tree.h"
#include "stages/simulate/survey.h"

namespace cornice::bench {
namespace {

constexpr double kFineM = 0.25, kInsideM = 2.0;
constexpr float kPresentM = 0.15f;
constexpr const char* kLidarHdCrs = "EPSG:2154+5720";
constexpr std::uint64_t kCacheBytes = std::uint64_t{2} << 30;

}  // namespace

TrueGround true_ground(const std::string& scene, double tile_m, std::uint64_t seed, int threads) {
  simulate::SurveyOptions survey;
  survey.scene_file = std::filesystem::path(CORNICE_SCENES) / (scene + ".yaml");
  survey.seed = seed;
  survey.product = simulate::SurveyProduct::kLidarHd;
  survey.tile_m = tile_m;
  simulate::SceneOptions options;
  options.file = survey.scene_file;
  options.seed = seed;
  options.extent = simulate::scene_extent(tile_grid(survey));
  options.threads = threads;
  return {simulate::Scene::build(options), tile_grid(survey).extent()};
}

void write_true_dem(const TrueGround& ground, double step_m, const std::filesystem::path& path) {
  Raster dem = ground.scene->ground_dem(step_m, ground.extent);
  dem.crs = crs_from_text(kLidarHdCrs);
  write_cog(path, dem);
}

void write_true_surface(const TrueGround& ground, double step_m,
                        const std::filesystem::path& path) {
  Mesh mesh = ground.scene->ground_mesh(step_m, ground.extent);
  mesh.crs_text = kLidarHdCrs;
  write_ply(path, mesh);
}

compare::Result compare_files(const std::filesystem::path& a, const std::filesystem::path& b,
                              const compare::Options& options,
                              const std::function<void(const compare::MeasuredPart&)>& show) {
  const auto source_a = compare::open_source(a, options, kCacheBytes);
  const auto source_b = compare::open_source(b, options, kCacheBytes);
  return compare::compare(
      *source_a, *source_b, options, {},
      [&](const compare::MeasuredPart& part) {
        if (show) show(part);
      },
      no_progress());
}

OverhangJudge::OverhangJudge(const TrueGround& ground) {
  const Mesh fine = ground.scene->ground_mesh(kFineM, ground.extent.grown(-kInsideM));
  origin_ = fine.origin;
  for (const Triangle& t : fine.triangles) {
    const Vec3f centre =
        (fine.positions[t[0]] + fine.positions[t[1]] + fine.positions[t[2]]) * (1.0f / 3.0f);
    Vec3d gradient;
    ground.scene->ground_value(origin_ + centre.cast<double>(), &gradient);
    if (!(gradient.z < 0.0)) continue;
    samples_.push_back({centre, triangle_area(fine, t)});
    true_m2_ += samples_.back().area_m2;
  }
}

void OverhangJudge::add(const compare::MeasuredPart& part) {
  if (part.side != compare::Side::kB || part.overhang.empty()) return;
  const auto first = static_cast<std::uint32_t>(positions_.size());
  const Vec3d shift = part.surface.origin - origin_;
  for (const Vec3f p : part.surface.positions) {
    positions_.push_back((p.cast<double>() + shift).cast<float>());
  }
  for (std::size_t t = 0; t < part.overhang.size(); ++t) {
    if (part.overhang[t] == 0) continue;
    const Triangle& corners = part.surface.triangles[t];
    listed_.push_back({corners[0] + first, corners[1] + first, corners[2] + first});
  }
}

double OverhangJudge::found_share() const {
  if (!(true_m2_ > 0.0)) return 1.0;
  const TriangleTree tree(positions_, listed_, 1);
  NearestQuery query;
  query.max_distance_sq = kPresentM * kPresentM;
  double found_m2 = 0.0;
  for (const Sample& sample : samples_) {
    if (tree.nearest(sample.position, query).found()) found_m2 += sample.area_m2;
  }
  return found_m2 / true_m2_;
}

}  // namespace cornice::bench
