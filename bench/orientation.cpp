// SPDX-License-Identifier: GPL-3.0-or-later
// Right and wrong sides of normals on simulated surveys: ours and what people use today.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "bench/bench_json.h"
#include "bench/orientation/peers.h"
#include "bench/orientation/picture.h"
#include "bench/orientation/score.h"
#include "bench/orientation/survey.h"
#include "bench/programs.h"
#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/io/ply.h"
#include "stages/normals/morton_order.h"
#include "stages/normals/normals.h"

namespace {

using namespace cornice;
using namespace cornice::bench;

constexpr const char* kOurs = "cornice";
/// Of the viewer of pictures above the horizon, degrees.
constexpr double kAltitude = 15.0;

struct Settings {
  std::vector<std::string> scenes{"alp", "cliff", "ledges"};
  std::vector<std::string> scanners{"oscillating", "polygon", "palmer"};
  int tile_m = 0;        ///< 0: the scene's own
  double density = 0.0;  ///< 0: the scene's own
  bool true_lines = false;
  bool ours_only = false;
  std::filesystem::path table;
  std::filesystem::path pictures;
  double azimuth_deg = 180.0;
  std::filesystem::path points;
};

/// The points that the methods are judged on, in the tree's order.
struct Judged {
  PointCloud points;
  std::vector<Vec3f> truth;
  std::vector<std::uint64_t> keys;
  std::vector<std::uint32_t> source;  ///< index in the survey
};

/// What is left after class filter and duplicates. No method gets the points cleaned of isolated
/// ones: in these scenes all are true.
Judged judged_points(const Survey& survey, int threads) {
  normals::FilterCounts counts;
  const normals::ClassRules rules = normals::built_in_rules(normals::rules_for_file(survey.tile));
  const std::vector<std::uint8_t> keep = points_to_keep(survey.points, rules, counts);
  std::vector<std::uint32_t> kept;
  std::vector<Vec3f> positions;
  for (std::uint32_t i = 0; i < keep.size(); ++i) {
    if (keep[i] == 0) continue;
    kept.push_back(i);
    positions.push_back(survey.points.positions[i]);
  }
  const normals::MortonOrder sorted = normals::sort_along_curve(positions, threads);
  Judged judged;
  judged.points.origin = survey.points.origin;
  for (std::size_t r = 0; r < sorted.order.size(); ++r) {
    const std::uint32_t i = kept[sorted.order[r]];
    const Vec3f p = survey.points.positions[i];
    if (!judged.points.positions.empty() && p == judged.points.positions.back()) continue;
    judged.keys.push_back(sorted.keys[r]);
    judged.source.push_back(i);
    judged.truth.push_back(survey.truth[i]);
    judged.points.positions.push_back(p);
    judged.points.gps_time_s.push_back(survey.points.gps_time_s[i]);
    judged.points.scan_angle_deg.push_back(survey.points.scan_angle_deg[i]);
    judged.points.point_source_id.push_back(survey.points.point_source_id[i]);
    judged.points.scanner_channel.push_back(survey.points.scanner_channel[i]);
    judged.points.user_data.push_back(survey.points.user_data[i]);
  }
  return judged;
}

Oriented ours(const Survey& survey, const Judged& judged, int threads) {
  normals::Options options;
  options.threads = threads;
  options.keep_source = true;
  options.isolated.method = normals::IsolatedOptions::Method::kNone;
  const normals::Result result = normals::compute_normals(
      survey.points, survey.points.size(), survey.lines,
      normals::built_in_rules(normals::rules_for_file(survey.tile)), options);
  std::vector<std::uint32_t> place(survey.points.size(), 0);
  for (std::uint32_t j = 0; j < judged.source.size(); ++j) place[judged.source[j]] = j;
  Oriented oriented{kOurs, std::vector<Vec3f>(judged.source.size()),
                    std::vector<std::uint8_t>(judged.source.size(), 0)};
  for (std::size_t r = 0; r < result.source.size(); ++r) {
    oriented.normals[place[result.source[r]]] = result.normals[r];
    oriented.settled[place[result.source[r]]] = 1;
  }
  return oriented;
}

/// Middle height of the sensor above the points; what a user would put the viewpoint at.
double sensor_height(const Survey& survey) {
  for (const FlightLine& line : survey.lines.lines) {
    if (!line.nodes.empty()) return line.nodes.front().position.z - survey.points.position(0).z;
  }
  return 1000.0;
}

std::vector<Oriented> all_methods(const Survey& survey, const Judged& judged, bool ours_only,
                                  int threads) {
  std::vector<Oriented> methods{ours(survey, judged, threads)};
  if (ours_only) return methods;
  const normals::PointTree tree(judged.points.positions, judged.keys, threads);
  const PeerInput input = make_peer_input(tree, judged.points, survey.lines, threads);
  methods.push_back(upward(input));
  methods.push_back(pcl_viewpoint(input, sensor_height(survey)));
  methods.push_back(spanning_tree(input));
  methods.push_back(thesis(input, false));
  methods.push_back(thesis(input, true));
  return methods;
}

void draw(const Settings& settings, const SurveyPlan& plan, const Judged& judged,
          const Oriented& method) {
  std::string name = plan.name() + " " + method.method + ".png";
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == ' ' || c == ',' || c == '(' || c == ')'; },
      '_');
  const auto colours = colour_by_truth(method.normals, method.settled, judged.truth,
                                       towards_viewer(settings.azimuth_deg, kAltitude));
  std::filesystem::create_directories(settings.pictures);
  write_picture(settings.pictures / name,
                view(judged.points.positions, colours, settings.azimuth_deg, kAltitude, 1400));
}

struct Extent {
  int tile_m;
  double density;
};

/// The blades of `ledges` are as thin for 5 points/m² as none of `alp` and `cliff` is for 20.
Extent extent_of(const std::string& scene, const Settings& settings, bool quick) {
  Extent extent = scene == "ledges" ? Extent{160, 5.0} : Extent{quick ? 100 : 200, 20.0};
  if (settings.tile_m > 0) extent.tile_m = settings.tile_m;
  if (settings.density > 0.0) extent.density = settings.density;
  return extent;
}

std::vector<SurveyPlan> plans(const Settings& settings, const Options& options) {
  std::vector<SurveyPlan> all;
  for (const std::string& scene : settings.scenes) {
    const Extent extent = extent_of(scene, settings, options.quick);
    for (const std::string& scanner : settings.scanners) {
      for (const bool whole : {false, true}) {
        SurveyPlan plan;
        plan.scene = scene;
        plan.scanner = scanner;
        plan.whole_degrees = whole;
        plan.tile_m = extent.tile_m;
        plan.density = extent.density;
        plan.seed = options.seed;
        plan.true_lines = settings.true_lines;
        // The quick run keeps the hardest of each kind.
        if (!options.quick || (scene != "alp" && whole)) all.push_back(plan);
      }
    }
  }
  return all;
}

/// Worst share of every method over all runs.
std::map<std::string, double> worst(const std::vector<Score>& scores,
                                    const std::function<const ClassScore&(const Score&)>& part) {
  std::map<std::string, double> result;
  for (const Score& s : scores) {
    if (part(s).points == 0) continue;
    const auto [at, is_new] = result.try_emplace(s.method, part(s).right_share());
    if (!is_new) at->second = std::min(at->second, part(s).right_share());
  }
  return result;
}

/// Share of every method over the points of all runs together.
std::map<std::string, double> pooled(const std::vector<Score>& scores,
                                     const std::function<const ClassScore&(const Score&)>& part) {
  std::map<std::string, ClassScore> sums;
  for (const Score& s : scores) {
    sums[s.method].points += part(s).points;
    sums[s.method].right += part(s).right;
  }
  std::map<std::string, double> result;
  for (const auto& [method, sum] : sums) result[method] = sum.right_share();
  return result;
}

double best_peer(const std::map<std::string, double>& shares) {
  double best = 0.0;
  for (const auto& [method, share] : shares) {
    if (method != kOurs) best = std::max(best, share);
  }
  return best;
}

/// Points wrong on the whole, unsettled ones too, by the one of the other methods with fewest; and
/// by ours.
struct WrongPoints {
  double ours = 0.0, best_peer = 0.0;
};

WrongPoints wrong_points(const std::vector<Score>& scores,
                         const std::function<const ClassScore&(const Score&)>& part) {
  std::map<std::string, double> wrong;
  for (const Score& s : scores) {
    wrong[s.method] += static_cast<double>(part(s).points - part(s).right);
  }
  WrongPoints result{wrong.at(kOurs), std::numeric_limits<double>::infinity()};
  for (const auto& [method, count] : wrong) {
    if (method != kOurs) result.best_peer = std::min(result.best_peer, count);
  }
  return result;
}

/// Runs in which another method has a greater share right, of all points or of overhang faces.
double runs_lost(const std::vector<Score>& scores) {
  std::map<std::string, const Score*> mine;
  std::map<std::string, bool> lost;
  for (const Score& s : scores) {
    if (s.method == kOurs) mine[s.run] = &s;
  }
  for (const Score& s : scores) {
    if (s.method == kOurs) continue;
    const Score& own = *mine.at(s.run);
    if (s.all.right_share() > own.all.right_share() ||
        s.overhang().right_share() > own.overhang().right_share()) {
      lost[s.run] = true;
    }
  }
  return static_cast<double>(lost.size());
}

void add_figures(const std::vector<Score>& scores, Result& result) {
  const auto of_all = [](const Score& s) -> const ClassScore& { return s.all; };
  const auto of_overhang = [](const Score& s) -> const ClassScore& { return s.overhang(); };
  const auto all = worst(scores, of_all), overhang = worst(scores, of_overhang);
  const auto all_pooled = pooled(scores, of_all), overhang_pooled = pooled(scores, of_overhang);
  result.figure("right_all", all.at(kOurs));
  if (overhang.count(kOurs) != 0) {
    result.figure("right_overhang", overhang.at(kOurs));
    result.figure("best_peer_right_overhang", best_peer(overhang));
  }
  result.figure("best_peer_right_all", best_peer(all));
  result.figure("right_all_pooled", all_pooled.at(kOurs));
  result.figure("best_peer_right_all_pooled", best_peer(all_pooled));
  result.figure("right_overhang_pooled", overhang_pooled.at(kOurs));
  result.figure("best_peer_right_overhang_pooled", best_peer(overhang_pooled));
  if (all.size() > 1) {
    const WrongPoints wrong = wrong_points(scores, of_all);
    const WrongPoints wrong_overhang = wrong_points(scores, of_overhang);
    result.figure("wrong_all", wrong.ours);
    result.figure("best_peer_wrong_all", wrong.best_peer);
    result.figure("wrong_overhang", wrong_overhang.ours);
    result.figure("best_peer_wrong_overhang", wrong_overhang.best_peer);
  }
  result.figure("runs_lost", runs_lost(scores));
}

void look_at(const Settings& settings) {
  const OrientedPoints cloud = read_ply_points(settings.points);
  std::filesystem::create_directories(settings.pictures);
  for (const int azimuth : {0, 45, 90, 135, 180, 225, 270, 315}) {
    const auto colours = colour_by_facing(cloud.normals, towards_viewer(azimuth, 20.0));
    const std::string name = settings.points.stem().string() + "_" + std::to_string(azimuth);
    write_picture(settings.pictures / (name + ".png"),
                  view(cloud.positions, colours, azimuth, 20.0, 1000));
  }
}

void measure(const Settings& settings, const Options& options, Result& result) {
  const ScratchFolder work("orientation");
  std::vector<Score> scores;
  for (const SurveyPlan& plan : plans(settings, options)) {
    const Survey survey =
        fly(plan, own_folder(), {CORNICE_SCENES, CORNICE_OWN_SCENES}, work.path(), options.threads);
    const Judged judged = judged_points(survey, options.threads);
    for (const Oriented& method :
         all_methods(survey, judged, settings.ours_only, options.threads)) {
      scores.push_back(
          score(plan.name(), method.method, judged.truth, method.normals, method.settled));
      if (!settings.pictures.empty()) draw(settings, plan, judged, method);
    }
    std::fprintf(stderr, "%s done\n", plan.name().c_str());
  }
  std::printf("%s\n", table(scores).c_str());
  if (!settings.table.empty()) write_file_atomically(settings.table, table_json(scores));
  std::string extents;
  for (const std::string& scene : settings.scenes) {
    const Extent extent = extent_of(scene, settings, options.quick);
    extents += (extents.empty() ? "" : ", ") + scene + " " + std::to_string(extent.tile_m) + " m " +
               std::to_string(std::lround(extent.density)) + " points/m²";
  }
  result.parameter("scenes", extents);
  result.parameter("noise_m", 0.03);
  result.parameter("lines", std::string(settings.true_lines ? "true" : "estimated"));
  add_figures(scores, result);
}

}  // namespace

int main(int argc, char** argv) {
  Settings settings;
  return run(
      "orientation", "Normals on the right side on simulated scenes", argc, argv,
      [&](CLI::App& app) {
        app.add_option("--scenes", settings.scenes,
                       "of samples/scenes and bench/orientation/scenes")
            ->delimiter(',');
        app.add_option("--scanners", settings.scanners)->delimiter(',');
        app.add_option("--tile-m", settings.tile_m,
                       "side of the simulated tile; 0: 200, of ledges 160");
        app.add_option("--density", settings.density,
                       "points per square metre; 0: 20, on ledges 5");
        app.add_flag("--true-lines", settings.true_lines, "true instead of estimated trajectories");
        app.add_flag("--ours-only", settings.ours_only, "without the other methods");
        app.add_option("--table", settings.table, "JSON file for the whole table");
        app.add_option("--pictures", settings.pictures, "folder for a picture per run and method");
        app.add_option("--azimuth", settings.azimuth_deg, "where the pictures' viewer stands");
        app.add_option("--points", settings.points,
                       "only draw these oriented points (PLY) from eight sides into --pictures");
      },
      [&](const Options& options, Result& result) {
        if (!settings.points.empty()) {
          look_at(settings);
          return;
        }
        measure(settings, options, result);
      });
}
