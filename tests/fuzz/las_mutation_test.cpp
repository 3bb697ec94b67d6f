// SPDX-License-Identifier: GPL-3.0-or-later
// A short, repeatable run of what the fuzzer does, with any compiler.
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/base/random.h"
#include "tests/fuzz/las_entry.h"
#include "tests/fuzz/las_seeds.h"
#include "tests/support/temporary_folder.h"

namespace cornice::test {
namespace {

/// One to eight changes: bits, bytes, numbers of interest, a cut, a stretch moved elsewhere.
Bytes mutated(Bytes bytes, std::uint64_t seed) {
  CounterRandom random(seed, 77, 0);
  for (std::uint64_t n = 1 + random.bits() % 8; n > 0 && bytes.size() > 8; --n) {
    // Half of the changes fall into the header and the first records.
    const std::size_t reach =
        random.bits() % 2 == 0 ? std::min<std::size_t>(bytes.size(), 500) : bytes.size();
    const std::size_t at = random.bits() % (reach - 8 + (reach == 8 ? 1 : 0));
    constexpr std::uint64_t kInteresting[] = {
        0,          1,          0x7f,  0xff,      0x7fff,     0xffff, 0x7fffffff,
        0xffffffff, 0x80000000, ~0ull, ~0ull / 2, 1ull << 63, 375,    0x7ff8ull << 48};
    const std::uint64_t number = kInteresting[random.bits() % std::size(kInteresting)];
    switch (random.bits() % 6) {
      case 0:
        bytes[at] ^= static_cast<std::uint8_t>(1u << random.bits() % 8);
        break;
      case 1:
        bytes[at] = static_cast<std::uint8_t>(random.bits());
        break;
      case 2:
        store_le<std::uint64_t>(bytes, at, number);
        break;
      case 3:
        store_le<std::uint32_t>(bytes, at, static_cast<std::uint32_t>(number));
        break;
      case 4:
        bytes.resize(at + 8);
        break;
      default:
        std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(random.bits() % (reach - 7)), 8,
                    bytes.begin() + static_cast<std::ptrdiff_t>(at));
    }
  }
  return bytes;
}

TEST(HostileBytes, SeedsPassForPointFiles) {
  for (const auto& [name, bytes] : las_seeds()) {
    EXPECT_EQ(parse_hostile_bytes(bytes), name != "lax") << name;
  }
}

TEST(HostileBytes, FortyThousandMutationsBreakNoPromise) {
  const auto seeds = las_seeds();
  std::uint64_t passed = 0;
  constexpr std::uint64_t kMutations = 40'000;
  for (std::uint64_t i = 0; i < kMutations; ++i) {
    // A vector of exactly that size: reading on behind it is seen by the address sanitizer.
    const Bytes bytes = mutated(seeds[i % seeds.size()].second, i);
    if (parse_hostile_bytes(bytes)) ++passed;
  }
  // Neither all refused nor all accepted: the mutations reach both sides of the checks.
  EXPECT_GT(passed, kMutations / 20);
  EXPECT_LT(passed, kMutations);
}

TEST(HostileBytes, EveryBeginningOfAFileIsHandled) {
  for (const auto& [name, bytes] : las_seeds()) {
    for (std::size_t size = 0; size < bytes.size(); size += 1 + size / 600) {
      parse_hostile_bytes(cut(bytes, size));
    }
  }
}

TEST(HostileBytes, MutatedFilesAreReadOrRefusedButNeverDoHarm) {
  const TemporaryFolder folder;
  const auto path = folder / "hostile.laz";
  const auto seeds = las_seeds();
  std::uint64_t read = 0;
  for (std::uint64_t i = 0; i < 1500; ++i) {
    write_file(path, mutated(seeds[i % seeds.size()].second, 1'000'000 + i));
    try {
      const LasInfo info = read_las_info(path, {.crs_override = "EPSG:2056"});
      LasReadOptions options{.attributes = Attribute::kAll, .threads = static_cast<int>(1 + i % 2)};
      options.keep_readable_part = true;
      const LasReadResult result = read_las(info, options);
      EXPECT_EQ(result.points.size(), result.points_decoded);
      ++read;
    } catch (const InputError&) {
    }
  }
  EXPECT_GT(read, 100u);
}

}  // namespace
}  // namespace cornice::test
