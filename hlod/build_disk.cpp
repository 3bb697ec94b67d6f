// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/build_disk.h"

#include <algorithm>
#include <mutex>
#include <optional>
#include <system_error>
#include <tuple>
#include <utility>

#include "core/base/error.h"
#include "core/base/parallel.h"

namespace cornice::hlod {
namespace {

namespace fs = std::filesystem;

/// Cells that a spool holds.
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

/// Where each cell's records begin in a list ordered by key; one more at the end.
std::vector<std::size_t> runs_of(const std::vector<SpoolCell>& cells) {
  std::vector<std::size_t> begins;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i == 0 || cells[i].key != cells[i - 1].key) begins.push_back(i);
  }
  begins.push_back(cells.size());
  return begins;
}

LevelCounts counts_of(const std::vector<CellSource::Info>& infos) {
  LevelCounts counts;
  counts.cells = infos.size();
  for (const CellSource::Info& info : infos) {
    counts.triangles += info.triangles;
    counts.vertices += info.vertices;
    counts.error_max_m = std::max(counts.error_max_m, double{info.error_m});
  }
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
  const std::vector<RimAnswer> answers = answer(std::move(rim));
  const Spool joined(folder_.path() / "joined.spool");
  SpoolWriter leaves(folder_.leaves(), folder_.text());
  progress.begin("finest level", joined.cells().size());
  parallel_for(joined.cells().size(), 1, threads_, [&](std::size_t c, std::size_t) {
    check_cancelled(progress);
    BuildCell cell = joined.read(joined.cells()[c]);
    const auto [begin, end] =
        std::equal_range(answers.begin(), answers.end(), RimAnswer{cell.key, 0, 0, {}, {}},
                         [](const RimAnswer& a, const RimAnswer& b) { return a.cell < b.cell; });
    finish_leaf(cell, {begin, end}, header_.normal_bits);
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

/// Answers to all rim vertices, in the order of the cells that they are for.
std::vector<RimAnswer> DiskLeaves::answer(std::vector<RimVertex> rim) const {
  const Spool joined(folder_.path() / "joined.spool");
  std::sort(rim.begin(), rim.end(), [](const RimVertex& a, const RimVertex& b) {
    return std::tie(a.home, a.cell, a.vertex) < std::tie(b.home, b.cell, b.vertex);
  });
  std::vector<std::size_t> begins;
  for (std::size_t i = 0; i < rim.size(); ++i) {
    if (i == 0 || rim[i].home != rim[i - 1].home) begins.push_back(i);
  }
  begins.push_back(rim.size());
  std::mutex mutex;
  std::vector<RimAnswer> answers;
  parallel_for(begins.size() - 1, 1, threads_, [&](std::size_t h, std::size_t) {
    BuildCell home;
    home.key = rim[begins[h]].home;
    const auto found =
        std::lower_bound(joined.cells().begin(), joined.cells().end(), home.key,
                         [](const SpoolCell& cell, const CellKey& key) { return cell.key < key; });
    if (found != joined.cells().end() && found->key == home.key) home = joined.read(*found);
    const std::vector<RimVertex> part(rim.begin() + static_cast<std::ptrdiff_t>(begins[h]),
                                      rim.begin() + static_cast<std::ptrdiff_t>(begins[h + 1]));
    const std::vector<RimAnswer> own = answer_rim(home, part);
    const std::lock_guard lock(mutex);
    answers.insert(answers.end(), own.begin(), own.end());
  });
  std::sort(answers.begin(), answers.end(), [](const RimAnswer& a, const RimAnswer& b) {
    return std::tie(a.cell, a.vertex) < std::tie(b.cell, b.vertex);
  });
  return answers;
}

std::vector<LevelCounts> build_levels_on_disk(
    const WorkFolder& folder, const Header& header, const BlockOptions& options, int threads,
    const std::function<void(const Node&, std::span<const std::byte>)>& parts, Progress& progress) {
  const int finest = header.lattice.finest_level;
  std::vector<LevelCounts> counts(static_cast<std::size_t>(finest) + 1);
  fs::path at = folder.leaves();
  for (int level = finest; level > 0; --level) {
    CellsOnDisk source(at);
    const fs::path next = folder.level(level);
    counts[static_cast<std::size_t>(level)] = counts_of(source.infos());
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
  CellsOnDisk roots(at);
  counts[0] = finish_roots(
      roots, [&](const FinishedPart& part) { parts(part.node, encode_cell(part.mesh, header)); });
  return counts;
}

}  // namespace cornice::hlod
