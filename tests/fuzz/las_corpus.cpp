// SPDX-License-Identifier: GPL-3.0-or-later
// Writes the files that fuzzing starts from: fuzz-las-corpus FOLDER.
#include <cstdio>
#include <filesystem>

#include "tests/fuzz/las_seeds.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: fuzz-las-corpus FOLDER\n");
    return 2;
  }
  std::filesystem::create_directories(argv[1]);
  for (const auto& [name, bytes] : cornice::test::las_seeds()) {
    cornice::test::write_file(std::filesystem::path(argv[1]) / name, bytes);
  }
}
