// SPDX-License-Identifier: GPL-3.0-or-later
// A page table around the eye after Tanner, Migdal and Jones, "The clipmap: a virtual mipmap",
// SIGGRAPH 1998, which wraps levels around in the same way; here it holds tiles instead of texels,
// so that only what a view needs takes room.
#include "terrain-viewer/render/drape_texture.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/base/error.h"

namespace cornice::viewer {
namespace {

/// With fewer tiles a view from the ground to the horizon is blurred.
constexpr std::size_t kFewestTiles = 64;
/// The array starts with this part of all that it may hold, and doubles.
constexpr std::size_t kFirstPart = 4;

constexpr std::uint64_t bytes_of_tile(RasterKind kind) {
  return std::uint64_t{kTileSide} * kTileSide * texel_bytes(kind);
}

GlTexture make_array(GLenum format, int side, std::size_t layers, GLenum filter) {
  GLuint id = 0;
  glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &id);
  GlTexture texture(id);
  while (glGetError() != GL_NO_ERROR) {
  }
  glTextureStorage3D(id, 1, format, side, side, static_cast<GLsizei>(layers));
  if (glGetError() != GL_NO_ERROR)
    throw RunError("GPU", "has no room for " + std::to_string(layers) +
                              " tiles of a raster; give "
                              "a smaller --drape-memory-mib");
  for (const GLenum which : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTextureParameteri(id, which, static_cast<GLint>(filter));
  for (const GLenum which : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    glTextureParameteri(id, which, GL_CLAMP_TO_EDGE);
  return texture;
}

int wrapped(int tile) { return tile & (DrapeTexture::kPages - 1); }

}  // namespace

DrapeTexture::DrapeTexture(const PyramidGrid& grid, RasterKind kind, std::uint64_t bytes)
    : grid_(grid), kind_(kind), tile_bytes_(bytes_of_tile(kind)) {
  GLint most_layers = 0;
  glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &most_layers);
  // An array of half as many is there while they are copied. Entries of the table are 16 bits, 0
  // being none.
  capacity_ = static_cast<std::size_t>(std::min<std::uint64_t>(
      {2 * bytes / (3 * tile_bytes_), static_cast<std::uint64_t>(most_layers), 65535}));
  capacity_ -= capacity_ % kFirstPart;
  if (capacity_ < kFewestTiles)
    throw RunError("GPU", "--drape-memory-mib has room for " + std::to_string(capacity_) +
                              " tiles of a raster; " + std::to_string(kFewestTiles) +
                              " are needed, " +
                              std::to_string((3 * kFewestTiles * tile_bytes_ >> 21) + 1) + " MiB");
  // No more than there are.
  std::uint64_t all = 0;
  for (int level = 0; level < grid.levels; ++level)
    all += static_cast<std::uint64_t>(grid.columns(level)) *
           static_cast<std::uint64_t>(grid.rows(level));
  capacity_ = static_cast<std::size_t>(std::min<std::uint64_t>(capacity_, all));
  first_places_ = (capacity_ + kFirstPart - 1) / kFirstPart;
  tiles_ = make_tiles(first_places_);
  places_ = first_places_;
  pages_ = make_array(GL_R16UI, kPages, static_cast<std::size_t>(grid.levels), GL_NEAREST);
  table_.resize(static_cast<std::size_t>(kPages) * kPages * static_cast<std::size_t>(grid.levels));
}

GlTexture DrapeTexture::make_tiles(std::size_t places) const {
  return make_array(kind_ == RasterKind::kPhoto ? GL_SRGB8_ALPHA8 : GL_RG32F, kTileSide, places,
                    GL_LINEAR);
}

/// What the GPU has no room for is not tried again.
void DrapeTexture::grow() {
  const std::size_t wanted = std::min(2 * places_, capacity_);
  try {
    GlTexture larger = make_tiles(wanted);
    glCopyImageSubData(tiles_.id(), GL_TEXTURE_2D_ARRAY, 0, 0, 0, 0, larger.id(),
                       GL_TEXTURE_2D_ARRAY, 0, 0, 0, 0, kTileSide, kTileSide,
                       static_cast<GLsizei>(places_));
    tiles_ = std::move(larger);
    places_ = wanted;
  } catch (const RunError&) {
    capacity_ = places_;
  }
}

void DrapeTexture::clear() {
  held_.clear();
  used_.clear();
  has_changed_ = true;
  if (places_ == first_places_) return;
  tiles_ = make_tiles(first_places_);
  places_ = first_places_;
}

void DrapeTexture::use(TileKey key, std::uint64_t frame) {
  const auto found = held_.find(key);
  if (found == held_.end()) return;
  found->second.frame = frame;
  used_.splice(used_.begin(), used_, found->second.use);
}

bool DrapeTexture::put(const RasterTile& tile, std::uint64_t frame) {
  if (held_.contains(tile.key)) return true;
  if (held_.size() == places_ && places_ < capacity_) grow();
  int place = static_cast<int>(held_.size());
  if (held_.size() == capacity_) {
    const auto oldest = held_.find(used_.back());
    if (oldest->second.frame >= frame) return false;
    place = oldest->second.place;
    held_.erase(oldest);
    used_.pop_back();
  }
  const bool is_photo = kind_ == RasterKind::kPhoto;
  glTextureSubImage3D(tiles_.id(), 0, 0, 0, place, kTileSide, kTileSide, 1,
                      is_photo ? GL_RGBA : GL_RG, is_photo ? GL_UNSIGNED_BYTE : GL_FLOAT,
                      tile.bytes.data());
  used_.push_front(tile.key);
  held_[tile.key] = {place, frame, used_.begin()};
  has_changed_ = true;
  return true;
}

DrapeBlock DrapeTexture::bind(Vec3d eye) {
  DrapeBlock block;
  block.what = {kind_ == RasterKind::kPhoto ? 1 : 2, grid_.levels, 0, 0};
  block.texel = {static_cast<float>(grid_.texel_x), static_cast<float>(grid_.texel_y), 1.0f, 0.0f};
  block.bounds = {static_cast<float>(grid_.west - eye.x), static_cast<float>(grid_.south() - eye.y),
                  static_cast<float>(grid_.east() - eye.x),
                  static_cast<float>(grid_.north - eye.y)};
  // Eyes far away from the raster: their tiles must fit 32 bits, and nothing of it is near.
  constexpr double kFarTiles = 1e6;
  for (int level = 0; level < grid_.levels; ++level) {
    const auto i = static_cast<std::size_t>(level);
    const double x = (eye.x - grid_.west) / (std::ldexp(grid_.texel_x, level) * kTileTexels);
    const double y = (grid_.north - eye.y) / (std::ldexp(grid_.texel_y, level) * kTileTexels);
    const double column = std::clamp(std::floor(x), -kFarTiles, kFarTiles);
    const double row = std::clamp(std::floor(y), -kFarTiles, kFarTiles);
    block.tile[i] = {static_cast<std::int32_t>(column), static_cast<std::int32_t>(row), 0, 0};
    block.within[i] = {static_cast<float>(x - column), static_cast<float>(y - row), 0.0f, 0.0f};
  }
  if (has_changed_ || written_around_ != block.tile) write_pages(block);
  glBindTextureUnit(1, tiles_.id());
  glBindTextureUnit(2, pages_.id());
  return block;
}

void DrapeTexture::write_pages(const DrapeBlock& block) {
  std::fill(table_.begin(), table_.end(), std::uint16_t{0});
  for (const auto& [key, held] : held_) {
    const auto& eye = block.tile[static_cast<std::size_t>(key.level)];
    // The same window as in the shader, or two tiles could share an entry.
    const int dx = key.column - eye[0], dy = key.row - eye[1];
    if (dx < -kPages / 2 || dx >= kPages / 2 || dy < -kPages / 2 || dy >= kPages / 2) continue;
    const auto at = static_cast<std::size_t>((key.level * kPages + wrapped(key.row)) * kPages +
                                             wrapped(key.column));
    table_[at] = static_cast<std::uint16_t>(held.place + 1);
  }
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureSubImage3D(pages_.id(), 0, 0, 0, 0, kPages, kPages, grid_.levels, GL_RED_INTEGER,
                      GL_UNSIGNED_SHORT, table_.data());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  written_around_ = block.tile;
  has_changed_ = false;
}

}  // namespace cornice::viewer
