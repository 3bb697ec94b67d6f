// SPDX-License-Identifier: GPL-3.0-or-later
// cornice-hlod build as it is run.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <iterator>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/io/ply.h"
#include "tests/support/full_disk.h"
#include "tests/support/meshes.h"
#include "tests/support/process.h"
#include "tests/support/temporary_folder.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;
using test::ProcessResult;
using test::TemporaryFolder;

std::vector<std::string> command_line(const std::vector<fs::path>& inputs, const fs::path& output,
                                      const std::vector<std::string>& more) {
  std::vector<std::string> words{(fs::path(CORNICE_BIN_DIR) / "cornice-hlod").string(), "build"};
  for (const fs::path& input : inputs) words.push_back(input.string());
  words.insert(words.end(), {"-o", output.string(), "--no-progress"});
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

ProcessResult run_build(const std::vector<fs::path>& inputs, const fs::path& output,
                        const std::vector<std::string>& more = {}) {
  return test::run_process(command_line(inputs, output, more));
}

/// The number after `name` in the summary; 0 where it is not there.
long count_told(const std::string& log, const std::string& name) {
  const std::size_t at = log.find(" " + name + " ");
  return at == std::string::npos ? 0 : std::stol(log.substr(at + name.size() + 2));
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
    const ProcessResult in_memory = run_build(tiles, folder / "memory.hlod", small);
    ASSERT_EQ(in_memory.exit_code, 0) << in_memory.err;
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
    const ProcessResult joined = run_build(regions, folder / "joined.hlod", {"--join"});
    ASSERT_EQ(joined.exit_code, 0) << joined.err;
    EXPECT_EQ(count_told(joined.err, "triangles_in"), 21600);
    EXPECT_TRUE(test::read_text(folder / "joined.hlod") == bytes);
    // The same with cells on disk.
    std::vector<fs::path> disk_regions;
    for (const std::string region : {"1/2", "2/2"}) {
      std::vector<std::string> one = disk;
      one.insert(one.end(), {"--region", region});
      disk_regions.push_back(folder / ("disk" + region.substr(0, 1) + ".part"));
      ASSERT_EQ(run_build(tiles, disk_regions.back(), one).exit_code, 0);
    }
    const ProcessResult all =
        run_build(disk_regions, folder / "all.hlod", {"--join", "--out-of-core"});
    ASSERT_EQ(all.exit_code, 0) << all.err;
    EXPECT_EQ(count_told(all.err, "triangles_in"), 21600);
    EXPECT_TRUE(test::read_text(folder / "all.hlod") == bytes);
    EXPECT_FALSE(fs::exists(folder / ".all.hlod.work"));
    regions.pop_back();
    const ProcessResult missing = run_build(regions, folder / "missing.hlod", {"--join"});
    EXPECT_EQ(missing.exit_code, 3) << missing.err;
    EXPECT_FALSE(fs::exists(folder / "missing.hlod"));
  }
}

/// Starts a build and kills it once `file` is in its work folder; false where it ended before.
bool kill_when(const std::vector<fs::path>& inputs, const fs::path& output,
               const std::vector<std::string>& more, const std::string& file) {
  const fs::path work = output.parent_path() / ("." + output.filename().string() + ".work");
  const pid_t child = ::fork();
  if (child == 0) {
    std::vector<std::string> words = command_line(inputs, output, more);
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    ::execv(arguments.front(), arguments.data());
    ::_exit(127);
  }
  int status = 0;
  while (::waitpid(child, &status, WNOHANG) == 0) {
    if (!fs::exists(work / file)) {
      ::usleep(200);
      continue;
    }
    ::kill(child, SIGKILL);
    ::waitpid(child, &status, 0);
  }
  return WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL;
}

TEST(HlodBuild, GoesOnAfterAKillToTheSameBytes) {
  const TemporaryFolder folder;
  const std::vector<fs::path> tiles = write_tiles(folder);
  const std::vector<std::string> options{"--cell-side", "8", "--out-of-core"};
  ASSERT_EQ(run_build(tiles, folder / "whole.hlod", options).exit_code, 0);
  const std::string bytes = test::read_text(folder / "whole.hlod");
  const fs::path work = folder / ".a.hlod.work";
  // Each kill finds the next file of the build; one that comes too late finds a whole output.
  for (const std::string file : {"joined.spool", "leaves.spool", "level-3.spool"}) {
    if (!kill_when(tiles, folder / "a.hlod", options, file)) break;
    EXPECT_FALSE(fs::exists(folder / "a.hlod")) << file;
  }
  if (!fs::exists(folder / "a.hlod")) {
    ASSERT_EQ(run_build(tiles, folder / "a.hlod", options).exit_code, 0);
  }
  EXPECT_TRUE(test::read_text(folder / "a.hlod") == bytes);
  EXPECT_FALSE(fs::exists(work));
  // Nothing is left but the tiles and the two files.
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator{}), 5);
}

TEST(HlodBuild, TakesObjAndKeepsToItsMemory) {
  const TemporaryFolder folder;
  std::string text;
  for (int v = 0; v < 400; ++v) {
    text += "v " + std::to_string(v % 20) + " " + std::to_string(v / 20) + " " +
            std::to_string(v % 7) + "\n";
  }
  for (int row = 0; row < 19; ++row) {
    for (int column = 1; column < 20; ++column) {
      const int a = row * 20 + column;
      text += "f " + std::to_string(a) + " " + std::to_string(a + 1) + " " +
              std::to_string(a + 21) + " " + std::to_string(a + 20) + "\n";
    }
  }
  test::write_text(folder / "a.obj", text);
  test::write_text(folder / "b.fbx", text);
  const ProcessResult obj = run_build({folder / "a.obj"}, folder / "a.hlod");
  if (obj.err.find("built without") == std::string::npos) {
    EXPECT_EQ(obj.exit_code, 0) << obj.err;
    EXPECT_NE(obj.err.find("triangles_in 722"), std::string::npos) << obj.err;
  }
  const ProcessResult other = run_build({folder / "b.fbx"}, folder / "b.hlod");
  EXPECT_EQ(other.exit_code, 3);
  EXPECT_EQ(test::line_count(other.err), 1u) << other.err;
  const ProcessResult small =
      run_build(write_tiles(folder), folder / "c.hlod", {"--memory", "0.1"});
  EXPECT_EQ(small.exit_code, 2);
  EXPECT_NE(small.err.find("at least 0.5 GiB"), std::string::npos) << small.err;
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
  // Three corners on a line are no surface.
  Mesh line;
  line.positions = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}};
  line.triangles = {{0, 1, 2}};
  write_ply(folder / "line.ply", line);
  for (const std::vector<std::string>& how : {std::vector<std::string>{}, {"--out-of-core"}}) {
    const ProcessResult flat = run_build({folder / "line.ply"}, folder / "a.hlod", how);
    EXPECT_EQ(flat.exit_code, 3);
    EXPECT_NE(flat.err.find("no triangle of the input has an area"), std::string::npos) << flat.err;
    EXPECT_EQ(test::line_count(flat.err), 1u) << flat.err;
  }
  EXPECT_EQ(run_build(tiles, folder / "a.txt").exit_code, 2);
  EXPECT_FALSE(fs::exists(folder / "a.hlod"));
  EXPECT_FALSE(fs::exists(folder / ".a.hlod.work"));
}

TEST(HlodBuild, WarnsOfFloatsFarFromTheirOrigin) {
  const TemporaryFolder folder;
  const Mesh mesh =
      test::height_mesh(2'600'000, 1'200'000, 20, 1, [](double, double) { return 0.0; });
  write_ply(folder / "far.ply", mesh);
  for (const std::vector<std::string>& how : {std::vector<std::string>{}, {"--out-of-core"}}) {
    const ProcessResult far = run_build({folder / "far.ply"}, folder / "far.hlod", how);
    EXPECT_EQ(far.exit_code, 0) << far.err;
    EXPECT_NE(far.err.find("far.ply: positions are floats up to 2600020 m from their origin, "
                           "known to 0.25 m only"),
              std::string::npos)
        << far.err;
    fs::remove(folder / "far.hlod");
  }
  EXPECT_EQ(run_build(write_tiles(folder), folder / "near.hlod").err.find("warning"),
            std::string::npos);
}

TEST(HlodBuild, SaysWhatAFullDiskLeaves) {
  const TemporaryFolder folder, disk;
  const std::vector<fs::path> tiles = write_tiles(folder);
  const auto outcome = test::on_full_disk(disk.path(), [&] {
    throw RunError("", run_build(tiles, disk / "a.hlod", {"--out-of-core"}).err);
  });
  if (!outcome) GTEST_SKIP() << "nobody may mount a small disk here";
  EXPECT_NE(outcome->find("the disk is full"), std::string::npos) << *outcome;
  // The first file of the build was not whole, so that nothing is left.
  EXPECT_EQ(outcome->find('|'), std::string::npos) << *outcome;
  EXPECT_EQ(outcome->find("keeps"), std::string::npos) << *outcome;
}

}  // namespace
}  // namespace cornice
