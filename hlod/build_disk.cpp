// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/build_disk.h"

#include <algorithm>
#include <mutex>
#include <optional>
#include <system_error>
#include <utility>

#include "core/base/error.h"
#include "core/base/parallel.h"

namespace cornice::hlod {
namespace {

namespace fs = std::filesystem;

/// Answers to rim vertices by the cells of a spool.
std::vector<RimAnswer> answers_on_disk(const Spool& spool, std::vector<RimVertex> rim,
                                       int threads) {
  const auto find = [&](const CellKey& key, BuildCell& buffer) -> const BuildCell* {
    const auto found =
        std::lower_bound(spool.cells().begin(), spool.cells().end(), key,
                         [](const SpoolCell& cell, const CellKey& k) { return cell.key < k; });
    buffer.key = key;
    if (found != spool.cells().end() && found->key == key) buffer = spool.read(*found);
    return &buffer;
  };
  return answer_all(std::move(rim), find, threads);
}

/// Cells that a spool holds. Those above the leaves learn here who shares their vertices.
class CellsOnDisk : public CellSource {
 public:
  CellsOnDisk(const fs::path& path, const Header& header, bool connect, int threads)
      : spool_(path), connect_(connect) {
    for (const SpoolCell& c : spool_.cells()) {
      infos_.push_back({c.key, c.error_m, c.triangles, c.vertices});
    }
    if (!connect) return;
    std::mutex mutex;
    std::vector<RimVertex> rim;
    parallel_for(infos_.size(), 1, threads, [&](std::size_t c, std::size_t) {
      const std::vector<RimVertex> own = rim_of(spool_.read(spool_.cells()[c]), header);
      const std::lock_guard lock(mutex);
      rim.insert(rim.end(), own.begin(), own.end());
    });
    answers_ = answers_on_disk(spool_, std::move(rim), threads);
  }
  const std::vector<Info>& infos() const override { return infos_; }
  BuildCell take(std::size_t index) override {
    BuildCell cell = spool_.read(spool_.cells()[index]);
    if (connect_) put_sharers(cell, answers_for(cell.key, answers_));
    return cell;
  }

 private:
  Spool spool_;
  bool connect_;
  std::vector<Info> infos_;
  std::vector<RimAnswer> answers_;
};

/// Where each cell's records begin in a list ordered by key; one more at the end.
std::vector<std::size_t> runs_of(const std::vector<SpoolCell>& cells) {
  std::vector<std::size_t> begins;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i == 0 || cells[i].key != cells[i - 1].key) begins.push_back(i);
  }
  begins.push_back(cells.size());
  return begins;
}

}  // namespace

WorkFolder::WorkFolder(fs::path folder, std::string text)
    : folder_(std::move(folder)), text_(std::move(text)) {
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error) throw RunError(folder_.string(), error.message());
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
    const std::string name = entry.path().filename().string();
    if (entry.path().extension() != ".spool") {
      throw RunError(folder_.string(), "holds " + name +
                                           ", which no build made; name another "
                                           "folder with --work");
    }
    // What is whole and of this build stays; the rest is of another, or half written.
    if (!has(entry.path())) fs::remove(entry.path(), error);
  }
}

fs::path WorkFolder::level(int level) const {
  return folder_ / ("level-" + std::to_string(level) + ".spool");
}

bool WorkFolder::has(const fs::path& spool) const {
  if (!fs::exists(spool)) return false;
  try {
    return Spool(spool).text() == text_;
  } catch (const InputError&) {
    return false;
  }
}

void WorkFolder::remove() const {
  std::error_code error;
  fs::remove_all(folder_, error);
}

DiskLeaves::DiskLeaves(const WorkFolder& folder, const Header& header, std::uint64_t max_pieces,
                       int threads)
    : folder_(folder),
      header_(header),
      threads_(threads),
      maker_(header, max_pieces, threads),
      pieces_(std::make_unique<SpoolWriter>(folder.path() / "pieces.spool", folder.text())) {}

void DiskLeaves::add(const Mesh& mesh) {
  for (const BuildCell& piece : maker_.pieces(mesh)) pieces_->add(piece);
}

LeafCounts DiskLeaves::finish(Progress& progress) {
  pieces_->commit();
  pieces_.reset();
  LeafCounts counts = maker_.counts();
  std::vector<RimVertex> rim;
  join(counts, rim, progress);
  const Spool joined(folder_.path() / "joined.spool");
  const std::vector<RimAnswer> answers = answers_on_disk(joined, std::move(rim), threads_);
  SpoolWriter leaves(folder_.leaves(), folder_.text());
  progress.begin("finest level", joined.cells().size());
  parallel_for(joined.cells().size(), 1, threads_, [&](std::size_t c, std::size_t) {
    check_cancelled(progress);
    BuildCell cell = joined.read(joined.cells()[c]);
    finish_leaf(cell, answers_for(cell.key, answers), header_.normal_bits);
    leaves.add(cell);
    progress.advance(1);
  });
  progress.end();
  leaves.commit();
  std::error_code error;
  fs::remove(folder_.path() / "joined.spool", error);
  return counts;
}

/// One record per cell, of its pieces in the order in which they came.
void DiskLeaves::join(LeafCounts& counts, std::vector<RimVertex>& rim, Progress& progress) const {
  const fs::path path = folder_.path() / "pieces.spool";
  const std::optional<Spool> pieces(std::in_place, path);
  const std::vector<std::size_t> begins = runs_of(pieces->cells());
  SpoolWriter joined(folder_.path() / "joined.spool", folder_.text());
  std::mutex mutex;
  progress.begin("cells", begins.size() - 1);
  parallel_for(begins.size() - 1, 1, threads_, [&](std::size_t c, std::size_t) {
    check_cancelled(progress);
    std::vector<BuildCell> own;
    for (std::size_t i = begins[c]; i < begins[c + 1]; ++i) {
      own.push_back(pieces->read(pieces->cells()[i]));
    }
    LeafCounts cell_counts;
    const BuildCell cell = join_pieces(std::move(own), cell_counts);
    joined.add(cell);
    const std::vector<RimVertex> cell_rim = rim_of(cell, header_);
    const std::lock_guard lock(mutex);
    rim.insert(rim.end(), cell_rim.begin(), cell_rim.end());
    counts.duplicate += cell_counts.duplicate;
    progress.advance(1);
  });
  progress.end();
  joined.commit();
  std::error_code error;
  fs::remove(path, error);
}

std::vector<LevelCounts> build_levels_on_disk(
    const WorkFolder& folder, const Header& header, const BlockOptions& options, int threads,
    const std::function<void(const Node&, std::span<const std::byte>)>& parts, Progress& progress) {
  const int finest = header.lattice.finest_level;
  std::vector<LevelCounts> counts(static_cast<std::size_t>(finest) + 1);
  fs::path at = folder.leaves();
  for (int level = finest; level > 0; --level) {
    CellsOnDisk source(at, header, level < finest, threads);
    const fs::path next = folder.level(level);
    counts[static_cast<std::size_t>(level)] = count_level(source.infos());
    if (!folder.has(next)) {
      SpoolWriter writer(next, folder.text());
      counts[static_cast<std::size_t>(level)] = build_level(
          source, header, options, {threads, {}}, [&](BuildCell cell) { writer.add(cell); },
          [&](const FinishedPart& part) { writer.add(part.node, encode_cell(part.mesh, header)); },
          progress);
      writer.commit();
    }
    const Spool made(next);
    for (const SpoolPart& part : made.parts()) parts(part.node, made.read(part));
    at = next;
  }
  CellsOnDisk roots(at, header, false, threads);
  counts[0] = finish_roots(
      roots, [&](const FinishedPart& part) { parts(part.node, encode_cell(part.mesh, header)); });
  return counts;
}

}  // namespace cornice::hlod
