// SPDX-License-Identifier: GPL-3.0-or-later
// Where stitched tiles go: a folder of tiles, or one mesh.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "stages/stitch/command.h"
#include "stages/stitch/edit.h"
#include "stages/stitch/survey.h"

namespace cornice::stitch {

/// Takes tiles one by one.
class Output {
 public:
  virtual ~Output() = default;
  virtual void add(const std::filesystem::path& path, EditedTile& tile) = 0;
  /// Gives a single mesh its name. Without it nothing of that is left.
  virtual void finish() {}
};

/// What the command's --output and --format ask for.
std::unique_ptr<Output> open_output(const Command& command, const Survey& survey);

/// Memory of a stage that has the largest of these tiles in hand.
std::uint64_t bytes_of_largest(const std::vector<std::filesystem::path>& tiles);

}  // namespace cornice::stitch
