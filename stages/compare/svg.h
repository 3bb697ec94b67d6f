// SPDX-License-Identifier: GPL-3.0-or-later
// Line drawings and plots as SVG text.
#pragma once

#include <array>
#include <string>

namespace cornice::compare {

/// Text that XML and HTML take as it is meant.
std::string escaped(const std::string& text);

/// Path commands, hundredths of a pixel.
std::string svg_move(double x, double y);
std::string svg_line(double x, double y);

struct PlotBox {
  double left, top, width, height;
};

/// The largest of 1, 2 or 5 times a power of ten that gives at most `most` steps over `range`.
double tick_step(double range, int most);

class Svg {
 public:
  Svg(double width, double height);
  void path(const std::string& commands, const std::string& colour, double width);
  void rectangle(const PlotBox& box, const std::string& fill);
  /// anchor: start, middle or end.
  void text(double x, double y, const std::string& text, const std::string& anchor = "start");
  /// A stroke of colour with its name.
  void key(double x, double y, const std::string& colour, const std::string& name);
  /// Frame, grid lines and numbers of both axes over values [from, to].
  void axes(const PlotBox& box, const std::array<double, 2>& x, const std::array<double, 2>& y);
  /// The whole document.
  std::string finish() const;

 private:
  double width_, height_;
  std::string body_;
};

}  // namespace cornice::compare
