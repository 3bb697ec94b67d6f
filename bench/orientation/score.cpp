// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/orientation/score.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace cornice::bench {
namespace {

constexpr double kDegrees = 57.29577951308232;

std::array<double, 3> quantiles(std::vector<float>& values) {
  std::array<double, 3> result{};
  if (values.empty()) return result;
  std::sort(values.begin(), values.end());
  constexpr std::array<double, 3> kShares{0.5, 0.95, 0.99};
  for (std::size_t q = 0; q < kShares.size(); ++q) {
    const auto at = static_cast<std::size_t>(kShares[q] * static_cast<double>(values.size() - 1));
    result[q] = static_cast<double>(values[at]);
  }
  return result;
}

std::string text(const char* format, auto... values) {
  std::array<char, 256> buffer{};
  std::snprintf(buffer.data(), buffer.size(), format, values...);
  return buffer.data();
}

nlohmann::json to_json(const ClassScore& s) {
  return {{"points", s.points},
          {"right", s.right_share()},
          {"unsettled", s.unsettled_share()},
          {"angle_deg",
           {{"median", s.angle_deg[0]}, {"p95", s.angle_deg[1]}, {"p99", s.angle_deg[2]}}}};
}

}  // namespace

std::size_t slope_class(Vec3f true_normal) {
  if (true_normal.z < 0.0f) return 3;
  const double slope_deg = std::acos(std::min(static_cast<double>(true_normal.z), 1.0)) * kDegrees;
  return std::min<std::size_t>(static_cast<std::size_t>(slope_deg / 30.0), 2);
}

Score score(const std::string& run, const std::string& method, const std::vector<Vec3f>& truth,
            const std::vector<Vec3f>& normals, const std::vector<std::uint8_t>& settled) {
  Score result;
  result.run = run;
  result.method = method;
  std::vector<float> all;
  std::array<std::vector<float>, 4> by_slope;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const std::size_t slope = slope_class(truth[i]);
    const double cosine = static_cast<double>(dot(truth[i], normals[i]));
    for (ClassScore* s : {&result.all, &result.by_slope[slope]}) {
      ++s->points;
      s->unsettled += settled[i] == 0 ? 1 : 0;
      s->right += settled[i] != 0 && cosine > 0.0 ? 1 : 0;
    }
    if (settled[i] == 0) continue;
    const auto angle = static_cast<float>(std::acos(std::min(std::abs(cosine), 1.0)) * kDegrees);
    all.push_back(angle);
    by_slope[slope].push_back(angle);
  }
  result.all.angle_deg = quantiles(all);
  for (std::size_t s = 0; s < by_slope.size(); ++s) {
    result.by_slope[s].angle_deg = quantiles(by_slope[s]);
  }
  return result;
}

std::string table(const std::vector<Score>& scores) {
  std::string out =
      text("%-24s %-24s %9s %8s | right %%: %8s %8s %8s %8s %8s %8s | angle, deg\n", "run",
           "method", "points", "unset %", "all", "0-30", "30-60", "60-90", "overhang", "(points)");
  for (const Score& s : scores) {
    out += text("%-24s %-24s %9zu %8.4f |          %8.4f", s.run.c_str(), s.method.c_str(),
                s.all.points, 100.0 * s.all.unsettled_share(), 100.0 * s.all.right_share());
    for (const ClassScore& c : s.by_slope) {
      out += c.points > 0 ? text(" %8.3f", 100.0 * c.right_share()) : text(" %8s", "-");
    }
    out += text(" %8zu", s.overhang().points);
    out += text(" | %.1f %.1f %.1f\n", s.all.angle_deg[0], s.all.angle_deg[1], s.all.angle_deg[2]);
  }
  return out;
}

std::string table_json(const std::vector<Score>& scores) {
  nlohmann::json rows = nlohmann::json::array();
  for (const Score& s : scores) {
    nlohmann::json row = {{"run", s.run}, {"method", s.method}, {"all", to_json(s.all)}};
    for (std::size_t c = 0; c < s.by_slope.size(); ++c) {
      row["by_slope"][kSlopeNames[c]] = to_json(s.by_slope[c]);
    }
    rows.push_back(std::move(row));
  }
  return rows.dump(1) + "\n";
}

}  // namespace cornice::bench
