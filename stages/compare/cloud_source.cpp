// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>

#include "core/geo/file_crs.h"
#include "core/io/las.h"
#include "core/io/ply.h"
#include "stages/compare/part_cache.h"
#include "stages/compare/source_kinds.h"

namespace cornice::compare {
namespace {

/// Points of a part, about.
constexpr double kPartPoints = 2e6;
/// Sides of parts are multiples of this.
constexpr double kSideM = 25.0;
constexpr double kLargestSideM = 1000.0;
/// Of all parts of all files; even the largest are a continent then.
constexpr double kMostBlocks = 1e7;
/// Not surface: noise, artefacts and points that were never measured (ASPRS and Lidar HD).
constexpr std::array<std::uint8_t, 4> kNoSurface{7, 18, 65, 66};

class CloudSource : public Source {
 public:
  CloudSource(SourceFacts facts, const Options& options, std::uint64_t cache_bytes)
      : cache_bytes_(cache_bytes),
        files_(cache_bytes),
        blocks_(cache_bytes / 2),
        threads_(options.threads) {
    facts_ = std::move(facts);
    keep_.fill(options.classes.empty() ? 1 : 0);
    for (const std::uint8_t code : kNoSurface) keep_[code] = 0;
    for (const int code : options.classes) keep_[static_cast<std::size_t>(code)] = 1;
    double area = 0.0;
    for (const std::filesystem::path& file : facts_.files) {
      add_file(file);
      area += file_boxes_.back().width() * file_boxes_.back().height();
    }
    if (facts_.vertices == 0) throw InputError(facts_.title, "has no points");
    make_blocks(area);
  }

  std::shared_ptr<const Surface> part(std::size_t index) override {
    return blocks_.get(
        index,
        [&] {
          const Box2d& box = parts_[index].box;
          auto surface =
              std::make_shared<Surface>(region(box, frame_of(box, 0.5 * (low_z_ + high_z_))));
          // Points on a border belong to the block east or north of it.
          drop(*surface, [&](Vec3d p) { return p.x < box.max_x && p.y < box.max_y; });
          return surface;
        },
        [](const Surface& surface) { return static_cast<std::uint64_t>(surface.bytes()); });
  }

  Surface region(const Box2d& box, Vec3d origin) override {
    Surface surface;
    surface.origin = origin;
    for (std::size_t i = 0; i < facts_.files.size(); ++i) {
      if (!file_boxes_[i].intersects(box)) continue;
      if (!infos_[i].path.empty() && infos_[i].point_count * sizeof(Vec3f) > cache_bytes_ / 2) {
        append(read_points(i, box), box, surface);
      } else {
        append(*whole(i), box, surface);
      }
    }
    if (surface.normals.size() != surface.positions.size()) surface.normals.clear();
    return surface;
  }

  std::vector<Box2d> coverage(const Box2d& near) const override {
    std::vector<Box2d> boxes;
    for (const Box2d& box : file_boxes_) {
      if (!box.empty() && box.intersects(near)) boxes.push_back(box);
    }
    return boxes;
  }

 private:
  void add_file(const std::filesystem::path& file) {
    const bool is_ply = file.extension() == ".ply" || file.extension() == ".PLY";
    infos_.emplace_back();
    Box3d box;
    if (is_ply) {
      const PlyInfo info = read_ply_info(file);
      if (!info.crs_text.empty()) join_crs(facts_, file, crs_of_file(file, info.crs_text));
      file_boxes_.emplace_back();
      const std::shared_ptr<const Surface> points = whole(infos_.size() - 1);
      for (const Vec3f p : points->positions) box.add(points->origin + p.cast<double>());
      facts_.vertices += points->positions.size();
      file_boxes_.back() = box.empty() ? Box2d{} : box.plan();
    } else {
      infos_.back() = read_las_info(file);
      if (!infos_.back().data_problem.empty()) {
        throw InputError(file.string(), infos_.back().data_problem);
      }
      join_crs(facts_, file, infos_.back().crs);
      facts_.vertices += infos_.back().point_count;
      if (infos_.back().point_count > 0) {
        box = infos_.back().bounds;
        if (box.empty()) {
          throw InputError(file.string(),
                           "has bounds in its header that hold nothing; make it anew");
        }
      }
      file_boxes_.push_back(box.empty() ? Box2d{} : box.plan());
    }
    if (box.empty()) {
      facts_.warnings.push_back(file.string() + ": has no points");
      return;
    }
    if (low_z_ > high_z_) low_z_ = box.min.z, high_z_ = box.max.z;
    low_z_ = std::min(low_z_, box.min.z), high_z_ = std::max(high_z_, box.max.z);
    facts_.box.add(box.min.x, box.min.y);
    facts_.box.add(box.max.x, box.max.y);
  }

  /// Headers may say that a file reaches anywhere.
  [[noreturn]] void refuse_widest() const {
    const auto widest = std::max_element(
        file_boxes_.begin(), file_boxes_.end(), [](const Box2d& a, const Box2d& b) {
          return std::max(a.width(), a.height()) < std::max(b.width(), b.height());
        });
    char text[160];
    std::snprintf(text, sizeof text,
                  "says it reaches from %.9g, %.9g to %.9g, %.9g in east and north", widest->min_x,
                  widest->min_y, widest->max_x, widest->max_y);
    throw InputError(facts_.files[static_cast<std::size_t>(widest - file_boxes_.begin())].string(),
                     std::string(text) +
                         ", which no survey does; see what cornice-info says of it, make it anew");
  }

  void make_blocks(double area) {
    const double density = static_cast<double>(facts_.vertices) / std::max(area, 1.0);
    const double side = std::clamp(std::floor(std::sqrt(kPartPoints / density) / kSideM) * kSideM,
                                   kSideM, kLargestSideM);
    const Box2d& box = facts_.box;
    if (!(box.width() / side * (box.height() / side) < kMostBlocks)) refuse_widest();
    for (double y = std::floor(box.min_y / side) * side; y <= box.max_y; y += side) {
      for (double x = std::floor(box.min_x / side) * side; x <= box.max_x; x += side) {
        const Box2d block{x, y, x + side, y + side};
        if (std::none_of(file_boxes_.begin(), file_boxes_.end(), [&](const Box2d& file) {
              return !file.empty() && file.intersects(block);
            })) {
          continue;
        }
        parts_.push_back({"block-" + std::to_string(parts_.size() + 1), block});
      }
    }
  }

  std::shared_ptr<const Surface> whole(std::size_t i) {
    return files_.get(
        i,
        [&] {
          return std::make_shared<const Surface>(
              infos_[i].path.empty() ? read_ply(facts_.files[i]) : read_points(i, std::nullopt));
        },
        [](const Surface& surface) { return static_cast<std::uint64_t>(surface.bytes()); });
  }

  Surface read_points(std::size_t i, std::optional<Box2d> window) {
    LasReadOptions options;
    options.attributes = Attribute::kClassification | Attribute::kFlags;
    options.window = window;
    options.origin = frame_of(file_boxes_[i], infos_[i].bounds.min.z);
    options.threads = threads_;
    const PointCloud points = read_las(infos_[i], options).points;
    Surface surface;
    surface.origin = points.origin;
    for (std::size_t p = 0; p < points.size(); ++p) {
      if (keep_[points.classification[p]] == 0) continue;
      if ((points.flags[p] & (kSynthetic | kWithheld)) != 0) continue;
      surface.positions.push_back(points.positions[p]);
    }
    return surface;
  }

  static Surface read_ply(const std::filesystem::path& path) {
    OrientedPoints points = read_ply_points(path);
    Surface surface;
    surface.origin = points.origin;
    surface.positions = std::move(points.positions);
    surface.normals = std::move(points.normals);
    return surface;
  }

  /// Appends the points of `from` in the box.
  static void append(const Surface& from, const Box2d& box, Surface& to) {
    const Vec3d shift = from.origin - to.origin;
    for (std::size_t i = 0; i < from.positions.size(); ++i) {
      const Vec3d p = from.positions[i].cast<double>();
      if (!box.contains(p.x + from.origin.x, p.y + from.origin.y)) continue;
      to.positions.push_back((p + shift).cast<float>());
      if (!from.normals.empty()) to.normals.push_back(from.normals[i]);
    }
  }

  template <class Keep>
  static void drop(Surface& surface, const Keep& keep) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < surface.positions.size(); ++i) {
      if (!keep(surface.origin + surface.positions[i].cast<double>())) continue;
      surface.positions[kept] = surface.positions[i];
      if (!surface.normals.empty()) surface.normals[kept] = surface.normals[i];
      ++kept;
    }
    surface.positions.resize(kept);
    if (!surface.normals.empty()) surface.normals.resize(kept);
  }

  std::array<std::uint8_t, 256> keep_{};  ///< by class
  std::vector<LasInfo> infos_;            ///< without path: PLY
  std::vector<Box2d> file_boxes_;
  double low_z_ = 1.0, high_z_ = 0.0;
  std::uint64_t cache_bytes_;
  PartCache<Surface> files_;
  PartCache<Surface> blocks_;
  int threads_;
};

}  // namespace

std::unique_ptr<Source> open_clouds(SourceFacts facts, const Options& options,
                                    std::uint64_t cache_bytes) {
  return std::make_unique<CloudSource>(std::move(facts), options, cache_bytes);
}

}  // namespace cornice::compare
