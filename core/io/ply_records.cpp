// SPDX-License-Identifier: GPL-3.0-or-later
// Turk 1994, "The PLY Polygon File Format". docs/formats/ply.md says what we make of it.
#include "core/io/ply_records.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>

#include "core/base/error.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;
using Vertices = PlyVertices;

// Records that stay in the first-level cache while their columns are taken apart.
constexpr std::size_t kBlockRecords = 1024;
// Above this a float cannot hold two millimetres any more.
constexpr double kLargestFloatCoordinateM = 16384.0;

static_assert(std::endian::native == std::endian::little, "binary values are copied as they are");
static_assert(sizeof(Vec3f) == 12 && sizeof(std::array<std::uint32_t, 3>) == 12);

/// Where the values of one property go: every `step` bytes from `to` on.
struct Column {
  PlyProperty property;
  PlyType to_type = PlyType::kFloat32;
  void* to = nullptr;
  bool is_kept = false;  ///< false: the property is passed over
  std::size_t step = 0;
  std::size_t offset = 0;  ///< in the record; of fixed-size records only
};

void store(const Column& column, std::size_t row, double value) {
  auto* at = static_cast<std::uint8_t*>(column.to) + row * column.step;
  const auto put = [&](auto typed) { std::memcpy(at, &typed, sizeof typed); };
  switch (column.to_type) {
    case PlyType::kUint8:
      return put(static_cast<std::uint8_t>(value));
    case PlyType::kUint16:
      return put(static_cast<std::uint16_t>(value));
    case PlyType::kFloat64:
      return put(value);
    default:
      // Values beyond float become infinite, which is refused where it matters.
      return put(static_cast<float>(value));
  }
}

bool is_wide(const PlyHeader& header, PlyType type) {
  return header.format == PlyFormat::kAscii || ply_size(type) > 4 ||
         (type != PlyType::kFloat32 && ply_size(type) == 4);
}

/// Makes room in `vertices` for every property and says where it goes.
class VertexLayout {
 public:
  VertexLayout(const fs::path& path, const PlyHeader& header, const PlyElement& element,
               Vertices& vertices)
      : element_(element), vertices_(vertices), columns_(element.properties.size()) {
    std::size_t offset = 0;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      columns_[i].property = element.properties[i];
      columns_[i].offset = offset;
      offset += ply_size(element.properties[i].list_count.value_or(element.properties[i].type));
    }
    place_positions(path, header);
    place_normals();
    // Growing vectors of properties would move what columns point to.
    vertices_.floats.reserve(columns_.size());
    vertices_.bytes.reserve(columns_.size());
    for (Column& column : columns_) place_other(column);
  }

  const std::vector<Column>& columns() const { return columns_; }

 private:
  std::size_t count() const { return static_cast<std::size_t>(element_.count); }

  template <class T>
  void place_triple(const std::array<std::size_t, 3>& at, std::vector<Vec3<T>>& to, PlyType type) {
    to.resize(count());
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Column& column = columns_[at[axis]];
      column.to_type = type;
      column.to = reinterpret_cast<std::uint8_t*>(to.data()) + axis * sizeof(T);
      column.step = sizeof(Vec3<T>);
      column.is_kept = true;
    }
  }

  void place_positions(const fs::path& path, const PlyHeader& header) {
    const std::array<std::optional<std::size_t>, 3> found{
        element_.find({"x"}), element_.find({"y"}), element_.find({"z"})};
    bool wide = false;
    for (const auto& index : found) {
      if (!index || element_.properties[*index].is_list()) {
        throw InputError(path.string(), "its vertices have no coordinates x, y and z");
      }
      wide = wide || is_wide(header, element_.properties[*index].type);
    }
    const std::array<std::size_t, 3> at{*found[0], *found[1], *found[2]};
    if (wide) {
      place_triple(at, vertices_.wide_positions, PlyType::kFloat64);
    } else {
      place_triple(at, vertices_.positions, PlyType::kFloat32);
    }
  }

  void place_normals() {
    const auto x = element_.find({"nx", "normal_x"});
    const auto y = element_.find({"ny", "normal_y"});
    const auto z = element_.find({"nz", "normal_z"});
    for (const auto& index : {x, y, z}) {
      if (!index || element_.properties[*index].is_list()) return;
    }
    place_triple({*x, *y, *z}, vertices_.normals, PlyType::kFloat32);
  }

  void place_other(Column& column) {
    const PlyProperty& property = column.property;
    if (column.is_kept || property.is_list()) return;
    if (property.name == "line_id" && property.type == PlyType::kUint16) {
      vertices_.line_id.resize(count());
      set(column, vertices_.line_id.data(), PlyType::kUint16);
    } else if (property.type == PlyType::kUint8) {
      vertices_.bytes.push_back({property.name, std::vector<std::uint8_t>(count())});
      set(column, vertices_.bytes.back().values.data(), PlyType::kUint8);
    } else {
      vertices_.floats.push_back({property.name, std::vector<float>(count())});
      set(column, vertices_.floats.back().values.data(), PlyType::kFloat32);
    }
  }

  template <class T>
  static void set(Column& column, T* to, PlyType type) {
    column.to = to;
    column.to_type = type;
    column.step = sizeof(T);
    column.is_kept = true;
  }

  const PlyElement& element_;
  Vertices& vertices_;
  std::vector<Column> columns_;
};

/// Copies one column of a block as it is, `bytes` from every record.
template <std::size_t bytes>
void copy_column(const std::uint8_t* from, std::size_t from_step, std::uint8_t* to,
                 std::size_t to_step, std::size_t rows) {
  for (std::size_t row = 0; row < rows; ++row) {
    std::memcpy(to + row * to_step, from + row * from_step, bytes);
  }
}

/// Number of columns from `first` on that are x, y, z of one vector and may be copied together.
bool is_triple(const std::vector<Column>& columns, std::size_t first) {
  if (first + 2 >= columns.size() || columns[first].step != sizeof(Vec3f)) return false;
  const auto* to = static_cast<const std::uint8_t*>(columns[first].to);
  for (std::size_t i = 1; i < 3; ++i) {
    const Column& column = columns[first + i];
    if (column.to != to + 4 * i || column.property.type != PlyType::kFloat32) return false;
  }
  return true;
}

void read_block(const std::vector<Column>& columns, const std::uint8_t* records,
                std::size_t record_bytes, std::size_t first_row, std::size_t rows,
                bool swap_bytes) {
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const Column& column = columns[c];
    if (!column.is_kept) continue;
    const std::uint8_t* from = records + column.offset;
    auto* to = static_cast<std::uint8_t*>(column.to) + first_row * column.step;
    const bool same = column.to_type == column.property.type && !swap_bytes;
    if (same && column.to_type == PlyType::kFloat32 && is_triple(columns, c)) {
      copy_column<12>(from, record_bytes, to, column.step, rows);
      c += 2;
    } else if (same && ply_size(column.to_type) == 4) {
      copy_column<4>(from, record_bytes, to, column.step, rows);
    } else if (same && ply_size(column.to_type) == 2) {
      copy_column<2>(from, record_bytes, to, column.step, rows);
    } else if (column.to_type == column.property.type && ply_size(column.to_type) == 1) {
      copy_column<1>(from, record_bytes, to, column.step, rows);
    } else {
      for (std::size_t row = 0; row < rows; ++row) {
        store(column, first_row + row,
              ply_value(from + row * record_bytes, column.property.type, swap_bytes));
      }
    }
  }
}

bool is_finite(Vec3d v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

[[noreturn]] void refuse(const fs::path& path, std::uint64_t row, const char* what) {
  throw InputError(path.string(),
                   "vertex " + std::to_string(row) + " has a " + what + " that is not finite");
}

}  // namespace

bool ply_positions_are_wide(const PlyHeader& header, const PlyElement& element) {
  for (const char* axis : {"x", "y", "z"}) {
    const auto found = element.find({axis});
    if (found && is_wide(header, element.properties[*found].type)) return true;
  }
  return false;
}

PlyVertices read_ply_vertices(const fs::path& path, PlyStream& stream, const PlyHeader& header,
                              const PlyElement& element, std::uint64_t first_row) {
  Vertices vertices;
  const VertexLayout layout(path, header, element, vertices);
  const auto count = static_cast<std::size_t>(element.count);
  if (header.format == PlyFormat::kAscii || element.has_lists()) {
    for (std::size_t row = 0; row < count; ++row) {
      stream.at(element.name, first_row + row);
      for (const Column& column : layout.columns()) {
        if (!column.is_kept) {
          stream.skip(column.property);
        } else {
          store(column, row, stream.number(column.property.type));
        }
      }
    }
    return vertices;
  }
  const std::size_t record_bytes = element.record_bytes();
  for (std::size_t row = 0; row < count; row += kBlockRecords) {
    const std::size_t rows = std::min(kBlockRecords, count - row);
    stream.at(element.name, first_row + row);
    read_block(layout.columns(), stream.bytes(rows * record_bytes), record_bytes, row, rows,
               header.format == PlyFormat::kBigEndian);
  }
  return vertices;
}

void add_to_box(const fs::path& path, const PlyVertices& vertices, std::uint64_t first_row,
                Box3d& box) {
  for (std::size_t i = 0; i < vertices.wide_positions.size(); ++i) {
    if (!is_finite(vertices.wide_positions[i])) refuse(path, first_row + i, "position");
    box.add(vertices.wide_positions[i]);
  }
}

Vec3d shift_for_floats(const Box3d& box) {
  if (box.empty()) return {};
  const double largest = std::max({std::abs(box.min.x), std::abs(box.min.y), std::abs(box.min.z),
                                   std::abs(box.max.x), std::abs(box.max.y), std::abs(box.max.z)});
  if (largest <= kLargestFloatCoordinateM) return {};
  return {std::floor(box.min.x), std::floor(box.min.y), std::floor(box.min.z)};
}

void settle_positions(const fs::path& path, PlyVertices& vertices, const Vec3d& shift,
                      std::uint64_t first_row) {
  if (!vertices.wide_positions.empty()) vertices.positions.resize(vertices.wide_positions.size());
  for (std::size_t i = 0; i < vertices.wide_positions.size(); ++i) {
    vertices.positions[i] = (vertices.wide_positions[i] - shift).cast<float>();
  }
  for (std::size_t i = 0; i < vertices.positions.size(); ++i) {
    if (!is_finite(vertices.positions[i].cast<double>())) refuse(path, first_row + i, "position");
  }
  for (std::size_t i = 0; i < vertices.normals.size(); ++i) {
    if (!is_finite(vertices.normals[i].cast<double>())) refuse(path, first_row + i, "normal");
  }
  vertices.wide_positions = {};
}

Mesh mesh_of_vertices(PlyVertices vertices, const Vec3d& origin, std::string crs_text) {
  Mesh mesh;
  mesh.origin = origin;
  mesh.crs_text = std::move(crs_text);
  mesh.positions = std::move(vertices.positions);
  mesh.normals = std::move(vertices.normals);
  mesh.float_properties = std::move(vertices.floats);
  mesh.byte_properties = std::move(vertices.bytes);
  if (!vertices.line_id.empty()) {
    const auto& ids = vertices.line_id;
    mesh.float_properties.push_back({"line_id", std::vector<float>(ids.begin(), ids.end())});
  }
  return mesh;
}

PlyFaceReader::PlyFaceReader(PlyStream& stream, const PlyElement& element,
                             std::uint64_t vertex_count, bool little_endian)
    : stream_(stream), element_(element), vertex_count_(vertex_count) {
  const auto found = element.find({"vertex_indices", "vertex_index"});
  stream.at(element.name, 0);
  if (!found || !element.properties[*found].is_list()) {
    stream.fail("the faces have no list vertex_indices");
  }
  list_ = *found;
  const PlyProperty& list = element.properties[list_];
  is_common_ = little_endian && element.properties.size() == 1 && ply_size(*list.list_count) == 1 &&
               (list.type == PlyType::kInt32 || list.type == PlyType::kUint32);
}

PlyFaceReader::Triangles PlyFaceReader::read(std::size_t limit) {
  triangles_.reserve(static_cast<std::size_t>(
      std::min<std::uint64_t>(limit, element_.count - face_ + triangles_.size())));
  while (face_ < element_.count && triangles_.size() < limit) {
    const std::uint64_t common = is_common_ ? read_common(limit - triangles_.size()) : 0;
    face_ += common;
    if (face_ < element_.count && common == 0) read_any(face_++);
  }
  if (triangles_.size() <= limit) return std::exchange(triangles_, {});
  // The rest of a polygon that went beyond the limit waits for the next call.
  const auto end = triangles_.begin() + static_cast<std::ptrdiff_t>(limit);
  Triangles rest(end, triangles_.end());
  triangles_.erase(end, triangles_.end());
  return std::exchange(triangles_, std::move(rest));
}

/// Triangles of one byte and three 32-bit indices, as many as are in the buffer.
std::uint64_t PlyFaceReader::read_common(std::size_t limit) {
  constexpr std::size_t kBytes = 13;
  const std::span<const std::uint8_t> buffer = stream_.peek(kBytes);
  const std::uint64_t most =
      std::min<std::uint64_t>({buffer.size() / kBytes, element_.count - face_, limit});
  std::uint64_t done = 0;
  for (const std::uint8_t* at = buffer.data(); done < most && *at == 3; ++done, at += kBytes) {
    std::array<std::uint32_t, 3> triangle{};
    std::memcpy(triangle.data(), at + 1, 12);
    // A negative index becomes a large one.
    if (std::max({triangle[0], triangle[1], triangle[2]}) >= vertex_count_) break;
    triangles_.push_back(triangle);
  }
  stream_.consume(static_cast<std::size_t>(done) * kBytes);
  return done;
}

void PlyFaceReader::read_any(std::uint64_t face) {
  stream_.at(element_.name, face);
  for (std::size_t i = 0; i < element_.properties.size(); ++i) {
    if (i == list_) {
      read_polygon(element_.properties[i]);
    } else {
      stream_.skip(element_.properties[i]);
    }
  }
}

/// A polygon as the fan of its first corner.
void PlyFaceReader::read_polygon(const PlyProperty& list) {
  const std::size_t corners = stream_.list_length(list);
  if (corners < 3)
    stream_.fail("a face has " + std::to_string(corners) + " corners, not 3 or more");
  const std::uint32_t apex = read_index(list.type);
  std::uint32_t before = read_index(list.type);
  for (std::size_t i = 2; i < corners; ++i) {
    const std::uint32_t corner = read_index(list.type);
    triangles_.push_back({apex, before, corner});
    before = corner;
  }
}

std::uint32_t PlyFaceReader::read_index(PlyType type) {
  const double index = stream_.number(type);
  if (!(index >= 0.0 && index < static_cast<double>(vertex_count_)) || index != std::floor(index)) {
    stream_.fail("a face refers to a vertex that is not there; there are " +
                 std::to_string(vertex_count_));
  }
  return static_cast<std::uint32_t>(index);
}

void skip_ply_element(PlyStream& stream, const PlyElement& element) {
  for (std::uint64_t row = 0; row < element.count; ++row) {
    stream.at(element.name, row);
    for (const PlyProperty& property : element.properties) stream.skip(property);
  }
}

const PlyElement* ply_element(const PlyHeader& header, const char* name) {
  for (const PlyElement& element : header.elements) {
    if (element.name == name) return &element;
  }
  return nullptr;
}

}  // namespace cornice
