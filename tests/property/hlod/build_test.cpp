// SPDX-License-Identifier: GPL-3.0-or-later
// Whatever is built keeps the promises of the format, and is the same however it is built.
#include "hlod/build.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <limits>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/base/progress.h"
#include "core/io/mesh_stream.h"
#include "core/io/ply.h"
#include "hlod/build_disk.h"
#include "hlod/file.h"
#include "hlod/file_check.h"
#include "tests/support/meshes.h"
#include "tests/support/temporary_folder.h"

namespace cornice::hlod {
namespace {

using test::TemporaryFolder;

Mesh ground(double x, int cells, double step = 1) {
  return test::height_mesh(x, 0, cells, step, [](double px, double py) {
    return 9 * std::sin(px / 11) * std::cos(py / 7) + std::sin(px * 1.3 + py * 2.1);
  });
}

struct Built {
  std::string bytes;
  FileCheck check;
  LeafCounts leaves;
  std::vector<LevelCounts> levels;
};

BuildOptions small_cells(Partition partition) {
  BuildOptions options;
  options.partition = partition;
  options.triangles_per_cell = 300;
  return options;
}

Built build(const std::vector<Mesh>& meshes, const BuildOptions& options, int threads = 1) {
  InputSummary input;
  for (const Mesh& mesh : meshes) summarise(mesh, "mesh", threads, input);
  const Header header = plan_header(input, options);
  LeafMaker maker(header, options.max_pieces, threads);
  std::vector<std::vector<BuildCell>> pieces;
  for (const Mesh& mesh : meshes) pieces.push_back(maker.pieces(mesh));
  Built built;
  built.leaves = maker.counts();
  const TemporaryFolder folder;
  FileWriter writer(folder / "a.hlod", header);
  built.levels = build_levels(finish_leaves(std::move(pieces), header, threads, built.leaves),
                              header, options.block, threads, [&](const FinishedPart& part) {
                                writer.add(part.node, encode_cell(part.mesh, header));
                              });
  writer.finish();
  built.bytes = test::read_text(folder / "a.hlod");
  built.check = check_file(File(folder / "a.hlod"), threads);
  return built;
}

void expect_sound(const Built& built) {
  EXPECT_EQ(built.check.faults(), 0u)
      << (built.check.examples.empty() ? "" : built.check.examples.front());
}

class BuildOf : public testing::TestWithParam<Partition> {};
INSTANTIATE_TEST_SUITE_P(Both, BuildOf, testing::Values(Partition::kQuadtree, Partition::kOctree));

TEST_P(BuildOf, GroundKeepsAllPromisesAndQuartersItsTriangles) {
  BuildOptions options = small_cells(GetParam());
  // Of smaller cells more vertices lie on borders, which stay.
  options.triangles_per_cell = 2000;
  const Built built = build({ground(0, 160)}, options);
  expect_sound(built);
  ASSERT_GE(built.levels.size(), 4u);
  std::uint64_t all = 0;
  for (std::size_t level = 0; level < built.levels.size(); ++level) {
    all += built.levels[level].triangles;
    if (level > 0) {
      EXPECT_GE(built.levels[level - 1].error_max_m, built.levels[level].error_max_m);
    }
  }
  EXPECT_EQ(built.levels.back().triangles, 2u * 160 * 160);
  EXPECT_LE(static_cast<double>(all), 1.4 * 2 * 160 * 160);
}

TEST_P(BuildOf, IsTheSameForAnyNumberOfThreads) {
  const std::vector<Mesh> tiles{ground(0, 60), ground(60, 60)};
  const BuildOptions options = small_cells(GetParam());
  EXPECT_TRUE(build(tiles, options, 1).bytes == build(tiles, options, 3).bytes);
}

TEST_P(BuildOf, OverhangsAndClosedSurfacesKeepAllPromises) {
  expect_sound(build({test::overhang_mesh(60, 40, 6, 0.7)}, small_cells(GetParam())));
  expect_sound(build({test::sphere_mesh(30, 5)}, small_cells(GetParam())));
}

TEST_P(BuildOf, TilesThatShareABorderIsThatOfTheWhole) {
  const Built parts = build({ground(0, 60), ground(60, 60)}, small_cells(GetParam()));
  expect_sound(parts);
  EXPECT_EQ(parts.levels.back().triangles, 4u * 60 * 60);
}

/// Ground with a square lake of two huge triangles in it, from `low` to `high` both ways.
Mesh lake(int side, float low, float high) {
  Mesh mesh = ground(0, side);
  std::erase_if(mesh.triangles, [&](const auto& t) {
    const Vec3f p = mesh.positions[t[0]];
    return p.x >= low && p.x < high && p.y >= low && p.y < high;
  });
  const auto corner = static_cast<std::uint32_t>(mesh.positions.size());
  for (const Vec3f p :
       {Vec3f{low, low, 0}, Vec3f{high, low, 0}, Vec3f{high, high, 0}, Vec3f{low, high, 0}}) {
    mesh.positions.push_back(p);
  }
  mesh.triangles.push_back({corner, corner + 1, corner + 2});
  mesh.triangles.push_back({corner, corner + 2, corner + 3});
  return mesh;
}

TEST_P(BuildOf, ALakeOfHugeTrianglesAmidFineGroundKeepsAllPromises) {
  const Built built = build({lake(100, 20, 80)}, small_cells(GetParam()));
  expect_sound(built);
  EXPECT_GT(built.leaves.split_pieces, 100u);
}

TEST_P(BuildOf, BadMeshesAreCountedAndKeepAllPromises) {
  Mesh mesh = ground(0, 50);
  const auto corner = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.push_back({10, 10, 25});
  mesh.positions.push_back({500, 500, 0});      // without a triangle
  mesh.triangles.push_back({0, 1, corner});     // three at an edge
  mesh.triangles.push_back(mesh.triangles[5]);  // twice
  mesh.triangles.push_back({7, 7, 8});          // no area
  mesh.triangles.push_back({mesh.triangles[9][1], mesh.triangles[9][0], mesh.triangles[9][2]});
  const Built built = build({mesh}, small_cells(GetParam()));
  expect_sound(built);
  EXPECT_EQ(built.leaves.duplicate, 2u);
  EXPECT_EQ(built.leaves.degenerate, 1u);
}

TEST_P(BuildOf, SoupIsThatOfTheIndexedMesh) {
  const Mesh mesh = ground(0, 40);
  Mesh soup;
  for (const auto& t : mesh.triangles) {
    const auto first = static_cast<std::uint32_t>(soup.positions.size());
    for (const std::uint32_t v : t) soup.positions.push_back(mesh.positions[v]);
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  EXPECT_TRUE(build({soup}, small_cells(GetParam())).bytes ==
              build({mesh}, small_cells(GetParam())).bytes);
}

TEST_P(BuildOf, OnDiskIsTheSameAndGoesOnAfterAKill) {
  const std::vector<Mesh> tiles{ground(0, 60), ground(60, 60)};
  const BuildOptions options = small_cells(GetParam());
  const Built in_memory = build(tiles, options);
  InputSummary input;
  for (const Mesh& mesh : tiles) summarise(mesh, "mesh", 1, input);
  const Header header = plan_header(input, options);
  const TemporaryFolder folder;
  const auto finish = [&](const WorkFolder& work, const std::string& name) {
    FileWriter writer(folder / name, header);
    build_levels_on_disk(
        work, header, options.block, 2,
        [&](const Node& node, std::span<const std::byte> block) { writer.add(node, block); });
    writer.finish();
    return test::read_text(folder / name);
  };
  {
    const WorkFolder work(folder / "work", "this build");
    DiskLeaves leaves(work, header, options.max_pieces, 2);
    for (const Mesh& mesh : tiles) leaves.add(mesh);
    leaves.finish(no_progress());
    EXPECT_TRUE(finish(work, "a.hlod") == in_memory.bytes);
  }
  // As a kill leaves it: some levels, and half of a file.
  std::filesystem::remove(folder / "work/level-2.spool");
  test::write_text(folder / "work/level-1.spool", "half");
  const WorkFolder again(folder / "work", "this build");
  EXPECT_TRUE(again.has(again.leaves()));
  EXPECT_FALSE(again.has(again.level(1)));
  EXPECT_TRUE(finish(again, "b.hlod") == in_memory.bytes);
  const WorkFolder other(folder / "work", "another build");
  EXPECT_FALSE(other.has(other.leaves()));
}

/// Kills its process at the n-th thing that it is told.
class KilledAt : public Progress {
 public:
  explicit KilledAt(int n) : left_(n) {}
  void begin(std::string_view, std::uint64_t) override { tell(); }
  void advance(std::uint64_t) override { tell(); }

 private:
  void tell() {
    if (--left_ == 0) ::raise(SIGKILL);
  }
  int left_;
};

/// Runs act() in a process of its own; true where that was killed.
template <class Act>
bool is_killed(const Act& act) {
  const pid_t child = ::fork();
  if (child == 0) {
    act();
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFSIGNALED(status) ? WTERMSIG(status) == SIGKILL : WEXITSTATUS(status) == 0);
  return WIFSIGNALED(status);
}

TEST_P(BuildOf, GoesOnToTheSameBytesWhereverItIsKilled) {
  const Mesh mesh = ground(0, 100);
  const BuildOptions options = small_cells(GetParam());
  InputSummary input;
  summarise(mesh, "mesh", 1, input);
  const Header header = plan_header(input, options);
  const TemporaryFolder folder;
  const auto make_leaves = [&](int n) {
    KilledAt progress(n);
    const WorkFolder work(folder / "work", "killed");
    DiskLeaves leaves(work, header, options.max_pieces, 1);
    if (leaves.wants_meshes()) leaves.add(mesh);
    leaves.finish(progress);
  };
  const auto make_levels = [&](int n) {
    KilledAt progress(n);
    const WorkFolder work(folder / "work", "killed");
    FileWriter writer(folder / "a.hlod", header);
    build_levels_on_disk(
        work, header, options.block, 1,
        [&](const Node& node, std::span<const std::byte> block) { writer.add(node, block); },
        progress);
    writer.finish();
  };
  // Every process goes on with what the one before left, and gets a little farther in a step that
  // it has to do anew.
  std::set<int> seen;
  int kills = 0;
  for (int n = 1; is_killed([&] { make_leaves(n); }); n += 5) ++kills;
  for (int n = 1; is_killed([&] { make_levels(n); }); ++n) {
    ++kills;
    EXPECT_FALSE(std::filesystem::exists(folder / "a.hlod"));
    for (int level = 0; level < header.lattice.finest_level; ++level) {
      const WorkFolder work(folder / "work", "killed");
      const bool is_there = work.has(work.level(level));
      // The next level's blocks are counted anew.
      if (is_there && seen.insert(level).second) n = 0;
    }
  }
  EXPECT_GE(kills, 5);
  // All but the root level, which is part of the file that is then written.
  EXPECT_GE(seen.size() + 1, static_cast<std::size_t>(header.lattice.finest_level));
  EXPECT_TRUE(test::read_text(folder / "a.hlod") == build({mesh}, options).bytes);
}

TEST_P(BuildOf, AFileReadInWindowsOfItsVerticesIsThatOfTheWhole) {
  const TemporaryFolder folder;
  Mesh mesh = ground(0, 100);
  std::reverse(mesh.triangles.begin(), mesh.triangles.end());
  write_ply(folder / "mesh.ply", mesh);
  // Sums of areas, and cell sides with them, are the same for pieces of 131,072 triangles alone.
  BuildOptions options = small_cells(GetParam());
  options.cell_side_m = 8;
  const Mesh whole = read_ply_mesh(folder / "mesh.ply");
  InputSummary input;
  summarise(whole, "mesh", 1, input);
  const Header header = plan_header(input, options);
  const auto stream = open_ply_mesh_stream(
      folder / "mesh.ply",
      {.vertex_bytes = 40'000, .piece_triangles = 3000, .scratch = folder.path()});
  const WorkFolder work(folder / "work", "windows");
  DiskLeaves leaves(work, header, options.max_pieces, 2);
  for (Mesh piece; stream->next(piece);) leaves.add(piece);
  // 10,201 vertices of 12 bytes at least do not fit into one window, or three.
  EXPECT_TRUE(stream->is_spilled());
  leaves.finish(no_progress());
  FileWriter writer(folder / "a.hlod", header);
  build_levels_on_disk(
      work, header, options.block, 2,
      [&](const Node& node, std::span<const std::byte> block) { writer.add(node, block); });
  writer.finish();
  EXPECT_TRUE(test::read_text(folder / "a.hlod") == build({whole}, options).bytes);
}

/// The finest level and all above it on disk, within `bytes` of memory.
std::string build_within(const std::vector<Mesh>& meshes, const BuildOptions& options,
                         std::size_t piece_triangles, std::uint64_t bytes) {
  InputSummary input;
  for (const Mesh& mesh : meshes) summarise(mesh, "mesh", 1, input);
  const Header header = plan_header(input, options);
  const TemporaryFolder folder;
  MemoryGate gate(bytes);
  DiskTask task;
  task.threads = 2;
  task.piece_triangles = piece_triangles;
  task.gate = &gate;
  const WorkFolder work(folder / "work", "small");
  DiskLeaves leaves(work, header, options.max_pieces, task);
  for (const Mesh& mesh : meshes) leaves.add(mesh);
  leaves.finish(no_progress());
  FileWriter writer(folder / "a.hlod", header);
  build_levels_on_disk(
      work, header, options.block, task,
      [&](const Node& node, std::span<const std::byte> block) { writer.add(node, block); });
  writer.finish();
  return test::read_text(folder / "a.hlod");
}

TEST_P(BuildOf, IsTheSameInSmallPiecesAndWithLittleMemory) {
  const std::vector<Mesh> meshes{lake(60, 10, 50), ground(60, 60)};
  const BuildOptions options = small_cells(GetParam());
  const std::string whole = build(meshes, options).bytes;
  EXPECT_TRUE(build_within(meshes, options, 1 << 20, std::uint64_t{1} << 40) == whole);
  EXPECT_TRUE(build_within(meshes, options, 37, 8'000'000) == whole);
  EXPECT_THROW(build_within(meshes, options, 1 << 20, 100'000), RunError);
}

TEST_P(BuildOf, ASliverAThousandCellsLongKeepsAllPromises) {
  Mesh mesh = ground(0, 20);
  const auto corner = static_cast<std::uint32_t>(mesh.positions.size());
  for (const Vec3f p : {Vec3f{20, 0, 0}, Vec3f{20, 1, 0}, Vec3f{8020, 500, 40}}) {
    mesh.positions.push_back(p);
  }
  mesh.triangles.push_back({corner, corner + 2, corner + 1});
  BuildOptions options;
  options.partition = GetParam();
  options.cell_side_m = 8;
  const Built built = build({mesh}, options);
  expect_sound(built);
  EXPECT_GT(built.leaves.split_pieces, 4'000u);
}

TEST(Build, PiecesOfAMeshSumUpAsTheWhole) {
  const Mesh mesh = ground(0, 300);
  InputSummary whole, parts;
  summarise(mesh, "mesh", 1, whole);
  for (std::size_t begin = 0; begin < mesh.triangles.size(); begin += 131072) {
    Mesh piece = mesh;
    const std::size_t end = std::min(mesh.triangles.size(), begin + 131072);
    piece.triangles.assign(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(begin),
                           mesh.triangles.begin() + static_cast<std::ptrdiff_t>(end));
    summarise(piece, "mesh", 2, parts);
  }
  EXPECT_EQ(parts.area_m2, whole.area_m2);
  EXPECT_EQ(parts.plan_area_m2, whole.plan_area_m2);
  EXPECT_EQ(parts.box.max.z, whole.box.max.z);
  EXPECT_EQ(parts.box.min.x, whole.box.min.x);
}

TEST(Build, AVertexWithoutATriangleDoesNotWidenTheFrame) {
  Mesh mesh = ground(0, 20);
  InputSummary before, after;
  summarise(mesh, "mesh", 1, before);
  mesh.positions.push_back({90'000, 90'000, 9'000});
  summarise(mesh, "mesh", 1, after);
  EXPECT_EQ(after.box.max.x, before.box.max.x);
  EXPECT_TRUE(plan_header(after, {}).lattice == plan_header(before, {}).lattice);
}

TEST(MemoryPlan, SharesOutWhatIsThereAndRefusesTooLittle) {
  EXPECT_THROW(plan_memory(std::uint64_t{400} << 20), UsageError);
  for (const std::uint64_t mib : {512, 4096, 65536}) {
    const MemoryPlan plan = plan_memory(mib << 20);
    EXPECT_EQ(plan.piece_triangles % 131072, 0u);
    EXPECT_LE(plan.vertex_bytes + 250 * plan.piece_triangles, mib << 20);
    EXPECT_LT(plan.work_bytes, mib << 20);
  }
}

TEST(Build, OfOneTriangleIsOneCell) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {3, 0, 0}, {0, 3, 1}};
  mesh.triangles = {{0, 1, 2}};
  const Built built = build({mesh}, {});
  expect_sound(built);
  EXPECT_EQ(built.check.cells, 1u);
  EXPECT_EQ(built.check.triangles, 1u);
}

TEST(Build, RefusesWhatItCannotUse) {
  InputSummary input;
  Mesh mesh = ground(0, 2);
  mesh.positions[3].z = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(summarise(mesh, "a.ply", 1, input), InputError);
  mesh = ground(0, 2);
  mesh.triangles[1][2] = 99;
  EXPECT_THROW(summarise(mesh, "a.ply", 1, input), InputError);
  EXPECT_THROW(plan_header(InputSummary{}, {}), InputError);
  mesh = ground(0, 2);
  mesh.crs_text = "EPSG:2056";
  summarise(mesh, "a.ply", 1, input);
  mesh.crs_text = "EPSG:2154";
  EXPECT_THROW(summarise(mesh, "b.ply", 1, input), InputError);
}

TEST(Build, SaysSoWhereATriangleIsThousandsOfCellsLong) {
  Mesh mesh = ground(0, 20);
  const auto corner = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.push_back({20000, 0, 0});
  mesh.positions.push_back({0, 20000, 0});
  mesh.triangles.push_back({0, corner, corner + 1});
  BuildOptions options;
  options.cell_side_m = 8;
  options.max_pieces = 100'000;
  EXPECT_THROW(build({mesh}, options), InputError);
}

/// A wall of squares of a metre, exactly vertical, along a line in plan.
Mesh wall(int length, int height, Vec3f along) {
  Mesh mesh;
  for (int row = 0; row <= height; ++row) {
    for (int column = 0; column <= length; ++column) {
      Vec3f p = static_cast<float>(column) * along;
      p.z = static_cast<float>(row);
      mesh.positions.push_back(p);
    }
  }
  const auto width = static_cast<std::uint32_t>(length) + 1;
  for (std::uint32_t at = 0; at + width + 1 < mesh.positions.size(); ++at) {
    if (at % width == width - 1) continue;
    mesh.triangles.push_back({at, at + 1, at + width + 1});
    mesh.triangles.push_back({at, at + width + 1, at + width});
  }
  return mesh;
}

TEST_P(BuildOf, AWallThatIsExactlyVerticalKeepsAllPromises) {
  for (const Vec3f along : {Vec3f{1, 0, 0}, Vec3f{0.6f, 0.8f, 0}}) {
    const Built built = build({wall(200, 15, along)}, small_cells(GetParam()));
    expect_sound(built);
    EXPECT_EQ(built.levels.back().triangles, 2u * 200 * 15);
    // About as many triangles in a cell as were asked for.
    EXPECT_GE(built.levels.back().cells, 8u);
    EXPECT_LE(built.levels.back().cells, 50u);
  }
}

TEST(Build, ChoosesCellsForAnyExtent) {
  // Two small places a thousand kilometres apart, and a needle that is nearly a line.
  InputSummary far;
  summarise(ground(0, 20), "a", 1, far);
  Mesh there = ground(0, 20);
  there.origin = {1e6, 0, 0};
  summarise(there, "b", 1, far);
  EXPECT_LE(plan_header(far, {}).lattice.finest_level, 16);
  InputSummary needle;
  Mesh thin;
  thin.positions = {{0, 0, 0}, {1e-7f, 0, 0}, {0, 0, 800}};
  thin.triangles = {{0, 1, 2}};
  summarise(thin, "c", 1, needle);
  EXPECT_NO_THROW(plan_header(needle, {}));
  BuildOptions tiny;
  tiny.cell_side_m = 1e-3;
  EXPECT_THROW(plan_header(far, tiny), InputError);
}

TEST(Build, RefusesCoordinatesThatAreNoMetres) {
  Mesh mesh = ground(0, 2);
  for (Vec3f& p : mesh.positions) p = 1e30f * p;
  InputSummary input;
  try {
    summarise(mesh, "a.ply", 1, input);
    FAIL() << "was accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(error.subject(), "a.ply");
  }
}

}  // namespace
}  // namespace cornice::hlod
