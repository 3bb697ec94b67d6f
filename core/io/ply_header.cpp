// SPDX-License-Identifier: GPL-3.0-or-later
// Turk 1994, "The PLY Polygon File Format". docs/formats/ply.md says what we add.
#include "core/io/ply_header.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/error.h"
#include "core/base/input_file.h"
#include "core/io/ply.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;

// A header has some dozen lines; one that goes on longer is none.
constexpr std::size_t kMaxHeaderBytes = std::size_t{1} << 20;

struct TypeName {
  PlyType type;
  std::string_view name;
};
// The older name of each type comes first; both are in use.
constexpr std::array<TypeName, 16> kTypeNames{{{PlyType::kInt8, "char"},
                                               {PlyType::kInt8, "int8"},
                                               {PlyType::kUint8, "uchar"},
                                               {PlyType::kUint8, "uint8"},
                                               {PlyType::kInt16, "short"},
                                               {PlyType::kInt16, "int16"},
                                               {PlyType::kUint16, "ushort"},
                                               {PlyType::kUint16, "uint16"},
                                               {PlyType::kInt32, "int"},
                                               {PlyType::kInt32, "int32"},
                                               {PlyType::kUint32, "uint"},
                                               {PlyType::kUint32, "uint32"},
                                               {PlyType::kFloat32, "float"},
                                               {PlyType::kFloat32, "float32"},
                                               {PlyType::kFloat64, "double"},
                                               {PlyType::kFloat64, "float64"}}};

bool is_integer(PlyType type) { return type != PlyType::kFloat32 && type != PlyType::kFloat64; }

/// Lines of a header as they are read, with their numbers for messages.
class HeaderLines {
 public:
  HeaderLines(const fs::path& path, std::streambuf& stream) : path_(path), stream_(stream) {}

  /// The next line without its end ("\n" or "\r\n").
  std::string next() {
    std::string line;
    ++number_;
    constexpr int kEnd = std::char_traits<char>::eof();
    for (int next = stream_.sbumpc(); next != kEnd; next = stream_.sbumpc()) {
      const char c = std::char_traits<char>::to_char_type(next);
      if (++bytes_ > kMaxHeaderBytes) fail("the header does not end");
      if (c == '\n') {
        if (!line.empty() && line.back() == '\r') line.pop_back();
        return line;
      }
      line += c;
    }
    fail("the file ends within the header");
  }

  [[noreturn]] void fail(const std::string& problem) const {
    throw InputError(path_.string(), problem + " (header line " + std::to_string(number_) + ")");
  }
  std::uint64_t bytes() const { return bytes_; }

 private:
  const fs::path& path_;
  std::streambuf& stream_;
  std::uint64_t bytes_ = 0;
  int number_ = 0;
};

std::vector<std::string> words_of(const std::string& line) {
  constexpr const char* kBlanks = " \t\r\v\f";
  std::vector<std::string> words;
  for (std::size_t at = line.find_first_not_of(kBlanks); at != std::string::npos;) {
    const std::size_t end = std::min(line.find_first_of(kBlanks, at), line.size());
    words.push_back(line.substr(at, end - at));
    at = line.find_first_not_of(kBlanks, end);
  }
  return words;
}

/// What follows the first word and its blank.
std::string rest_of(const std::string& line, const std::string& first_word) {
  const std::size_t at = line.find(first_word) + first_word.size();
  return at < line.size() ? line.substr(at + 1) : std::string();
}

PlyType type_from(const std::string& word, const HeaderLines& lines) {
  for (const TypeName& known : kTypeNames) {
    if (known.name == word) return known.type;
  }
  lines.fail("unknown type '" + word.substr(0, 40) + "'");
}

PlyFormat format_from(const std::vector<std::string>& words, const HeaderLines& lines) {
  if (words.size() != 3) lines.fail("a format line has a format and a version");
  if (words[2] != "1.0") lines.fail("version '" + words[2].substr(0, 40) + "' is not 1.0");
  if (words[1] == "ascii") return PlyFormat::kAscii;
  if (words[1] == "binary_little_endian") return PlyFormat::kLittleEndian;
  if (words[1] == "binary_big_endian") return PlyFormat::kBigEndian;
  lines.fail("unknown format '" + words[1].substr(0, 40) + "'");
}

PlyElement element_from(const std::vector<std::string>& words, const HeaderLines& lines) {
  PlyElement element;
  if (words.size() != 3) lines.fail("an element has a name and a count");
  element.name = words[1];
  const char* last = words[2].data() + words[2].size();
  const auto [end, error] = std::from_chars(words[2].data(), last, element.count);
  if (error != std::errc() || end != last) {
    lines.fail("'" + words[2].substr(0, 40) + "' is no count of elements");
  }
  return element;
}

PlyProperty property_from(const std::vector<std::string>& words, const HeaderLines& lines) {
  PlyProperty property;
  if (words.size() == 3) {
    property.type = type_from(words[1], lines);
  } else if (words.size() == 5 && words[1] == "list") {
    property.list_count = type_from(words[2], lines);
    property.type = type_from(words[3], lines);
    if (!is_integer(*property.list_count)) lines.fail("the length of a list must be an integer");
  } else {
    lines.fail("a property has a type and a name");
  }
  property.name = words.back();
  return property;
}

/// "cornice origin E N H" and "cornice crs TEXT".
void take_comment(const std::string& comment, const HeaderLines& lines, PlyHeader& header) {
  header.comments.push_back(comment);
  const std::vector<std::string> words = words_of(comment);
  if (words.size() < 2 || words[0] != "cornice") return;
  if (words[1] == "crs") header.crs_text = rest_of(comment, "crs");
  if (words[1] != "origin") return;
  std::array<double, 3> values{};
  bool good = words.size() == 5;
  for (std::size_t i = 0; good && i < 3; ++i) {
    const std::string& word = words[i + 2];
    const char* last = word.data() + word.size();
    const auto [end, error] = std::from_chars(word.data(), last, values[i]);
    good = error == std::errc() && end == last && std::isfinite(values[i]);
  }
  if (!good) lines.fail("'" + comment.substr(0, 80) + "' is not 'cornice origin E N H'");
  header.origin = {values[0], values[1], values[2]};
}

/// Refuses elements that cannot be in the file, before anything is allocated for them.
void check_size(const fs::path& path, const PlyHeader& header) {
  std::uint64_t left = header.file_bytes - header.header_bytes;
  for (const PlyElement& element : header.elements) {
    if (element.count == 0) continue;
    if (element.properties.empty()) {
      throw InputError(path.string(), "element '" + element.name + "' has no properties");
    }
    // An ascii value takes a digit and a blank at least.
    const std::uint64_t least =
        header.format == PlyFormat::kAscii ? 2 * element.properties.size() : element.record_bytes();
    // The last value of an ascii file may lack its line end.
    const std::uint64_t room = left + (header.format == PlyFormat::kAscii ? 1 : 0);
    if (element.count > room / least) {
      throw InputError(path.string(), "is truncated: " + std::to_string(element.count) + " '" +
                                          element.name + "' need at least " +
                                          std::to_string(least) + " bytes each, but only " +
                                          std::to_string(left) + " bytes are left");
    }
    left -= std::min(left, element.count * least);
  }
}

}  // namespace

std::size_t ply_size(PlyType type) {
  switch (type) {
    case PlyType::kInt8:
    case PlyType::kUint8:
      return 1;
    case PlyType::kInt16:
    case PlyType::kUint16:
      return 2;
    case PlyType::kInt32:
    case PlyType::kUint32:
    case PlyType::kFloat32:
      return 4;
    case PlyType::kFloat64:
      return 8;
  }
  return 0;
}

const char* ply_type_name(PlyType type) {
  const auto* known = std::find_if(kTypeNames.begin(), kTypeNames.end(),
                                   [&](const TypeName& name) { return name.type == type; });
  return known->name.data();
}

bool PlyElement::has_lists() const {
  return std::any_of(properties.begin(), properties.end(),
                     [](const PlyProperty& property) { return property.is_list(); });
}

std::size_t PlyElement::record_bytes() const {
  std::size_t bytes = 0;
  for (const PlyProperty& property : properties) {
    bytes += ply_size(property.list_count.value_or(property.type));
  }
  return bytes;
}

std::optional<std::size_t> PlyElement::find(std::initializer_list<const char*> names) const {
  for (std::size_t i = 0; i < properties.size(); ++i) {
    for (const char* wanted : names) {
      if (properties[i].name == wanted) return i;
    }
  }
  return std::nullopt;
}

PlyHeader read_ply_header(const fs::path& path) {
  check_input_file(path);
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw InputError(path.string(), "cannot be opened");
  PlyHeader header;
  header.file_bytes = fs::file_size(path);
  if (header.file_bytes == 0) throw InputError(path.string(), "is empty");
  std::array<char, 3> magic{};
  stream.read(magic.data(), magic.size());
  if (std::string_view(magic.data(), magic.size()) != "ply") {
    throw InputError(path.string(), "is no PLY: it does not begin with 'ply'");
  }
  stream.seekg(0);
  HeaderLines lines(path, *stream.rdbuf());
  if (words_of(lines.next()) != std::vector<std::string>{"ply"}) lines.fail("is no PLY");
  bool has_format = false;
  for (;;) {
    const std::string line = lines.next();
    const std::vector<std::string> words = words_of(line);
    if (words.empty()) continue;
    if (words[0] == "end_header") break;
    if (words[0] == "format") {
      header.format = format_from(words, lines);
      has_format = true;
    } else if (words[0] == "comment" || words[0] == "obj_info") {
      take_comment(rest_of(line, words[0]), lines, header);
    } else if (words[0] == "element") {
      header.elements.push_back(element_from(words, lines));
    } else if (words[0] == "property") {
      if (header.elements.empty()) lines.fail("a property stands before any element");
      header.elements.back().properties.push_back(property_from(words, lines));
    } else {
      lines.fail("unknown word '" + words[0].substr(0, 40) + "'");
    }
  }
  if (!has_format) throw InputError(path.string(), "the header has no format line");
  header.header_bytes = lines.bytes();
  check_size(path, header);
  return header;
}

std::uint64_t PlyInfo::count(std::string_view element) const {
  for (const Element& one : elements) {
    if (one.name == element) return one.count;
  }
  return 0;
}

PlyInfo read_ply_info(const fs::path& path) {
  PlyHeader header = read_ply_header(path);
  PlyInfo info;
  info.format = header.format == PlyFormat::kAscii          ? "ascii"
                : header.format == PlyFormat::kLittleEndian ? "binary_little_endian"
                                                            : "binary_big_endian";
  for (const PlyElement& element : header.elements) {
    PlyInfo::Element& listed = info.elements.emplace_back();
    listed.name = element.name;
    listed.count = element.count;
    for (const PlyProperty& property : element.properties) {
      std::string type = ply_type_name(property.type);
      if (property.is_list()) {
        type = std::string("list ") + ply_type_name(*property.list_count) + " " + type;
      }
      listed.properties.emplace_back(property.name, type);
    }
  }
  info.comments = std::move(header.comments);
  info.origin = header.origin;
  info.crs_text = std::move(header.crs_text);
  info.header_bytes = header.header_bytes;
  return info;
}

}  // namespace cornice
