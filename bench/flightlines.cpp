// SPDX-License-Identifier: GPL-3.0-or-later
// How well flight lines are found: simulated surveys of each scanner pattern and product, with fine
// and whole-degree angles, ids as they are and zeroed, against what the simulator knows.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/bench_json.h"
#include "bench/flightlines/survey_score.h"

namespace {

using namespace cornice;
namespace lines = cornice::flightlines;
namespace sim = cornice::simulate;
using bench::FlownSurvey;
using bench::Score;

/// Angles rounded, as formats 0-5 hold them; ids zeroed where asked.
std::vector<PointCloud> spoiled(std::vector<PointCloud> tiles, bool whole_degrees, bool zero_ids) {
  for (PointCloud& tile : tiles) {
    if (whole_degrees)
      for (float& angle : tile.scan_angle_deg) angle = std::round(angle);
    if (zero_ids) std::fill(tile.point_source_id.begin(), tile.point_source_id.end(), 0);
  }
  return tiles;
}

const char* product_name(sim::SurveyProduct product) {
  return product == sim::SurveyProduct::kLidarHd ? "lidarhd" : "swiss";
}

void print_lines(const lines::SurveyLines& found, const Score& score) {
  for (const bench::LineScore& each : score.each) {
    const lines::LineEstimate& e = found.lines[each.id - 1];
    const double n = static_cast<double>(std::max<std::size_t>(1, each.nodes));
    std::printf(
        "    %u: %.1f s, %llu points, angles %.0f..%.0f, %s (%zu pulses, %zu pairs), error across "
        "%.3f +- %.3f deg, plan %.2f +- %.2f m, height %.2f +- %.2f m, residuals: angle %.4f scan "
        "%.4f deg, pair %.2f, cone %.3f +- %.3f %s\n",
        each.id, e.line.last_time_s - e.line.first_time_s,
        static_cast<unsigned long long>(e.points), e.min_angle_deg, e.max_angle_deg,
        e.method.c_str(), e.pulses_used, e.pairs_used, each.across_error_deg,
        e.line.across_standard_error_deg,
        std::sqrt((each.square_sum - each.vertical_square_sum) / n), e.position_error_m,
        std::sqrt(each.vertical_square_sum / n), e.height_error_m, e.angle_residual_deg,
        e.scan_residual_deg, e.pair_residual, e.cone_deg, e.cone_error_deg,
        e.line.beam_reason.c_str());
  }
}

/// True where no choice was made.
bool is_asked(const std::vector<std::string>& asked, const std::string& name) {
  return asked.empty() || std::find(asked.begin(), asked.end(), name) != asked.end();
}

struct Totals {
  Score fine, whole;
};

void run_survey(const sim::SurveyOptions& options, const sim::Scene& scene, bool show_lines,
                const bench::Options& run, Totals& totals, bench::Result& result) {
  const FlownSurvey flown = bench::fly_in_memory(options, scene, run.threads);
  const std::string name = sim::scanner_name(options.scanner.pattern) + "_" +
                           product_name(options.product) + "_" + scene.name();
  for (const bool whole : {false, true}) {
    for (const bool zero : {false, true}) {
      const std::vector<PointCloud> tiles = spoiled(flown.tiles, whole, zero);
      double seconds = 0.0;
      const lines::SurveyLines found = bench::find_lines(tiles, run.threads, seconds);
      const Score score = bench::score_lines(flown, found);
      (whole ? totals.whole : totals.fine).add(score);
      std::printf(
          "%-34s %-5s %-8s %3d lines, across %.4f deg, sensor %.3f m (plan %.3f, height %.3f), %d "
          "split errors, %d without path, %.2f M points, %.2f s\n",
          name.c_str(), whole ? "whole" : "fine", zero ? "no ids" : "ids", score.lines,
          score.azimuth_error_deg, score.rms_m(), score.horizontal_m(), score.vertical_m(),
          score.split_errors, score.without_path, 1e-6 * static_cast<double>(flown.points()),
          seconds);
      if (show_lines) print_lines(found, score);
      if (zero) continue;
      const std::string suffix = "_" + name + (whole ? "_whole" : "_fine");
      result.figure("azimuth_error_deg" + suffix, score.azimuth_error_deg);
      result.figure("sensor_rms_m" + suffix, score.rms_m());
    }
  }
}

/// Points per second after decoding, of a dense tile: the work on points and that on lines.
double points_per_second(const sim::Scene& scene, const sim::SurveyOptions& base,
                         const bench::Options& run, double side_m, double density) {
  sim::SurveyOptions options = base;
  options.tiles = "1x1";
  options.tile_m = side_m;
  options.density = density;
  const FlownSurvey flown = bench::fly_in_memory(options, scene, run.threads);
  std::vector<double> rates;
  for (int turn = 0; turn < 3; ++turn) {
    double seconds = 0.0;
    bench::find_lines(flown.tiles, run.threads, seconds);
    rates.push_back(static_cast<double>(flown.tiles[0].size()) / seconds);
  }
  return bench::median(rates);
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> scenes;
  double density = 1.0;
  std::vector<std::string> scanners, products;
  bool show_lines = false;
  return bench::run(
      "flightlines", "Flight lines and sensor paths against the truth of simulated surveys", argc,
      argv,
      [&](CLI::App& app) {
        app.add_option("--scene", scenes, "scenes by name (alp valley; with --quick valley)");
        app.add_option("--density", density, "points/m2 of the surveys");
        app.add_option("--scanner", scanners, "oscillating, polygon, palmer (all)");
        app.add_option("--product", products, "lidarhd, swiss (both)");
        app.add_flag("--lines", show_lines, "prints every line");
      },
      [&](const bench::Options& options, bench::Result& result) {
        if (scenes.empty())
          scenes = options.quick ? std::vector<std::string>{"valley"}
                                 : std::vector<std::string>{"alp", "valley"};
        Totals totals;
        double rate = 0.0;
        for (const std::string& name : scenes) {
          sim::SurveyOptions survey;
          survey.scene_file = std::filesystem::path(CORNICE_SCENES) / (name + ".yaml");
          survey.seed = options.seed;
          survey.tiles = "2x2";
          survey.tile_m = options.quick ? 250.0 : 500.0;
          survey.density = density;
          survey.flight.cross_line = !options.quick;
          // One scene serves both products: it stands on the corner of the first.
          const Vec3d corner = sim::default_corner(sim::SurveyProduct::kSwissSurface3d);
          survey.corner = {corner.x, corner.y};
          const auto scene = bench::build_scene(survey, options.threads);
          for (const auto pattern : {sim::ScannerPattern::kOscillating,
                                     sim::ScannerPattern::kPolygon, sim::ScannerPattern::kPalmer})
            for (const auto product :
                 {sim::SurveyProduct::kSwissSurface3d, sim::SurveyProduct::kLidarHd}) {
              if (!is_asked(scanners, sim::scanner_name(pattern)) ||
                  !is_asked(products, product_name(product)))
                continue;
              survey.scanner.pattern = pattern;
              survey.product = product;
              run_survey(survey, *scene, show_lines, options, totals, result);
            }
          if (rate == 0.0 && !show_lines)
            rate = points_per_second(*scene, survey, options, options.quick ? 200.0 : 1000.0, 20.0);
        }
        result.figure("azimuth_error_deg_max",
                      std::max(totals.fine.azimuth_error_deg, totals.whole.azimuth_error_deg));
        result.figure("crab_error_deg_max",
                      std::max(totals.fine.crab_error_deg, totals.whole.crab_error_deg));
        result.figure("sensor_rms_m_fine", totals.fine.rms_m());
        result.figure("sensor_rms_m_whole", totals.whole.rms_m());
        result.figure("split_errors", totals.fine.split_errors + totals.whole.split_errors);
        result.figure("sign_errors", totals.fine.sign_errors + totals.whole.sign_errors);
        result.figure("lines_without_path", totals.fine.without_path + totals.whole.without_path);
        result.figure("lines", totals.fine.lines + totals.whole.lines);
        result.figure("points_per_s", rate);
        result.parameter("density_points_per_m2", density);
        result.parameter("tiles", std::string("2x2"));
        result.parameter("tile_m", options.quick ? 250.0 : 500.0);
        std::string names;
        for (const std::string& name : scenes) names += (names.empty() ? "" : " ") + name;
        result.parameter("scenes", names);
      });
}
