// SPDX-License-Identifier: GPL-3.0-or-later
// An indexed mesh that does not fit into memory is read once for every window of its vertices that
// does: the faces go by piece by piece, and the vertices of the window that a piece uses go to the
// window's scratch file. Then pieces and scratch files are read side by side, front to back. Faces
// may name vertices in any order: no pass reads anything at random.
#include "core/io/mesh_stream.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cerrno>
#include <cstring>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/write_problem.h"
#include "core/io/ply_header.h"
#include "core/io/ply_records.h"
#include "core/io/ply_stream.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;
using Triangles = std::vector<std::array<std::uint32_t, 3>>;

/// Numbers of the vertices that some triangles use, in ascending order.
class UsedVertices {
 public:
  explicit UsedVertices(const Triangles& triangles) {
    std::uint32_t low = std::numeric_limits<std::uint32_t>::max(), high = 0;
    for (const auto& t : triangles) {
      low = std::min({low, t[0], t[1], t[2]});
      high = std::max({high, t[0], t[1], t[2]});
    }
    if (triangles.empty()) return;
    first_word_ = low / 64;
    bits_.resize(high / 64 - first_word_ + 1);
    for (const auto& t : triangles) {
      for (const std::uint32_t v : t) bits_[v / 64 - first_word_] |= bit(v);
    }
    before_.resize(bits_.size());
    for (std::size_t w = 0; w < bits_.size(); ++w) {
      before_[w] = static_cast<std::uint32_t>(count_);
      count_ += static_cast<std::size_t>(std::popcount(bits_[w]));
    }
  }

  std::size_t count() const { return count_; }
  /// Place of a used vertex among them.
  std::uint32_t place(std::uint32_t vertex) const {
    const std::size_t w = vertex / 64 - first_word_;
    return before_[w] + static_cast<std::uint32_t>(std::popcount(bits_[w] & (bit(vertex) - 1)));
  }
  /// Those in [first, last).
  std::vector<std::uint32_t> between(std::uint64_t first, std::uint64_t last) const {
    std::vector<std::uint32_t> vertices;
    const std::size_t begin = std::max<std::uint64_t>(first / 64, first_word_) - first_word_;
    for (std::size_t w = begin; w < bits_.size() && 64 * (w + first_word_) < last; ++w) {
      for (std::uint64_t left = bits_[w]; left != 0; left &= left - 1) {
        const std::uint64_t v =
            64 * (w + first_word_) + static_cast<std::uint64_t>(std::countr_zero(left));
        if (v >= first && v < last) vertices.push_back(static_cast<std::uint32_t>(v));
      }
    }
    return vertices;
  }

 private:
  static std::uint64_t bit(std::uint32_t vertex) { return std::uint64_t{1} << vertex % 64; }

  std::size_t first_word_ = 0, count_ = 0;
  std::vector<std::uint64_t> bits_;
  std::vector<std::uint32_t> before_;  ///< used vertices before each word
};

/// Calls act(values) for every array of values per vertex.
template <class Act>
void for_each_array(Mesh& mesh, const Act& act) {
  act(mesh.positions);
  act(mesh.normals);
  for (FloatProperty& p : mesh.float_properties) act(p.values);
  for (ByteProperty& p : mesh.byte_properties) act(p.values);
}

/// A mesh without vertices and triangles, with the arrays that another has.
Mesh frame_of(const Mesh& mesh) {
  Mesh frame;
  frame.origin = mesh.origin;
  frame.crs_text = mesh.crs_text;
  for (const FloatProperty& p : mesh.float_properties)
    frame.float_properties.push_back({p.name, {}});
  for (const ByteProperty& p : mesh.byte_properties) frame.byte_properties.push_back({p.name, {}});
  return frame;
}

/// Appends the named vertices of a mesh whose first vertex has the number `first`.
void append_vertices(const Mesh& from, std::uint64_t first, std::span<const std::uint32_t> vertices,
                     Mesh& to) {
  const auto append = [&](const auto& source, auto& target) {
    if (source.empty()) return;
    for (const std::uint32_t v : vertices) target.push_back(source[v - first]);
  };
  append(from.positions, to.positions);
  append(from.normals, to.normals);
  for (std::size_t i = 0; i < from.float_properties.size(); ++i) {
    append(from.float_properties[i].values, to.float_properties[i].values);
  }
  for (std::size_t i = 0; i < from.byte_properties.size(); ++i) {
    append(from.byte_properties[i].values, to.byte_properties[i].values);
  }
}

/// A file without a name: gone with the object, and with the process.
class ScratchFile {
 public:
  explicit ScratchFile(const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    std::string name = (folder / ".cornice-vertices-XXXXXX").string();
    file_ = ::mkstemp(name.data());
    if (file_ < 0) fail(name);
    ::unlink(name.c_str());
    folder_ = folder.string();
  }
  ~ScratchFile() {
    if (file_ >= 0) ::close(file_);
  }
  ScratchFile(ScratchFile&& other) noexcept
      : folder_(std::move(other.folder_)), file_(std::exchange(other.file_, -1)), at_(other.at_) {}
  ScratchFile& operator=(ScratchFile&&) = delete;
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;

  template <class T>
  void write(const std::vector<T>& values) {
    const auto* from = reinterpret_cast<const char*>(values.data());
    for (std::size_t left = values.size() * sizeof(T); left > 0;) {
      const ssize_t put = ::pwrite(file_, from, left, static_cast<off_t>(at_));
      if (put < 0 && errno == EINTR) continue;
      if (put < 0) fail(folder_);
      from += put, at_ += static_cast<std::uint64_t>(put), left -= static_cast<std::size_t>(put);
    }
  }
  /// Appends `count` values.
  template <class T>
  void read(std::vector<T>& values, std::size_t count) {
    const std::size_t old = values.size();
    values.resize(old + count);
    auto* to = reinterpret_cast<char*>(values.data() + old);
    for (std::size_t left = count * sizeof(T); left > 0;) {
      const ssize_t got = ::pread(file_, to, left, static_cast<off_t>(at_));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) fail(folder_);
      to += got, at_ += static_cast<std::uint64_t>(got), left -= static_cast<std::size_t>(got);
    }
  }
  void rewind() { at_ = 0; }

 private:
  [[noreturn]] static void fail(const std::string& name) {
    throw RunError(name, "vertices cannot be kept there: " + write_problem(errno));
  }

  std::string folder_;
  int file_ = -1;
  std::uint64_t at_ = 0;
};

class PlyMeshStream : public MeshStream {
 public:
  PlyMeshStream(fs::path path, const MeshStreamOptions& options)
      : path_(std::move(path)), options_(options), header_(read_ply_header(path_)) {
    find_elements();
    scan();
    if (windows() > 1) spill();
    rewind();
  }

  bool next(Mesh& piece) override {
    Triangles triangles = faces_ ? faces_->read(options_.piece_triangles) : Triangles{};
    if (triangles.empty()) return false;
    const UsedVertices used(triangles);
    piece = frame_;
    for (std::size_t w = 0; w < windows(); ++w) {
      const auto vertices = used.between(w * window_, (w + 1) * window_);
      if (windows() == 1) {
        append_vertices(kept_, 0, vertices, piece);
      } else {
        read_back(files_[w], vertices.size(), piece);
      }
    }
    for (auto& t : triangles) {
      for (std::uint32_t& v : t) v = used.place(v);
    }
    piece.triangles = std::move(triangles);
    return true;
  }

  void rewind() override {
    faces_.reset();
    if (face_ == nullptr) return;
    PlyHeader from = header_;
    from.header_bytes = faces_begin_;
    stream_ = std::make_unique<PlyStream>(path_, from);
    faces_ = std::make_unique<PlyFaceReader>(*stream_, *face_, vertex_->count,
                                             header_.format == PlyFormat::kLittleEndian);
    for (ScratchFile& file : files_) file.rewind();
  }

  bool is_spilled() const override { return windows() > 1; }

 private:
  std::size_t windows() const { return begins_.size(); }

  void find_elements() {
    vertex_ = ply_element(header_, "vertex");
    face_ = ply_element(header_, "face");
    if (vertex_ == nullptr) throw InputError(path_.string(), "has no vertices");
    if (face_ == nullptr && ply_element(header_, "tristrips") != nullptr) {
      throw InputError(path_.string(), "holds triangle strips; save it with faces");
    }
    if (vertex_->count > std::numeric_limits<std::uint32_t>::max()) {
      throw InputError(path_.string(), "has more vertices than 32 bits can count");
    }
    // No property takes more than 4 bytes once it is read but wide positions.
    const std::uint64_t wide = ply_positions_are_wide(header_, *vertex_) ? 24 : 0;
    window_ = std::max<std::uint64_t>(
        options_.vertex_bytes / (4 * vertex_->properties.size() + wide + 1), 1);
  }

  /// Finds where windows and faces begin, and what wide positions are relative to. Where all
  /// vertices fit into one window they are kept.
  void scan() {
    PlyStream stream(path_, header_);
    PlyVertices rows;
    int left = face_ == nullptr ? 1 : 2;
    for (const PlyElement& element : header_.elements) {
      if (&element == face_) {
        faces_begin_ = stream.offset();
        if (--left == 0) break;
      }
      if (&element != vertex_) {
        skip_ply_element(stream, element);
        continue;
      }
      Box3d box;
      for (std::uint64_t first = 0; first == 0 || first < vertex_->count; first += window_) {
        begins_.push_back(stream.offset());
        rows = {};  // before the next window's are there
        rows = read_rows(stream, first);
        add_to_box(path_, rows, first, box);
      }
      shift_ = shift_for_floats(box);
      if (--left == 0) break;
    }
    kept_ = settled(std::move(rows), (windows() - 1) * window_);
    has_normals_ = !kept_.normals.empty();
    frame_ = frame_of(kept_);
    if (windows() > 1) kept_ = {};
  }

  /// The vertices of one window, where the stream is.
  PlyVertices read_rows(PlyStream& stream, std::uint64_t first) {
    PlyElement rows = *vertex_;
    rows.count = std::min(window_, vertex_->count - first);
    PlyVertices vertices = read_ply_vertices(path_, stream, header_, rows, first);
    stream.at(vertex_->name, first + rows.count);  // `rows` is gone, the stream is not
    return vertices;
  }

  Mesh settled(PlyVertices vertices, std::uint64_t first) const {
    settle_positions(path_, vertices, shift_, first);
    return mesh_of_vertices(std::move(vertices), header_.origin + shift_, header_.crs_text);
  }

  /// Writes the vertices that pieces use, window by window.
  void spill() {
    const fs::path folder = options_.scratch.empty() ? fs::temp_directory_path() : options_.scratch;
    for (std::size_t w = 0; w < windows(); ++w) {
      PlyHeader from = header_;
      from.header_bytes = begins_[w];
      PlyStream stream(path_, from);
      const std::uint64_t first = w * window_;
      const Mesh window = settled(read_rows(stream, first), first);
      rewind();
      files_.emplace_back(folder);
      Mesh part = frame_;
      while (faces_) {
        const Triangles triangles = faces_->read(options_.piece_triangles);
        if (triangles.empty()) break;
        for_each_array(part, [](auto& values) { values.clear(); });
        const UsedVertices used(triangles);
        append_vertices(window, first, used.between(first, first + window_), part);
        for_each_array(part, [&](auto& values) { files_.back().write(values); });
      }
    }
  }

  void read_back(ScratchFile& file, std::size_t count, Mesh& piece) const {
    file.read(piece.positions, count);
    if (has_normals_) file.read(piece.normals, count);
    for (FloatProperty& p : piece.float_properties) file.read(p.values, count);
    for (ByteProperty& p : piece.byte_properties) file.read(p.values, count);
  }

  fs::path path_;
  MeshStreamOptions options_;
  PlyHeader header_;
  const PlyElement* vertex_ = nullptr;
  const PlyElement* face_ = nullptr;
  std::uint64_t window_ = 1;           ///< vertices of a window
  std::vector<std::uint64_t> begins_;  ///< of the windows, in the file
  std::uint64_t faces_begin_ = 0;
  Vec3d shift_;
  Mesh kept_;   ///< all vertices where they are one window
  Mesh frame_;  ///< a piece without vertices
  bool has_normals_ = false;
  std::vector<ScratchFile> files_;
  std::unique_ptr<PlyStream> stream_;
  std::unique_ptr<PlyFaceReader> faces_;
};

class PiecesOfMesh : public MeshStream {
 public:
  PiecesOfMesh(Mesh mesh, std::size_t piece_triangles)
      : mesh_(std::move(mesh)), piece_triangles_(piece_triangles) {}

  bool next(Mesh& piece) override {
    const std::size_t end = std::min(mesh_.triangles.size(), at_ + piece_triangles_);
    if (at_ == end) return false;
    Triangles triangles(mesh_.triangles.begin() + static_cast<std::ptrdiff_t>(at_),
                        mesh_.triangles.begin() + static_cast<std::ptrdiff_t>(end));
    at_ = end;
    const UsedVertices used(triangles);
    piece = frame_of(mesh_);
    append_vertices(mesh_, 0, used.between(0, mesh_.positions.size()), piece);
    for (auto& t : triangles) {
      for (std::uint32_t& v : t) v = used.place(v);
    }
    piece.triangles = std::move(triangles);
    return true;
  }
  void rewind() override { at_ = 0; }

 private:
  Mesh mesh_;
  std::size_t piece_triangles_, at_ = 0;
};

}  // namespace

std::unique_ptr<MeshStream> open_ply_mesh_stream(const fs::path& path,
                                                 const MeshStreamOptions& options) {
  return std::make_unique<PlyMeshStream>(path, options);
}

std::unique_ptr<MeshStream> stream_of_mesh(Mesh mesh, const MeshStreamOptions& options) {
  return std::make_unique<PiecesOfMesh>(std::move(mesh), options.piece_triangles);
}

}  // namespace cornice
