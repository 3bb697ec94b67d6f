// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/io/mesh_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "core/base/error.h"
#include "core/base/input_file.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kStlHead = 84, kStlTriangle = 50;

/// The lines of a text file, and the words of the present one.
class Lines {
 public:
  explicit Lines(const fs::path& path) : path_(path) {
    check_input_file(path);
    file_.open(path, std::ios::binary);
    if (!file_) throw InputError(path.string(), "cannot be opened");
  }

  bool next() {
    if (!std::getline(file_, line_)) return false;
    ++number_;
    rest_ = line_;
    return true;
  }
  /// As next, past lines that are empty or begin with #.
  bool next_with_words() {
    while (next()) {
      std::string_view look = rest_;
      const std::string_view first = word();
      rest_ = look;
      if (!first.empty() && first.front() != '#') return true;
    }
    return false;
  }
  /// The next word of the line; empty where there is none.
  std::string_view word() {
    const auto begin = rest_.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos) return {};
    rest_.remove_prefix(begin);
    const std::string_view found = rest_.substr(0, rest_.find_first_of(" \t\r"));
    rest_.remove_prefix(found.size());
    return found;
  }
  double number() { return value<double>("a number"); }
  std::int64_t whole() { return value<std::int64_t>("a whole number"); }
  Vec3d point() {
    const double x = number(), y = number(), z = number();
    if (!(std::isfinite(x) && std::isfinite(y) && std::isfinite(z))) fail("is not finite");
    return {x, y, z};
  }

  [[noreturn]] void fail(const std::string& problem) const {
    throw InputError(path_.string(),
                     "line " + std::to_string(number_) + " " + problem + "; repair the mesh");
  }

 private:
  template <class T>
  T value(const char* kind) {
    std::string_view text = word();
    if (!text.empty() && text.front() == '+') text.remove_prefix(1);
    T result{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), result);
    if (error != std::errc() || end != text.data() + text.size()) {
      fail(text.empty() ? std::string("ends where ") + kind + " should be"
                        : "has '" + std::string(text.substr(0, 20)) + "', which is not " + kind);
    }
    return result;
  }

  const fs::path& path_;
  std::ifstream file_;
  std::string line_;
  std::string_view rest_;
  std::uint64_t number_ = 0;
};

/// The vertex that a corner of an OBJ face names ("7", "7/1", "-1//2"), counted from 1.
std::int64_t corner_of(std::string_view word, std::int64_t vertices, const Lines& lines) {
  const std::string_view text = word.substr(0, word.find('/'));
  std::int64_t vertex = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), vertex);
  if (error != std::errc() || end != text.data() + text.size() || vertex == 0) {
    lines.fail("has '" + std::string(word.substr(0, 20)) + "', which names no vertex");
  }
  if (vertex < 0) vertex += vertices + 1;
  if (vertex < 1) lines.fail("names a vertex before the first one");
  return vertex;
}

void refuse_empty(const fs::path& path, const std::vector<Vec3d>& vertices) {
  if (vertices.empty()) throw InputError(path.string(), "holds no vertices; is it a mesh?");
}

}  // namespace

std::vector<Vec3d> scan_obj(const fs::path& path) {
  Lines lines(path);
  std::vector<Vec3d> vertices;
  std::int64_t highest = 0;
  while (lines.next()) {
    const std::string_view kind = lines.word();
    if (kind == "v") vertices.push_back(lines.point());
    if (kind != "f") continue;
    int corners = 0;
    for (auto word = lines.word(); !word.empty(); word = lines.word(), ++corners) {
      highest =
          std::max(highest, corner_of(word, static_cast<std::int64_t>(vertices.size()), lines));
    }
    if (corners < 3)
      lines.fail("is a face of " + std::to_string(corners) + " corners, not 3 or more");
  }
  refuse_empty(path, vertices);
  if (highest > static_cast<std::int64_t>(vertices.size())) {
    throw InputError(path.string(), "a face names vertex " + std::to_string(highest) +
                                        ", and there are " + std::to_string(vertices.size()) +
                                        "; repair the mesh");
  }
  return vertices;
}

ImportedMesh read_off(const fs::path& path) {
  Lines lines(path);
  const bool has_head = lines.next_with_words();
  const std::string_view head = has_head ? lines.word() : std::string_view{};
  if (head.size() < 3 || head.substr(head.size() - 3) != "OFF") {
    throw InputError(path.string(), "does not begin with OFF; is it a mesh?");
  }
  if (!lines.word().empty()) lines.fail("has more than the word OFF");
  if (!lines.next_with_words()) lines.fail("is the last, and the counts are missing");
  const std::int64_t count = lines.whole(), faces = lines.whole();
  ImportedMesh off;
  std::vector<Vec3d>& vertices = off.positions;
  for (std::int64_t v = 0; v < count; ++v) {
    if (!lines.next_with_words()) {
      lines.fail("is the last, after " + std::to_string(v) + " of " + std::to_string(count) +
                 " vertices");
    }
    vertices.push_back(lines.point());
  }
  refuse_empty(path, vertices);
  for (std::int64_t f = 0; f < faces; ++f) {
    if (!lines.next_with_words()) {
      lines.fail("is the last, after " + std::to_string(f) + " of " + std::to_string(faces) +
                 " faces");
    }
    const std::int64_t corners = lines.whole();
    if (corners < 3)
      lines.fail("is a face of " + std::to_string(corners) + " corners, not 3 or more");
    std::uint32_t apex = 0, before = 0;
    for (std::int64_t c = 0; c < corners; ++c) {
      const std::int64_t vertex = lines.whole();
      if (vertex < 0 || vertex >= count) {
        lines.fail("names vertex " + std::to_string(vertex) + ", and there are " +
                   std::to_string(count) + " from 0 on");
      }
      const auto corner = static_cast<std::uint32_t>(vertex);
      if (c == 0) apex = corner;
      if (c >= 2) off.mesh.triangles.push_back({apex, before, corner});
      before = corner;
    }
  }
  return off;
}

void check_stl(const fs::path& path) {
  check_input_file(path);
  const std::uint64_t bytes = fs::file_size(path);
  std::ifstream file(path, std::ios::binary);
  char head[kStlHead] = {};
  file.read(head, static_cast<std::streamsize>(kStlHead));
  if (std::string_view(head, 5) == "solid" && std::memchr(head, 0, kStlHead - 4) == nullptr) {
    Lines lines(path);
    std::uint64_t corners = 0, facets = 0;
    bool ended = false;
    while (lines.next()) {
      const std::string_view word = lines.word();
      if (word == "vertex") lines.point(), ++corners;
      if (word == "endfacet" && ++facets * 3 != corners)
        lines.fail("ends a facet without 3 vertices");
      ended = word == "endsolid" || (ended && word.empty());
    }
    if (!ended) lines.fail("is the last, and is not endsolid");
    return;
  }
  std::uint32_t triangles = 0;
  std::memcpy(&triangles, head + kStlHead - 4, sizeof triangles);
  if (bytes < kStlHead || bytes < kStlHead + kStlTriangle * triangles) {
    throw InputError(path.string(), "is no STL, or ends early: its " + std::to_string(bytes) +
                                        " bytes are too few for its triangles");
  }
}

}  // namespace cornice
