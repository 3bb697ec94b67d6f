// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/panels.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "terrain-viewer/app/go_to.h"
#include "terrain-viewer/app/key_actions.h"
#include "terrain-viewer/app/legend.h"

namespace cornice::viewer {
namespace {

constexpr ImGuiWindowFlags kPlain = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs |
                                    ImGuiWindowFlags_AlwaysAutoResize |
                                    ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoNav;
constexpr float kLayersWidth = 300.0f;
constexpr double kDegrees = 180.0 / std::numbers::pi;

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

/// Returns its edges.
Taken draw_read_out(const PanelState& state, const Camera& camera, int width, int height) {
  ImGui::SetNextWindowPos({12.0f, float(height) - 12.0f}, ImGuiCond_Always, {0.0f, 1.0f});
  ImGui::SetNextWindowBgAlpha(0.6f);
  ImGui::SetNextWindowSizeConstraints(
      {0.0f, 0.0f}, {std::max(1.0f, float(width) - 24.0f), std::max(1.0f, float(height))});
  ImGui::Begin("read-out", nullptr, kPlain);
  ImGui::TextUnformatted(state.read_out.c_str());
  ImGui::Text("eye E %.1f  N %.1f  H %.1f m", camera.eye.x, camera.eye.y, camera.eye.z);
  ImGui::Text("heading %.0f, pitch %.0f, %s %.3g m/s", camera.heading_deg, camera.pitch_deg,
              state.walks ? "walking" : "flying", state.speed_ms);
  if (!state.message.empty()) {
    ImGui::PushStyleColor(ImGuiCol_Text, {1.0f, 0.75f, 0.4f, 1.0f});
    ImGui::PushTextWrapPos(std::max(60.0f, float(width) - 40.0f));
    ImGui::TextUnformatted(state.message.c_str());
    ImGui::PopTextWrapPos();
    ImGui::PopStyleColor();
  }
  const ImVec2 corner = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
  ImGui::End();
  return {corner.x + size.x, corner.y};
}

void draw_light(Session& session) {
  if (!ImGui::TreeNode("Light")) return;
  Light light = session.light();
  const auto slider = [](const char* name, double& value, float low, float high, const char* text) {
    auto number = static_cast<float>(value);
    if (!ImGui::SliderFloat(name, &number, low, high, text)) return false;
    value = number;
    return true;
  };
  bool changes = false;
  if (session.place()) changes |= ImGui::Checkbox("of a time, UTC", &light.is_of_time);
  if (light.is_of_time && session.place()) {
    changes |= ImGui::SliderInt("month", &light.month, 1, 12);
    changes |= ImGui::SliderInt("day", &light.day, 1, 31);
    changes |= slider("hour", light.hour, 0.0f, 23.98f, "%.2f");
  } else {
    changes |= slider("azimuth", light.azimuth_deg, 0.0f, 360.0f, "%.0f deg");
    changes |= slider("elevation", light.elevation_deg, 0.0f, 90.0f, "%.0f deg");
  }
  if (changes) session.set_light(light);
  const Vec3d sun = normalized(session.style().sun);
  ImGui::TextDisabled("sun at %.0f deg, %.0f deg high",
                      std::fmod(std::atan2(sun.x, sun.y) * kDegrees + 360.0, 360.0),
                      std::asin(sun.z) * kDegrees);
  ImGui::TreePop();
}

void draw_bookmarks(PanelState& state, PanelResult& result) {
  if (state.bookmarks.empty() || !ImGui::TreeNode("Bookmarks")) return;
  for (std::size_t i = 0; i < state.bookmarks.size(); ++i) {
    ImGui::PushID(static_cast<int>(i));
    const bool drops = ImGui::SmallButton("x");
    ImGui::SameLine();
    if (ImGui::Selectable(state.bookmarks[i].name.c_str())) result.go = state.bookmarks[i].camera;
    ImGui::PopID();
    if (!drops) continue;
    state.bookmarks.erase(state.bookmarks.begin() + static_cast<std::ptrdiff_t>(i));
    break;
  }
  ImGui::TreePop();
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
  auto share = static_cast<float>(state.line.share);
  if (ImGui::SliderFloat("line", &share, 0.0f, 1.0f, "")) state.line.share = share;
}

/// What is seen on both sides, by names.
SideNames sides_of(Session& session) {
  std::vector<std::string> visible;
  for (std::size_t i = 0; i < session.layers().size(); ++i)
    if (session.looks()[i].is_visible) visible.push_back(session.layers()[i]->name());
  std::string cover;
  if (session.cover() == Cover::kPhoto) cover = "photograph " + session.photo()->name();
  if (session.cover() == Cover::kDifference) cover = "differences " + session.difference()->name();
  return side_names(visible, cover);
}

/// A name at the top beside the line, cut where its side ends: `left` and `right` are the side's.
void draw_side_name(const std::string& name, float left, float right, bool is_at_right) {
  constexpr float kTop = 12.0f, kGap = 10.0f, kPad = 4.0f;
  const ImVec2 size = ImGui::CalcTextSize(name.c_str());
  const float x = is_at_right ? right - kGap - size.x : left + kGap;
  ImDrawList* draw = ImGui::GetForegroundDrawList();
  draw->PushClipRect({left, 0.0f}, {right, kTop + size.y + 2.0f * kPad}, true);
  draw->AddRectFilled({x - kPad, kTop - kPad}, {x + size.x + kPad, kTop + size.y + kPad},
                      IM_COL32(0, 0, 0, 170), 3.0f);
  draw->AddText({x, kTop}, IM_COL32_WHITE, name.c_str());
  draw->PopClipRect();
}

/// Between the two pictures, with a handle where it can be dragged.
void draw_split_line(const PanelState& state, Session& session, int width, int height) {
  if (!session.can_split() || state.split == Split::Kind::kNone) return;
  const bool is_swipe = state.split == Split::Kind::kSwipe;
  const float x = is_swipe ? float(state.line.share) * float(width) : float(width / 2);
  const float middle = 0.5f * float(height);
  ImDrawList* draw = ImGui::GetBackgroundDrawList();
  draw->AddLine({x, 0.0f}, {x, float(height)}, IM_COL32_WHITE, 2.0f);
  if (is_swipe) {
    draw->AddCircleFilled({x, middle}, 9.0f, IM_COL32(255, 255, 255, 230));
    draw->AddTriangleFilled({x - 6.0f, middle}, {x - 2.0f, middle - 4.0f},
                            {x - 2.0f, middle + 4.0f}, IM_COL32(60, 60, 60, 255));
    draw->AddTriangleFilled({x + 6.0f, middle}, {x + 2.0f, middle + 4.0f},
                            {x + 2.0f, middle - 4.0f}, IM_COL32(60, 60, 60, 255));
  }
  const SideNames names = sides_of(session);
  draw_side_name(names.left, 0.0f, x, true);
  draw_side_name(names.right, x, float(width), false);
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

void draw_layers(PanelState& state, Session& session, int height, PanelResult& result) {
  if (!state.shows_layers) return;
  ImGui::SetNextWindowPos({12.0f, 12.0f}, ImGuiCond_FirstUseEver);
  ImGui::SetNextWindowSizeConstraints({kLayersWidth, 0.0f},
                                      {kLayersWidth, std::max(100.0f, float(height) - 130.0f)});
  ImGui::Begin("Layers", &state.shows_layers, ImGuiWindowFlags_AlwaysAutoResize);
  ImGui::PushItemWidth(0.65f * kLayersWidth);
  draw_layer_rows(session);
  draw_split(state, session);
  draw_cover(session);
  ImGui::Separator();
  Style& style = session.style();
  int shading = static_cast<int>(style.shading);
  if (ImGui::Combo("shading", &shading, kShadingNames.data(),
                   static_cast<int>(kShadingNames.size())))
    style.shading = static_cast<Shading>(shading);
  if (const std::string missing = session.missing_values(); !missing.empty())
    ImGui::TextWrapped("%s", missing.c_str());
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
  ImGui::SliderInt("picture", &state.picture_scale, 1, 4, "F12: window x %d");
  draw_light(session);
  draw_bookmarks(state, result);
  if (!state.recent.empty() && ImGui::TreeNode("Recent files")) {
    for (const std::filesystem::path& file : state.recent)
      if (ImGui::Selectable(file.c_str())) result.open = file;
    ImGui::TreePop();
  }
  ImGui::PopItemWidth();
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
  ImGui::Text("GPU %.0f of %.0f MiB, %.1f MB/s uploaded",
              double(session.cells().used_bytes()) / 1048576.0,
              double(session.cells().capacity_bytes()) / 1048576.0, state.uploads.mb_per_s());
  ImGui::Text("disk %.1f MB/s", state.reads.mb_per_s());
  for (const auto& layer : session.layers()) {
    const LayerCounts& c = layer->counts();
    ImGui::Text("%s: %u drawn, %u loaded, %u missing, %u waiting, %.1f MiB read",
                layer->name().c_str(), c.cells, c.cells_loaded, c.cells_missing,
                static_cast<unsigned>(c.store.cells_waiting),
                double(c.store.bytes_read) / 1048576.0);
  }
  if (session.cover() != Cover::kNone)
    ImGui::Text("raster: %zu tiles needed, %zu missing, %.0f MiB", counts.drape.tiles_needed,
                counts.drape.tiles_missing, double(counts.drape.used_bytes) / 1048576.0);
  ImGui::End();
}

void draw_help(PanelState& state) {
  if (!state.shows_help) return;
  ImGui::Begin("Help", &state.shows_help, ImGuiWindowFlags_AlwaysAutoResize);
  // The font's letters are all equally wide.
  for (const HelpRow& row : help_rows()) ImGui::Text("%-18s%s", row.keys, row.does);
  ImGui::End();
}

void draw_place_box(PanelState& state, Session& session, const Camera& camera, int width,
                    const Ground& ground, PanelResult& result) {
  if (!state.asks_place) return;
  ImGui::SetNextWindowPos({0.5f * float(width), 80.0f}, ImGuiCond_Always, {0.5f, 0.0f});
  ImGui::Begin("Go to", &state.asks_place, ImGuiWindowFlags_AlwaysAutoResize);
  ImGui::TextUnformatted("easting northing [height], or latitude longitude");
  if (ImGui::IsWindowAppearing() || !state.message_of_place.empty()) ImGui::SetKeyboardFocusHere();
  state.message_of_place.clear();
  if (ImGui::InputText("##place", state.place.data(), state.place.size(),
                       ImGuiInputTextFlags_EnterReturnsTrue)) {
    const PlaceFound found =
        find_place(state.place.data(), session.layers().front()->file().header().crs_text);
    state.message = state.message_of_place = found.problem;
    state.asks_place = !found.place;
    if (found.place)
      result.go = camera_over(found, camera, ground, box_of(session.layers()).highest.z);
  }
  ImGui::End();
}

}  // namespace

PanelResult draw_panels(PanelState& state, Session& session, const Camera& camera, int width,
                        int height, const FrameCounts& counts, const Ground& ground) {
  PanelResult result;
  draw_legends(session.style(), session.cover() == Cover::kDifference, session.level_count(),
               width);
  const Taken taken = draw_read_out(state, camera, width, height);
  draw_scale_and_north(camera, width, height, state.depth_m, taken);
  draw_layers(state, session, height, result);
  draw_split_line(state, session, width, height);
  draw_frames(state, session, counts);
  draw_help(state);
  draw_place_box(state, session, camera, width, ground, result);
  return result;
}

}  // namespace cornice::viewer
