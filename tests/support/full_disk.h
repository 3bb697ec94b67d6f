// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

namespace cornice::test {

/// Runs `body` in a child process that sees `folder` as a disk of 64 KiB. Returns what() of the
/// RunError that it throws and the names of the files left in the folder, "WHAT|NAME|NAME..."; ""
/// for what() where it throws none. Nothing where this machine lets nobody mount.
std::optional<std::string> on_full_disk(const std::filesystem::path& folder,
                                        const std::function<void()>& body);

}  // namespace cornice::test
