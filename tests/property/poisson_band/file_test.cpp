// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>
#include <xxhash.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <limits>

#include "core/base/error.h"
#include "core/base/random.h"
#include "stages/poisson/band_file.h"
#include "tests/property/poisson_extract/fields.h"
#include "tests/support/full_disk.h"
#include "tests/support/temporary_folder.h"

namespace cornice {
namespace {

using namespace cornice::test;

TileField small_field() {
  return {sampled_adaptively(smooth_noise(1, 9.0), {{-2, -2, -1}, {2, 2, 1}}, 3,
                             [](int, BrickKey b) { return (b.x + b.y) % 2 == 0; }),
          {-9, -10, 11, 12},
          16,
          "EPSG:2056+5728",
          false,
          -40,
          77};
}

void write_bytes(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

/// What reading says, or "" where it reads.
std::string complaint(const std::filesystem::path& path) {
  try {
    read_field(path);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

/// Makes the checksums right again, so that what a test changed is what is refused.
void seal(std::string& bytes) {
  constexpr std::size_t kHead = 96;
  const std::uint64_t body = XXH3_64bits(bytes.data() + kHead, bytes.size() - kHead);
  std::memcpy(bytes.data() + 80, &body, 8);
  const std::uint64_t head = XXH3_64bits(bytes.data(), 88);
  std::memcpy(bytes.data() + 88, &head, 8);
}

template <class T>
void put(std::string& bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof(T));
}

TEST(FieldFile, HoldsAFieldToTheBit) {
  const TemporaryFolder folder;
  const TileField written = small_field();
  const auto path = folder.path() / "a.field";
  write_field(path, written);
  const TileField read = read_field(path);
  EXPECT_EQ(read.tile, written.tile);
  EXPECT_EQ(read.ramp, written.ramp);
  EXPECT_EQ(read.crs_text, written.crs_text);
  EXPECT_EQ(read.z0, -40);
  EXPECT_EQ(read.z1, 77);
  EXPECT_EQ(read.is_band, written.is_band);
  EXPECT_EQ(read.field.lattice(), written.field.lattice());
  ASSERT_EQ(read.field.levels().size(), written.field.levels().size());
  for (std::size_t l = 0; l < read.field.levels().size(); ++l) {
    EXPECT_EQ(read.field.levels()[l].bricks, written.field.levels()[l].bricks);
    EXPECT_EQ(read.field.levels()[l].values, written.field.levels()[l].values);
  }
  const FieldHead head = read_field_head(path);
  EXPECT_EQ(head.tile, written.tile);
  EXPECT_EQ(head.crs_text, written.crs_text);
  EXPECT_FALSE(head.is_band);
}

TEST(FieldFile, AnEmptyFieldIsAFile) {
  const TemporaryFolder folder;
  const TileField empty{Field({0.5}, {}), {0, 0, 10, 10}, 8, "", true};
  write_field(folder.path() / "e.band", empty);
  const TileField read = read_field(folder.path() / "e.band");
  EXPECT_TRUE(read.field.levels().empty());
  EXPECT_TRUE(read.is_band);
}

TEST(FieldFile, EveryTruncationIsRefused) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a.field";
  write_field(path, small_field());
  const std::string bytes = test::read_text(path);
  for (std::size_t length = 0; length < bytes.size();
       length += length < 200 ? 1 : 1 + bytes.size() / 50) {
    write_bytes(path, bytes.substr(0, length));
    EXPECT_NE(complaint(path), "") << length;
  }
  write_bytes(path, bytes + "x");
  EXPECT_NE(complaint(path).find("bytes instead of"), std::string::npos);
}

TEST(FieldFile, EveryChangedByteIsNoticed) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a.field";
  write_field(path, small_field());
  const std::string bytes = test::read_text(path);
  for (int trial = 0; trial < 300; ++trial) {
    CounterRandom random(1, 2, static_cast<std::uint64_t>(trial));
    std::string changed = bytes;
    const std::size_t at =
        trial < 96 ? static_cast<std::size_t>(trial)
                   : static_cast<std::size_t>(random.uniform() * static_cast<double>(bytes.size()));
    changed[at] = static_cast<char>(changed[at] ^ static_cast<char>(1 + random.bits() % 255));
    write_bytes(path, changed);
    const std::string said = complaint(path);
    EXPECT_NE(said, "") << at;
    EXPECT_EQ(said.find('\n'), std::string::npos);
  }
}

TEST(FieldFile, AHeadThatLiesIsRefusedBeforeAnythingIsAllocated) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a.field";
  write_field(path, small_field());
  const std::string bytes = test::read_text(path);
  const std::vector<std::pair<std::string, std::function<void(std::string&)>>> lies{
      {"bricks", [](std::string& b) { put<std::uint64_t>(b, 64, std::uint64_t{1} << 60); }},
      {"length", [](std::string& b) { put<std::uint64_t>(b, 72, ~std::uint64_t{0}); }},
      {"levels", [](std::string& b) { put<std::uint32_t>(b, 52, 0xffffffffu); }},
      {"crs", [](std::string& b) { put<std::uint32_t>(b, 56, 0xfffffff0u); }},
      {"step", [](std::string& b) { put<double>(b, 16, 0.0); }},
      {"step", [](std::string& b) { put<double>(b, 16, std::nan("")); }},
      {"tile", [](std::string& b) { put<std::int32_t>(b, 24, 100); }},
      {"tile", [](std::string& b) { put<std::int32_t>(b, 24, std::numeric_limits<int>::min()); }},
      {"heights", [](std::string& b) { put<std::int32_t>(b, 40, 1000); }},
      {"ramp", [](std::string& b) { put<std::int32_t>(b, 48, -3); }},
      {"version", [](std::string& b) { put<std::uint32_t>(b, 8, 2); }},
      {"kind", [](std::string& b) { put<std::uint32_t>(b, 12, 7); }},
      {"level", [](std::string& b) { put<std::uint64_t>(b, 96 + 14, 1u << 30); }},
      {"order", [](std::string& b) { put<std::int32_t>(b, 96 + 14 + 8, 1000); }},
      {"far", [](std::string& b) { put<std::int32_t>(b, 96 + 14 + 8, -(1 << 30)); }},
      {"value", [](std::string& b) { put<float>(b, b.size() - 4, std::nanf("")); }},
      {"value",
       [](std::string& b) { put<float>(b, b.size() - 4, std::numeric_limits<float>::infinity()); }},
  };
  for (const auto& [name, lie] : lies) {
    std::string changed = bytes;
    lie(changed);
    seal(changed);
    write_bytes(path, changed);
    const std::string said = complaint(path);
    EXPECT_NE(said, "") << name;
    EXPECT_EQ(said.find("checksum"), std::string::npos) << name << ": " << said;
  }
}

TEST(FieldFile, OtherFilesAreRefused) {
  const TemporaryFolder folder;
  EXPECT_NE(complaint(folder.path() / "missing"), "");
  EXPECT_NE(complaint(folder.path()), "");
  write_bytes(folder.path() / "text", std::string(5000, 'x'));
  EXPECT_NE(complaint(folder.path() / "text").find("no field of cornice-poisson"),
            std::string::npos);
}

TEST(FieldFile, AFullDiskIsAnErrorThatLeavesNothing) {
  const TemporaryFolder folder;
  const TileField field = small_field();
  const auto outcome =
      on_full_disk(folder.path(), [&] { write_field(folder.path() / "a.field", field); });
  if (!outcome) GTEST_SKIP() << "the system does not let a test mount a small disk";
  EXPECT_NE(outcome->find("a.field: cannot be written: the disk is full; free some space"),
            std::string::npos)
      << *outcome;
  EXPECT_EQ(outcome->find('|'), std::string::npos) << *outcome;
}

}  // namespace
}  // namespace cornice
