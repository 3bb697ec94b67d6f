// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/legend.h"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>

#include "terrain-viewer/app/scale_bar.h"

namespace cornice::viewer {
namespace {

constexpr float kBarWidth = 18.0f, kBarHeight = 160.0f;

/// Classes are equally high, however wide they are: so all of them can be read.
Colour colour_at(const Ramp& ramp, double share) {
  if (!ramp.is_stepped) return ramp.at(ramp.low() + (ramp.high() - ramp.low()) * share);
  return ramp.stops[static_cast<std::size_t>(share * double(ramp.stops.size() - 1))].colour;
}

/// Height of a stop's label: of a value at its place, of a word in the middle of its class; the end
/// of the last class has none.
std::optional<double> share_of(const Ramp& ramp, std::size_t stop) {
  const std::size_t last = ramp.stops.size() - 1;
  if (ramp.is_stepped && stop == last) return std::nullopt;
  if (ramp.is_stepped)
    return (double(stop) + (ramp.stops[stop].label.empty() ? 0.0 : 0.5)) / double(last);
  return (ramp.stops[stop].value - ramp.low()) / (ramp.high() - ramp.low());
}

std::string label_of(const Ramp::Stop& stop) {
  if (!stop.label.empty()) return stop.label;
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.4g", stop.value);
  return text.data();
}

Ramp level_legend(int levels) {
  Ramp ramp{"Level", "", {}, true};
  for (int level = 0; level < levels; ++level) {
    std::string label = std::to_string(level);
    if (level == 0) label += ", coarsest";
    if (level > 0 && level == levels - 1) label += ", finest";
    ramp.stops.push_back({double(level), level_colour(level), std::move(label)});
  }
  ramp.stops.push_back({double(levels), level_colour(levels - 1)});
  return ramp;
}

ImU32 colour_of(Colour c) { return IM_COL32(c[0], c[1], c[2], 255); }

}  // namespace

LegendEdges draw_legend(const Ramp& ramp, float right, float top) {
  ImGui::SetNextWindowPos({right, top}, ImGuiCond_Always, {1.0f, 0.0f});
  ImGui::SetNextWindowBgAlpha(0.6f);
  ImGui::Begin(ramp.title.c_str(), nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs |
                   ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoSavedSettings |
                   ImGuiWindowFlags_NoNav);
  ImGui::Text("%s%s%s", ramp.title.c_str(), ramp.unit.empty() ? "" : ", ", ramp.unit.c_str());
  // Half a line for the label of the upper end.
  ImGui::Dummy({0.0f, 4.0f});
  float widest = 0.0f;
  ImDrawList* draw = ImGui::GetWindowDrawList();
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const auto steps = static_cast<int>(kBarHeight);
  for (int i = 0; i < steps; ++i) {
    const float upper = corner.y + kBarHeight - float(i + 1);
    draw->AddRectFilled({corner.x, upper}, {corner.x + kBarWidth, upper + 1.0f},
                        colour_of(colour_at(ramp, (i + 0.5) / steps)));
  }
  for (std::size_t stop = 0; stop < ramp.stops.size(); ++stop) {
    const auto share = share_of(ramp, stop);
    if (!share) continue;
    const std::string text = label_of(ramp.stops[stop]);
    draw->AddText({corner.x + kBarWidth + 6.0f, corner.y + kBarHeight * float(1.0 - *share) - 7.0f},
                  IM_COL32_WHITE, text.c_str());
    widest = std::max(widest, ImGui::CalcTextSize(text.c_str()).x);
  }
  ImGui::Dummy({kBarWidth + 6.0f + widest, kBarHeight + 10.0f});
  const LegendEdges edges{right - ImGui::GetWindowWidth(), top + ImGui::GetWindowHeight()};
  ImGui::End();
  return edges;
}

std::optional<Ramp> legend_of(const Style& style, int levels) {
  if (style.shading == Shading::kLevel || style.shading == Shading::kCell)
    return level_legend(std::max(1, levels));
  return ramp_of(style);
}

void draw_legends(const Style& style, bool has_difference, int levels, int width) {
  constexpr float kGap = 8.0f;
  float right = float(width) - 12.0f, top = 12.0f;
  if (has_difference) {
    const LegendEdges above = draw_legend(difference_ramp(style.difference_high_m), right, top);
    // Another is as high: beside this one where there is no room below.
    const bool fits = 2.0f * above.bottom - top + kGap <= ImGui::GetIO().DisplaySize.y;
    if (fits)
      top = above.bottom + kGap;
    else
      right = above.left - kGap;
  }
  if (const auto ramp = legend_of(style, levels)) draw_legend(*ramp, right, top);
}

void draw_scale_and_north(const Camera& camera, int width, int height, double depth_m,
                          Taken taken) {
  constexpr double kMostPixels = 180.0;
  ImDrawList* draw = ImGui::GetForegroundDrawList();
  const ScaleBar bar = scale_bar(camera, height, depth_m, kMostPixels);
  const auto length = float(bar.pixels);
  const float wide = std::max(length, ImGui::CalcTextSize(bar.label.c_str()).x);
  const auto [right, low] = scale_place(width, height, wide, taken.right, taken.top);
  draw->AddRectFilled({right - length - 2.0f, low - 6.0f}, {right + 2.0f, low + 2.0f},
                      IM_COL32(0, 0, 0, 140));
  draw->AddRectFilled({right - length, low - 4.0f}, {right, low}, IM_COL32_WHITE);
  draw->AddText({right - wide, low - 22.0f}, IM_COL32_WHITE, bar.label.c_str());
  const ImVec2 centre{right - 24.0f, low - 66.0f};
  const double angle = -camera.heading_deg * std::numbers::pi / 180.0;
  const auto at = [&](double a, float radius) {
    return ImVec2{centre.x + radius * float(std::sin(angle + a)),
                  centre.y - radius * float(std::cos(angle + a))};
  };
  draw->AddCircleFilled(centre, 38.0f, IM_COL32(0, 0, 0, 110));
  constexpr double kSide = 0.5 * std::numbers::pi;
  draw->AddTriangleFilled(at(0.0, 20.0f), at(kSide, 7.0f), at(-kSide, 7.0f),
                          IM_COL32(235, 80, 60, 255));
  const ImVec2 north = at(0.0, 30.0f), letter = ImGui::CalcTextSize("N");
  draw->AddText({north.x - 0.5f * letter.x, north.y - 0.5f * letter.y}, IM_COL32_WHITE, "N");
  draw->AddTriangleFilled(at(std::numbers::pi, 20.0f), at(-kSide, 7.0f), at(kSide, 7.0f),
                          IM_COL32(230, 230, 230, 255));
}

}  // namespace cornice::viewer
