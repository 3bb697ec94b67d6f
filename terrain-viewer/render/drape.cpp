// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/render/drape.h"

#include <utility>

namespace cornice::viewer {
namespace {

/// Of the room for tiles, what one view may need; the rest is for what comes next.
constexpr double kRoomShare = 0.85;
/// A tile is 0.3 or 0.5 MB.
constexpr std::size_t kTilesPerFrame = 8;
/// As for cells: read for a view so much wider than what is seen, and so far ahead of the motion.
constexpr double kWiderDeg = 20.0;
constexpr double kAheadSeconds = 0.8;

}  // namespace

Drape::Drape(const std::vector<std::filesystem::path>& files, RasterKind kind,
             const std::string& scene_crs, std::uint64_t gpu_bytes)
    : Drape(std::make_unique<RasterPyramid>(files, kind, scene_crs), gpu_bytes,
            files.front().filename().string()) {}

Drape::Drape(std::unique_ptr<RasterPyramid> pyramid, std::uint64_t gpu_bytes, std::string name)
    : name_(std::move(name)),
      grid_(pyramid->grid()),
      kind_(pyramid->kind()),
      advice_(pyramid->advice()),
      texture_(grid_, kind_, gpu_bytes) {
  const RasterTile coarsest = pyramid->read({grid_.levels - 1, 0, 0});
  if (kind_ == RasterKind::kValues) range_ = value_range(coarsest);
  texture_.put(coarsest, 0);
  loader_ = std::make_unique<TileLoader>(std::move(pyramid));
}

std::vector<TileKey> Drape::needed(const TileView& view, std::uint64_t frame) {
  hidden_s_ = 0.0;
  const auto room = static_cast<std::size_t>(kRoomShare * double(texture_.capacity()));
  TileView wider = view;
  wider.wider_deg = kWiderDeg;
  std::vector<TileKey> keys = wanted_tiles(grid_, wider, room);
  // The coarsest last: what is left longest unused goes first.
  for (auto key = keys.rbegin(); key != keys.rend(); ++key) texture_.use(*key, frame);
  texture_.use({grid_.levels - 1, 0, 0}, frame);
  return keys;
}

std::vector<TileKey> Drape::missing_of(const std::vector<TileKey>& keys) const {
  std::vector<TileKey> missing;
  for (const TileKey& key : keys)
    if (!texture_.holds(key) && !loader_->has_failed(key)) missing.push_back(key);
  return missing;
}

bool Drape::upload(std::size_t most, std::uint64_t frame) {
  bool had_room = true;
  for (const RasterTile& tile : loader_->take(most))
    had_room = texture_.put(tile, frame) && had_room;
  return had_room;
}

void Drape::count(std::size_t needed, std::size_t missing) {
  counts_ = {needed, missing, loader_->tiles_read(), texture_.used_bytes(),
             texture_.allocated_bytes()};
}

void Drape::update(const TileView& view, Vec3d velocity, std::uint64_t frame) {
  const auto need = needed(view, frame);
  upload(kTilesPerFrame, frame);
  auto missing = missing_of(need);
  count(need.size(), missing.size());
  if (missing.empty() && norm(velocity) > 0.0) {
    TileView ahead = view;
    ahead.camera.eye += kAheadSeconds * velocity;
    const auto spare = texture_.capacity() - need.size();
    missing = missing_of(wanted_tiles(grid_, ahead, spare));
  }
  loader_->want(missing);
}

void Drape::hide(double seconds) {
  hidden_s_ += seconds;
  if (hidden_s_ < kHiddenSeconds) return;
  loader_->want({});
  texture_.clear();
  count(0, 0);
}

bool Drape::settle(const TileView& view, std::uint64_t frame) {
  const auto need = needed(view, frame);
  while (true) {
    const auto missing = missing_of(need);
    count(need.size(), missing.size());
    if (missing.empty()) break;
    loader_->want(missing);
    loader_->wait();
    // The GPU may turn out to have less than was given.
    if (!upload(TileLoader::kMostReady, frame)) break;
  }
  for (const TileKey& key : need)
    if (!texture_.holds(key)) return false;
  return true;
}

}  // namespace cornice::viewer
