// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/base/atomic_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "core/base/error.h"
#include "tests/support/full_disk.h"
#include "tests/support/temporary_folder.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;
using test::read_text;
using test::TemporaryFolder;
using test::write_text;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(AtomicFile, AppearsUnderItsNameOnlyAfterCommit) {
  const TemporaryFolder folder;
  AtomicFile file(folder / "a.ply");
  write_text(file.path(), "whole");
  EXPECT_FALSE(fs::exists(folder / "a.ply"));
  file.commit();
  EXPECT_EQ(read_text(folder / "a.ply"), "whole");
  EXPECT_THAT(folder.entries(), ElementsAre("a.ply"));
}

TEST(AtomicFile, LeavesNothingWhenItIsNotCommitted) {
  const TemporaryFolder folder;
  {
    const AtomicFile file(folder / "a.gpkg");
    write_text(file.path(), "half");
    write_text(file.path().string() + "-journal", "of a library");
  }
  EXPECT_THAT(folder.entries(), IsEmpty());
}

TEST(AtomicFile, KeepsTheOldFileWhenItIsNotCommitted) {
  const TemporaryFolder folder;
  write_text(folder / "a.txt", "old");
  {
    const AtomicFile file(folder / "a.txt");
    write_text(file.path(), "half");
  }
  EXPECT_EQ(read_text(folder / "a.txt"), "old");
}

TEST(AtomicFile, KeepsTheExtensionAndHidesThePartialName) {
  const TemporaryFolder folder;
  const AtomicFile file(folder / "tile.copc.laz");
  EXPECT_EQ(file.path().extension(), ".laz");
  EXPECT_EQ(file.path().parent_path(), folder.path());
  EXPECT_EQ(file.path().filename().string().front(), '.');
}

TEST(AtomicFile, CreatesMissingFolders) {
  const TemporaryFolder folder;
  write_file_atomically(folder.path() / "x" / "y" / "a.txt", "deep");
  EXPECT_EQ(read_text(folder.path() / "x" / "y" / "a.txt"), "deep");
}

TEST(AtomicFile, LetsTwoWritersOfOneTargetFinishWhole) {
  const TemporaryFolder folder;
  const fs::path target = folder / "a.bin";
  std::vector<std::thread> writers;
  for (int w = 0; w < 8; ++w) {
    writers.emplace_back([&, w] {
      for (int i = 0; i < 20; ++i) {
        write_file_atomically(target, std::string(50000, static_cast<char>('a' + w)));
      }
    });
  }
  for (std::thread& writer : writers) writer.join();
  const std::string text = read_text(target);
  ASSERT_EQ(text.size(), 50000u);
  EXPECT_EQ(text.find_first_not_of(text[0]), std::string::npos) << "bytes of two writers mixed";
  EXPECT_THAT(folder.entries(), ElementsAre("a.bin"));
}

TEST(AtomicFile, FollowsASymbolicLinkInsteadOfReplacingIt) {
  const TemporaryFolder folder;
  write_text(folder / "real.txt", "old");
  fs::create_symlink(folder / "real.txt", folder / "link.txt");
  write_file_atomically(folder / "link.txt", "new");
  EXPECT_TRUE(fs::is_symlink(folder / "link.txt"));
  EXPECT_EQ(read_text(folder / "real.txt"), "new");
}

TEST(AtomicFile, RefusesATargetThatIsAFolderOrADevice) {
  const TemporaryFolder folder;
  EXPECT_THROW(AtomicFile file(folder.path()), RunError);
  EXPECT_THROW(AtomicFile file("/dev/null"), RunError);
}

TEST(AtomicFile, SaysWhichFileCannotBeWritten) {
  try {
    AtomicFile file("/proc/nowhere/a.txt");
    FAIL() << "a folder under /proc cannot be created";
  } catch (const RunError& error) {
    EXPECT_EQ(error.subject(), "/proc/nowhere/a.txt");
    EXPECT_THAT(error.what(), HasSubstr("folder"));
  }
}

TEST(AtomicFile, LeavesNothingOfAFileThatDoesNotFit) {
  const TemporaryFolder folder;
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    signal(SIGXFSZ, SIG_IGN);  // the write then fails, as on a full disk
    const rlimit limit{4096, 4096};
    setrlimit(RLIMIT_FSIZE, &limit);
    try {
      write_file_atomically(folder / "a.txt", std::string(10000, 'x'));
      _exit(1);
    } catch (const RunError& error) {
      _exit(error.subject() == folder / "a.txt" ? 0 : 2);
    }
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
  EXPECT_THAT(folder.entries(), IsEmpty());
}

TEST(AtomicFile, TellsOfAFullDiskAndLeavesNothing) {
  const TemporaryFolder folder;
  const auto outcome = test::on_full_disk(
      folder.path(), [&] { write_file_atomically(folder / "a.txt", std::string(200000, 'x')); });
  if (!outcome) GTEST_SKIP() << "this machine does not let a test mount a small disk";
  EXPECT_EQ(*outcome, (folder / "a.txt").string() +
                          ": cannot be written: the disk is full; free some space or write "
                          "elsewhere, then run again");
}

TEST(AtomicFile, CommitFailsWhereNothingWasWritten) {
  const TemporaryFolder folder;
  AtomicFile file(folder / "a.txt");
  EXPECT_THROW(file.commit(), RunError);
  EXPECT_FALSE(fs::exists(folder / "a.txt"));
}

TEST(RemoveStalePartials, ClearsWhatAKilledProcessLeftAndNothingElse) {
  const TemporaryFolder folder;
  const fs::path target = folder / "a.laz";
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    auto* file = new AtomicFile(target);  // never destroyed: the process is gone at once
    std::ofstream(file->path()) << "half";
    _exit(0);
  }
  waitpid(child, nullptr, 0);
  const AtomicFile living(target);
  write_text(living.path(), "in the making");
  write_text(folder / ".a.laz.notes", "somebody's own");
  ASSERT_EQ(folder.entries().size(), 3u);
  EXPECT_EQ(remove_stale_partials(target), 1);
  EXPECT_TRUE(fs::exists(living.path()));
  EXPECT_TRUE(fs::exists(folder / ".a.laz.notes"));
  EXPECT_EQ(remove_stale_partials(folder.path()), 0);
}

TEST(RemoveStalePartials, LeavesThoseOfOtherTargetsAndOtherMachines) {
  const TemporaryFolder folder;
  write_text(folder / ".a.laz.some-other-host.1-0.partial.laz", "");
  write_text(folder / ".b.laz.localhost.x-0.partial.laz", "");
  EXPECT_EQ(remove_stale_partials(folder / "a.laz"), 0);
  EXPECT_EQ(remove_stale_partials(folder.path() / "nowhere" / "c.laz"), 0);
  EXPECT_EQ(folder.entries().size(), 2u);
}

TEST(RemoveLivePartials, ClearsTheTemporaryFilesOfThisProcess) {
  const TemporaryFolder folder;
  const AtomicFile file(folder / "a.txt");
  write_text(file.path(), "half");
  remove_live_partials();
  EXPECT_THAT(folder.entries(), IsEmpty());
}

}  // namespace
}  // namespace cornice
