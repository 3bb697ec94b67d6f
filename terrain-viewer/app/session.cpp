// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/session.h"

#include <algorithm>
#include <array>
#include <chrono>

namespace cornice::viewer {
namespace {

constexpr Colour kBlack{0, 0, 0};

/// Layers go to their levels by a share of the way that grows with the time of a frame, in whole
/// numbers: short frames end before they are there. A frame of so long goes more than half of the
/// way, and so arrives.
constexpr double kArrivingS = 0.25;

bool is_same_view(const LayerView& a, const LayerView& b) {
  return a.camera == b.camera && a.width == b.width && a.height == b.height &&
         a.error_pixels == b.error_pixels && a.triangle_budget == b.triangle_budget;
}

/// What a hierarchy must hold for a shading, and its name.
struct Needed {
  std::uint32_t bits = 0;
  const char* name = "";
};

Needed needed_by(Shading shading) {
  switch (shading) {
    case Shading::kSupport:
      return {hlod::kHasSupport, "distances to measured points"};
    case Shading::kSource:
      return {hlod::kHasSource, "sources"};
    case Shading::kColour:
      return {hlod::kHasColour, "colours"};
    default:
      return {};
  }
}

bool has(const Layer& layer, Needed needed) {
  return (layer.file().header().attributes & needed.bits) == needed.bits;
}

}  // namespace

Session::Session(const Options& options)
    : options_(options),
      cells_(static_cast<std::uint64_t>(options.gpu_memory_mib * 1048576.0)),
      layers_(open_layers(options, cells_)),
      looks_(layers_.size()),
      style_(style_for(options, layers_)),
      place_(place_of(layers_)),
      light_(light_of(options)) {
  if (!options.difference.empty()) add_drape({options.difference}, RasterKind::kValues);
  if (!options.orthophoto.empty()) add_drape(options.orthophoto, RasterKind::kPhoto);
  if (!options.difference.empty()) cover_ = Cover::kDifference;
}

void Session::set_light(const Light& light) {
  light_ = light;
  style_.sun = towards_sun(light_, place_);
}

void Session::add_layer(const std::filesystem::path& file) {
  viewer::add_layer(layers_, file, options_, cells_);
  looks_.emplace_back();
  is_frozen_ = false;
}

void Session::swap_layers(std::size_t i, std::size_t j) {
  std::swap(layers_[i], layers_[j]);
  std::swap(looks_[i], looks_[j]);
}

void Session::blink() {
  if (looks_.size() < 2) return;
  LayerLook &last = looks_.back(), &other = looks_[looks_.size() - 2];
  other.is_visible = last.is_visible;
  last.is_visible = !last.is_visible;
}

void Session::add_drape(const std::vector<std::filesystem::path>& files, RasterKind kind) {
  const bool is_photo = kind == RasterKind::kPhoto;
  auto drape =
      std::make_unique<Drape>(files, kind, layers_.front()->file().header().crs_text,
                              static_cast<std::uint64_t>(options_.drape_memory_mib * 1048576.0));
  if (!is_photo) style_.difference_high_m = options_.difference_range_m.value_or(drape->range());
  (is_photo ? photo_ : difference_) = std::move(drape);
  cover_ = is_photo ? Cover::kPhoto : Cover::kDifference;
}

Drape* Session::shown_drape() const {
  if (cover_ == Cover::kPhoto) return photo_.get();
  if (cover_ == Cover::kDifference) return difference_.get();
  return nullptr;
}

Cover Session::cover() const { return shown_drape() != nullptr ? cover_ : Cover::kNone; }

void Session::update_drape(const LayerView& view, FrameCounts& counts) {
  Drape* drape = shown_drape();
  for (Drape* other : {photo_.get(), difference_.get()})
    if (other != nullptr && other != drape) other->hide(view.seconds);
  if (drape == nullptr) return;
  const SceneBox box = box_of(layers_);
  const TileView tiles{view.camera,         double(view.width) / view.height,
                       double(view.height), box.lowest.z,
                       box.highest.z,       0.0};
  if (view.seconds > 0.0)
    drape->update(tiles, view.velocity, frame_);
  else
    drape->settle(tiles, frame_);
  counts.drape = drape->counts();
}

std::size_t Session::last_visible() const {
  std::size_t last = layers_.size();
  for (std::size_t i = 0; i < layers_.size(); ++i)
    if (looks_[i].is_visible) last = i;
  return last;
}

std::size_t Session::visible_count() const {
  return static_cast<std::size_t>(std::count_if(
      looks_.begin(), looks_.end(), [](const LayerLook& look) { return look.is_visible; }));
}

void Session::choose(const LayerView& view, FrameCounts& counts) {
  for (std::size_t i = 0; i < layers_.size(); ++i) {
    if (!looks_[i].is_visible) continue;
    if (!is_frozen_) {
      if (view.seconds > 0.0)
        layers_[i]->update(view, cells_, frame_);
      else
        layers_[i]->settle(view, cells_, frame_);
    }
    counts.missing += layers_[i]->counts().cells_missing;
    if (!is_frozen_) counts.uploaded_bytes += layers_[i]->counts().uploaded_bytes;
  }
  counts.is_settled = counts.missing == 0;
  update_drape(view, counts);
}

void Session::draw_part(Part part, const Split& split, FrameCounts& counts) {
  const bool has_two = visible_count() > 1;
  const std::size_t last = last_visible();
  Drape* drape = part == Part::kFirst && !has_two ? nullptr : shown_drape();
  renderer_.set_drape(drape != nullptr ? &drape->texture() : nullptr);
  Swipe swipe;
  if (split.kind == Split::Kind::kSwipe) swipe = {split.column, part == Part::kFirst ? -1 : 1};
  for (std::size_t i = 0; i < layers_.size(); ++i) {
    if (!looks_[i].is_visible) continue;
    if (part != Part::kWhole && has_two && (i == last) != (part == Part::kSecond)) continue;
    Style style = style_;
    style.opacity = looks_[i].opacity;
    // Values that are not there would all be drawn as 0, black colours for instance.
    if (!has(*layers_[i], needed_by(style.shading))) style.shading = Shading::kPlain;
    const DrawCounts drawn = renderer_.draw(layers_[i]->list(), cells_, style, swipe);
    counts.triangles += drawn.triangles;
    counts.cells += drawn.cells;
    counts.calls += drawn.calls;
  }
}

void Session::draw_panes(GLuint framebuffer, const LayerView& view, const Split& split,
                         FrameCounts& counts) {
  const Colour* clear = options_.has_sky ? nullptr : &kBlack;
  const auto begin = [&](int left) {
    renderer_.begin(framebuffer, view.width, view.height, view.camera, style_, clear, left);
  };
  const auto end = [&] {
    if (style_.shading == Shading::kOverdraw) counts.overdraw = renderer_.show_overdraw();
  };
  if (split.kind == Split::Kind::kSideBySide) {
    // Of an odd width a column is left over.
    const std::array<float, 4> black{0.0f, 0.0f, 0.0f, 1.0f};
    glClearNamedFramebufferfv(framebuffer, GL_COLOR, 0, black.data());
  }
  begin(0);
  const bool is_split = split.kind != Split::Kind::kNone;
  draw_part(is_split ? Part::kFirst : Part::kWhole, split, counts);
  if (split.kind == Split::Kind::kSideBySide) {
    end();
    begin(view.width);
  }
  if (is_split) draw_part(Part::kSecond, split, counts);
  end();
}

void Session::heed_budget(double choose_ms, double seconds, FrameCounts& counts) {
  while (const auto ms = timer_.take()) gpu_ms_ = *ms;
  counts.draw_ms = std::max(choose_ms, gpu_ms_);
  budget_.set_target_ms(options_.frame_ms);
  const bool is_after_pause = std::exchange(is_after_pause_, false);
  if (seconds > 0.0 && !is_frozen_ && !is_after_pause) budget_.add(counts.draw_ms, seconds);
}

/// Whether this frame differs from the one before, or the next may from this one.
bool Session::changes(const LayerView& view, const Split& split, const FrameCounts& counts) {
  std::vector<double> look{double(style_.shading), style_.has_edges ? 1.0 : 0.0, double(cover()),
                           double(split.kind), is_frozen_ ? 1.0 : 0.0};
  bool waits = counts.uploaded_bytes > 0 || counts.drape.tiles_missing > 0;
  for (std::size_t i = 0; i < layers_.size(); ++i) {
    if (!looks_[i].is_visible) continue;
    const Layer& layer = *layers_[i];
    waits |=
        !is_frozen_ && layer.counts().cells_missing > 0 && layer.counts().store.cells_waiting > 0;
    look.insert(look.end(), {double(i), layer.counts().share});
    for (const hlod::MorphBand& band : layer.list().bands) look.push_back(band.end);
  }
  const bool is_same = is_same_view(view, drawn_view_) && look == drawn_look_;
  drawn_view_ = view;
  drawn_look_ = std::move(look);
  return waits || !is_same;
}

FrameCounts Session::draw(GLuint framebuffer, int width, int height, const Camera& camera,
                          double seconds, Vec3d velocity, const Split& split) {
  const auto start = std::chrono::steady_clock::now();
  const auto milliseconds = [&] {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
        .count();
  };
  ++frame_;
  FrameCounts counts;
  LayerView view;
  view.camera = camera;
  view.width = pane_width(width, split);
  view.height = height;
  // Pictures that wait for all they need have no need to be quick.
  view.error_pixels = options_.error_pixels / (seconds > 0.0 ? budget_.share() : 1.0);
  view.triangle_budget = static_cast<std::uint64_t>(options_.triangle_budget_m * 1e6);
  view.seconds = seconds;
  view.velocity = velocity;
  const bool arrives = came_to_rest_ && is_same_view(view, drawn_view_);
  if (arrives && seconds > 0.0) view.seconds = std::max(seconds, kArrivingS);
  counts.error_pixels = view.error_pixels;
  choose(view, counts);
  counts.select_ms = milliseconds();
  timer_.begin();
  draw_panes(framebuffer, view, split, counts);
  timer_.end();
  came_to_rest_ = !changes(view, split, counts);
  if (!came_to_rest_) budget_.look_anew();
  heed_budget(milliseconds(), seconds, counts);
  counts.is_still = came_to_rest_ && arrives && (is_frozen_ || budget_.is_settled());
  return counts;
}

int Session::level_count() const {
  std::size_t most = 0;
  for (const auto& layer : layers_) most = std::max(most, layer->file().levels().size());
  return static_cast<int>(most);
}

std::string Session::missing_values() const {
  const Needed needed = needed_by(style_.shading);
  std::string names;
  for (std::size_t i = 0; i < layers_.size(); ++i)
    if (looks_[i].is_visible && !has(*layers_[i], needed))
      names += (names.empty() ? "" : ", ") + layers_[i]->name();
  return names.empty() ? "" : names + " without " + needed.name + ": drawn plain";
}

std::vector<std::string> Session::take_failures() {
  std::vector<std::string> all;
  for (const auto& layer : layers_)
    for (std::string& failure : layer->take_failures()) all.push_back(std::move(failure));
  for (Drape* drape : {photo_.get(), difference_.get()}) {
    if (drape == nullptr) continue;
    for (std::string& failure : drape->take_failures()) all.push_back(std::move(failure));
  }
  return all;
}

}  // namespace cornice::viewer
