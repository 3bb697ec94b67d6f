// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

namespace cornice::test {

/// What a program did.
struct ProcessResult {
  int exit_code = 0;  ///< 128 + n where signal n killed it
  std::string out;
  std::string err;
};

/// Runs a program to its end; arguments[0] is its path or name on PATH. Where signal_number is not
/// 0 it is sent as soon as the file `signal_when` is not empty.
ProcessResult run_process(const std::vector<std::string>& arguments, int signal_number = 0,
                          const std::string& signal_when = "");

/// Number of lines of a text.
std::size_t line_count(const std::string& text);

}  // namespace cornice::test
