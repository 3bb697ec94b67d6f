// SPDX-License-Identifier: GPL-3.0-or-later
// Files that are read: what is wrong with one, said before any of it is read.
#pragma once

#include <filesystem>

namespace cornice {

/// Throws InputError, with the remedy, where `path` is not a regular file that may be read. Opening
/// a pipe would wait for a writer, and what has no size cannot be checked against its header.
void check_input_file(const std::filesystem::path& path);

/// Throws InputError where the path is not UTF-8: files of text that name it could not.
void check_utf8_name(const std::filesystem::path& path);

}  // namespace cornice
