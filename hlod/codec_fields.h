// SPDX-License-Identifier: GPL-3.0-or-later
// What a vertex has beside its position, as channels of whole numbers that are
// guessed from other vertices and stored as differences.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "hlod/cell.h"
#include "hlod/codec_bytes.h"
#include "hlod/codec_walk.h"

namespace cornice::hlod {

/// A difference of numbers of `bits` bits, near 0, as a code of `bits` bits;
/// and back.
inline std::uint32_t difference_code(std::uint32_t value, std::uint32_t guess, int bits) {
  // Carried to the top of 32 bits and back, so that the sign is that of `bits`
  // bits.
  const int shift = 32 - bits;
  const auto difference = static_cast<std::int32_t>((value - guess) << shift) >> shift;
  return zigzag(static_cast<std::uint32_t>(difference)) & ((1u << bits) - 1u);
}
inline std::uint32_t from_difference(std::uint32_t code, std::uint32_t guess, int bits) {
  return (guess + unzigzag(code)) & ((1u << bits) - 1u);
}

/// Codes as one stream of bytes for each 8 of their bits, lowest first.
void write_codes(BlockWriter& block, std::span<const std::uint32_t> codes, int bits);
void write_codes(BlockWriter& block, std::span<const std::uint16_t> codes, int bits);
void read_codes(BlockReader& block, std::span<std::uint32_t> codes, int bits);

/// Normals of `bits` bits a component, guessed from `guesses`, one rounded pair
/// per vertex.
using PackedNormal = std::array<std::int16_t, 2>;
void write_normals(BlockWriter& block, std::span<const CellVertex> vertices,
                   std::span<const PackedNormal> guesses, int bits);
/// False where a normal comes out of its range.
bool read_normals(BlockReader& block, std::span<CellVertex> vertices,
                  std::span<const PackedNormal> guesses, int bits);

/// The channels of `attributes`, guessed over the walk's references.
void write_channels(BlockWriter& block, std::span<const CellVertex> vertices,
                    std::span<const SmallTriangle> references, std::uint32_t attributes);
void read_channels(BlockReader& block, std::span<CellVertex> vertices,
                   std::span<const SmallTriangle> references, std::uint32_t attributes);

/// The same, guessed from one other vertex each.
void write_channels_near(BlockWriter& block, std::span<const CellVertex> vertices,
                         std::span<const CellVertex> like, std::span<const std::uint16_t> which,
                         std::uint32_t attributes);
void read_channels_near(BlockReader& block, std::span<CellVertex> vertices,
                        std::span<const CellVertex> like, std::span<const std::uint16_t> which,
                        std::uint32_t attributes);

}  // namespace cornice::hlod
