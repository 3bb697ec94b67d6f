// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/codec_fields.h"

#include <algorithm>

#include "hlod/octahedral.h"

namespace cornice::hlod {
namespace {

/// Guesses of a channel from the reference vertices (a, b, o).
enum class Guess {
  kNear,           ///< a
  kBetween,        ///< the mean of a and b
  kParallelogram,  ///< a + b - o
};

struct Channel {
  std::uint32_t attribute;  ///< one of AttributeBits
  int bits;                 ///< 8 or 16; differences wrap around there
  Guess guess;
  std::uint16_t (*get)(const CellVertex& vertex);
  void (*set)(CellVertex& vertex, std::uint16_t value);
};

template <std::size_t component>
constexpr Channel colour_channel() {
  return {
      kHasColour, 8, Guess::kBetween,
      [](const CellVertex& v) -> std::uint16_t { return v.colour[component]; },
      [](CellVertex& v, std::uint16_t x) { v.colour[component] = static_cast<std::uint8_t>(x); }};
}

template <std::size_t component>
constexpr Channel texture_channel() {
  return {kHasTexture, 16, Guess::kParallelogram,
          [](const CellVertex& v) { return v.texture[component]; },
          [](CellVertex& v, std::uint16_t x) { v.texture[component] = x; }};
}

/// In the order in which they are stored.
constexpr std::array<Channel, 7> kChannels{
    Channel{kHasSupport, 16, Guess::kBetween, [](const CellVertex& v) { return v.support; },
            [](CellVertex& v, std::uint16_t x) { v.support = x; }},
    Channel{kHasSource, 8, Guess::kNear,
            [](const CellVertex& v) -> std::uint16_t { return v.source; },
            [](CellVertex& v, std::uint16_t x) { v.source = static_cast<std::uint8_t>(x); }},
    colour_channel<0>(),
    colour_channel<1>(),
    colour_channel<2>(),
    texture_channel<0>(),
    texture_channel<1>()};

std::uint32_t low_bits(int bits) { return (1u << bits) - 1u; }

std::uint32_t wrapped_normal(std::int16_t component) {
  return static_cast<std::uint32_t>(std::int32_t{component});
}

/// Of vertex v; the first vertex has no other to be guessed from.
std::uint32_t guess_of(const Channel& channel, std::span<const CellVertex> vertices, std::size_t v,
                       const SmallTriangle& r) {
  if (v == 0) return 0;
  const std::uint32_t a = channel.get(vertices[r[0]]);
  if (channel.guess == Guess::kNear) return a;
  const std::uint32_t b = channel.get(vertices[r[1]]);
  if (channel.guess == Guess::kBetween) return (a + b + 1) / 2;
  return (a + b - channel.get(vertices[r[2]])) & low_bits(channel.bits);
}

template <class T>
void write_planes(BlockWriter& block, std::span<const T> codes, int bits) {
  T used = 0;
  for (const T code : codes) used |= code;
  std::vector<std::uint8_t> plane(codes.size());
  for (int shift = 0; shift < bits; shift += 8) {
    if ((used >> shift & 255u) == 0) {
      block.zeros();
      continue;
    }
    for (std::size_t i = 0; i < codes.size(); ++i) {
      plane[i] = static_cast<std::uint8_t>(codes[i] >> shift);
    }
    block.stream(plane);
  }
}

}  // namespace

void write_codes(BlockWriter& block, std::span<const std::uint32_t> codes, int bits) {
  write_planes(block, codes, bits);
}
void write_codes(BlockWriter& block, std::span<const std::uint16_t> codes, int bits) {
  write_planes(block, codes, bits);
}

void read_codes(BlockReader& block, std::span<std::uint32_t> codes, int bits) {
  std::vector<std::uint8_t> plane(codes.size());
  block.stream(plane);
  std::copy(plane.begin(), plane.end(), codes.begin());
  for (int shift = 8; shift < bits; shift += 8) {
    if (!block.stream(plane)) continue;
    for (std::size_t i = 0; i < codes.size(); ++i) {
      codes[i] |= static_cast<std::uint32_t>(plane[i]) << shift;
    }
  }
}

void write_normals(BlockWriter& block, std::span<const CellVertex> vertices,
                   std::span<const PackedNormal> guesses, int bits) {
  std::vector<std::uint16_t> codes(vertices.size());
  for (std::size_t c = 0; c < 2; ++c) {
    for (std::size_t v = 0; v < vertices.size(); ++v) {
      codes[v] = static_cast<std::uint16_t>(difference_code(wrapped_normal(vertices[v].normal[c]),
                                                            wrapped_normal(guesses[v][c]), bits));
    }
    write_codes(block, codes, bits);
  }
}

bool read_normals(BlockReader& block, std::span<CellVertex> vertices,
                  std::span<const PackedNormal> guesses, int bits) {
  const int limit = octahedral_limit(bits), shift = 32 - bits;
  std::vector<std::uint32_t> codes(vertices.size());
  bool good = true;
  for (std::size_t c = 0; c < 2; ++c) {
    read_codes(block, codes, bits);
    for (std::size_t v = 0; v < vertices.size(); ++v) {
      const std::uint32_t sum = wrapped_normal(guesses[v][c]) + unzigzag(codes[v]);
      const std::int32_t value = static_cast<std::int32_t>(sum << shift) >> shift;
      good = good && value >= -limit;
      vertices[v].normal[c] = static_cast<std::int16_t>(value);
    }
  }
  return good;
}

void write_channels(BlockWriter& block, std::span<const CellVertex> vertices,
                    std::span<const SmallTriangle> references, std::uint32_t attributes) {
  std::vector<std::uint16_t> codes(vertices.size());
  for (const Channel& channel : kChannels) {
    if ((attributes & channel.attribute) == 0) continue;
    for (std::size_t v = 0; v < vertices.size(); ++v) {
      codes[v] = static_cast<std::uint16_t>(difference_code(
          channel.get(vertices[v]), guess_of(channel, vertices, v, references[v]), channel.bits));
    }
    write_codes(block, codes, channel.bits);
  }
}

void read_channels(BlockReader& block, std::span<CellVertex> vertices,
                   std::span<const SmallTriangle> references, std::uint32_t attributes) {
  std::vector<std::uint32_t> codes(vertices.size());
  for (const Channel& channel : kChannels) {
    if ((attributes & channel.attribute) == 0) continue;
    read_codes(block, codes, channel.bits);
    for (std::size_t v = 0; v < vertices.size(); ++v) {
      const std::uint32_t guess = guess_of(channel, vertices, v, references[v]);
      channel.set(vertices[v],
                  static_cast<std::uint16_t>(from_difference(codes[v], guess, channel.bits)));
    }
  }
}

void write_channels_near(BlockWriter& block, std::span<const CellVertex> vertices,
                         std::span<const CellVertex> like, std::span<const std::uint16_t> which,
                         std::uint32_t attributes) {
  std::vector<std::uint16_t> codes(vertices.size());
  for (const Channel& channel : kChannels) {
    if ((attributes & channel.attribute) == 0) continue;
    for (std::size_t v = 0; v < vertices.size(); ++v) {
      codes[v] = static_cast<std::uint16_t>(
          difference_code(channel.get(vertices[v]), channel.get(like[which[v]]), channel.bits));
    }
    write_codes(block, codes, channel.bits);
  }
}

void read_channels_near(BlockReader& block, std::span<CellVertex> vertices,
                        std::span<const CellVertex> like, std::span<const std::uint16_t> which,
                        std::uint32_t attributes) {
  std::vector<std::uint32_t> codes(vertices.size());
  for (const Channel& channel : kChannels) {
    if ((attributes & channel.attribute) == 0) continue;
    read_codes(block, codes, channel.bits);
    for (std::size_t v = 0; v < vertices.size(); ++v) {
      channel.set(vertices[v], static_cast<std::uint16_t>(from_difference(
                                   codes[v], channel.get(like[which[v]]), channel.bits)));
    }
  }
}

}  // namespace cornice::hlod
