// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/compare/source.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <optional>

#include "core/base/error.h"
#include "core/base/input_file.h"
#include "core/io/ply.h"
#include "stages/compare/source_kinds.h"

namespace cornice::compare {
namespace {

namespace fs = std::filesystem;

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// What a file holds by its name; nothing where it is none of ours.
std::optional<Kind> kind_by_name(const fs::path& file) {
  const std::string name = lower(file.filename().string());
  if (name.ends_with(".ply")) return Kind::kMesh;
  if (name.ends_with(".tif") || name.ends_with(".tiff") || name.ends_with(".asc")) {
    return Kind::kDem;
  }
  if (name.ends_with(".las") || name.ends_with(".laz") || name.ends_with(".las.zip")) {
    return Kind::kCloud;
  }
  return std::nullopt;
}

Kind kind_of(const fs::path& file) {
  const std::optional<Kind> kind = kind_by_name(file);
  if (!kind) {
    throw InputError(file.string(),
                     "is no mesh (.ply), raster (.tif, .asc) or point file (.las, .laz, .ply)");
  }
  if (*kind != Kind::kMesh) return *kind;
  const PlyInfo info = read_ply_info(file);
  const bool has_faces =
      std::any_of(info.elements.begin(), info.elements.end(),
                  [](const PlyInfo::Element& element) { return element.name == "face"; });
  return has_faces ? Kind::kMesh : Kind::kCloud;
}

std::vector<fs::path> listed_files(const fs::path& list) {
  check_input_file(list);
  std::ifstream in(list);
  if (!in) throw InputError(list.string(), "cannot be read");
  std::vector<fs::path> files;
  for (std::string line; std::getline(in, line);) {
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    if (line.empty()) continue;
    const fs::path file(line);
    files.push_back(file.is_absolute() ? file : list.parent_path() / file);
  }
  return files;
}

std::string box_text(const Box2d& box) {
  char text[160];
  std::snprintf(text, sizeof text, "%.1f to %.1f east, %.1f to %.1f north", box.min_x, box.max_x,
                box.min_y, box.max_y);
  return text;
}

std::string crs_words(const Crs& crs) { return crs.name.empty() ? crs.text() : crs.name; }

}  // namespace

const char* kind_name(Kind kind) {
  if (kind == Kind::kMesh) return "mesh";
  return kind == Kind::kDem ? "DEM" : "point cloud";
}

std::vector<fs::path> files_of(const fs::path& path) {
  std::error_code error;
  std::vector<fs::path> files;
  if (fs::is_directory(path, error)) {
    for (const fs::directory_entry& entry : fs::directory_iterator(path)) {
      if (entry.is_regular_file() && kind_by_name(entry.path())) files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
  } else if (lower(path.extension().string()) == ".txt") {
    files = listed_files(path);
  } else {
    files.push_back(path);
  }
  if (files.empty()) throw InputError(path.string(), "holds no mesh, raster or point file");
  for (const fs::path& file : files) {
    check_input_file(file);
  }
  return files;
}

void join_crs(SourceFacts& facts, const fs::path& file, const Crs& crs) {
  if (!crs.empty() && crs.metres_per_unit == 0.0) {
    throw InputError(file.string(), "is in degrees (" + crs_words(crs) +
                                        "); transform it to a system in metres first");
  }
  if (!crs.empty() && (std::abs(crs.metres_per_unit - 1.0) > 1e-9 ||
                       std::abs(crs.vertical_metres_per_unit - 1.0) > 1e-9)) {
    char unit[32];
    std::snprintf(unit, sizeof unit, "%.7g",
                  crs.metres_per_unit != 1.0 ? crs.metres_per_unit : crs.vertical_metres_per_unit);
    throw InputError(file.string(), "is in feet or another unit of " + std::string(unit) + " m (" +
                                        crs_words(crs) + "); transform it to metres first");
  }
  if (crs.empty()) return;
  if (facts.crs.empty()) facts.crs = crs;
  if (!same_crs(facts.crs, crs)) {
    throw InputError(file.string(), "has another coordinate system (" + crs_words(crs) +
                                        ") than the files before it (" + crs_words(facts.crs) +
                                        ")");
  }
}

Vec3d frame_of(const Box2d& box, double height) {
  return {std::floor(0.5 * (box.min_x + box.max_x)), std::floor(0.5 * (box.min_y + box.max_y)),
          std::floor(height)};
}

std::unique_ptr<Source> open_source(const fs::path& path, const Options& options,
                                    std::uint64_t cache_bytes) {
  SourceFacts facts;
  facts.title = path.string();
  facts.files = files_of(path);
  facts.kind = kind_of(facts.files.front());
  for (const fs::path& file : facts.files) {
    facts.file_bytes += fs::file_size(file);
    const Kind kind = kind_of(file);
    if (kind == facts.kind) continue;
    throw InputError(file.string(), std::string("is a ") + kind_name(kind) + ", but " +
                                        facts.files.front().string() + " is a " +
                                        kind_name(facts.kind) + "; a side is of one kind");
  }
  if (facts.kind == Kind::kMesh) return open_meshes(std::move(facts), cache_bytes, options.threads);
  if (facts.kind == Kind::kDem) return open_dems(std::move(facts), cache_bytes);
  return open_clouds(std::move(facts), options, cache_bytes);
}

Box2d check_pair(const SourceFacts& a, const SourceFacts& b, std::vector<std::string>& warnings) {
  if (a.crs.empty() != b.crs.empty()) {
    const SourceFacts& without = a.crs.empty() ? a : b;
    warnings.push_back(without.title + ": names no coordinate system; taken for that of the other");
  } else if (a.crs.has_vertical && b.crs.has_vertical && a.crs.horizontal_epsg != 0 &&
             a.crs.horizontal_epsg == b.crs.horizontal_epsg && !same_crs(a.crs, b.crs)) {
    throw InputError(b.title, "has heights of another datum (" + crs_words(b.crs) + ") than " +
                                  a.title + " (" + crs_words(a.crs) +
                                  "); transform one of them first, with gdalwarp or PDAL");
  } else if (!same_crs(a.crs, b.crs)) {
    throw InputError(b.title, "has another coordinate system (" + crs_words(b.crs) + ") than " +
                                  a.title + " (" + crs_words(a.crs) +
                                  "); transform one of them first, with gdalwarp or PDAL");
  } else if (a.crs.has_vertical != b.crs.has_vertical) {
    const SourceFacts& without = a.crs.has_vertical ? b : a;
    warnings.push_back(without.title + ": names no height system; taken for that of the other");
  }
  const Box2d common{std::max(a.box.min_x, b.box.min_x), std::max(a.box.min_y, b.box.min_y),
                     std::min(a.box.max_x, b.box.max_x), std::min(a.box.max_y, b.box.max_y)};
  if (!(common.min_x < common.max_x && common.min_y < common.max_y)) {
    throw InputError(b.title, "lies elsewhere (" + box_text(b.box) + ") than " + a.title + " (" +
                                  box_text(a.box) + "); there is nothing to compare");
  }
  return common;
}

}  // namespace cornice::compare
