// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/build_disk.h"

#include <algorithm>
#include <mutex>
#include <system_error>
#include <tuple>
#include <utility>

#include "core/base/error.h"
#include "core/base/parallel.h"

namespace cornice::hlod {
namespace {

namespace fs = std::filesystem;

// Memory that a cell takes for each byte of its records, while it is read, joined and written.
constexpr std::uint64_t kTimesOfRecord = 6;
// Cells of a band of columns: enough for all threads.
constexpr std::size_t kCellsOfBand = 256;

MemoryGate::Hold hold_for(const DiskTask& task, const CellKey& key, std::uint64_t record_bytes) {
  if (task.gate == nullptr) return {nullptr, 0};
  return task.gate->hold(cell_name(key), kTimesOfRecord * record_bytes);
}

/// Whole columns of cells of a spool: cells [begin, end), whose numbers along x begin at `first`.
struct Band {
  std::size_t begin = 0, end = 0;
  std::int32_t first = 0;
};

std::vector<Band> bands_of(const std::vector<SpoolCell>& cells) {
  std::vector<Band> bands;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const bool new_column = i == 0 || cells[i].key.i != cells[i - 1].key.i;
    if (bands.empty() || (new_column && i - bands.back().begin >= kCellsOfBand)) {
      bands.push_back({i, i, cells[i].key.i});
    }
    bands.back().end = i + 1;
  }
  return bands;
}

/// Tells the cells of a spool who shares their vertices, band by band: a vertex lies in its cell or
/// in one beside it, so reports and answers go no farther than the bands beside, and no more than a
/// few bands' are in memory.
class Connector {
 public:
  using Finish = std::function<void(BuildCell cell, std::span<const RimAnswer> answers)>;

  Connector(const Spool& spool, const Header& header, const DiskTask& task)
      : spool_(spool), header_(header), task_(task), bands_(bands_of(spool.cells())) {}

  /// Calls finish for every cell, from several threads.
  void run(Progress& progress, const Finish& finish) {
    rims_.resize(bands_.size());
    answers_.resize(bands_.size());
    for (std::size_t b = 0; b < bands_.size() + 2; ++b) {
      check_cancelled(progress);
      if (b < bands_.size()) report(bands_[b]);
      if (b >= 1 && b - 1 < bands_.size()) answer(b - 1);
      if (b >= 2) finish_band(b - 2, finish);
    }
  }

 private:
  std::size_t band_of(std::int32_t i) const {
    const auto after = std::upper_bound(bands_.begin() + 1, bands_.end(), i,
                                        [](std::int32_t c, const Band& b) { return c < b.first; });
    return static_cast<std::size_t>(after - bands_.begin()) - 1;
  }

  void report(const Band& band) {
    std::mutex mutex;
    parallel_for(band.end - band.begin, 1, task_.threads, [&](std::size_t c, std::size_t) {
      const SpoolCell& entry = spool_.cells()[band.begin + c];
      const auto hold = hold_for(task_, entry.key, entry.bytes);
      const std::vector<RimVertex> own = rim_of(spool_.read(entry), header_);
      const std::lock_guard lock(mutex);
      for (const RimVertex& r : own) rims_[band_of(r.home.i)].push_back(r);
    });
  }

  void answer(std::size_t b) {
    const auto find = [&](const CellKey& key, BuildCell& buffer) -> const BuildCell* {
      const auto found =
          std::lower_bound(spool_.cells().begin(), spool_.cells().end(), key,
                           [](const SpoolCell& cell, const CellKey& k) { return cell.key < k; });
      buffer.key = key;
      if (found != spool_.cells().end() && found->key == key) buffer = spool_.read(*found);
      return &buffer;
    };
    for (const RimAnswer& a : answer_all(std::move(rims_[b]), find, task_.threads)) {
      answers_[band_of(a.cell.i)].push_back(a);
    }
    rims_[b] = {};
  }

  void finish_band(std::size_t b, const Finish& finish) {
    std::vector<RimAnswer> answers = std::move(answers_[b]);
    std::sort(answers.begin(), answers.end(), [](const RimAnswer& p, const RimAnswer& q) {
      return std::tie(p.cell, p.vertex) < std::tie(q.cell, q.vertex);
    });
    const Band& band = bands_[b];
    parallel_for(band.end - band.begin, 1, task_.threads, [&](std::size_t c, std::size_t) {
      const SpoolCell& entry = spool_.cells()[band.begin + c];
      const auto hold = hold_for(task_, entry.key, entry.bytes);
      finish(spool_.read(entry), answers_for(entry.key, answers));
    });
  }

  const Spool& spool_;
  const Header& header_;
  const DiskTask& task_;
  std::vector<Band> bands_;
  std::vector<std::vector<RimVertex>> rims_;     ///< per band: of vertices that lie in it
  std::vector<std::vector<RimAnswer>> answers_;  ///< per band: for its cells
};

/// Cells that a spool holds, sharers known.
class CellsOnDisk : public CellSource {
 public:
  explicit CellsOnDisk(const fs::path& path) : spool_(path) {
    for (const SpoolCell& c : spool_.cells()) {
      infos_.push_back({c.key, c.error_m, c.triangles, c.vertices});
    }
  }
  const std::vector<Info>& infos() const override { return infos_; }
  BuildCell take(std::size_t index) override { return spool_.read(spool_.cells()[index]); }

 private:
  Spool spool_;
  std::vector<Info> infos_;
};

/// The cells of a spool once they know their sharers. What is written for that has no name any
/// more: it is gone when it is of no use.
std::unique_ptr<CellsOnDisk> connected(const WorkFolder& folder, const fs::path& path,
                                       const Header& header, const DiskTask& task,
                                       Progress& progress) {
  const fs::path to = folder.path() / "connected.spool";
  {
    const Spool spool(path);
    SpoolWriter writer(to, folder.text());
    Connector(spool, header, task)
        .run(progress, [&](BuildCell cell, std::span<const RimAnswer> answers) {
          put_sharers(cell, answers);
          writer.add(cell);
        });
    writer.commit();
  }
  auto cells = std::make_unique<CellsOnDisk>(to);
  std::error_code error;
  fs::remove(to, error);
  return cells;
}

/// Where each cell's records begin in a list ordered by key; one more at the end.
std::vector<std::size_t> runs_of(const std::vector<SpoolCell>& cells) {
  std::vector<std::size_t> begins;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i == 0 || cells[i].key != cells[i - 1].key) begins.push_back(i);
  }
  begins.push_back(cells.size());
  return begins;
}

std::vector<std::uint64_t> numbers_of(const LeafCounts& counts) {
  return {counts.triangles, counts.degenerate, counts.duplicate, counts.split_pieces};
}
DiskTask task_of(int threads) {
  DiskTask task;
  task.threads = threads;
  return task;
}
LeafCounts counts_of(const std::vector<std::uint64_t>& numbers) {
  return {numbers.at(0), numbers.at(1), numbers.at(2), numbers.at(3)};
}

/// Parts of a level and cells of the next coarser one, to a spool.
LevelCounts build_one_level(CellSource& source, int level, const fs::path& next,
                            const WorkFolder& folder, const Header& header,
                            const BlockOptions& options, const DiskTask& task, Progress& progress) {
  const Region* const region = task.region;
  LevelTask level_task{task.threads, {}, task.gate};
  if (region != nullptr) {
    level_task.skips = [&](const std::vector<CellKey>& cells) {
      return !region->needed[static_cast<std::size_t>(level)].contains(cells.front().i);
    };
  }
  SpoolWriter writer(next, folder.text());
  const LevelCounts counts = build_level(
      source, header, options, level_task,
      [&](const BuildCell& cell) {
        // A region's neighbours are of use as those who share vertices.
        const bool is_wanted =
            region == nullptr ||
            region->needed[static_cast<std::size_t>(level) - 1].grown().contains(cell.key.i);
        if (is_wanted) writer.add(cell);
      },
      [&](const FinishedPart& part) {
        if (region != nullptr && !region->owns(part.node.key)) return;
        writer.add(part.node, encode_cell(part.mesh, header));
      },
      progress);
  writer.commit();
  return counts;
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
                       const DiskTask& task)
    : folder_(folder), header_(header), task_(task), maker_(header, max_pieces, task.threads) {
  if (folder.has(folder.pieces()) || folder.has(folder.joined())) return;
  pieces_ = std::make_unique<SpoolWriter>(folder.pieces(), folder.text());
}

DiskLeaves::DiskLeaves(const WorkFolder& folder, const Header& header, std::uint64_t max_pieces,
                       int threads)
    : DiskLeaves(folder, header, max_pieces, task_of(threads)) {}

void DiskLeaves::add(const Mesh& mesh) {
  const auto finest = static_cast<std::size_t>(header_.lattice.finest_level);
  maker_.pieces(mesh, task_.piece_triangles, [&](const BuildCell& piece) {
    // A region's neighbours are of use as those who share vertices.
    const bool is_read =
        task_.region == nullptr || task_.region->needed[finest].grown().contains(piece.key.i);
    if (is_read) pieces_->add(piece);
  });
}

LeafCounts DiskLeaves::finish(Progress& progress) {
  if (pieces_ != nullptr) {
    pieces_->commit(numbers_of(maker_.counts()));
    pieces_.reset();
  }
  if (!folder_.has(folder_.joined())) join(progress);
  const Spool joined(folder_.joined());
  const auto finest = static_cast<std::size_t>(header_.lattice.finest_level);
  SpoolWriter leaves(folder_.leaves(), folder_.text());
  progress.begin("finest level", joined.cells().size());
  Connector(joined, header_, task_)
      .run(progress, [&](BuildCell cell, std::span<const RimAnswer> answers) {
        progress.advance(1);
        const bool is_needed =
            task_.region == nullptr || task_.region->needed[finest].contains(cell.key.i);
        if (!is_needed) return;
        finish_leaf(cell, answers, header_.normal_bits);
        leaves.add(cell);
      });
  progress.end();
  leaves.commit(joined.numbers());
  std::error_code error;
  fs::remove(folder_.joined(), error);
  return counts_of(joined.numbers());
}

/// One record per cell, of its pieces in the order in which they came.
void DiskLeaves::join(Progress& progress) const {
  {
    const Spool pieces(folder_.pieces());
    const std::vector<std::size_t> begins = runs_of(pieces.cells());
    SpoolWriter joined(folder_.joined(), folder_.text());
    LeafCounts counts = counts_of(pieces.numbers());
    std::mutex mutex;
    progress.begin("cells", begins.size() - 1);
    parallel_for(begins.size() - 1, 1, task_.threads, [&](std::size_t c, std::size_t) {
      check_cancelled(progress);
      std::uint64_t bytes = 0;
      for (std::size_t i = begins[c]; i < begins[c + 1]; ++i) bytes += pieces.cells()[i].bytes;
      const auto hold = hold_for(task_, pieces.cells()[begins[c]].key, bytes);
      std::vector<BuildCell> own;
      for (std::size_t i = begins[c]; i < begins[c + 1]; ++i) {
        own.push_back(pieces.read(pieces.cells()[i]));
      }
      LeafCounts cell_counts;
      joined.add(join_pieces(std::move(own), cell_counts));
      const std::lock_guard lock(mutex);
      counts.duplicate += cell_counts.duplicate;
      progress.advance(1);
    });
    progress.end();
    joined.commit(numbers_of(counts));
  }
  std::error_code error;
  fs::remove(folder_.pieces(), error);
}

LeafCounts counts_of_leaves(const WorkFolder& folder) {
  return counts_of(Spool(folder.leaves()).numbers());
}

std::vector<LevelCounts> build_levels_on_disk(
    const WorkFolder& folder, const Header& header, const BlockOptions& options, int threads,
    const std::function<void(const Node&, std::span<const std::byte>)>& parts, Progress& progress) {
  return build_levels_on_disk(folder, header, options, task_of(threads), parts, progress);
}

std::vector<LevelCounts> build_levels_on_disk(
    const WorkFolder& folder, const Header& header, const BlockOptions& options,
    const DiskTask& task, const std::function<void(const Node&, std::span<const std::byte>)>& parts,
    Progress& progress) {
  const Region* const region = task.region;
  const int finest = header.lattice.finest_level, last = region == nullptr ? 0 : region->level;
  std::vector<LevelCounts> counts(static_cast<std::size_t>(finest) + 1);
  fs::path at = task.first_level ? folder.level(*task.first_level) : folder.leaves();
  for (int level = task.first_level.value_or(finest); level > last; --level) {
    const fs::path next = folder.level(level - 1);
    LevelCounts& level_counts = counts[static_cast<std::size_t>(level)];
    if (folder.has(next)) {
      level_counts = count_level(CellsOnDisk(at).infos());
    } else {
      const bool connects = level < finest || task.first_level;
      const auto source = connects ? connected(folder, at, header, task, progress)
                                   : std::make_unique<CellsOnDisk>(at);
      level_counts = build_one_level(*source, level, next, folder, header, options, task, progress);
    }
    const Spool made(next);
    for (const SpoolPart& part : made.parts()) parts(part.node, made.read(part));
    at = next;
  }
  if (region != nullptr) return counts;
  CellsOnDisk roots(at);
  counts[0] = finish_roots(
      roots, [&](const FinishedPart& part) { parts(part.node, encode_cell(part.mesh, header)); });
  return counts;
}

}  // namespace cornice::hlod
