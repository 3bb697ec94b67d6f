// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/io/laz_chunk_table.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/base/random.h"
#include "core/io/byte_source.h"
#include "core/io/las_chunks.h"
#include "core/io/las_header.h"
#include "core/io/little_endian.h"
#include "tests/property/las_writer/clouds.h"
#include "tests/support/temporary_folder.h"

namespace cornice::test {
namespace {

std::vector<LazChunk> chunks_of(std::size_t count, bool with_counts, std::uint64_t seed) {
  std::vector<LazChunk> chunks;
  for (std::size_t i = 0; i < count; ++i) {
    CounterRandom random(seed, 0, i);
    // Spread over all magnitudes, so that every interval of the code is met.
    const auto number = [&] {
      return static_cast<std::uint32_t>(random.bits() >> (32 + random.bits() % 32));
    };
    const std::uint32_t points = number();
    chunks.push_back({with_counts ? points : 0, number()});
  }
  return chunks;
}

TEST(LazChunkTable, WhatWasEncodedIsDecoded) {
  for (const bool with_counts : {false, true}) {
    for (const std::size_t count : {0u, 1u, 2u, 17u, 5000u}) {
      const auto chunks = chunks_of(count, with_counts, count);
      const auto bytes = encode_chunk_table(chunks, with_counts);
      EXPECT_EQ(decode_chunk_table(bytes, with_counts, count), chunks);
    }
  }
}

TEST(LazChunkTable, ExtremeDifferencesSurvive) {
  constexpr std::uint32_t kMost = std::numeric_limits<std::uint32_t>::max();
  const std::vector<LazChunk> chunks = {{0, 0},      {kMost, kMost}, {0, 0x80000000u},
                                        {1, 0},      {0, 1},         {0x80000000u, 0x7fffffffu},
                                        {kMost, 0u}, {2, 3}};
  EXPECT_EQ(decode_chunk_table(encode_chunk_table(chunks, true), true, 100), chunks);
}

TEST(LazChunkTable, BytesBehindTheTableDoNotMatter) {
  const auto chunks = chunks_of(50, true, 1);
  auto bytes = encode_chunk_table(chunks, true);
  bytes.insert(bytes.end(), 100, 0xa5);
  EXPECT_EQ(decode_chunk_table(bytes, true, 50), chunks);
}

TEST(LazChunkTable, ATableThatEndsEarlyIsRefused) {
  const auto chunks = chunks_of(200, true, 2);
  const auto bytes = encode_chunk_table(chunks, true);
  for (const std::size_t size : {std::size_t{0}, std::size_t{7}, bytes.size() / 2}) {
    EXPECT_EQ(decode_chunk_table(std::span(bytes).first(size), true, 200), std::nullopt) << size;
  }
}

TEST(LazChunkTable, MoreChunksThanThereCanBeAreRefusedBeforeMemoryIsTaken) {
  auto bytes = encode_chunk_table(chunks_of(3, true, 3), true);
  store_le<std::uint32_t>(bytes, 4, 0xffffffffu);
  EXPECT_EQ(decode_chunk_table(bytes, true, 1000), std::nullopt);
}

TEST(LazChunkTable, AnUnknownVersionIsRefused) {
  auto bytes = encode_chunk_table(chunks_of(3, true, 4), true);
  bytes[0] = 1;
  EXPECT_EQ(decode_chunk_table(bytes, true, 1000), std::nullopt);
}

TEST(LazChunkTable, GarbageEndsWithoutHarm) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    CounterRandom random(seed, 9, 0);
    std::vector<std::uint8_t> bytes;
    append_le<std::uint32_t>(bytes, 0);
    append_le<std::uint32_t>(bytes, 500);
    for (std::size_t i = random.bits() % 3000; i > 0; --i) {
      bytes.push_back(static_cast<std::uint8_t>(random.bits()));
    }
    const auto chunks = decode_chunk_table(bytes, seed % 2 == 0, 500);
    EXPECT_EQ(chunks ? chunks->size() : 500u, 500u);
  }
}

/// LASzip's own table in a file it wrote, byte for byte, and the sums it stands for.
TEST(LazChunkTable, TheTableThatLaszipWroteIsReadAndWrittenTheSame) {
  const TemporaryFolder folder;
  for (const int format : {1, 6}) {
    LasWriteOptions options;
    options.point_format = format;
    options.chunk_points = 100;
    const auto path = folder / "a.laz";
    {
      LasWriter writer(path, options);
      writer.write(sample_cloud(1234, options, 5));
      writer.close();
    }
    const auto source = open_point_file(path).bytes;
    const LasInfo info = read_las_info(path);
    const auto file = read_bytes(*source, 0, static_cast<std::size_t>(source->size()));
    const auto table_at =
        static_cast<std::size_t>(load_le<std::uint64_t>(file, info.point_data_offset));
    const std::span<const std::uint8_t> table = std::span(file).subspan(table_at);
    const auto chunks = decode_chunk_table(table, false, 1000);
    ASSERT_TRUE(chunks);
    EXPECT_EQ(chunks->size(), 13u);
    std::uint64_t sum = info.point_data_offset + 8;
    for (const LazChunk& chunk : *chunks) sum += chunk.bytes;
    EXPECT_EQ(sum, table_at);
    const auto again = encode_chunk_table(*chunks, false);
    ASSERT_LE(again.size(), table.size());
    EXPECT_TRUE(std::equal(again.begin(), again.end(), table.begin()));
  }
}

}  // namespace
}  // namespace cornice::test
