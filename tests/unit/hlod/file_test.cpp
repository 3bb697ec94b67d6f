// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "core/base/error.h"
#include "core/base/random.h"
#include "tests/support/full_disk.h"
#include "tests/support/hlod_cells.h"
#include "tests/support/temporary_folder.h"

namespace cornice::hlod {
namespace {

using test::read_text;
using test::same_mesh;
using test::TemporaryFolder;
using test::write_text;
using testing::HasSubstr;

struct Part {
  CellMesh mesh;
  Node node;
};

/// Cells of three levels, one of them in two parts, one far to the south-west.
std::vector<Part> sample_parts(const Header& header) {
  std::vector<Part> parts;
  std::uint64_t seed = 1;
  for (const CellKey key : {CellKey{3, 0, 1, 0}, CellKey{3, 1, 1, 0}, CellKey{2, 0, 0, 0},
                            CellKey{3, -5, -7, 0}, CellKey{0, 0, 0, 0}, CellKey{1, 0, 0, 0}}) {
    const CellMesh mesh = test::sample_cell(test::bumpy_ground(12, 9, seed), header, key, seed);
    parts.push_back({mesh, make_node(mesh, 0.5f / static_cast<float>(seed), 0.25f)});
    ++seed;
  }
  parts.push_back(parts.front());
  parts.back().node.part = 1;
  return parts;
}

void write_file(const std::filesystem::path& path, const Header& header,
                const std::vector<Part>& parts) {
  FileWriter writer(path, header);
  for (const Part& part : parts) writer.add(part.node, encode_cell(part.mesh, header));
  writer.finish();
}

std::string problem_of(const std::filesystem::path& path) {
  try {
    const File file(path);
    for (const Node& node : file.nodes()) file.read(node);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(HlodFile, GivesBackWhatWasWritten) {
  const TemporaryFolder folder;
  const Header header = test::sample_header();
  const std::vector<Part> parts = sample_parts(header);
  write_file(folder / "a.hlod", header, parts);
  const File file(folder / "a.hlod");
  EXPECT_EQ(file.header().lattice, header.lattice);
  EXPECT_EQ(file.header().crs_text, header.crs_text);
  EXPECT_EQ(file.header().provenance, header.provenance);
  EXPECT_EQ(file.header().attributes, header.attributes);
  EXPECT_EQ(file.header().edge_share, header.edge_share);
  ASSERT_EQ(file.nodes().size(), parts.size());
  for (const Node& node : file.nodes()) {
    const auto part = std::find_if(parts.begin(), parts.end(), [&](const Part& p) {
      return p.node.key == node.key && p.node.part == node.part;
    });
    ASSERT_NE(part, parts.end());
    EXPECT_TRUE(same_mesh(file.read(node), part->mesh));
    EXPECT_EQ(node.error_m, part->node.error_m);
    EXPECT_EQ(node.step_error_m, part->node.step_error_m);
    EXPECT_EQ(node.lowest, part->node.lowest);
    EXPECT_EQ(node.highest, part->node.highest);
  }
  EXPECT_EQ(folder.entries(), std::vector<std::string>{"a.hlod"});
}

TEST(HlodFile, SortsNodesAndCountsLevels) {
  const TemporaryFolder folder;
  const Header header = test::sample_header();
  write_file(folder / "a.hlod", header, sample_parts(header));
  const File file(folder / "a.hlod");
  for (std::size_t n = 1; n < file.nodes().size(); ++n) {
    const Node &a = file.nodes()[n - 1], &b = file.nodes()[n];
    EXPECT_TRUE(a.key < b.key || (a.key == b.key && a.part + 1 == b.part));
    EXPECT_EQ(a.offset + a.bytes, b.offset) << "blocks lie one after the other";
  }
  ASSERT_EQ(file.levels().size(), 4u);
  EXPECT_EQ(file.levels()[3].cells, 3u);
  EXPECT_EQ(file.levels()[3].triangles, 4u * 2 * 11 * 8);
  EXPECT_DOUBLE_EQ(file.levels()[0].error_max_m, 0.1f);
  for (const Node& node : file.nodes()) {
    const Vec3d low = header.lattice.position(node.lowest, node.key.level);
    EXPECT_TRUE(file.bounds().contains(low));
  }
}

TEST(HlodFile, HasTheSameBytesWhateverTheOrderAndTheThreads) {
  const TemporaryFolder folder;
  const Header header = test::sample_header();
  std::vector<Part> parts = sample_parts(header);
  write_file(folder / "a.hlod", header, parts);
  std::reverse(parts.begin(), parts.end());
  write_file(folder / "b.hlod", header, parts);
  std::sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) {
    return a.node.key != b.node.key ? a.node.key < b.node.key : a.node.part < b.node.part;
  });
  write_file(folder / "sorted.hlod", header, parts);
  {
    FileWriter writer(folder / "c.hlod", header);
    std::vector<std::thread> threads;
    for (const Part& part : parts) {
      threads.emplace_back([&] { writer.add(part.node, encode_cell(part.mesh, header)); });
    }
    for (std::thread& thread : threads) thread.join();
    writer.finish();
  }
  const std::string bytes = read_text(folder / "a.hlod");
  EXPECT_EQ(read_text(folder / "b.hlod"), bytes);
  EXPECT_EQ(read_text(folder / "sorted.hlod"), bytes);
  EXPECT_EQ(read_text(folder / "c.hlod"), bytes);
}

TEST(HlodFile, MayHoldNoCellsAtAll) {
  const TemporaryFolder folder;
  const Header header = test::sample_header();
  write_file(folder / "a.hlod", header, {});
  EXPECT_TRUE(File(folder / "a.hlod").nodes().empty());
}

TEST(HlodFile, LeavesNothingBehindWithoutFinish) {
  const TemporaryFolder folder;
  const Header header = test::sample_header();
  {
    FileWriter writer(folder / "a.hlod", header);
    const Part part = sample_parts(header).front();
    writer.add(part.node, encode_cell(part.mesh, header));
  }
  EXPECT_TRUE(folder.entries().empty());
}

TEST(HlodFile, RefusesAPartThatWasWrittenTwice) {
  const TemporaryFolder folder;
  const Header header = test::sample_header();
  std::vector<Part> parts = sample_parts(header);
  parts.push_back(parts.front());
  EXPECT_THROW(write_file(folder / "a.hlod", header, parts), RunError);
  EXPECT_TRUE(folder.entries().empty());
}

TEST(HlodFile, SaysThatTheDiskIsFull) {
  const TemporaryFolder folder;
  const Header header = test::sample_header();
  const auto outcome = test::on_full_disk(folder.path(), [&] {
    CellMesh mesh = test::sample_cell(test::bumpy_ground(120, 100, 3), header, {3, 0, 0, 0}, 3);
    FileWriter writer(folder / "a.hlod", header);
    writer.add(make_node(mesh, 0, 0), encode_cell(mesh, header));
    writer.finish();
  });
  if (!outcome) GTEST_SKIP() << "nobody may mount a small disk here";
  EXPECT_THAT(*outcome, HasSubstr("cannot be written: the disk is full; free some space"));
  EXPECT_EQ(outcome->find('|'), std::string::npos) << *outcome;
}

TEST(HlodFile, RefusesWhatIsNoHierarchy) {
  const TemporaryFolder folder;
  write_text(folder / "a.hlod", "ply\nformat ascii 1.0\n");
  EXPECT_THAT(problem_of(folder / "a.hlod"), HasSubstr("is no .hlod file"));
  write_text(folder / "a.hlod", "");
  EXPECT_THAT(problem_of(folder / "a.hlod"), HasSubstr("is no .hlod file"));
  EXPECT_THAT(problem_of(folder / "none.hlod"), HasSubstr("No such file"));
  EXPECT_THAT(problem_of(folder.path()), HasSubstr("is a folder, not a file"));
}

TEST(HlodFile, RefusesANewerVersionAndTheOtherByteOrder) {
  const TemporaryFolder folder;
  const Header header = test::sample_header();
  write_file(folder / "a.hlod", header, sample_parts(header));
  const std::string bytes = read_text(folder / "a.hlod");
  std::string newer = bytes;
  newer[8] = 2;
  write_text(folder / "b.hlod", newer);
  EXPECT_THAT(problem_of(folder / "b.hlod"), HasSubstr("version 2 of the format"));
  std::string swapped = bytes;
  std::reverse(swapped.begin() + 12, swapped.begin() + 16);
  write_text(folder / "b.hlod", swapped);
  EXPECT_THAT(problem_of(folder / "b.hlod"), HasSubstr("the other order"));
  std::string flipped = bytes;
  flipped[12] ^= 1;
  write_text(folder / "b.hlod", flipped);
  EXPECT_THAT(problem_of(folder / "b.hlod"), HasSubstr("has a damaged head"));
}

TEST(HlodFile, SaysOfEveryCutFileThatItIsNotWhole) {
  const TemporaryFolder folder;
  const Header header = test::sample_header();
  write_file(folder / "a.hlod", header, sample_parts(header));
  const std::string bytes = read_text(folder / "a.hlod");
  for (std::size_t size = 0; size < bytes.size(); size += 1 + size / 50) {
    write_text(folder / "b.hlod", bytes.substr(0, size));
    ASSERT_NE(problem_of(folder / "b.hlod"), "") << size;
  }
  write_text(folder / "b.hlod", bytes + "x");
  EXPECT_THAT(problem_of(folder / "b.hlod"), HasSubstr("cut or added to"));
}

TEST(HlodFile, NoticesEveryFlippedBit) {
  const TemporaryFolder folder;
  const Header header = test::sample_header();
  write_file(folder / "a.hlod", header, sample_parts(header));
  const std::string bytes = read_text(folder / "a.hlod");
  for (std::size_t i = 0; i < bytes.size(); i += 1 + i / 400) {
    std::string flipped = bytes;
    flipped[i] = static_cast<char>(flipped[i] ^ (1 << (CounterRandom(1, 2, i).bits() % 8)));
    write_text(folder / "b.hlod", flipped);
    ASSERT_NE(problem_of(folder / "b.hlod"), "") << i;
  }
}

}  // namespace
}  // namespace cornice::hlod
