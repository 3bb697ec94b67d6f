// SPDX-License-Identifier: GPL-3.0-or-later
// Files of fields and bands: docs/formats/field.md.
#pragma once

#include <cstdint>
#include <filesystem>

#include "stages/poisson/band.h"

namespace cornice {

/// What the head of a file says.
struct FieldHead {
  Lattice lattice;
  LatticeBox tile;
  std::int32_t ramp = 0;
  bool is_band = false;
  std::string crs_text;
  std::uint64_t bricks = 0;  ///< of all levels
};

/// Writes atomically. Throws RunError where the disk is full.
void write_field(const std::filesystem::path& path, const TileField& tile);

/// Both throw InputError, in one line, for what is no such file, is damaged (checksums), truncated,
/// longer than it says, or says what no field can be. Nothing is allocated on the word of a head
/// that the file's length does not bear out.
FieldHead read_field_head(const std::filesystem::path& path);
TileField read_field(const std::filesystem::path& path);

}  // namespace cornice
