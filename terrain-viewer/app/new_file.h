// SPDX-License-Identifier: GPL-3.0-or-later
// Names for files that a window writes.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace cornice::viewer {

/// `stem`, or `stem`-2, -3, ... : the first with which no file of these endings (".png") is there.
/// A file that is not to be seen counts as not there.
std::string unused_stem(const std::filesystem::path& folder, const std::string& stem,
                        const std::vector<std::string>& endings);

/// "20261122-235959", local time.
std::string time_stamp();

}  // namespace cornice::viewer
