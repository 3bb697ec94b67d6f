// SPDX-License-Identifier: GPL-3.0-or-later
// Rasters of heights as surfaces: pixel centres joined by triangles.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/io/raster_file.h"
#include "stages/compare/source_kinds.h"

namespace cornice::compare {
namespace {

/// Pixels along a part's side: 2 million triangles.
constexpr std::int64_t kBlock = 1000;
/// Parts of a pixel by which grids that are taken for one may be off each other.
constexpr double kGridTolerance = 0.01;
constexpr float kNoHeight = std::numeric_limits<float>::quiet_NaN();

/// Pixels of the common grid, both ends included; rows count from the first file's north edge down.
struct Window {
  std::int64_t col0, row0, col1, row1;
  std::int64_t width() const { return col1 - col0 + 1; }
  std::int64_t height() const { return row1 - row0 + 1; }
};

class DemSource : public Source {
 public:
  DemSource(SourceFacts facts, std::uint64_t cache_bytes) {
    limit_raster_cache(cache_bytes);
    facts_ = std::move(facts);
    for (const std::filesystem::path& file : facts_.files) add_file(file);
    for (const Window& tile : tiles_) {
      facts_.vertices += static_cast<std::uint64_t>(tile.width() * tile.height());
      const Box2d box = centre_box(tile);
      facts_.box.add(box.min_x, box.min_y);
      facts_.box.add(box.max_x, box.max_y);
      add_blocks(tile);
    }
    const double columns = (facts_.box.max_x - facts_.box.min_x) / facts_.step_m;
    const double rows = (facts_.box.max_y - facts_.box.min_y) / facts_.step_m;
    if (tiles_.size() == 1) {
      facts_.triangles = static_cast<std::uint64_t>(2.0 * std::round(columns) * std::round(rows));
    } else {
      facts_.triangles = 2 * facts_.vertices;
    }
  }

  std::shared_ptr<const Surface> part(std::size_t index) override {
    // The quads whose first pixel is in the block: its first row and column of the next ones too.
    Window window = blocks_[index];
    const Window own{window.col0, window.row0, window.col1 + 1, window.row1 + 1};
    constexpr std::int64_t kRim = 2;
    window = {own.col0 - kRim, own.row0 - kRim, own.col1 + kRim, own.row1 + kRim};
    const Box2d& box = parts_[index].box;
    Surface wide = triangulate(window, {0.0, 0.0, 0.0}, box);
    wide.normals = vertex_normals(wide.positions, wide.triangles);
    wide.curvature = vertex_curvature(wide);
    return std::make_shared<const Surface>(cut(wide, window, own));
  }

  Surface region(const Box2d& box, Vec3d origin) override {
    const auto col = [&](double x) {
      return static_cast<std::int64_t>(std::floor((x - west_) / facts_.step_m - 0.5));
    };
    const auto row = [&](double y) {
      return static_cast<std::int64_t>(std::floor((north_ - y) / facts_.step_m - 0.5));
    };
    const Window window{col(box.min_x), row(box.max_y), col(box.max_x) + 1, row(box.min_y) + 1};
    quads_.clear();
    return triangulate(clipped(window), origin, {});
  }

  std::vector<Box2d> coverage(const Box2d& near) const override {
    std::vector<Box2d> boxes;
    for (const Window& tile : tiles_) {
      // To the next tile's first pixels, if there is one.
      const Window reach = clipped({tile.col0, tile.row0, tile.col1 + 1, tile.row1 + 1});
      const Box2d box = centre_box(reach);
      if (box.intersects(near)) boxes.push_back(box);
    }
    return boxes;
  }

 private:
  void add_file(const std::filesystem::path& file) {
    const RasterHead head = RasterFile(file).head();
    require_metres(file, head);
    join_crs(facts_, file, head.crs);
    if (tiles_.empty()) {
      facts_.step_m = head.step;
      west_ = head.west;
      north_ = head.north;
    }
    const double col = (head.west - west_) / facts_.step_m;
    const double row = (north_ - head.north) / facts_.step_m;
    if (std::abs(head.step - facts_.step_m) * head.width > kGridTolerance * facts_.step_m ||
        std::abs(col - std::round(col)) > kGridTolerance ||
        std::abs(row - std::round(row)) > kGridTolerance) {
      throw InputError(file.string(), "its pixels do not lie on the grid of " +
                                          facts_.files.front().string() +
                                          "; resample it first, with gdalwarp -tr -tap");
    }
    const auto c = static_cast<std::int64_t>(std::llround(col));
    const auto r = static_cast<std::int64_t>(std::llround(row));
    tiles_.push_back({c, r, c + head.width - 1, r + head.height - 1});
  }

  /// The part of a file's own pixels, in blocks of the common grid.
  void add_blocks(const Window& tile) {
    const auto first = [](std::int64_t x) {
      return static_cast<std::int64_t>(std::floor(static_cast<double>(x) / kBlock));
    };
    for (std::int64_t j = first(tile.row0); j <= first(tile.row1); ++j) {
      for (std::int64_t i = first(tile.col0); i <= first(tile.col1); ++i) {
        const Window block{std::max(tile.col0, i * kBlock), std::max(tile.row0, j * kBlock),
                           std::min(tile.col1, (i + 1) * kBlock - 1),
                           std::min(tile.row1, (j + 1) * kBlock - 1)};
        blocks_.push_back(block);
        const Box2d box = centre_box({block.col0, block.row0, block.col1 + 1, block.row1 + 1});
        parts_.push_back({"block-" + std::to_string(blocks_.size()), box});
      }
    }
  }

  Box2d centre_box(const Window& w) const {
    const double step = facts_.step_m;
    return {west_ + (static_cast<double>(w.col0) + 0.5) * step,
            north_ - (static_cast<double>(w.row1) + 0.5) * step,
            west_ + (static_cast<double>(w.col1) + 0.5) * step,
            north_ - (static_cast<double>(w.row0) + 0.5) * step};
  }

  /// Without what lies beyond all files; empty windows have no width.
  Window clipped(Window w) const {
    Window all = tiles_.front();
    for (const Window& t : tiles_) {
      all = {std::min(all.col0, t.col0), std::min(all.row0, t.row0), std::max(all.col1, t.col1),
             std::max(all.row1, t.row1)};
    }
    return {std::max(w.col0, all.col0), std::max(w.row0, all.row0), std::min(w.col1, all.col1),
            std::min(w.row1, all.row1)};
  }

  std::vector<float> heights(const Window& w) {
    std::vector<float> values(static_cast<std::size_t>(w.width() * w.height()), kNoHeight);
    for (std::size_t i = 0; i < tiles_.size(); ++i) {
      const Window& t = tiles_[i];
      const Window both{std::max(w.col0, t.col0), std::max(w.row0, t.row0),
                        std::min(w.col1, t.col1), std::min(w.row1, t.row1)};
      if (both.width() <= 0 || both.height() <= 0) continue;
      RasterFile file(facts_.files[i]);
      const auto width = static_cast<std::size_t>(both.width());
      std::vector<float> rows(width * static_cast<std::size_t>(both.height()));
      file.read(static_cast<int>(both.col0 - t.col0), static_cast<int>(both.row0 - t.row0),
                static_cast<int>(both.width()), static_cast<int>(both.height()), rows.data(),
                width);
      require_ground(facts_.files[i], rows);
      for (std::size_t k = 0; k < rows.size(); ++k) {
        const auto row = both.row0 + static_cast<std::int64_t>(k / width);
        const auto col = both.col0 + static_cast<std::int64_t>(k % width);
        float& to = values[static_cast<std::size_t>((row - w.row0) * w.width() + col - w.col0)];
        // Where files overlap the first one counts.
        if (std::isnan(to)) to = rows[k];
      }
    }
    return values;
  }

  /// The triangles between the pixel centres of a window. Where `frame_box` is not empty the frame
  /// is that of the box at the first height met, else `origin`. quads_ gets the pixel of each
  /// triangle.
  Surface triangulate(const Window& w, Vec3d origin, const Box2d& frame_box) {
    Surface surface;
    surface.origin = origin;
    quads_.clear();
    if (w.width() < 1 || w.height() < 1) return surface;
    const std::vector<float> z = heights(w);
    if (!frame_box.empty()) {
      const auto first = std::find_if(z.begin(), z.end(), [](float v) { return !std::isnan(v); });
      surface.origin = frame_of(frame_box, first == z.end() ? 0.0 : static_cast<double>(*first));
    }
    const auto width = static_cast<std::size_t>(w.width());
    std::vector<std::uint32_t> number(z.size(), 0xffffffffu);
    const Box2d centres = centre_box(w);
    for (std::size_t i = 0; i < z.size(); ++i) {
      if (std::isnan(z[i])) continue;
      number[i] = static_cast<std::uint32_t>(surface.positions.size());
      const Vec3d at{centres.min_x + static_cast<double>(i % width) * facts_.step_m,
                     centres.max_y - static_cast<double>(i / width) * facts_.step_m,
                     static_cast<double>(z[i])};
      surface.positions.push_back((at - surface.origin).cast<float>());
    }
    for (std::size_t i = 0; i + width < z.size(); ++i) {
      if (i % width + 1 == width) continue;
      // nw ne
      // sw se
      add_quad({i, i + 1, i + width, i + width + 1}, z, number, surface);
      quads_.resize(surface.triangles.size(), i);
    }
    return surface;
  }

  /// Two triangles along the flatter diagonal, or one where a corner has no height.
  static void add_quad(const std::array<std::size_t, 4>& c, const std::vector<float>& z,
                       const std::vector<std::uint32_t>& number, Surface& surface) {
    const auto add = [&](std::size_t a, std::size_t b, std::size_t d) {
      if (std::isnan(z[a]) || std::isnan(z[b]) || std::isnan(z[d])) return;
      surface.triangles.push_back({number[a], number[b], number[d]});
    };
    const auto [nw, ne, sw, se] = c;
    const bool all = !std::isnan(z[nw] + z[ne] + z[sw] + z[se]);
    const bool along_nw_se = all ? std::abs(z[nw] - z[se]) <= std::abs(z[ne] - z[sw])
                                 : std::isnan(z[ne]) || std::isnan(z[sw]);
    if (along_nw_se) {
      add(nw, sw, se);
      add(nw, se, ne);
    } else {
      add(nw, sw, ne);
      add(ne, sw, se);
    }
  }

  /// The triangles of the quads whose first pixel lies in `own` without its last row and column.
  Surface cut(const Surface& wide, const Window& window, const Window& own) const {
    Surface surface;
    surface.origin = wide.origin;
    std::vector<std::uint32_t> number(wide.positions.size(), 0xffffffffu);
    for (std::size_t t = 0; t < wide.triangles.size(); ++t) {
      const auto col = window.col0 + static_cast<std::int64_t>(quads_[t]) % window.width();
      const auto row = window.row0 + static_cast<std::int64_t>(quads_[t]) / window.width();
      if (col < own.col0 || row < own.row0 || col >= own.col1 || row >= own.row1) continue;
      Triangle corners = wide.triangles[t];
      for (std::uint32_t& v : corners) {
        if (number[v] == 0xffffffffu) {
          number[v] = static_cast<std::uint32_t>(surface.positions.size());
          surface.positions.push_back(wide.positions[v]);
          surface.normals.push_back(wide.normals[v]);
          surface.curvature.push_back(wide.curvature[v]);
        }
        v = number[v];
      }
      surface.triangles.push_back(corners);
    }
    return surface;
  }

  double west_ = 0.0, north_ = 0.0;
  std::vector<Window> tiles_;
  std::vector<Window> blocks_;
  std::vector<std::size_t> quads_;  ///< pixel of each triangle made last
};

}  // namespace

std::unique_ptr<Source> open_dems(SourceFacts facts, std::uint64_t cache_bytes) {
  return std::make_unique<DemSource>(std::move(facts), cache_bytes);
}

}  // namespace cornice::compare
