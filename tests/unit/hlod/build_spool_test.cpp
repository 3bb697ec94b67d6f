// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/build_spool.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/base/error.h"
#include "tests/support/process.h"
#include "tests/support/temporary_folder.h"

namespace cornice::hlod {
namespace {

using test::TemporaryFolder;

BuildCell small_cell(std::int32_t i) {
  BuildCell cell;
  cell.key.level = 3;
  cell.key.i = i;
  cell.error_m = 0.5f;
  cell.vertices.resize(4);
  for (std::int32_t v = 0; v < 4; ++v)
    cell.vertices[static_cast<std::size_t>(v)].position = {v, i, 7};
  cell.triangles = {{0, 1, 2}, {1, 3, 2}};
  return cell;
}

std::vector<std::byte> block_of(std::size_t bytes) {
  std::vector<std::byte> block(bytes);
  for (std::size_t i = 0; i < bytes; ++i) block[i] = static_cast<std::byte>(i * 37);
  return block;
}

void write_spool(const std::filesystem::path& path) {
  SpoolWriter writer(path, "a build");
  for (const std::int32_t i : {5, 2}) writer.add(small_cell(i));
  Node node;
  node.key.level = 4;
  for (const std::size_t bytes : {60u, 90u}) writer.add(node, block_of(bytes));
  writer.commit({1, 2, 3});
}

void read_all(const std::filesystem::path& path) {
  const Spool spool(path);
  for (const SpoolCell& cell : spool.cells()) spool.read(cell);
  for (const SpoolPart& part : spool.parts()) spool.read(part);
}

TEST(Spool, GivesBackCellsByTheirKeysAndPartsInTheirOrder) {
  const TemporaryFolder folder;
  write_spool(folder / "a.spool");
  const Spool spool(folder / "a.spool");
  EXPECT_EQ(spool.text(), "a build");
  EXPECT_EQ(spool.numbers(), (std::vector<std::uint64_t>{1, 2, 3}));
  ASSERT_EQ(spool.cells().size(), 2u);
  const BuildCell cell = spool.read(spool.cells()[0]);
  EXPECT_EQ(cell.key.i, 2);
  EXPECT_EQ(cell.triangles, small_cell(2).triangles);
  EXPECT_EQ(cell.vertices[3].position, small_cell(2).vertices[3].position);
  ASSERT_EQ(spool.parts().size(), 2u);
  EXPECT_EQ(spool.read(spool.parts()[1]), block_of(90));
}

TEST(Spool, RefusesAFileWithAnyBitFlipped) {
  const TemporaryFolder folder;
  write_spool(folder / "a.spool");
  EXPECT_NO_THROW(read_all(folder / "a.spool"));
  const std::string bytes = test::read_text(folder / "a.spool");
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::string damaged = bytes;
    damaged[i] = static_cast<char>(damaged[i] ^ (1 << i % 8));
    test::write_text(folder / "b.spool", damaged);
    EXPECT_THROW(read_all(folder / "b.spool"), InputError) << "byte " << i;
  }
}

TEST(Spool, RefusesACutFile) {
  const TemporaryFolder folder;
  write_spool(folder / "a.spool");
  const std::string bytes = test::read_text(folder / "a.spool");
  for (std::size_t left = 0; left < bytes.size(); ++left) {
    test::write_text(folder / "b.spool", bytes.substr(0, left));
    EXPECT_THROW(read_all(folder / "b.spool"), InputError) << left << " bytes";
  }
}

}  // namespace
}  // namespace cornice::hlod
