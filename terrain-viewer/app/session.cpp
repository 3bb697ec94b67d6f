// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/session.h"

#include <chrono>

namespace cornice::viewer {
namespace {

constexpr Colour kBlack{0, 0, 0};

}  // namespace

Session::Session(const Options& options)
    : options_(options),
      cells_(static_cast<std::uint64_t>(options.gpu_memory_mib * 1048576.0)),
      layers_(open_layers(options, cells_)),
      looks_(layers_.size()),
      style_(style_for(options, layers_)) {
  if (!options.difference.empty()) add_drape({options.difference}, RasterKind::kValues);
  if (!options.orthophoto.empty()) add_drape(options.orthophoto, RasterKind::kPhoto);
  if (!options.difference.empty()) cover_ = Cover::kDifference;
}

void Session::add_layer(const std::filesystem::path& file) {
  viewer::add_layer(layers_, file, options_, cells_);
  looks_.emplace_back();
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
  renderer_.set_drape(drape != nullptr ? &drape->texture() : nullptr);
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

FrameCounts Session::draw(GLuint framebuffer, int width, int height, const Camera& camera,
                          double seconds, Vec3d velocity, double swipe_column) {
  const auto start = std::chrono::steady_clock::now();
  ++frame_;
  LayerView view;
  view.camera = camera;
  view.width = width;
  view.height = height;
  view.error_pixels = options_.error_pixels;
  view.triangle_budget = static_cast<std::uint64_t>(options_.triangle_budget_m * 1e6);
  view.seconds = seconds;
  view.velocity = velocity;
  FrameCounts counts;
  std::size_t last = layers_.size();
  for (std::size_t i = 0; i < layers_.size(); ++i) {
    if (!looks_[i].is_visible) continue;
    last = i;
    if (seconds > 0.0)
      layers_[i]->update(view, cells_, frame_);
    else
      layers_[i]->settle(view, cells_, frame_);
    counts.missing += layers_[i]->counts().cells_missing;
    counts.uploaded_bytes += layers_[i]->counts().uploaded_bytes;
  }
  counts.is_settled = counts.missing == 0;
  update_drape(view, counts);
  counts.select_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  renderer_.begin(framebuffer, width, height, camera, style_, options_.has_sky ? nullptr : &kBlack);
  for (std::size_t i = 0; i < layers_.size(); ++i) {
    if (!looks_[i].is_visible) continue;
    Style style = style_;
    style.opacity = looks_[i].opacity;
    Swipe swipe;
    if (swipe_column >= 0.0) swipe = {swipe_column, i == last ? 1 : -1};
    const DrawCounts drawn = renderer_.draw(layers_[i]->list(), cells_, style, swipe);
    counts.triangles += drawn.triangles;
    counts.cells += drawn.cells;
    counts.calls += drawn.calls;
  }
  return counts;
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
