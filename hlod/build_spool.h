// SPDX-License-Identifier: GPL-3.0-or-later
// Cells and finished parts on disk, on their way through the builder. The files live as long as a
// build does, or travel from the job of a region to the one that joins; they are of no use to
// anyone else, and no other version reads them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "hlod/build_cell.h"
#include "hlod/file.h"

namespace cornice::hlod {

/// Where a cell is and what building has to know of it beforehand.
struct SpoolCell {
  CellKey key;
  float error_m = 0;
  std::uint32_t unused = 0;  ///< in place of padding, whose bytes would be anything
  std::uint64_t offset = 0, bytes = 0, triangles = 0, vertices = 0;
  std::uint64_t checksum = 0;  ///< XXH3 of the record
};

/// Where a part's block is; the node's own offset and checksum are not used.
struct SpoolPart {
  Node node;
  std::uint64_t offset = 0, bytes = 0, checksum = 0;
};

/// Writes a spool, which appears whole. May be given records from several threads.
class SpoolWriter {
 public:
  /// `text` tells spools of one build from those of another. Throws RunError where it cannot be
  /// written.
  SpoolWriter(const std::filesystem::path& path, std::string text);
  ~SpoolWriter();
  SpoolWriter(const SpoolWriter&) = delete;
  SpoolWriter& operator=(const SpoolWriter&) = delete;

  void add(const BuildCell& cell);
  void add(const Node& node, std::span<const std::byte> block);
  /// `numbers` are for whoever reads it.
  void commit(const std::vector<std::uint64_t>& numbers = {});

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// A whole spool. Safe to read from several threads.
class Spool {
 public:
  /// Throws InputError for what is no spool of this version, or is not whole.
  explicit Spool(const std::filesystem::path& path);
  ~Spool();
  Spool(const Spool&) = delete;
  Spool& operator=(const Spool&) = delete;

  const std::string& text() const;
  const std::vector<std::uint64_t>& numbers() const;
  /// In the order of their keys; of one key, in the order in which they were added.
  const std::vector<SpoolCell>& cells() const;
  const std::vector<SpoolPart>& parts() const;
  /// Throw InputError where the record is damaged: regions travel between machines.
  BuildCell read(const SpoolCell& cell) const;
  std::vector<std::byte> read(const SpoolPart& part) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cornice::hlod
