// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/compare/svg.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace cornice::compare {
namespace {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", value == 0.0 ? 0.0 : value);
  return text;
}

/// As many digits as a tick of that step needs.
std::string tick_text(double value, double step) {
  const int digits = std::max(0, -static_cast<int>(std::floor(std::log10(step) + 1e-9)));
  char text[48];
  std::snprintf(text, sizeof text, "%.*f", digits, value == 0.0 ? 0.0 : value);
  return text;
}

}  // namespace

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '&')
      out += "&amp;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  }
  return out;
}

std::string svg_move(double x, double y) { return "M" + number(x) + " " + number(y); }
std::string svg_line(double x, double y) { return "L" + number(x) + " " + number(y); }

double tick_step(double range, int most) {
  if (!(range > 0.0)) return 1.0;
  double step = std::pow(10.0, std::floor(std::log10(range / most)));
  for (const double factor : {1.0, 2.0, 5.0, 10.0}) {
    if (range / (step * factor) <= most) return step * factor;
  }
  return 10.0 * step;
}

Svg::Svg(double width, double height) : width_(width), height_(height) {}

void Svg::path(const std::string& commands, const std::string& colour, double width) {
  if (commands.empty()) return;
  body_ += "<path d=\"" + commands + "\" fill=\"none\" stroke=\"" + colour + "\" stroke-width=\"" +
           number(width) + "\" stroke-linecap=\"round\"/>\n";
}

void Svg::rectangle(const PlotBox& box, const std::string& fill) {
  body_ += "<rect x=\"" + number(box.left) + "\" y=\"" + number(box.top) + "\" width=\"" +
           number(box.width) + "\" height=\"" + number(box.height) + "\" fill=\"" + fill + "\"/>\n";
}

void Svg::text(double x, double y, const std::string& text, const std::string& anchor) {
  body_ += "<text x=\"" + number(x) + "\" y=\"" + number(y) + "\" text-anchor=\"" + anchor + "\">" +
           escaped(text) + "</text>\n";
}

void Svg::key(double x, double y, const std::string& colour, const std::string& name) {
  path(svg_move(x, y) + svg_line(x + 24.0, y), colour, 3.0);
  text(x + 30.0, y + 4.0, name);
}

void Svg::axes(const PlotBox& box, const std::array<double, 2>& x, const std::array<double, 2>& y) {
  std::string lines;
  const double step_x = tick_step(x[1] - x[0], 10), step_y = tick_step(y[1] - y[0], 7);
  for (double v = std::ceil(x[0] / step_x - 1e-9) * step_x; v <= x[1] + 1e-9; v += step_x) {
    const double at = box.left + (v - x[0]) / (x[1] - x[0]) * box.width;
    lines += svg_move(at, box.top) + svg_line(at, box.top + box.height);
    text(at, box.top + box.height + 16.0, tick_text(v, step_x), "middle");
  }
  for (double v = std::ceil(y[0] / step_y - 1e-9) * step_y; v <= y[1] + 1e-9; v += step_y) {
    const double at = box.top + (y[1] - v) / (y[1] - y[0]) * box.height;
    lines += svg_move(box.left, at) + svg_line(box.left + box.width, at);
    text(box.left - 6.0, at + 4.0, tick_text(v, step_y), "end");
  }
  path(lines, "#dddddd", 1.0);
}

std::string Svg::finish() const {
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + number(width_) + " " +
         number(height_) + "\" width=\"" + number(width_) + "\" height=\"" + number(height_) +
         "\" font-family=\"sans-serif\" font-size=\"12\" fill=\"#333333\">\n" + body_ + "</svg>\n";
}

}  // namespace cornice::compare
