// SPDX-License-Identifier: GPL-3.0-or-later
// cornice-hlod build as it is run.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "core/io/ply.h"
#include "tests/support/meshes.h"
#include "tests/support/process.h"
#include "tests/support/temporary_folder.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;
using test::ProcessResult;
using test::TemporaryFolder;

ProcessResult run_build(const std::vector<fs::path>& inputs, const fs::path& output,
                        const std::vector<std::string>& more = {}) {
  std::vector<std::string> words{(fs::path(CORNICE_BIN_DIR) / "cornice-hlod").string(), "build"};
  for (const fs::path& input : inputs) words.push_back(input.string());
  words.insert(words.end(), {"-o", output.string(), "--no-progress"});
  words.insert(words.end(), more.begin(), more.end());
  return test::run_process(words);
}

std::vector<fs::path> write_tiles(const TemporaryFolder& folder) {
  std::vector<fs::path> tiles;
  for (const double x : {0.0, 60.0, 120.0}) {
    tiles.push_back(folder / ("tile" + std::to_string(static_cast<int>(x)) + ".ply"));
    write_ply(tiles.back(), test::height_mesh(x, 0, 60, 1, [](double px, double py) {
                return 8 * std::sin(px / 9) * std::cos(py / 7) + std::sin(px + 2 * py);
              }));
  }
  return tiles;
}

TEST(HlodBuild, GivesTheSameBytesInMemoryOnDiskAndJoinedFromRegions) {
  for (const std::string partition : {"quadtree", "octree"}) {
    const TemporaryFolder folder;
    const std::vector<fs::path> tiles = write_tiles(folder);
    const std::vector<std::string> small{"--partition", partition, "--cell-side", "8"};
    ASSERT_EQ(run_build(tiles, folder / "memory.hlod", small).exit_code, 0);
    const std::string bytes = test::read_text(folder / "memory.hlod");
    std::vector<std::string> disk = small;
    disk.insert(disk.end(), {"--out-of-core", "--threads", "2"});
    ASSERT_EQ(run_build(tiles, folder / "disk.hlod", disk).exit_code, 0);
    EXPECT_TRUE(test::read_text(folder / "disk.hlod") == bytes);
    std::vector<fs::path> regions;
    for (const std::string region : {"1/3", "2/3", "3/3"}) {
      std::vector<std::string> one = small;
      one.insert(one.end(), {"--region", region});
      regions.push_back(folder / (region.substr(0, 1) + ".part"));
      ASSERT_EQ(run_build(tiles, regions.back(), one).exit_code, 0);
    }
    ASSERT_EQ(run_build(regions, folder / "joined.hlod", {"--join"}).exit_code, 0);
    EXPECT_TRUE(test::read_text(folder / "joined.hlod") == bytes);
    regions.pop_back();
    const ProcessResult missing = run_build(regions, folder / "missing.hlod", {"--join"});
    EXPECT_EQ(missing.exit_code, 3) << missing.err;
    EXPECT_FALSE(fs::exists(folder / "missing.hlod"));
  }
}

TEST(HlodBuild, SaysWhatIsWrongInOneLine) {
  const TemporaryFolder folder;
  const std::vector<fs::path> tiles = write_tiles(folder);
  EXPECT_EQ(run_build(tiles, folder / "a.hlod", {"--region", "4/3"}).exit_code, 2);
  EXPECT_EQ(run_build(tiles, folder / "a.hlod", {"--block-side", "6"}).exit_code, 2);
  EXPECT_EQ(run_build({folder / "none.ply"}, folder / "a.hlod").exit_code, 3);
  write_ply(folder / "empty.ply", Mesh{});
  const ProcessResult empty = run_build({folder / "empty.ply"}, folder / "a.hlod");
  EXPECT_EQ(empty.exit_code, 3);
  EXPECT_EQ(test::line_count(empty.err), 1u) << empty.err;
  EXPECT_FALSE(fs::exists(folder / "a.hlod"));
}

}  // namespace
}  // namespace cornice
