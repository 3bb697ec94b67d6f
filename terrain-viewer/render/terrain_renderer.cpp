// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/render/terrain_renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "hlod/octahedral.h"
#include "terrain-viewer/render/overdraw.h"
#include "terrain-viewer/render/shaders.h"
#include "terrain-viewer/scene/sun.h"

namespace cornice::viewer {
namespace {

/// As in shaders/frame.glsl.
struct FrameBlock {
  Matrix4 view_projection{};
  std::array<float, 4> sun{}, sun_colour{}, sky{}, ground{}, haze{}, eye_height{}, contours{};
  std::array<std::int32_t, 4> shading{};
  std::array<float, 4> place{};
};

/// As Draw in shaders/surface.vert.
struct DrawRecord {
  std::array<std::int32_t, 4> origin{}, parent_origin{}, band{}, eye{};
  std::array<float, 4> offset{}, colour{}, parent_colour{}, scales{};
};

/// As glMultiDrawElementsIndirect reads it.
struct DrawCommand {
  std::uint32_t count = 0, instances = 1, first_index = 0;
  std::int32_t base_vertex = 0;
  std::uint32_t base_instance = 0;
};

constexpr std::size_t kRampTexels = 256;
/// A page of cells is a call, and calls draw one after the other. The cells are drawn in so many
/// parts, the nearest first, so that far ones of one page do not come before near ones of another.
constexpr std::size_t kParts = 4;
/// Floats hold places within so many metres to some millimetres.
constexpr double kNoisePeriodM = 65536.0;

std::array<float, 4> floats(Vec3d v, double w) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z),
          static_cast<float>(w)};
}

std::array<float, 4> floats(const Colour& c, double w) {
  return floats(Vec3d{c[0] / 255.0, c[1] / 255.0, c[2] / 255.0}, w);
}

std::array<std::int32_t, 4> whole(hlod::LatticePoint p, std::int64_t fourth) {
  return {p.x, p.y, p.z, static_cast<std::int32_t>(fourth)};
}

/// What all cells of a list have alike.
DrawRecord shared_record(const DrawList& list, Vec3d eye) {
  const hlod::Lattice& lattice = list.header->lattice;
  const bool is_octree = list.header->partition == hlod::Partition::kOctree;
  DrawRecord record;
  record.eye = whole(list.eye, is_octree ? -1 : list.slab_distance);
  const double step = lattice.step(lattice.finest_level);
  const Vec3d rest = eye - lattice.position(list.eye, lattice.finest_level);
  record.offset = floats(-rest, step);
  record.scales[0] = 1.0f / static_cast<float>(hlod::octahedral_limit(list.header->normal_bits));
  return record;
}

DrawRecord record_of(const DrawList& list, const DrawList::Item& item, DrawRecord record,
                     double eye_height, bool has_cell_colours) {
  const hlod::Node& node = (*list.nodes)[item.row];
  const int level = node.key.level;
  record.origin = whole(node.lowest, item.cell.first_vertex);
  record.parent_origin = whole(level > 0 ? parent_origin(node.lowest) : node.lowest,
                               item.cell.first_vertex + item.cell.vertex_count);
  if (level > 0) {
    const hlod::MorphBand band = list.bands[static_cast<std::size_t>(level)];
    record.band = {band.end, band.shift, band.band, band.finer};
  } else {
    record.band = {0, 0, 0, list.header->lattice.finest_level};
  }
  const Colour colour = has_cell_colours ? cell_colour(level, item.row) : level_colour(level);
  record.colour = floats(colour, eye_height);
  // What is drawn of a vertex that has morphed is the level above.
  record.parent_colour =
      floats(has_cell_colours || level == 0 ? colour : level_colour(level - 1), 0.0);
  return record;
}

/// Cells of one page that one call draws.
struct Run {
  std::uint32_t page = 0;
  std::size_t first = 0, count = 0;  ///< among the commands
};

/// A buffer that grows to what is written into it.
class GrowingBuffer {
 public:
  void write(const void* data, std::size_t bytes) {
    if (bytes > capacity_) {
      capacity_ = std::max(bytes, 2 * capacity_);
      buffer_ = make_buffer(capacity_);
    }
    if (bytes > 0) glNamedBufferSubData(buffer_.id(), 0, static_cast<GLsizeiptr>(bytes), data);
  }
  GLuint id() const { return buffer_.id(); }

 private:
  GlBuffer buffer_;
  std::size_t capacity_ = 0;
};

GlTexture make_ramp_texture() {
  GLuint id = 0;
  glCreateTextures(GL_TEXTURE_1D, 1, &id);
  glTextureStorage1D(id, 1, GL_SRGB8, kRampTexels);
  glTextureParameteri(id, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTextureParameteri(id, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glTextureParameteri(id, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  return GlTexture(id);
}

void write_ramp(const GlTexture& texture, const Ramp& ramp) {
  const auto table = ramp.table(kRampTexels);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureSubImage1D(texture.id(), 0, 0, kRampTexels, GL_RGB, GL_UNSIGNED_BYTE, table.data());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
}

FrameBlock frame_block(const Camera& camera, int width, int height, const Style& style) {
  FrameBlock block;
  block.view_projection = view_projection(camera, double(width) / height, kNearM);
  const Vec3d sun = normalized(style.sun);
  const Daylight day = daylight(sun.z);
  block.sun = floats(sun, style.sun_strength * day.sun);
  block.sun_colour = floats(day.sun_colour, day.warmth);
  block.sky = floats(day.sky, style.ambient);
  const double thinning = style.haze_height_m > 0.0
                              ? std::exp(-std::max(0.0, camera.eye.z) / style.haze_height_m)
                              : 1.0;
  block.ground = floats(day.ground, style.haze_range_m > 0.0 ? thinning / style.haze_range_m : 0.0);
  block.haze = floats(day.haze, style.haze_height_m);
  const auto ramp = ramp_of(style);
  block.eye_height = {static_cast<float>(camera.eye.z), ramp ? static_cast<float>(ramp->low()) : 0,
                      ramp ? static_cast<float>(ramp->high()) : 1,
                      static_cast<float>(style.opacity)};
  block.contours = {static_cast<float>(style.contour_interval_m),
                    static_cast<float>(style.snow_line_m), static_cast<float>(style.tree_line_m),
                    0};
  const bool is_numbered = style.shading == Shading::kLevel || style.shading == Shading::kCell;
  block.shading = {static_cast<int>(style.shading), ramp || is_numbered ? 1 : 0, 0, 0};
  block.place = {static_cast<float>(std::fmod(camera.eye.x, kNoisePeriodM)),
                 static_cast<float>(std::fmod(camera.eye.y, kNoisePeriodM)), 0, 0};
  return block;
}

/// Keeps what is drawn to one side of a swipe line while it lives: a pixel whose middle is left of
/// the line to the left side, any other to the right one.
class SwipeScissor {
 public:
  SwipeScissor(const Swipe& swipe, int left, int width, int height) : is_used_(swipe.side != 0) {
    if (!is_used_) return;
    const int first = static_cast<int>(
        std::clamp(std::ceil(swipe.column - 0.5), double(left), double(left) + width));
    const bool is_left = swipe.side < 0;
    glScissor(is_left ? left : first, 0, is_left ? first - left : left + width - first, height);
    glEnable(GL_SCISSOR_TEST);
  }
  ~SwipeScissor() {
    if (is_used_) glDisable(GL_SCISSOR_TEST);
  }
  SwipeScissor(const SwipeScissor&) = delete;
  SwipeScissor& operator=(const SwipeScissor&) = delete;

 private:
  bool is_used_;
};

}  // namespace

struct TerrainRenderer::State {
  GlProgram surface = make_program("surface", shaders::kSurfaceVertex, shaders::kSurfaceFragment);
  GlProgram sky = make_program("sky", shaders::kSkyVertex, shaders::kSkyFragment);
  GlProgram edges = make_program("edges", shaders::kSurfaceVertex, shaders::kEdgesFragment);
  GlVertexArray array = make_vertex_array();
  GlBuffer frame = make_buffer(sizeof(FrameBlock));
  GlBuffer drape_block = make_buffer(sizeof(DrapeBlock));
  GlTexture ramp = make_ramp_texture(), drape_ramp = make_ramp_texture();
  DrapeTexture* drape = nullptr;
  GrowingBuffer records, commands, draw_indices;
  std::vector<DrawRecord> drawn;    ///< memory that prepare() uses again
  std::vector<DrawCommand> orders;  ///< likewise
  std::vector<std::uint64_t> keys;  ///< likewise
  std::vector<Run> runs;            ///< of what was prepared last
  std::size_t draw_index_count = 0;
  Camera camera;
  std::unique_ptr<Overdraw> overdraw;
  GLuint framebuffer = 0;
  int width = 0, height = 0, left = 0;

  void set_frame(const Style& style) {
    const FrameBlock block = frame_block(camera, width, height, style);
    glNamedBufferSubData(frame.id(), 0, sizeof block, &block);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, frame.id());
    if (const auto colours = ramp_of(style)) write_ramp(ramp, *colours);
    glBindTextureUnit(0, ramp.id());
    set_drape_block(style);
  }

  void set_drape_block(const Style& style) {
    DrapeBlock block;
    if (drape != nullptr) block = drape->bind(camera.eye);
    const Ramp colours = difference_ramp(style.difference_high_m);
    block.texel[2] = static_cast<float>(style.drape_opacity);
    block.texel[3] = static_cast<float>(style.photo_relief);
    block.ramp = {static_cast<float>(colours.low()), static_cast<float>(colours.high()), 0, 0};
    write_ramp(drape_ramp, colours);
    glBindTextureUnit(3, drape_ramp.id());
    glNamedBufferSubData(drape_block.id(), 0, sizeof block, &block);
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, drape_block.id());
  }

  /// Items of the list in the order to draw them: by part of the list, then page, the nearest
  /// first.
  void sort_items(const DrawList& list) {
    keys.clear();
    const std::uint64_t all = list.items.size();
    for (std::uint64_t i = 0; i < all; ++i)
      keys.push_back((i * kParts / all) << 56 | std::uint64_t{list.items[i].cell.page} << 32 | i);
    std::sort(keys.begin(), keys.end());
  }

  /// Sends the list to the GPU; returns what a draw call would draw.
  DrawCounts prepare(const DrawList& list, const GpuCells& cells, Shading shading) {
    const DrawRecord shared = shared_record(list, camera.eye);
    drawn.clear(), orders.clear(), runs.clear();
    DrawCounts counts;
    sort_items(list);
    for (const std::uint64_t key : keys) {
      const DrawList::Item& item = list.items[static_cast<std::uint32_t>(key)];
      if (runs.empty() || runs.back().page != item.cell.page)
        runs.push_back({item.cell.page, orders.size(), 0});
      ++runs.back().count;
      orders.push_back({item.cell.index_count, 1, item.cell.first_index,
                        static_cast<std::int32_t>(item.cell.first_vertex),
                        static_cast<std::uint32_t>(drawn.size())});
      drawn.push_back(record_of(list, item, shared, camera.eye.z, shading == Shading::kCell));
      counts.triangles += item.cell.index_count / 3;
    }
    counts.cells = static_cast<std::uint32_t>(drawn.size());
    records.write(drawn.data(), drawn.size() * sizeof(DrawRecord));
    commands.write(orders.data(), orders.size() * sizeof(DrawCommand));
    bind(drawn.size());
    if (!runs.empty()) bind_page(runs.front().page, cells);
    return counts;
  }

  void bind(std::size_t draws) {
    // gl_BaseInstance is not in OpenGL 4.5: an attribute that steps once per instance tells a
    // vertex which draw it belongs to.
    if (draws > draw_index_count) {
      std::vector<std::uint32_t> indices(2 * draws);
      std::iota(indices.begin(), indices.end(), 0u);
      draw_indices.write(indices.data(), indices.size() * 4);
      draw_index_count = indices.size();
    }
    glBindVertexArray(array.id());
    glVertexArrayVertexBuffer(array.id(), 0, draw_indices.id(), 0, 4);
    glVertexArrayAttribIFormat(array.id(), 0, 1, GL_UNSIGNED_INT, 0);
    glVertexArrayAttribBinding(array.id(), 0, 0);
    glVertexArrayBindingDivisor(array.id(), 0, 1);
    glEnableVertexArrayAttrib(array.id(), 0);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, records.id());
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, commands.id());
  }

  void bind_page(std::uint32_t page, const GpuCells& cells) const {
    glVertexArrayElementBuffer(array.id(), cells.indices(page));
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, cells.vertices(page));
  }

  /// Draws what was prepared; returns the number of calls.
  std::uint32_t call(const GpuCells& cells) const {
    for (const Run& run : runs) {
      bind_page(run.page, cells);
      const std::uintptr_t first = run.first * sizeof(DrawCommand);
      glMultiDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_SHORT,
                                  reinterpret_cast<const void*>(first),
                                  static_cast<GLsizei>(run.count), 0);
    }
    return static_cast<std::uint32_t>(runs.size());
  }

  void draw_sky() const {
    const CameraAxes axes = axes_of(camera);
    const double up = std::tan(0.5 * camera.field_of_view_deg * 3.14159265358979323846 / 180.0);
    const double right = up * width / height;
    const std::array<Vec3d, 3> columns{right * axes.right, up * axes.up, axes.forward};
    std::array<float, 9> rays{};
    for (std::size_t c = 0; c < 3; ++c) {
      rays[3 * c] = static_cast<float>(columns[c].x);
      rays[3 * c + 1] = static_cast<float>(columns[c].y);
      rays[3 * c + 2] = static_cast<float>(columns[c].z);
    }
    glUseProgram(sky.id());
    glUniformMatrix3fv(glGetUniformLocation(sky.id(), "rays"), 1, GL_FALSE, rays.data());
    glBindVertexArray(array.id());
    glDisable(GL_DEPTH_TEST);
    glDepthMask(GL_FALSE);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glDepthMask(GL_TRUE);
    glEnable(GL_DEPTH_TEST);
  }
};

TerrainRenderer::TerrainRenderer() : state_(std::make_unique<State>()) {}
TerrainRenderer::~TerrainRenderer() = default;

void TerrainRenderer::begin(GLuint framebuffer, int width, int height, const Camera& camera,
                            const Style& style, const Colour* clear_colour, int left) {
  state_->framebuffer = framebuffer;
  state_->left = left;
  state_->camera = camera;
  state_->width = width;
  state_->height = height;
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glViewport(left, 0, width, height);
  glScissor(left, 0, width, height);
  glEnable(GL_SCISSOR_TEST);
  glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_GREATER);
  glDisable(GL_CULL_FACE);
  const Colour colour = clear_colour != nullptr ? *clear_colour : Colour{0, 0, 0};
  glClearColor(float(colour[0]) / 255.0f, float(colour[1]) / 255.0f, float(colour[2]) / 255.0f, 1);
  glClearDepth(0.0);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  glDisable(GL_SCISSOR_TEST);
  state_->set_frame(style);
  if (style.shading == Shading::kOverdraw) {
    if (!state_->overdraw) state_->overdraw = std::make_unique<Overdraw>();
    state_->overdraw->begin(width, height);
  } else if (clear_colour == nullptr) {
    state_->draw_sky();
  }
}

void TerrainRenderer::set_drape(DrapeTexture* drape) { state_->drape = drape; }

DrawCounts TerrainRenderer::draw(const DrawList& list, const GpuCells& cells, const Style& style,
                                 const Swipe& swipe) {
  const SwipeScissor scissor(swipe, state_->left, state_->width, state_->height);
  state_->set_frame(style);
  DrawCounts counts = state_->prepare(list, cells, style.shading);
  if (style.shading == Shading::kOverdraw) {
    glUseProgram(state_->overdraw->program());
    counts.calls = state_->call(cells);
    return counts;
  }
  if (style.opacity < 1.0) {
    glEnable(GL_BLEND);
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  }
  glUseProgram(state_->surface.id());
  counts.calls = state_->call(cells);
  if (style.has_edges) {
    glEnable(GL_BLEND);
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    glPolygonMode(GL_FRONT_AND_BACK, GL_LINE);
    glEnable(GL_POLYGON_OFFSET_LINE);
    glPolygonOffset(1.0f, 1.0f);  // towards the eye: depth is reversed
    glUseProgram(state_->edges.id());
    counts.calls += state_->call(cells);
    glDisable(GL_POLYGON_OFFSET_LINE);
    glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  }
  glDisable(GL_BLEND);
  return counts;
}

double TerrainRenderer::show_overdraw() {
  return state_->overdraw->show(state_->framebuffer, state_->left);
}

void TerrainRenderer::place(const DrawList& list, const GpuCells& cells, std::size_t count,
                            GLuint places) {
  const GlProgram program =
      make_program("places", shaders::kSurfaceVertex, shaders::kSurfaceFragment, {"from_eye"});
  state_->prepare(list, cells, Shading::kPlain);
  glUseProgram(program.id());
  glBindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, places);
  glEnable(GL_RASTERIZER_DISCARD);
  glBeginTransformFeedback(GL_POINTS);
  const auto first = static_cast<GLint>(list.items.front().cell.first_vertex);
  glDrawArraysInstancedBaseInstance(GL_POINTS, first, static_cast<GLsizei>(count), 1, 0);
  glEndTransformFeedback();
  glDisable(GL_RASTERIZER_DISCARD);
}

}  // namespace cornice::viewer
