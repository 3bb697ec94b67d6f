// SPDX-License-Identifier: GPL-3.0-or-later
// The page of a comparison: one HTML file that needs nothing beside it.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iterator>

#include "core/base/error.h"
#include "stages/compare/output.h"
#include "stages/compare/svg.h"

namespace cornice::compare {
namespace {

constexpr std::size_t kListedOverhangs = 40;
constexpr int kBars = 80;
/// Above this a DEM may be from pictures instead of LiDAR.
constexpr double kHighGroundM = 2000.0;

const char* const kStyle =
    "body{font:15px/1.45 sans-serif;color:#222;max-width:1240px;margin:24px auto;padding:0 16px}"
    "h1{font-size:24px;margin:0 0 4px}h2{font-size:18px;margin:32px 0 8px;border-bottom:1px solid "
    "#ddd;padding-bottom:4px}table{border-collapse:collapse;margin:8px 0 16px;font-size:13px}"
    "th,td{padding:3px 9px;text-align:right;border-bottom:1px solid #eee;white-space:nowrap}"
    "th{font-weight:600;background:#f6f6f4}th:first-child,td:first-child{text-align:left}"
    "tr.group td{background:#fafaf8;font-weight:600}figure{margin:12px 0 20px}"
    "figure img,figure svg{max-width:100%;height:auto;border:1px solid #e4e4e0}"
    "figcaption{color:#555;font-size:13px}.warning{background:#fff4e0;border-left:4px solid "
    "#e09a30;padding:6px 12px;margin:6px 0}.wide{overflow-x:auto}";

std::string number(double value, int digits) {
  char text[48];
  std::snprintf(text, sizeof text, "%.*f", digits, value == 0.0 ? 0.0 : value);
  return text;
}

std::string read_all(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (!in.good() && !in.eof()) throw RunError(path.string(), "cannot be read back");
  return bytes;
}

std::string base64(const std::string& bytes) {
  constexpr const char* kLetters =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = (group << 8) | (i + k < bytes.size() ? static_cast<std::uint8_t>(bytes[i + k]) : 0u);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += i + k > bytes.size() ? '=' : kLetters[(group >> (18 - 6 * k)) & 63u];
    }
  }
  return text;
}

std::string row(const std::vector<std::string>& cells, const char* tag = "td") {
  std::string html = "<tr>";
  for (const std::string& cell : cells) {
    html += std::string("<") + tag + ">" + cell + "</" + tag + ">";
  }
  return html + "</tr>\n";
}

std::string bytes_text(std::uint64_t bytes) {
  const auto value = static_cast<double>(bytes);
  return value >= 1e9 ? number(value / 1e9, 2) + " GB" : number(value / 1e6, 2) + " MB";
}

std::string sides_table(const Result& result) {
  std::string html = "<table>" + row({"", "A", "B"}, "th");
  const auto both = [&](const std::string& name, const auto& of) {
    html += row({name, of(result.sides[0]), of(result.sides[1])});
  };
  both("path", [](const SideResult& s) { return escaped(s.facts.title); });
  both("kind", [](const SideResult& s) { return std::string(kind_name(s.facts.kind)); });
  both("files", [](const SideResult& s) { return std::to_string(s.facts.files.size()); });
  both("size of the files", [](const SideResult& s) { return bytes_text(s.facts.file_bytes); });
  both("coordinate system", [](const SideResult& s) {
    return s.facts.crs.empty() ? std::string("not named")
                               : escaped(s.facts.crs.text().substr(0, 60));
  });
  both("vertices, pixels or points",
       [](const SideResult& s) { return std::to_string(s.facts.vertices); });
  both("triangles", [](const SideResult& s) {
    return s.facts.triangles == 0 ? std::string("-") : std::to_string(s.facts.triangles);
  });
  both("surface, m2", [](const SideResult& s) {
    return s.area_m2 > 0.0 ? number(s.area_m2, 0) : std::string("-");
  });
  both("overhangs", [](const SideResult& s) { return std::to_string(s.overhangs.size()); });
  both("surface below the horizon, m2",
       [](const SideResult& s) { return number(s.overhang_m2, 1); });
  both("ground with several layers, m2",
       [](const SideResult& s) { return number(s.layered_m2, 1); });
  return html + "</table>\n";
}

std::vector<std::string> summary_cells(const std::string& name, const Summary& s) {
  std::vector<std::string> cells{name, std::to_string(s.count), std::to_string(s.missing)};
  if (s.count == 0) {
    cells.insert(cells.end(), 7 + s.completeness.size(), "-");
    return cells;
  }
  for (const double value : {s.mean, s.rms, s.median, s.nmad, s.percentiles[1],
                             s.percentiles[kPercentiles.size() - 2], s.highest}) {
    cells.push_back(number(value, 3));
  }
  for (const double share : s.completeness) cells.push_back(number(100.0 * share, 2) + " %");
  return cells;
}

std::string statistics_table(const Measurement& m, const Options& options) {
  std::vector<std::string> head{"",         "measured", "missing", "mean m", "RMS m",
                                "median m", "NMAD m",   "5 % m",   "95 % m", "highest m"};
  for (const double t : options.tolerances_m) {
    char text[32];
    std::snprintf(text, sizeof text, "within %g m", t);
    head.push_back(text);
  }
  std::string html =
      "<h3>" + escaped(m.title) + "</h3><div class=\"wide\"><table>" + row(head, "th");
  for (const Grouping grouping : kGroupings) {
    if (grouping != Grouping::kAll && !m.by_place) continue;
    if (grouping != Grouping::kAll) {
      std::string title = std::string("by ") + grouping_name(grouping);
      if (grouping == Grouping::kSlope) title += ", degrees";
      html += "<tr class=\"group\"><td colspan=\"" + std::to_string(head.size()) + "\">" + title +
              "</td></tr>\n";
    }
    const std::vector<std::string>& names = group_names(grouping);
    for (std::size_t i = 0; i < names.size(); ++i) {
      const Summary s = m.statistics->group(grouping, i).summary();
      if (s.count + s.missing > 0) html += row(summary_cells(names[i], s));
    }
  }
  return html + "</table></div>\n";
}

std::string histogram(const Result& result) {
  const double limit = 2.0 * result.colour_range_m;
  Svg svg(900, 300);
  const PlotBox box{56, 30, 828, 224};
  struct Line {
    std::string colour;
    std::vector<double> share;
    std::string title;
  };
  const char* colours[] = {"#444444", "#c2571a", "#1b5fa8", "#2d8a4e"};
  std::vector<Line> lines;
  double most = 1e-9;
  for (const Measurement& m : measurements_of(result)) {
    const Distribution& all = m.statistics->all();
    Line line{colours[lines.size() % 4], {}, m.title};
    for (const std::uint64_t n : all.histogram(limit, kBars)) {
      line.share.push_back(100.0 * static_cast<double>(n) /
                           static_cast<double>(std::max<std::uint64_t>(1, all.count())));
      most = std::max(most, line.share.back());
    }
    lines.push_back(std::move(line));
  }
  svg.axes(box, {-limit, limit}, {0.0, most});
  double key_x = 60.0;
  for (const Line& line : lines) {
    std::string path;
    for (std::size_t k = 0; k < line.share.size(); ++k) {
      const double y = box.top + box.height * (1.0 - line.share[k] / most);
      const double left = box.left + box.width * static_cast<double>(k) / kBars;
      path +=
          (k == 0 ? svg_move(left, y) : svg_line(left, y)) + svg_line(left + box.width / kBars, y);
    }
    svg.path(path, line.colour, 1.6);
    svg.key(key_x, 14.0, line.colour, line.title);
    key_x += 60.0 + 7.0 * static_cast<double>(line.title.size());
  }
  svg.text(box.left + box.width / 2, 288.0,
           "difference, m (percent of all in each bar; the outer bars hold what lies beyond)",
           "middle");
  return "<figure>" + svg.finish() + "</figure>\n";
}

std::string overhang_table(const Result& result) {
  std::string html;
  for (const Side side : kSides) {
    const std::vector<Overhang>& list = result.sides[index_of(side)].overhangs;
    if (list.empty()) continue;
    html += std::string("<h3>Of ") + (side == Side::kA ? "A" : "B") + ": " +
            std::to_string(list.size()) + ", " +
            number(result.sides[index_of(side)].overhang_m2, 1) + " m2</h3><table>" +
            row({"", "east m", "north m", "height m", "area m2", "seen from above m2", "depth m",
                 "length m", "rise m", "faces deg", "below horizon deg"},
                "th");
    for (std::size_t i = 0; i < std::min(list.size(), kListedOverhangs); ++i) {
      const Overhang& o = list[i];
      html += row({std::to_string(i + 1), number(o.centre.x, 1), number(o.centre.y, 1),
                   number(o.centre.z, 1), number(o.area_m2, 1), number(o.plan_m2, 1),
                   number(o.depth_m, 1), number(o.length_m, 1), number(o.height_m, 1),
                   number(o.azimuth_deg, 0), number(o.steepest_deg, 0)});
    }
    html += "</table>";
    if (list.size() > kListedOverhangs) html += "<p>All of them are in overhangs.csv.</p>";
  }
  return html.empty() ? "<p>Neither surface looks below the horizon anywhere.</p>" : html;
}

std::string versions_table(const Result& result) {
  if (result.sides[1].facts.kind == Kind::kCloud) return "";
  std::string html = "<h2>Triangles for an error</h2><table>" +
                     row({"mesh", "triangles", "file", "RMS from B, m"}, "th");
  for (const Version& v : result.versions) {
    html += row({escaped(v.title), v.triangles == 0 ? "-" : std::to_string(v.triangles),
                 bytes_text(v.file_bytes), number(v.distances.rms, 4)});
  }
  const SourceFacts& b = result.sides[1].facts;
  html += row({escaped(b.title) + " (B itself)", std::to_string(b.triangles),
               bytes_text(b.file_bytes), "0"}) +
          "</table>";
  if (const auto triangles = triangles_for_error_of_a(result)) {
    html += "<p>Versions of B need about " + number(*triangles, 0) +
            " triangles for the error that A has with " +
            std::to_string(result.sides[0].facts.triangles) + ".</p>";
  }
  return html;
}

std::string figures_html(const std::filesystem::path& folder, const std::vector<Figure>& figures) {
  std::string html;
  for (const Figure& figure : figures) {
    const std::string bytes = read_all(folder / figure.file);
    html += "<figure>";
    html += figure.file.ends_with(".svg")
                ? bytes
                : "<img alt=\"" + escaped(figure.caption) + "\" src=\"data:image/png;base64," +
                      base64(bytes) + "\">";
    html += "<figcaption>" + escaped(figure.caption) + "</figcaption></figure>\n";
  }
  return html;
}

}  // namespace

std::string comparison_page(const Result& result, const Options& options,
                            const std::filesystem::path& folder,
                            const std::vector<Figure>& figures) {
  const Box2d& c = result.common;
  std::string html =
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Comparison of two "
      "surfaces</title><style>" +
      std::string(kStyle) + "</style></head><body>\n<h1>Two surfaces of one place</h1>\n<p>" +
      number(c.width(), 0) + " by " + number(c.height(), 0) + " m of common ground, from " +
      number(c.min_x, 0) + ", " + number(c.min_y, 0) +
      ". Differences are positive (blue) where B lies above or outside A.</p>\n";
  for (const std::string& warning : result.warnings) {
    html += "<p class=\"warning\">" + escaped(warning) + "</p>\n";
  }
  const bool has_dem =
      result.sides[0].facts.kind == Kind::kDem || result.sides[1].facts.kind == Kind::kDem;
  if (has_dem && result.highest_m > kHighGroundM) {
    html +=
        "<p class=\"warning\">The ground rises above 2000 m. National DEMs are partly made "
        "from pictures there, with a standard deviation of 1 to 3 m: differences of that size "
        "can be the DEM's own.</p>\n";
  }
  html += sides_table(result);
  html += "<h2>Maps and views</h2>\n" + figures_html(folder, figures);
  html += "<h2>Differences</h2>\n" + histogram(result);
  for (const Measurement& m : measurements_of(result)) html += statistics_table(m, options);
  if (result.m3c2) {
    html += "<p>M3C2: " + std::to_string(result.m3c2->significant) + " of " +
            std::to_string(result.m3c2->measured) +
            " distances are larger than their level of detection at 95 %, " +
            number(result.m3c2->mean_detection_95_m, 3) + " m on average.</p>\n";
  }
  html += "<h2>Overhangs</h2>\n" + overhang_table(result) + versions_table(result);
  html += "<h2>What is measured</h2><p>Surfaces are sampled once per " +
          number(options.spacing_m, 2) +
          " m square of their area; a distance is that to the "
          "nearest point of the other surface within " +
          number(options.max_distance_m, 1) +
          " m. <i>Missing</i>: nothing that near, or the other surface ends there. <i>Within</i>: "
          "share of all, missing ones too. NMAD: 1.4826 times the median deviation from the "
          "median. Classes are those of the surface that was sampled; of vertical differences, "
          "those of the grid.</p></body></html>\n";
  return html;
}

}  // namespace cornice::compare
