// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/panels.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/geo/crs.h"
#include "core/geo/globe.h"
#include "terrain-viewer/scene/navigation.h"

namespace cornice::viewer {
namespace {

constexpr ImGuiWindowFlags kPlain = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs |
                                    ImGuiWindowFlags_AlwaysAutoResize |
                                    ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoNav;

ImU32 colour_of(Colour c) { return IM_COL32(c[0], c[1], c[2], 255); }

/// Below `top`; returns where the next legend may begin.
float draw_legend(const Ramp& ramp, float right, float top) {
  ImGui::SetNextWindowPos({right, top}, ImGuiCond_Always, {1.0f, 0.0f});
  ImGui::SetNextWindowBgAlpha(0.6f);
  ImGui::Begin(ramp.title.c_str(), nullptr, kPlain);
  ImGui::Text("%s%s%s", ramp.title.c_str(), ramp.unit.empty() ? "" : ", ", ramp.unit.c_str());
  ImDrawList* draw = ImGui::GetWindowDrawList();
  constexpr float kWidth = 18.0f, kHeight = 160.0f;
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  constexpr int kSteps = 80;
  for (int i = 0; i < kSteps; ++i) {
    const double value = ramp.low() + (ramp.high() - ramp.low()) * (i + 0.5) / kSteps;
    const float upper = corner.y + kHeight * (1.0f - float(i + 1) / kSteps);
    draw->AddRectFilled({corner.x, upper}, {corner.x + kWidth, upper + kHeight / kSteps + 1.0f},
                        colour_of(ramp.at(value)));
  }
  for (const Ramp::Stop& stop : ramp.stops) {
    const double share = (stop.value - ramp.low()) / (ramp.high() - ramp.low());
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.4g", stop.value);
    draw->AddText({corner.x + kWidth + 6.0f, corner.y + kHeight * float(1.0 - share) - 7.0f},
                  IM_COL32_WHITE, text.data());
  }
  ImGui::Dummy({kWidth + 70.0f, kHeight + 10.0f});
  const float next = top + ImGui::GetWindowHeight() + 8.0f;
  ImGui::End();
  return next;
}

void draw_legends(const Session& session, const Style& style, int width) {
  const float right = float(width) - 12.0f;
  float top = 12.0f;
  if (session.cover() == Cover::kDifference)
    top = draw_legend(difference_ramp(style.difference_high_m), right, top);
  if (const auto ramp = ramp_of(style)) draw_legend(*ramp, right, top);
}

/// What lies over the ground's own colours.
void draw_cover(Session& session) {
  Style& style = session.style();
  if (session.photo() == nullptr && session.difference() == nullptr) return;
  ImGui::Separator();
  const Cover shown = session.cover();
  const auto button = [&](const char* name, Cover cover) {
    if (ImGui::RadioButton(name, shown == cover)) session.set_cover(cover);
  };
  button("nothing over it", Cover::kNone);
  if (session.photo() != nullptr) button(session.photo()->name().c_str(), Cover::kPhoto);
  if (session.difference() != nullptr)
    button(session.difference()->name().c_str(), Cover::kDifference);
  const auto slider = [](const char* name, double& value, float low, float high) {
    auto number = static_cast<float>(value);
    if (ImGui::SliderFloat(name, &number, low, high, "%.2f")) value = number;
  };
  if (shown != Cover::kNone) slider("strength", style.drape_opacity, 0.0f, 1.0f);
  if (shown == Cover::kPhoto) slider("light on it", style.photo_relief, 0.0f, 1.0f);
  if (shown == Cover::kDifference) {
    auto high = static_cast<float>(style.difference_high_m);
    if (ImGui::SliderFloat("range", &high, 0.01f, 100.0f, "%.2f m", ImGuiSliderFlags_Logarithmic))
      style.difference_high_m = high;
  }
}

/// A round number of metres whose bar is at most `pixels` long.
double round_length(double metres_per_pixel, double pixels) {
  const double most = metres_per_pixel * pixels;
  const double power = std::pow(10.0, std::floor(std::log10(most)));
  for (const double factor : {5.0, 2.0})
    if (factor * power <= most) return factor * power;
  return power;
}

void draw_scale_and_north(const Camera& camera, int width, int height, double distance_m) {
  ImDrawList* draw = ImGui::GetForegroundDrawList();
  const double per_pixel = 2.0 * distance_m *
                           std::tan(0.5 * camera.field_of_view_deg * std::numbers::pi / 180.0) /
                           height;
  const double length = round_length(per_pixel, 180.0);
  const float bar = float(length / per_pixel);
  const float right = float(width) - 24.0f, low = float(height) - 28.0f;
  draw->AddRectFilled({right - bar - 2.0f, low - 2.0f}, {right + 2.0f, low + 6.0f},
                      IM_COL32(0, 0, 0, 140));
  draw->AddRectFilled({right - bar, low}, {right, low + 4.0f}, IM_COL32_WHITE);
  std::array<char, 48> text{};
  if (length >= 1000.0)
    std::snprintf(text.data(), text.size(), "%g km", length / 1000.0);
  else
    std::snprintf(text.data(), text.size(), "%g m", length);
  draw->AddText({right - bar, low - 18.0f}, IM_COL32_WHITE, text.data());
  const ImVec2 centre{float(width) - 44.0f, float(height) - 84.0f};
  const double angle = -camera.heading_deg * std::numbers::pi / 180.0;
  const auto at = [&](double a, float radius) {
    return ImVec2{centre.x + radius * float(std::sin(angle + a)),
                  centre.y - radius * float(std::cos(angle + a))};
  };
  draw->AddCircleFilled(centre, 24.0f, IM_COL32(0, 0, 0, 110));
  draw->AddTriangleFilled(at(0.0, 20.0f), at(2.6, 9.0f), at(-2.6, 9.0f),
                          IM_COL32(235, 80, 60, 255));
  draw->AddTriangleFilled(at(std::numbers::pi, 20.0f), at(0.54, 9.0f), at(-0.54, 9.0f),
                          IM_COL32(230, 230, 230, 255));
}

void draw_read_out(const PanelState& state, const Camera& camera, int height,
                   const std::optional<UnderCursor>& under) {
  ImGui::SetNextWindowPos({12.0f, float(height) - 12.0f}, ImGuiCond_Always, {0.0f, 1.0f});
  ImGui::SetNextWindowBgAlpha(0.6f);
  ImGui::Begin("read-out", nullptr, kPlain);
  if (under) {
    ImGui::Text("E %.2f  N %.2f  H %.2f m", under->point.x, under->point.y, under->point.z);
    if (under->slope_deg) {
      ImGui::SameLine();
      ImGui::Text("  slope %.0f deg", *under->slope_deg);
    }
  } else {
    ImGui::Text("sky");
  }
  ImGui::Text("eye E %.1f  N %.1f  H %.1f m, heading %.0f, pitch %.0f, %s %.3g m/s", camera.eye.x,
              camera.eye.y, camera.eye.z, camera.heading_deg, camera.pitch_deg,
              state.walks ? "walking" : "flying", state.speed_ms);
  if (!state.message.empty())
    ImGui::TextColored({1.0f, 0.75f, 0.4f, 1.0f}, "%s", state.message.c_str());
  ImGui::End();
}

/// One picture or two of the same view.
void draw_split(PanelState& state, const Session& session) {
  if (!session.can_split()) return;
  const auto button = [&](const char* name, Split::Kind kind) {
    if (ImGui::RadioButton(name, state.split == kind)) state.split = kind;
  };
  button("one picture", Split::Kind::kNone);
  ImGui::SameLine();
  button("swipe", Split::Kind::kSwipe);
  ImGui::SameLine();
  button("side by side", Split::Kind::kSideBySide);
  if (state.split != Split::Kind::kSwipe) return;
  auto share = static_cast<float>(state.swipe);
  if (ImGui::SliderFloat("line", &share, 0.0f, 1.0f, "")) state.swipe = share;
}

/// Up and down in the order in which layers are drawn, and visible and opaque.
void draw_layer_rows(Session& session) {
  for (std::size_t i = 0; i < session.layers().size(); ++i) {
    LayerLook& look = session.looks()[i];
    ImGui::PushID(static_cast<int>(i));
    if (i > 0) {
      if (ImGui::SmallButton("up")) session.swap_layers(i - 1, i);
      ImGui::SameLine();
    }
    ImGui::Checkbox(session.layers()[i]->name().c_str(), &look.is_visible);
    auto opacity = static_cast<float>(look.opacity);
    if (ImGui::SliderFloat("opacity", &opacity, 0.1f, 1.0f, "%.2f")) look.opacity = opacity;
    ImGui::PopID();
  }
}

void draw_layers(PanelState& state, Session& session, PanelResult& result) {
  if (!state.shows_layers) return;
  ImGui::SetNextWindowPos({12.0f, 12.0f}, ImGuiCond_FirstUseEver);
  ImGui::SetNextWindowSize({300.0f, 0.0f}, ImGuiCond_FirstUseEver);
  ImGui::Begin("Layers", &state.shows_layers);
  draw_layer_rows(session);
  draw_split(state, session);
  draw_cover(session);
  ImGui::Separator();
  Style& style = session.style();
  int shading = static_cast<int>(style.shading);
  if (ImGui::Combo("shading", &shading, kShadingNames.data(),
                   static_cast<int>(kShadingNames.size())))
    style.shading = static_cast<Shading>(shading);
  auto contours = static_cast<float>(style.contour_interval_m);
  if (ImGui::SliderFloat("contours", &contours, 0.0f, 100.0f, "%.0f m"))
    style.contour_interval_m = contours;
  ImGui::Checkbox("edges", &style.has_edges);
  auto pixels = static_cast<float>(session.error_pixels());
  if (ImGui::SliderFloat("error", &pixels, 0.5f, 16.0f, "%.1f pixels",
                         ImGuiSliderFlags_Logarithmic))
    session.error_pixels() = pixels;
  auto frame_ms = static_cast<float>(session.frame_ms());
  if (ImGui::SliderFloat("frame time", &frame_ms, 0.0f, 100.0f,
                         frame_ms > 0.0f ? "at most %.0f ms" : "no limit"))
    session.frame_ms() = frame_ms;
  ImGui::Checkbox("freeze what is chosen", &session.is_frozen());
  if (!state.bookmarks.empty() && ImGui::TreeNode("Bookmarks")) {
    for (const PanelState::Bookmark& bookmark : state.bookmarks)
      if (ImGui::Selectable(bookmark.name.c_str())) result.go = bookmark.camera;
    ImGui::TreePop();
  }
  if (!state.recent.empty() && ImGui::TreeNode("Recent files")) {
    for (const std::filesystem::path& file : state.recent)
      if (ImGui::Selectable(file.c_str())) result.open = file;
    ImGui::TreePop();
  }
  ImGui::End();
}

void draw_frames(PanelState& state, Session& session, const FrameCounts& counts) {
  if (!state.shows_frames) return;
  ImGui::SetNextWindowPos({324.0f, 12.0f}, ImGuiCond_FirstUseEver);
  ImGui::Begin("Frames", &state.shows_frames, ImGuiWindowFlags_AlwaysAutoResize);
  const float slowest = *std::max_element(state.frame_ms.begin(), state.frame_ms.end());
  ImGui::PlotLines("##ms", state.frame_ms.data(), static_cast<int>(state.frame_ms.size()),
                   static_cast<int>(state.frame_at), nullptr, 0.0f, std::max(20.0f, slowest),
                   {280.0f, 60.0f});
  const std::size_t last = (state.frame_at + state.frame_ms.size() - 1) % state.frame_ms.size();
  ImGui::Text("frame %.1f ms, drawing %.1f ms, choosing %.2f ms", double(state.frame_ms[last]),
              counts.draw_ms, counts.select_ms);
  ImGui::Text("error %.2f pixels%s", counts.error_pixels,
              session.is_frozen() ? ", what is drawn is frozen" : "");
  if (counts.overdraw > 0.0) ImGui::Text("each pixel drawn %.2f times", counts.overdraw);
  ImGui::Text("%.2f M triangles, %u cells, %u calls", double(counts.triangles) * 1e-6, counts.cells,
              counts.calls);
  ImGui::Text(
      "GPU %.0f of %.0f MiB, %.1f kB uploaded", double(session.cells().used_bytes()) / 1048576.0,
      double(session.cells().capacity_bytes()) / 1048576.0, double(counts.uploaded_bytes) / 1024.0);
  for (const auto& layer : session.layers()) {
    const LayerCounts& c = layer->counts();
    ImGui::Text("%s: %u loaded, %u missing, %.1f MiB read", layer->name().c_str(), c.cells_loaded,
                c.cells_missing, double(c.store.bytes_read) / 1048576.0);
  }
  if (session.cover() != Cover::kNone)
    ImGui::Text("raster: %zu tiles needed, %zu missing, %.0f MiB", counts.drape.tiles_needed,
                counts.drape.tiles_missing, double(counts.drape.used_bytes) / 1048576.0);
  ImGui::End();
}

void draw_help(PanelState& state) {
  if (!state.shows_help) return;
  ImGui::Begin("Help", &state.shows_help, ImGuiWindowFlags_AlwaysAutoResize);
  ImGui::TextUnformatted(
      "left drag      turn around the point under the cursor\n"
      "right drag     move the ground with the cursor\n"
      "middle drag    look around\n"
      "wheel          towards the cursor and back; while flying: speed\n"
      "double click   go there\n"
      "W A S D  Q E   fly; Shift: five times as fast\n"
      "Space          walk on the ground, fly again\n"
      "Home           see all\n"
      "Ctrl+Z Ctrl+Y  camera back and forth\n"
      "G              go to coordinates\n"
      "B              bookmark this view\n"
      "N              next shading      C  contour lines\n"
      "X              edges             L  layers\n"
      "O              photograph, differences, neither\n"
      "V              one picture, swipe, side by side\n"
      "K              freeze what is chosen\n"
      "1 .. 9         show or hide a layer\n"
      "Tab            blink between the last two layers\n"
      "F3             frame times       F11  full screen\n"
      "F12            picture and its camera\n"
      "Ctrl+Q         quit\n"
      "P              add this view to a path; Shift+P saves it, Ctrl+P plays it\n"
      "drop a file    hierarchy: a layer; raster: over the ground");
  ImGui::End();
}

/// Where a text says to go: above that place, looking down at it.
std::optional<Camera> camera_at(const std::string& text, Session& session, const Camera& camera,
                                std::string& message) {
  const auto place = parse_place(text);
  if (!place) {
    message = "\"" + text + "\" is no place: 2643500 1158000, or 46.5N 8.1E";
    return std::nullopt;
  }
  Vec3d at{place->first, place->second, 0.0};
  if (place->is_globe) {
    const std::string& crs = session.layers().front()->file().header().crs_text;
    const auto projected = crs.empty()
                               ? std::nullopt
                               : Globe(crs_from_text(crs)).projected(place->first, place->second);
    if (!projected) {
      message = "latitude and longitude need a layer with a reference system";
      return std::nullopt;
    }
    at = *projected;
  }
  const SceneBox box = box_of(session.layers());
  at.z = place->z.value_or(box.highest.z);
  return looking_at(camera, at + Vec3d{0.0, -400.0, 300.0}, at);
}

void draw_place_box(PanelState& state, Session& session, const Camera& camera, int width,
                    PanelResult& result) {
  if (!state.asks_place) return;
  ImGui::SetNextWindowPos({0.5f * float(width), 80.0f}, ImGuiCond_Always, {0.5f, 0.0f});
  ImGui::Begin("Go to", &state.asks_place, ImGuiWindowFlags_AlwaysAutoResize);
  ImGui::TextUnformatted("easting northing [height], or latitude longitude");
  if (ImGui::IsWindowAppearing()) ImGui::SetKeyboardFocusHere();
  if (ImGui::InputText("##place", state.place.data(), state.place.size(),
                       ImGuiInputTextFlags_EnterReturnsTrue)) {
    result.go = camera_at(state.place.data(), session, camera, state.message);
    state.asks_place = !result.go;
  }
  ImGui::End();
}

}  // namespace

PanelResult draw_panels(PanelState& state, Session& session, const Camera& camera, int width,
                        int height, const std::optional<UnderCursor>& under,
                        const FrameCounts& counts) {
  PanelResult result;
  draw_legends(session, session.style(), width);
  const double distance = under ? norm(under->point - camera.eye) : 1000.0;
  draw_scale_and_north(camera, width, height, distance);
  draw_read_out(state, camera, height, under);
  draw_layers(state, session, result);
  draw_frames(state, session, counts);
  draw_help(state);
  draw_place_box(state, session, camera, width, result);
  return result;
}

}  // namespace cornice::viewer
