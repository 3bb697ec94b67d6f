// SPDX-License-Identifier: GPL-3.0-or-later
// Turk 1994, "The PLY Polygon File Format". docs/formats/ply.md says what we make of it.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/io/ply.h"
#include "core/io/ply_header.h"
#include "core/io/ply_stream.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;

// Records that stay in the first-level cache while their columns are taken apart.
constexpr std::size_t kBlockRecords = 1024;
// Above this a float cannot hold two millimetres any more.
constexpr double kLargestFloatCoordinateM = 16384.0;

static_assert(std::endian::native == std::endian::little, "binary values are copied as they are");
static_assert(sizeof(Vec3f) == 12 && sizeof(std::array<std::uint32_t, 3>) == 12);

/// The vertex element of a file.
struct Vertices {
  std::vector<Vec3f> positions;
  std::vector<Vec3d> wide_positions;  ///< instead of positions, where the file has them wider
  std::vector<Vec3f> normals;
  std::vector<FloatProperty> floats;
  std::vector<ByteProperty> bytes;
  std::vector<std::uint16_t> line_id;
};

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

Vertices read_vertices(const fs::path& path, PlyStream& stream, const PlyHeader& header,
                       const PlyElement& element) {
  Vertices vertices;
  const VertexLayout layout(path, header, element, vertices);
  const auto count = static_cast<std::size_t>(element.count);
  if (header.format == PlyFormat::kAscii || element.has_lists()) {
    for (std::size_t row = 0; row < count; ++row) {
      stream.at(element.name, row);
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
    stream.at(element.name, row);
    read_block(layout.columns(), stream.bytes(rows * record_bytes), record_bytes, row, rows,
               header.format == PlyFormat::kBigEndian);
  }
  return vertices;
}

bool is_finite(Vec3d v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

[[noreturn]] void refuse(const fs::path& path, std::size_t row, const char* what) {
  throw InputError(path.string(),
                   "vertex " + std::to_string(row) + " has a " + what + " that is not finite");
}

/// Turns wide positions into floats, relative to a nearer origin where a float is too coarse for
/// them, and refuses what is not finite.
void settle_positions(const fs::path& path, Vertices& vertices, Vec3d& origin) {
  Box3d bounds;
  for (std::size_t i = 0; i < vertices.wide_positions.size(); ++i) {
    if (!is_finite(vertices.wide_positions[i])) refuse(path, i, "position");
    bounds.add(vertices.wide_positions[i]);
  }
  Vec3d shift;
  if (!bounds.empty()) {
    const double largest =
        std::max({std::abs(bounds.min.x), std::abs(bounds.min.y), std::abs(bounds.min.z),
                  std::abs(bounds.max.x), std::abs(bounds.max.y), std::abs(bounds.max.z)});
    if (largest > kLargestFloatCoordinateM) {
      shift = {std::floor(bounds.min.x), std::floor(bounds.min.y), std::floor(bounds.min.z)};
    }
  }
  origin += shift;
  if (!vertices.wide_positions.empty()) vertices.positions.resize(vertices.wide_positions.size());
  for (std::size_t i = 0; i < vertices.wide_positions.size(); ++i) {
    vertices.positions[i] = (vertices.wide_positions[i] - shift).cast<float>();
  }
  for (std::size_t i = 0; i < vertices.positions.size(); ++i) {
    if (!is_finite(vertices.positions[i].cast<double>())) refuse(path, i, "position");
  }
  for (std::size_t i = 0; i < vertices.normals.size(); ++i) {
    if (!is_finite(vertices.normals[i].cast<double>())) refuse(path, i, "normal");
  }
  vertices.wide_positions = {};
}

/// Reads the face element into triangles.
class FaceReader {
 public:
  using Triangles = std::vector<std::array<std::uint32_t, 3>>;

  FaceReader(PlyStream& stream, const PlyElement& element, std::uint64_t vertex_count,
             bool little_endian)
      : stream_(stream), element_(element), vertex_count_(vertex_count) {
    const auto found = element.find({"vertex_indices", "vertex_index"});
    stream.at(element.name, 0);
    if (!found || !element.properties[*found].is_list()) {
      stream.fail("the faces have no list vertex_indices");
    }
    list_ = *found;
    const PlyProperty& list = element.properties[list_];
    is_common_ = little_endian && element.properties.size() == 1 &&
                 ply_size(*list.list_count) == 1 &&
                 (list.type == PlyType::kInt32 || list.type == PlyType::kUint32);
  }

  Triangles read() {
    triangles_.reserve(static_cast<std::size_t>(element_.count));
    std::uint64_t face = 0;
    while (face < element_.count) {
      const std::uint64_t common = is_common_ ? read_common(face) : 0;
      face += common;
      if (face < element_.count && common == 0) read_any(face++);
    }
    return std::move(triangles_);
  }

 private:
  /// Triangles of one byte and three 32-bit indices, as many as are in the buffer.
  std::uint64_t read_common(std::uint64_t first_face) {
    constexpr std::size_t kBytes = 13;
    const std::span<const std::uint8_t> buffer = stream_.peek(kBytes);
    const std::uint64_t most =
        std::min<std::uint64_t>(buffer.size() / kBytes, element_.count - first_face);
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

  void read_any(std::uint64_t face) {
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
  void read_polygon(const PlyProperty& list) {
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

  std::uint32_t read_index(PlyType type) {
    const double index = stream_.number(type);
    if (!(index >= 0.0 && index < static_cast<double>(vertex_count_)) ||
        index != std::floor(index)) {
      stream_.fail("a face refers to a vertex that is not there; there are " +
                   std::to_string(vertex_count_));
    }
    return static_cast<std::uint32_t>(index);
  }

  PlyStream& stream_;
  const PlyElement& element_;
  const std::uint64_t vertex_count_;
  std::size_t list_ = 0;
  bool is_common_ = false;
  Triangles triangles_;
};

void skip_element(PlyStream& stream, const PlyElement& element) {
  for (std::uint64_t row = 0; row < element.count; ++row) {
    stream.at(element.name, row);
    for (const PlyProperty& property : element.properties) stream.skip(property);
  }
}

struct Contents {
  PlyHeader header;
  Vertices vertices;
  FaceReader::Triangles triangles;
};

const PlyElement* element_named(const PlyHeader& header, const char* name) {
  for (const PlyElement& element : header.elements) {
    if (element.name == name) return &element;
  }
  return nullptr;
}

Contents read_contents(const fs::path& path, bool with_faces) {
  Contents contents;
  contents.header = read_ply_header(path);
  const PlyHeader& header = contents.header;
  const PlyElement* vertex = element_named(header, "vertex");
  const PlyElement* face = with_faces ? element_named(header, "face") : nullptr;
  if (vertex == nullptr) throw InputError(path.string(), "has no vertices");
  if (with_faces && face == nullptr && element_named(header, "tristrips") != nullptr) {
    throw InputError(path.string(), "holds triangle strips; save it with faces");
  }
  if (vertex->count > std::numeric_limits<std::uint32_t>::max()) {
    throw InputError(path.string(), "has more vertices than 32 bits can count");
  }
  PlyStream stream(path, header);
  std::size_t wanted = face == nullptr ? 1 : 2;
  for (const PlyElement& element : header.elements) {
    if (&element == vertex) {
      contents.vertices = read_vertices(path, stream, header, element);
    } else if (&element == face) {
      contents.triangles =
          FaceReader(stream, element, vertex->count, header.format == PlyFormat::kLittleEndian)
              .read();
    } else {
      skip_element(stream, element);
      continue;
    }
    if (--wanted == 0) break;
  }
  settle_positions(path, contents.vertices, contents.header.origin);
  return contents;
}

}  // namespace

Mesh read_ply_mesh(const fs::path& path) {
  Contents contents = read_contents(path, true);
  Mesh mesh;
  mesh.origin = contents.header.origin;
  mesh.crs_text = std::move(contents.header.crs_text);
  mesh.positions = std::move(contents.vertices.positions);
  mesh.normals = std::move(contents.vertices.normals);
  mesh.float_properties = std::move(contents.vertices.floats);
  mesh.byte_properties = std::move(contents.vertices.bytes);
  if (!contents.vertices.line_id.empty()) {
    const auto& ids = contents.vertices.line_id;
    mesh.float_properties.push_back({"line_id", std::vector<float>(ids.begin(), ids.end())});
  }
  mesh.triangles = std::move(contents.triangles);
  return mesh;
}

OrientedPoints read_ply_points(const fs::path& path) {
  Contents contents = read_contents(path, false);
  if (contents.vertices.normals.empty() && !contents.vertices.positions.empty()) {
    throw InputError(path.string(), "its points have no normals nx, ny and nz");
  }
  OrientedPoints points;
  points.origin = contents.header.origin;
  points.crs_text = std::move(contents.header.crs_text);
  points.positions = std::move(contents.vertices.positions);
  points.normals = std::move(contents.vertices.normals);
  for (FloatProperty& property : contents.vertices.floats) {
    if (property.name == "quality" && points.quality.empty()) {
      points.quality = std::move(property.values);
    } else {
      points.float_properties.push_back(std::move(property));
    }
  }
  points.byte_properties = std::move(contents.vertices.bytes);
  points.line_id = std::move(contents.vertices.line_id);
  return points;
}

}  // namespace cornice
