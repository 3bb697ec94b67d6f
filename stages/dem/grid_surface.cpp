// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/dem/grid_surface.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <mutex>
#include <utility>

#include "core/base/parallel.h"

namespace cornice::dem {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;
/// Set in the index of a place that has a second vertex; pieces are far below 2^31 vertices.
constexpr std::uint32_t kDoubledBit = 0x80000000u;
constexpr std::size_t kRowsPerTask = 16;

/// The cells around a vertex, as bits.
enum Quadrant : unsigned { kNW = 1, kNE = 2, kSE = 4, kSW = 8 };

bool has(float z) { return z == z; }
bool is_full_kind(Cell cell) { return cell == Cell::kRising || cell == Cell::kFalling; }
unsigned triangles_of(Cell cell) {
  return cell == Cell::kEmpty ? 0u : is_full_kind(cell) ? 2u : 1u;
}

struct RowFacts {
  std::uint64_t empty = 0;
  float lowest = std::numeric_limits<float>::infinity();
  float highest = -std::numeric_limits<float>::infinity();
};

RowFacts facts_of(const float* own, std::int64_t width) {
  RowFacts facts;
  for (std::int64_t i = 0; i < width; ++i) {
    if (!has(own[i])) {
      ++facts.empty;
    } else {
      facts.lowest = std::min(facts.lowest, own[i]);
      facts.highest = std::max(facts.highest, own[i]);
    }
  }
  return facts;
}

}  // namespace

GridSurface::GridSurface(HeightWindow window, int threads)
    : window_(std::move(window)),
      width_(window_.own.width),
      height_(window_.own.height),
      stride_(HeightWindow::rect_for(window_.own).width) {
  cells_.resize(static_cast<std::size_t>(width_ * height_));
  const auto rows = static_cast<std::size_t>(height_);
  parallel_for(rows, kRowsPerTask, threads, [&](std::size_t begin, std::size_t end) {
    std::vector<double> scratch;
    for (std::size_t row = begin; row < end; ++row) {
      decide_row(static_cast<std::int64_t>(row), scratch);
    }
  });
  clear_taken();
  number_vertices(threads);
  // The lower left corner of a cell is its own pixel: vertex row 1 is the first own one.
  const RowFacts facts = parallel_reduce(
      rows, kRowsPerTask, threads, RowFacts{},
      [&](std::size_t begin, std::size_t end) {
        RowFacts part;
        for (std::size_t row = begin; row < end; ++row) {
          const RowFacts f = facts_of(heights_row(static_cast<std::int64_t>(row) + 1), width_);
          part = {part.empty + f.empty, std::min(part.lowest, f.lowest),
                  std::max(part.highest, f.highest)};
        }
        return part;
      },
      [](RowFacts& all, const RowFacts& part) {
        all = {all.empty + part.empty, std::min(all.lowest, part.lowest),
               std::max(all.highest, part.highest)};
      });
  empty_pixels_ = facts.empty;
  lowest_ = facts.lowest, highest_ = facts.highest;
}

bool GridSurface::is_full(std::int64_t col, std::int64_t row) const {
  const float* upper = heights_row(row) + col;
  const float* lower = heights_row(row + 1) + col;
  return has(upper[0]) && has(upper[1]) && has(lower[0]) && has(lower[1]);
}

// A cell with three heights gets its triangle where full cells stand behind both of its legs. So
// no triangle hangs by one edge or a corner, the rim of a hole has no dents of half a pixel, and
// the surface as a whole is a manifold: two full cells that touch in a corner are always joined on
// both sides. What a cell gets depends on heights alone, not on the piece that it is in.
//
//      F---F---F
//      | F | F |       . has no height: its cell gets the triangle that F and F lean on
//      F---F---F
//      | F |  /
//      F---F   .
Cell GridSurface::three_corners(std::int64_t col, std::int64_t row, Cell missing) const {
  const bool leg_is_north = missing == Cell::kWithoutSW || missing == Cell::kWithoutSE;
  const bool leg_is_west = missing == Cell::kWithoutNE || missing == Cell::kWithoutSE;
  const std::int64_t beside_row = leg_is_north ? row - 1 : row + 1;
  const std::int64_t beside_col = leg_is_west ? col - 1 : col + 1;
  return is_full(col, beside_row) && is_full(beside_col, row) ? missing : Cell::kEmpty;
}

void GridSurface::decide_row(std::int64_t row, std::vector<double>& scratch) {
  const float* z0 = heights_row(row - 1) - 1;
  const float* z1 = heights_row(row) - 1;
  const float* z2 = heights_row(row + 1) - 1;
  const float* z3 = heights_row(row + 2) - 1;
  // Keys' weights half-way between samples are (-1, 9, 9, -1) / 16, first down the columns.
  scratch.resize(static_cast<std::size_t>(width_ + 3));
  for (std::int64_t i = 0; i < width_ + 3; ++i) {
    scratch[static_cast<std::size_t>(i)] =
        9.0 * (static_cast<double>(z1[i]) + static_cast<double>(z2[i])) -
        (static_cast<double>(z0[i]) + static_cast<double>(z3[i]));
  }
  const double* v = scratch.data();
  Cell* cells = cells_.data() + row * width_;
  for (std::int64_t i = 0; i < width_; ++i) {
    const double nw = z1[i + 1], ne = z1[i + 2], sw = z2[i + 1], se = z2[i + 2];
    const double centre = 9.0 * (v[i + 1] + v[i + 2]) - (v[i] + v[i + 3]);  // times 256
    const double rising = std::abs(128.0 * (sw + ne) - centre);
    const double falling = std::abs(128.0 * (nw + se) - centre);
    cells[i] = rising <= falling ? Cell::kRising : Cell::kFalling;
    if (centre == centre) continue;
    const int missing = !has(z1[i + 1]) + !has(z1[i + 2]) + !has(z2[i + 1]) + !has(z2[i + 2]);
    if (missing == 0) {
      // Beside a hole or the survey's edge the centre is not known: the flatter diagonal.
      cells[i] = std::abs(sw - ne) <= std::abs(nw - se) ? Cell::kRising : Cell::kFalling;
    } else if (missing == 1) {
      cells[i] = three_corners(i, row,
                               !has(z1[i + 1])   ? Cell::kWithoutNW
                               : !has(z1[i + 2]) ? Cell::kWithoutNE
                               : !has(z2[i + 1]) ? Cell::kWithoutSW
                                                 : Cell::kWithoutSE);
    } else {
      cells[i] = Cell::kEmpty;
    }
  }
}

void GridSurface::clear_taken() {
  for (const PixelRect& taken : window_.taken) {
    const PixelRect part = taken.common(window_.own);
    for (std::int64_t row = 0; row < part.height; ++row) {
      Cell* from = cells_.data() + (part.row - window_.own.row + row) * width_ +
                   (part.col - window_.own.col);
      std::fill(from, from + part.width, Cell::kEmpty);
    }
  }
}

/// Bits of the quadrants of a vertex's second fan of triangles; 0 where it has one fan or none. Two
/// cells are of one fan where they share an edge from the vertex.
std::uint8_t GridSurface::second_fan(std::int64_t col, std::int64_t row) const {
  const std::array<Cell, 4> cells{cell_at(col - 1, row - 1), cell_at(col, row - 1),
                                  cell_at(col, row), cell_at(col - 1, row)};
  // The vertex is the SE, SW, NW, NE corner of these.
  constexpr std::array<Cell, 4> kWithoutVertex{Cell::kWithoutSE, Cell::kWithoutSW, Cell::kWithoutNW,
                                               Cell::kWithoutNE};
  const float* here = heights_row(row) + col;
  const std::array<bool, 4> edge_after{has(here[-stride_]), has(here[1]), has(here[stride_]),
                                       has(here[-1])};
  std::array<bool, 4> there{};
  for (std::size_t q = 0; q < 4; ++q) {
    there[q] = cells[q] != Cell::kEmpty && cells[q] != kWithoutVertex[q];
  }
  // The first fan: from the first cell on in both directions.
  std::size_t first = 0;
  while (first < 4 && !there[first]) ++first;
  if (first == 4) return 0;
  std::uint8_t fan = static_cast<std::uint8_t>(1u << first);
  for (std::size_t q = first; edge_after[q % 4] && there[(q + 1) % 4] && q < first + 3; ++q) {
    fan = static_cast<std::uint8_t>(fan | (1u << ((q + 1) % 4)));
  }
  for (std::size_t q = first + 4; edge_after[(q - 1) % 4] && there[(q - 1) % 4] && q > first + 1;
       --q) {
    fan = static_cast<std::uint8_t>(fan | (1u << ((q - 1) % 4)));
  }
  std::uint8_t rest = 0;
  for (std::size_t q = 0; q < 4; ++q) {
    if (there[q] && (fan & (1u << q)) == 0) rest = static_cast<std::uint8_t>(rest | (1u << q));
  }
  return rest;
}

/// Marks the places of one row that have a vertex with 0, or with the bit of doubled ones.
std::uint64_t GridSurface::count_vertices(std::int64_t row, std::vector<Double>& doubles) {
  std::uint32_t* index = index_.data() + row * (width_ + 1);
  std::uint64_t count = 0;
  for (std::int64_t col = 0; col <= width_; ++col) {
    const std::array<Cell, 4> cells{cell_at(col - 1, row - 1), cell_at(col, row - 1),
                                    cell_at(col - 1, row), cell_at(col, row)};
    const auto full = std::count_if(cells.begin(), cells.end(), is_full_kind);
    bool used = full > 0;
    if (full < 4) {
      used = used || (cells[0] != Cell::kEmpty && cells[0] != Cell::kWithoutSE) ||
             (cells[1] != Cell::kEmpty && cells[1] != Cell::kWithoutSW) ||
             (cells[2] != Cell::kEmpty && cells[2] != Cell::kWithoutNE) ||
             (cells[3] != Cell::kEmpty && cells[3] != Cell::kWithoutNW);
      const std::uint8_t second = used ? second_fan(col, row) : std::uint8_t{0};
      if (second != 0) {
        doubles.push_back({static_cast<std::size_t>(row * (width_ + 1) + col), second});
        index[col] = kDoubledBit;
        ++count;
        continue;
      }
    }
    index[col] = used ? 0u : kNone;
    count += used ? 1u : 0u;
  }
  return count;
}

void GridSurface::number_row(std::int64_t row) {
  std::uint32_t* index = index_.data() + row * (width_ + 1);
  auto next = static_cast<std::uint32_t>(first_vertex_[static_cast<std::size_t>(row)]);
  for (std::int64_t col = 0; col <= width_; ++col) {
    if (index[col] != kNone) index[col] |= next++;
  }
}

void GridSurface::number_vertices(int threads) {
  const auto rows = static_cast<std::size_t>(height_) + 1;
  index_.resize(rows * static_cast<std::size_t>(width_ + 1));
  first_vertex_.assign(rows + 1, 0);
  first_triangle_.assign(rows, 0);
  std::vector<std::vector<Double>> doubles((rows + kRowsPerTask - 1) / kRowsPerTask);
  parallel_for(rows, kRowsPerTask, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      first_vertex_[row + 1] =
          count_vertices(static_cast<std::int64_t>(row), doubles[begin / kRowsPerTask]);
      if (row + 1 == rows) continue;
      std::uint64_t triangles = 0;
      const Cell* cells = cells_.data() + row * static_cast<std::size_t>(width_);
      for (std::int64_t col = 0; col < width_; ++col) triangles += triangles_of(cells[col]);
      first_triangle_[row + 1] = triangles;
    }
  });
  for (std::size_t row = 0; row < rows; ++row) {
    first_vertex_[row + 1] += first_vertex_[row];
    if (row + 1 < rows) first_triangle_[row + 1] += first_triangle_[row];
  }
  for (const std::vector<Double>& part : doubles) {
    doubles_.insert(doubles_.end(), part.begin(), part.end());
  }
  first_double_ = first_vertex_.back();
  first_vertex_.push_back(first_double_ + doubles_.size());
  parallel_for(rows, kRowsPerTask, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) number_row(static_cast<std::int64_t>(row));
  });
}

void GridSurface::vertex_record(std::int64_t col, std::int64_t row, const VertexPlaces& places,
                                std::uint8_t* to) const {
  const float* z = heights_row(row) + col;
  const float here = z[0];
  // Slopes by central differences, one-sided where a side has no height.
  const auto slope = [&](float before, float after) {
    const bool both = has(before) && has(after);
    const float rise = (has(after) ? after : here) - (has(before) ? before : here);
    return rise / (both ? 2.0f * places.step : places.step);
  };
  const float to_east = slope(z[-1], z[1]);
  const float to_north = slope(z[stride_], z[-stride_]);
  const float up = 1.0f / std::sqrt(to_east * to_east + to_north * to_north + 1.0f);
  const std::array<float, 6> record{places.east[static_cast<std::size_t>(col)],
                                    places.north[static_cast<std::size_t>(row)],
                                    here,
                                    -to_east * up,
                                    -to_north * up,
                                    up};
  static_assert(sizeof(record) == kVertexBytes && std::endian::native == std::endian::little);
  std::memcpy(to, record.data(), sizeof(record));
}

void GridSurface::vertex_records(std::int64_t begin, std::int64_t end, const VertexPlaces& places,
                                 std::uint8_t* to) const {
  for (std::int64_t row = begin; row < std::min(end, vertex_rows()); ++row) {
    const std::uint32_t* index = index_.data() + row * (width_ + 1);
    for (std::int64_t col = 0; col <= width_; ++col) {
      if (index[col] == kNone) continue;
      vertex_record(col, row, places, to);
      to += kVertexBytes;
    }
  }
  if (end <= vertex_rows()) return;
  for (const Double& twin : doubles_) {
    const auto place = static_cast<std::int64_t>(twin.place);
    vertex_record(place % (width_ + 1), place / (width_ + 1), places, to);
    to += kVertexBytes;
  }
}

std::uint32_t GridSurface::index_for(std::int64_t col, std::int64_t row, unsigned quadrant) const {
  const auto place = static_cast<std::size_t>(row * (width_ + 1) + col);
  const std::uint32_t index = index_[place];
  if ((index & kDoubledBit) == 0 || index == kNone) return index;
  const auto twin = std::lower_bound(doubles_.begin(), doubles_.end(), place,
                                     [](const Double& d, std::size_t p) { return d.place < p; });
  return (twin->quadrants & quadrant) == 0
             ? index & ~kDoubledBit
             : static_cast<std::uint32_t>(first_double_ +
                                          static_cast<std::uint64_t>(twin - doubles_.begin()));
}

void GridSurface::triangle_records(std::int64_t begin, std::int64_t end, std::uint8_t* to) const {
  const auto put = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const std::array<std::uint32_t, 3> corners{a, b, c};
    to[0] = 3;
    std::memcpy(to + 1, corners.data(), 12);
    to += kTriangleBytes;
  };
  for (std::int64_t row = begin; row < end; ++row) {
    const Cell* cells = cells_.data() + row * width_;
    for (std::int64_t col = 0; col < width_; ++col) {
      const Cell cell = cells[col];
      if (cell == Cell::kEmpty) continue;
      // The cell is the SE quadrant of its NW corner, and so on.
      const std::uint32_t nw = index_for(col, row, kSE), ne = index_for(col + 1, row, kSW);
      const std::uint32_t sw = index_for(col, row + 1, kNE), se = index_for(col + 1, row + 1, kNW);
      switch (cell) {
        case Cell::kRising:
          put(sw, se, ne);
          put(sw, ne, nw);
          break;
        case Cell::kFalling:
          put(sw, se, nw);
          put(se, ne, nw);
          break;
        case Cell::kWithoutNW:
          put(sw, se, ne);
          break;
        case Cell::kWithoutNE:
          put(sw, se, nw);
          break;
        case Cell::kWithoutSW:
          put(se, ne, nw);
          break;
        default:
          put(sw, ne, nw);
      }
    }
  }
}

Mesh whole_mesh(const GridSurface& surface, const VertexPlaces& places, int threads) {
  Mesh mesh;
  const auto vertices = static_cast<std::size_t>(surface.vertices());
  const auto triangles = static_cast<std::size_t>(surface.triangles());
  mesh.positions.resize(vertices);
  mesh.normals.resize(vertices);
  mesh.triangles.resize(triangles);
  const auto rows = static_cast<std::size_t>(surface.vertex_rows()) + 1;
  parallel_for(rows, kRowsPerTask, threads, [&](std::size_t begin, std::size_t end) {
    const auto from = static_cast<std::int64_t>(begin), to = static_cast<std::int64_t>(end);
    const auto first = static_cast<std::size_t>(surface.vertices_before(from));
    const auto last = static_cast<std::size_t>(surface.vertices_before(to));
    std::vector<std::uint8_t> records((last - first) * GridSurface::kVertexBytes);
    surface.vertex_records(from, to, places, records.data());
    for (std::size_t v = first; v < last; ++v) {
      const std::uint8_t* record = records.data() + (v - first) * GridSurface::kVertexBytes;
      std::memcpy(&mesh.positions[v], record, sizeof(Vec3f));
      std::memcpy(&mesh.normals[v], record + sizeof(Vec3f), sizeof(Vec3f));
    }
  });
  parallel_for(rows - 2, kRowsPerTask, threads, [&](std::size_t begin, std::size_t end) {
    const auto from = static_cast<std::int64_t>(begin), to = static_cast<std::int64_t>(end);
    const auto first = static_cast<std::size_t>(surface.triangles_before(from));
    const auto last = static_cast<std::size_t>(surface.triangles_before(to));
    std::vector<std::uint8_t> records((last - first) * GridSurface::kTriangleBytes);
    surface.triangle_records(from, to, records.data());
    for (std::size_t t = first; t < last; ++t) {
      std::memcpy(mesh.triangles[t].data(),
                  records.data() + (t - first) * GridSurface::kTriangleBytes + 1, 12);
    }
  });
  return mesh;
}

}  // namespace cornice::dem
