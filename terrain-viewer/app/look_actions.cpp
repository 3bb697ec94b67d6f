// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/look_actions.h"

#include <cstddef>

namespace cornice::viewer {
namespace {

constexpr double kContoursM = 20.0;

std::string next_shading(Style& style) {
  const std::size_t next = (static_cast<std::size_t>(style.shading) + 1) % kShadingNames.size();
  style.shading = static_cast<Shading>(next);
  return std::string("shading: ") + kShadingNames[next];
}

std::string next_cover(Session& session) {
  const bool has_photo = session.photo() != nullptr;
  const bool has_difference = session.difference() != nullptr;
  if (!has_photo && !has_difference)
    return "nothing lies over the ground; drop a photograph or a raster of differences";
  switch (session.cover()) {
    case Cover::kNone:
      session.set_cover(has_photo ? Cover::kPhoto : Cover::kDifference);
      break;
    case Cover::kPhoto:
      session.set_cover(has_difference ? Cover::kDifference : Cover::kNone);
      break;
    case Cover::kDifference:
      session.set_cover(Cover::kNone);
  }
  return "";
}

std::string next_split(const Session& session, Split::Kind& split) {
  if (!session.can_split()) return "two pictures need two visible layers, or a raster over one";
  split = static_cast<Split::Kind>((static_cast<int>(split) + 1) % 3);
  return "";
}

std::string toggle_layer(Session& session, int nth) {
  auto& looks = session.looks();
  const auto i = static_cast<std::size_t>(nth);
  if (i >= looks.size()) return "there is no layer " + std::to_string(nth + 1);
  looks[i].is_visible = !looks[i].is_visible;
  return "";
}

std::string blink(Session& session) {
  if (session.looks().size() < 2) return "to blink needs two layers";
  session.blink();
  return "";
}

}  // namespace

std::optional<std::string> heed_look(Asked asked, Session& session, Split::Kind& split) {
  Style& style = session.style();
  switch (asked.action) {
    case Action::kNextShading:
      return next_shading(style);
    case Action::kContours:
      style.contour_interval_m = style.contour_interval_m > 0.0 ? 0.0 : kContoursM;
      return "";
    case Action::kEdges:
      style.has_edges = !style.has_edges;
      return "";
    case Action::kNextCover:
      return next_cover(session);
    case Action::kNextSplit:
      return next_split(session, split);
    case Action::kFreeze:
      session.is_frozen() = !session.is_frozen();
      return session.is_frozen() ? "frozen: what is drawn stays chosen; K goes on" : "";
    case Action::kToggleLayer:
      return toggle_layer(session, asked.nth);
    case Action::kBlink:
      return blink(session);
    default:
      return std::nullopt;
  }
}

}  // namespace cornice::viewer
