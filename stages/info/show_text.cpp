// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "stages/info/show.h"
#include "stages/info/wording.h"

namespace cornice::info {
namespace {

constexpr std::size_t kLabelWidth = 13;
constexpr std::size_t kMostLines = 12;  // point source ids shown one by one
constexpr std::size_t kTextWidth = 86;  // of a list before it wraps

/// Text in two columns; a label of a line is not repeated.
class Screen {
 public:
  void line(const std::string& label, const std::string& text) {
    std::string start = label;
    start.resize(std::max(kLabelWidth, label.size() + 1), ' ');
    text_ += start + text + "\n";
  }
  /// Entries behind each other, wrapped.
  void list(const std::string& label, const std::vector<std::string>& entries) {
    std::string row;
    std::string next_label = label;
    for (const std::string& entry : entries) {
      if (!row.empty() && row.size() + entry.size() + 2 > kTextWidth) {
        line(next_label, row + ",");
        next_label.clear();
        row.clear();
      }
      row += (row.empty() ? "" : ", ") + entry;
    }
    line(next_label, row.empty() ? "none" : row);
  }
  std::string text() && { return std::move(text_); }

 private:
  std::string text_;
};

std::string range(double low, double high, int digits) {
  return fixed(low, digits) + " .. " + fixed(high, digits);
}

std::string crs_line(const Crs& crs, const std::string& source) {
  if (crs.empty()) return "none";
  const bool has_code = crs.horizontal_epsg != 0;
  std::string text = has_code && crs.text() != crs.wkt ? crs.text() + " " + crs.name : crs.name;
  if (has_code && crs.text() == crs.wkt)
    text += " (EPSG:" + std::to_string(crs.horizontal_epsg) + ")";
  text += ", " + unit_name(crs.metres_per_unit);
  return source.empty() ? text : text + ", from " + source;
}

void show_bounds(Screen& screen, const PointFacts& facts) {
  const Box3d& box = facts.bounds;
  if (box.empty()) return;
  const LasInfo& header = facts.header;
  const int x = digits_of_step(header.scale.x);
  const int y = digits_of_step(header.scale.y);
  const int z = digits_of_step(header.scale.z);
  screen.line("bounds", "x " + range(box.min.x, box.max.x, x) + " (" +
                            fixed(box.max.x - box.min.x, x) + "), y " +
                            range(box.min.y, box.max.y, y) + " (" +
                            fixed(box.max.y - box.min.y, y) + "),");
  screen.line("", "z " + range(box.min.z, box.max.z, z) + " (" + fixed(box.max.z - box.min.z, z) +
                      "); the header " + (facts.bounds_agree ? "agrees" : "does not agree"));
}

void show_counts(Screen& screen, const PointFacts& facts) {
  std::vector<std::string> classes, returns, flags;
  const double total = static_cast<double>(std::max<std::uint64_t>(facts.readable, 1));
  for (int code = 0; code < 256; ++code) {
    const std::uint64_t count = facts.classes[static_cast<std::size_t>(code)];
    if (count == 0) continue;
    classes.push_back(class_name(code) + " " + grouped(count) + " (" +
                      fixed(100.0 * static_cast<double>(count) / total, 1) + " %)");
  }
  for (std::size_t i = 0; i < facts.by_return.size(); ++i) {
    if (facts.by_return[i] > 0) {
      returns.push_back(std::to_string(i) + ": " + grouped(facts.by_return[i]));
    }
  }
  const auto flag = [&](const char* name, std::uint64_t count) {
    if (count > 0) flags.push_back(std::string(name) + " " + grouped(count));
  };
  flag("withheld", facts.withheld);
  flag("overlap", facts.overlap);
  flag("synthetic", facts.synthetic);
  flag("key points", facts.key_points);
  screen.list("classes", classes);
  screen.list("returns", returns);
  if (!flags.empty()) screen.list("flags", flags);
}

void show_time(Screen& screen, const PointFacts& facts) {
  const TimeFacts& time = facts.time;
  if (!time.has_field) {
    screen.line("GPS time", "the point format has none");
    return;
  }
  if (!time.good_min_s) {
    screen.line("GPS time", time.zero == facts.readable ? "all 0" : "none above 0");
    return;
  }
  std::string text =
      range(*time.good_min_s, *time.good_max_s, 3) + " s, " + time_kind_name(time.kind);
  const std::string first = date_of(*time.good_min_s, time.kind);
  const std::string last = date_of(*time.good_max_s, time.kind);
  if (!first.empty()) text += ", " + (first == last ? first : first + " .. " + last);
  screen.line("GPS time", text);
}

void show_angles(Screen& screen, const PointFacts& facts) {
  const AngleFacts& angle = facts.angle;
  if (!angle.min_deg) return;
  const int digits = angle.whole_degrees && angle.unit_deg == 1.0 ? 0 : 3;
  screen.line("scan angle", range(*angle.min_deg, *angle.max_deg, digits) + " degrees, " +
                                counted(angle.distinct, "value") +
                                (angle.whole_degrees ? ", whole degrees" : ""));
}

void show_lines(Screen& screen, const PointFacts& facts) {
  std::uint64_t passes = 0;
  for (const LineFacts& line : facts.lines) passes += line.passes;
  std::vector<std::string> channels;
  for (std::size_t i = 0; i < facts.by_channel.size(); ++i) {
    if (facts.by_channel[i] > 0) channels.push_back(std::to_string(i));
  }
  std::size_t ids = 0;
  for (std::size_t i = 0; i < facts.lines.size(); ++i) {
    ids += i == 0 || facts.lines[i].point_source_id != facts.lines[i - 1].point_source_id ? 1 : 0;
  }
  std::string text = counted(ids, "point source id");
  if (channels.size() > 1) text += ", " + counted(channels.size(), "channel");
  if (facts.lines_complete && passes > 0) {
    text += ", " + grouped(passes) + (passes == 1 ? " pass" : " passes");
  }
  screen.line("lines", text);
  for (std::size_t i = 0; i < std::min(kMostLines, facts.lines.size()); ++i) {
    const LineFacts& line = facts.lines[i];
    std::string row = std::to_string(line.point_source_id);
    if (channels.size() > 1) row += " channel " + std::to_string(line.channel);
    row += ": " + counted(line.points, "point");
    if (line.first_s) row += ", " + range(*line.first_s, *line.last_s, 3) + " s";
    if (facts.lines_complete && line.passes > 1) row += ", " + grouped(line.passes) + " passes";
    screen.line("", row);
  }
  if (facts.lines.size() > kMostLines) {
    screen.line("", "and " + grouped(facts.lines.size() - kMostLines) + " more");
  }
}

std::string extra_byte_text(const ExtraByte& attribute) {
  static constexpr std::array<const char*, 11> kTypes = {"raw",   "uint8",  "int8",  "uint16",
                                                         "int16", "uint32", "int32", "uint64",
                                                         "int64", "float",  "double"};
  std::string type = std::to_string(attribute.size) + " bytes";
  if (attribute.data_type > 0 && attribute.data_type < kTypes.size()) {
    type = kTypes[attribute.data_type];
  }
  return attribute.name + " (" + type + ")";
}

void show(Screen& screen, const FileFacts& file, const PointFacts& facts) {
  const LasInfo& header = facts.header;
  screen.line("format", kind_name(file) + ", LAS 1." + std::to_string(header.version_minor) +
                            ", point format " + std::to_string(header.point_format) + ", " +
                            std::to_string(header.record_bytes) + " bytes a record, " +
                            byte_size(file.bytes) + (header.zipped ? " zipped" : ""));
  screen.line("made by", "'" + header.generating_software + "', system '" +
                             header.system_identifier + "', day " +
                             std::to_string(header.creation_day) + " of " +
                             std::to_string(header.creation_year));
  std::string points = grouped(facts.readable);
  if (facts.readable != header.point_count) points += " of " + grouped(header.point_count);
  if (facts.density_per_m2) {
    points += ", " + shortest(*facts.density_per_m2, 4) + " a m2 over " +
              shortest(facts.occupied_m2, 4) + " m2 (cells of " + shortest(facts.cell_m, 4) + " m)";
  }
  screen.line("points", points);
  show_bounds(screen, facts);
  screen.line("CRS", crs_line(header.crs, header.crs_source));
  if (facts.readable > 0) {
    show_counts(screen, facts);
    screen.line("intensity",
                std::to_string(facts.intensity_min) + " .. " + std::to_string(facts.intensity_max));
    show_time(screen, facts);
    show_angles(screen, facts);
    show_lines(screen, facts);
  }
  if (header.extra_bytes.empty()) return;
  std::vector<std::string> attributes;
  for (const ExtraByte& attribute : header.extra_bytes) {
    attributes.push_back(extra_byte_text(attribute));
  }
  screen.list("extra bytes", attributes);
}

void show(Screen& screen, const FileFacts& file, const PlyFacts& facts) {
  screen.line("format", "PLY, " + facts.header.format + ", " + byte_size(file.bytes));
  for (const PlyInfo::Element& element : facts.header.elements) {
    std::vector<std::string> properties;
    for (const auto& [name, type] : element.properties) properties.push_back(name + " " + type);
    screen.list(element.name, properties);
    screen.line("", grouped(element.count) + " of them");
  }
  const Vec3d origin = facts.header.origin;
  screen.line("origin",
              shortest(origin.x, 12) + " " + shortest(origin.y, 12) + " " + shortest(origin.z, 12));
  if (!facts.bounds.empty()) {
    const Box3d& box = facts.bounds;
    screen.line("bounds", "x " + range(box.min.x, box.max.x, 3) + ", y " +
                              range(box.min.y, box.max.y, 3) + ", z " +
                              range(box.min.z, box.max.z, 3));
  }
  screen.line("CRS", crs_line(facts.crs, ""));
}

void show(Screen& screen, const FileFacts& file, const RasterFacts& facts) {
  std::string format = facts.format;
  if (!facts.layout.empty()) format += " (" + facts.layout + ")";
  if (!facts.compression.empty()) format += ", " + facts.compression;
  screen.line("format", format + ", " + counted(static_cast<std::uint64_t>(facts.bands), "band") +
                            " of " + facts.type + ", " +
                            counted(static_cast<std::uint64_t>(facts.overviews), "overview") +
                            ", " + byte_size(file.bytes));
  std::string size = std::to_string(facts.width) + " x " + std::to_string(facts.height) + " pixels";
  if (facts.has_position)
    size += " of " + shortest(facts.step_x) + " x " + shortest(std::abs(facts.step_y));
  screen.line("size", size + (facts.pixel_is_point ? ", pixel is point" : ""));
  if (facts.has_position) {
    screen.line("bounds", "x " + shortest(facts.bounds.min_x, 12) + " .. " +
                              shortest(facts.bounds.max_x, 12) + ", y " +
                              shortest(facts.bounds.min_y, 12) + " .. " +
                              shortest(facts.bounds.max_y, 12));
  }
  if (facts.min) {
    const double all = static_cast<double>(facts.width) * facts.height;
    screen.line("values", shortest(*facts.min, 7) + " .. " + shortest(*facts.max, 7) + ", " +
                              fixed(100.0 * static_cast<double>(facts.valid) / all, 1) +
                              " % of the pixels have one");
  }
  screen.line("no data", facts.no_data ? shortest(*facts.no_data) : "no value stands for it");
  screen.line("CRS", crs_line(facts.crs, ""));
}

struct Contents {
  std::string size;
  const Crs* crs = nullptr;
};

Contents contents(const PointFacts& facts) {
  std::string size = counted(facts.readable, "point");
  if (facts.density_per_m2) size += ", " + shortest(*facts.density_per_m2, 4) + " a m2";
  return {size, &facts.header.crs};
}
Contents contents(const PlyFacts& facts) {
  return {counted(facts.vertices, "vertex") + ", " + counted(facts.faces, "face"), &facts.crs};
}
Contents contents(const RasterFacts& facts) {
  return {std::to_string(facts.width) + " x " + std::to_string(facts.height) + " pixels",
          &facts.crs};
}

}  // namespace

std::string kind_name(const FileFacts& file) {
  if (std::holds_alternative<PlyFacts>(file.facts)) return "PLY";
  if (const auto* raster = std::get_if<RasterFacts>(&file.facts)) return raster->format;
  switch (std::get<PointFacts>(file.facts).header.container) {
    case LasContainer::kLas:
      return "LAS";
    case LasContainer::kLaz:
      return "LAZ";
    case LasContainer::kCopc:
      return "COPC";
  }
  return "LAS";
}

std::string screen_text(const FileFacts& file) {
  Screen screen;
  screen.line("file", file.path.string());
  std::visit([&](const auto& facts) { show(screen, file, facts); }, file.facts);
  if (file.defects.empty()) screen.line("defects", "none found");
  for (std::size_t i = 0; i < file.defects.size(); ++i) {
    screen.line(i == 0 ? "defects" : "", "- " + file.defects[i].text);
  }
  return std::move(screen).text();
}

std::string summary_line(const FileFacts& file) {
  const Contents what = std::visit([](const auto& facts) { return contents(facts); }, file.facts);
  std::string crs = what.crs->empty() ? "no CRS" : what.crs->text();
  if (crs == what.crs->wkt && !what.crs->empty()) crs = what.crs->name;
  return file.path.string() + ": " + kind_name(file) + ", " + what.size + ", " + crs + ", " +
         (file.defects.empty() ? "no defects" : counted(file.defects.size(), "defect"));
}

}  // namespace cornice::info
