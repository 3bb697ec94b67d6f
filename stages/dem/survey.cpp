// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/dem/survey.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <tuple>
#include <utility>

#include "core/base/error.h"
#include "core/geo/vertical_crs.h"
#include "stages/dem/resample.h"

namespace cornice::dem {
namespace {

namespace fs = std::filesystem;

constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();
/// Parts of a pixel by which a tile may be off the common grid: headers round.
constexpr double kGridTolerance = 0.01;
/// Ground lies between the trenches' edges and Everest; -9999, 9999 and 32767 are no heights.
constexpr float kHighestGround_m = 9000.0f;
constexpr std::size_t kOpenFiles = 32;
constexpr std::size_t kNamesInWarning = 3;

std::string number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.10g", value);
  return text.data();
}

bool comes_before(const Tile& a, const Tile& b) {
  return std::make_tuple(-a.head.north, a.head.west, a.path.filename().string(), a.path.string()) <
         std::make_tuple(-b.head.north, b.head.west, b.path.filename().string(), b.path.string());
}

/// "3 tiles WHAT: a.tif, b.tif, ..."
std::string named(const std::vector<std::string>& names, const std::string& what) {
  std::string text =
      std::to_string(names.size()) + (names.size() == 1 ? " tile " : " tiles ") + what;
  for (std::size_t i = 0; i < std::min(names.size(), kNamesInWarning); ++i) {
    text += (i == 0 ? ": " : ", ") + names[i];
  }
  return names.size() > kNamesInWarning ? text + ", ..." : text;
}

}  // namespace

Survey::Survey(const std::vector<fs::path>& paths, const SurveyOptions& options)
    : is_resampled_(options.resample_m.has_value()), no_data_(options.no_data) {
  std::vector<RasterFile> opened;
  for (const fs::path& path : paths) {
    RasterFile file(path);
    tiles_.push_back({path, file.head(), {}});
    if (opened.size() < kOpenFiles) opened.push_back(std::move(file));
  }
  std::sort(tiles_.begin(), tiles_.end(), comes_before);
  for (RasterFile& file : opened) {
    const auto tile = std::find_if(tiles_.begin(), tiles_.end(),
                                   [&](const Tile& t) { return t.path == file.path(); });
    if (no_data_) file.set_no_data(*no_data_);
    open_.emplace_back(static_cast<std::size_t>(tile - tiles_.begin()), std::move(file));
  }
  check_crs(options);
  lay_out(options);
  find_overlaps();
}

void Survey::check_crs(const SurveyOptions& options) {
  const Crs told = options.crs.empty() ? Crs{} : crs_from_text(options.crs);
  std::vector<std::string> replaced, without_heights;
  for (Tile& tile : tiles_) {
    const std::string name = tile.path.filename().string();
    if (!told.empty()) {
      if (!tile.head.crs.empty() && !same_crs(tile.head.crs, told)) replaced.push_back(name);
      tile.head.crs = told;
    }
    if (tile.head.crs.empty()) {
      throw InputError(tile.path.string(),
                       "has no CRS, neither in the file nor by its name; tell it with --crs, such "
                       "as --crs EPSG:2056+5728");
    }
    require_metres(tile.path, tile.head);
    if (!same_crs(tile.head.crs, tiles_.front().head.crs)) {
      throw InputError(tile.path.string(),
                       "is in " + tile.head.crs.name + ", but " + tiles_.front().path.string() +
                           " is in " + tiles_.front().head.crs.name +
                           "; bring both into one system and datum, with gdalwarp -t_srs");
    }
    if (!tile.head.crs.has_vertical) without_heights.push_back(name);
    if (crs_.empty() || (!crs_.has_vertical && tile.head.crs.has_vertical)) crs_ = tile.head.crs;
  }
  if (!replaced.empty()) warnings_.push_back(named(replaced, "said another CRS than --crs"));
  if (!options.vertical_crs.empty()) {
    crs_ = with_vertical(crs_, options.vertical_crs);
  } else if (!crs_.has_vertical) {
    warnings_.push_back(
        "no tile says which vertical system its heights are in; tell it with --vertical-crs");
  } else if (!without_heights.empty()) {
    warnings_.push_back(named(without_heights, "without a vertical system, taken as of " +
                                                   crs_.text() + " like the others"));
  }
}

void Survey::lay_out(const SurveyOptions& options) {
  const Tile& first = tiles_.front();
  step_ = options.resample_m.value_or(first.head.step);
  if (is_resampled_) {
    for (Tile& tile : tiles_) tile.rect = resampled_rect(tile.head, step_);
    return;
  }
  west_ = first.head.west;
  north_ = first.head.north;
  for (Tile& tile : tiles_) {
    const RasterHead& head = tile.head;
    const double col = (head.west - west_) / step_, row = (north_ - head.north) / step_;
    const double off = std::max(std::abs(col - std::round(col)), std::abs(row - std::round(row)));
    const double stretch = std::abs(head.step - step_) * std::max(head.width, head.height);
    if (off > kGridTolerance || stretch > kGridTolerance * step_) {
      throw InputError(tile.path.string(),
                       "its grid, " + number(head.step) + " m from " + number(head.west) + ", " +
                           number(head.north) + ", does not fit that of " + first.path.string() +
                           ", " + number(step_) + " m from " + number(west_) + ", " +
                           number(north_) + "; bring all onto one with --resample " +
                           number(step_));
    }
    tile.rect = {std::llround(col), std::llround(row), head.width, head.height};
  }
}

void Survey::find_overlaps() {
  std::vector<std::string> overlapping, alone;
  std::vector<bool> has_neighbour(tiles_.size(), false);
  std::vector<std::size_t> by_row(tiles_.size());
  for (std::size_t i = 0; i < tiles_.size(); ++i) by_row[i] = i;
  std::sort(by_row.begin(), by_row.end(), [&](std::size_t a, std::size_t b) {
    return std::make_pair(tiles_[a].rect.row, a) < std::make_pair(tiles_[b].rect.row, b);
  });
  for (std::size_t a = 0; a < by_row.size(); ++a) {
    const Tile& one = tiles_[by_row[a]];
    for (std::size_t b = a + 1; b < by_row.size(); ++b) {
      const Tile& other = tiles_[by_row[b]];
      if (other.rect.row > one.rect.end_row()) break;
      if (one.rect.grown(1).common(other.rect).empty()) continue;
      has_neighbour[by_row[a]] = has_neighbour[by_row[b]] = true;
      const PixelRect both = one.rect.common(other.rect);
      if (both.empty()) continue;
      overlapping.push_back(one.path.filename().string() + " and " +
                            other.path.filename().string() + " (" + std::to_string(both.width) +
                            " x " + std::to_string(both.height) + " pixels)");
    }
  }
  for (std::size_t i = 0; i < tiles_.size() && tiles_.size() > 1; ++i) {
    if (!has_neighbour[i]) alone.push_back(tiles_[i].path.filename().string());
  }
  if (!overlapping.empty()) {
    std::string text = named(overlapping, "");
    text = std::to_string(overlapping.size()) +
           " pairs of tiles overlap, the more northern, then "
           "more western one counts" +
           text.substr(text.find(':'));
    warnings_.push_back(text);
  }
  if (!alone.empty()) warnings_.push_back(named(alone, "beside no other"));
}

RasterFile& Survey::open(std::size_t index) {
  const auto found = std::find_if(open_.begin(), open_.end(),
                                  [&](const auto& entry) { return entry.first == index; });
  if (found != open_.end()) {
    open_.splice(open_.begin(), open_, found);
  } else {
    open_.emplace_front(index, RasterFile(tiles_[index].path));
    if (no_data_) open_.front().second.set_no_data(*no_data_);
    if (open_.size() > kOpenFiles) open_.pop_back();
  }
  return open_.front().second;
}

void Survey::read_part(std::size_t index, const PixelRect& part, float* to, std::size_t stride) {
  RasterFile& file = open(index);
  if (is_resampled_) {
    resample(file, part, step_, to, stride);
  } else {
    const PixelRect& rect = tiles_[index].rect;
    file.read(static_cast<int>(part.col - rect.col), static_cast<int>(part.row - rect.row),
              static_cast<int>(part.width), static_cast<int>(part.height), to, stride);
  }
  for (std::int64_t row = 0; row < part.height; ++row) {
    const float* line = to + static_cast<std::size_t>(row) * stride;
    const float* const end = line + part.width;
    const float* bad =
        std::find_if(line, end, [](float z) { return std::abs(z) > kHighestGround_m; });
    if (bad == end) continue;
    const std::string value = number(static_cast<double>(*bad));
    throw InputError(file.path().string(),
                     "has a height of " + value + " m at " +
                         number(east_of(part.col + (bad - line))) + ", " +
                         number(north_of(part.row + row)) +
                         ", which no ground has; if it stands for no data, say --no-data " + value);
  }
}

void Survey::add_tile(std::size_t index, const PixelRect& window, std::vector<float>& heights) {
  const PixelRect part = window.common(tiles_[index].rect);
  if (part.empty()) return;
  std::vector<float> values(part.area());
  read_part(index, part, values.data(), static_cast<std::size_t>(part.width));
  for (std::int64_t row = 0; row < part.height; ++row) {
    const float* from = values.data() + row * part.width;
    float* to =
        heights.data() + (part.row - window.row + row) * window.width + (part.col - window.col);
    for (std::int64_t i = 0; i < part.width; ++i) {
      // Not-a-number differs from itself.
      if (from[i] == from[i]) to[i] = from[i];
    }
  }
}

std::vector<float> Survey::read(const PixelRect& window) {
  std::vector<float> heights(window.area(), kNothing);
  for (std::size_t i = tiles_.size(); i-- > 0;) add_tile(i, window, heights);
  return heights;
}

std::vector<PixelRect> Survey::taken(std::size_t index, const PixelRect& rect) const {
  std::vector<PixelRect> parts;
  for (std::size_t i = 0; i < index; ++i) {
    const PixelRect part = tiles_[i].rect.common(rect);
    if (!part.empty()) parts.push_back(part);
  }
  return parts;
}

std::uint64_t Survey::window_bytes(std::uint64_t pixels) const {
  // The window, one tile's part of it, and numbers of 8 bytes while a strip is converted.
  std::uint64_t largest_block = 0;
  for (const Tile& tile : tiles_) largest_block = std::max(largest_block, tile.head.block_bytes);
  return 2 * sizeof(float) * pixels + largest_block;
}

}  // namespace cornice::dem
