// SPDX-License-Identifier: GPL-3.0-or-later
// The one way to stderr: whole lines and a progress bar that do not run into each other.
// Thread contract: every function may be called from any thread.
#pragma once

#include <string>

namespace cornice {

/// True where stderr is a terminal that can redraw a line.
bool console_is_terminal();

/// Columns of the terminal; 80 where not known.
int console_width();

/// Writes one line; line breaks and control characters within it become spaces. A bar on screen
/// moves below it.
void console_line(const std::string& line);

/// Shows `text` in place of the bar that is there; empty: takes it away.
void console_bar(const std::string& text);

}  // namespace cornice
