// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/build.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <mutex>
#include <utility>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "hlod/partition.h"

namespace cornice::hlod {
namespace {

constexpr std::size_t kTriangleGrain = std::size_t{1} << 17;
constexpr int kMaxLevel = 16;

// Memory of a block while it is simplified, with its cells, for each of its triangles.
constexpr std::uint64_t kBytesPerBlockTriangle = 400;
// A block is large where so many like it would fill the memory.
constexpr std::uint64_t kLargeBlocks = 64;

// Of cells whose side is not given: half of what is possible, as the side is rounded; metres.
constexpr double kMostCellsAcross = 32768, kLeastSide = 1e-6;
// Metres; a quarter of a micrometre is lost there.
constexpr double kFarthest = 1e9;

/// Of some triangles.
struct MeshExtent {
  double plan = 0, whole = 0;  ///< areas
  Vec3f low, high;
};

std::uint32_t attributes_of(const Mesh& mesh) {
  std::uint32_t attributes = 0;
  for (const FloatProperty& p : mesh.float_properties) {
    if (p.name == "support") attributes |= kHasSupport;
    if (p.name == "u" || p.name == "s" || p.name == "texture_u") attributes |= kHasTexture;
  }
  for (const ByteProperty& p : mesh.byte_properties) {
    if (p.name == "source" || p.name == "class") attributes |= kHasSource;
    if (p.name == "red") attributes |= kHasColour;
  }
  return attributes;
}

MeshExtent extent_of(const Mesh& mesh, std::size_t begin, std::size_t end) {
  double plan = 0, whole = 0;
  Vec3f low = mesh.positions[mesh.triangles[begin][0]], high = low;
  const auto least = [](Vec3f p, Vec3f q) {
    return Vec3f{std::min(p.x, q.x), std::min(p.y, q.y), std::min(p.z, q.z)};
  };
  const auto most = [](Vec3f p, Vec3f q) {
    return Vec3f{std::max(p.x, q.x), std::max(p.y, q.y), std::max(p.z, q.z)};
  };
  for (std::size_t i = begin; i < end; ++i) {
    const Triangle& t = mesh.triangles[i];
    const Vec3f a = mesh.positions[t[0]], b = mesh.positions[t[1]], c = mesh.positions[t[2]];
    const Vec3f n = cross(b - a, c - a);
    plan += 0.5 * std::abs(double{n.z});
    whole += 0.5 * double{norm(n)};
    low = least(least(low, a), least(b, c));
    high = most(most(high, a), most(b, c));
  }
  return {plan, whole, low, high};
}

/// The side of the finest cells, metres; `size` is that of the input.
double chosen_side(const InputSummary& input, Vec3d size, const BuildOptions& options) {
  if (options.cell_side_m) return *options.cell_side_m;
  const bool is_octree = options.partition == Partition::kOctree;
  const double plan = std::max(size.x, size.y);
  const double area = is_octree ? input.area_m2 : input.plan_area_m2;
  const double cells = static_cast<double>(input.triangles) / options.triangles_per_cell;
  // A wall has no area in plan: its columns follow each other along a line.
  const double along = std::min(plan / cells, plan);
  const double least = std::max(plan, size.z) / kMostCellsAcross;
  const double side = std::max({std::sqrt(area / cells), along, least, kLeastSide});
  return std::exp2(std::round(std::log2(side)));
}

/// Throws for coordinates that are no metres on any ground.
void check_size(const Box3d& box, const std::string& name) {
  const Vec3d &low = box.min, &high = box.max;
  const double most = std::max({std::abs(low.x), std::abs(low.y), std::abs(low.z), std::abs(high.x),
                                std::abs(high.y), std::abs(high.z)});
  if (most <= kFarthest) return;
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", most);
  throw InputError(
      name, "has coordinates of " + std::string(text) + "; they have to be metres, below 1e9");
}

/// The builders of the threads that are at work: one each, kept for its memory.
class Builders {
 public:
  Builders(const Header& header, const BlockOptions& options)
      : header_(header), options_(options) {}

  std::unique_ptr<BlockBuilder> take() {
    const std::lock_guard lock(mutex_);
    if (idle_.empty()) return std::make_unique<BlockBuilder>(header_, options_);
    auto builder = std::move(idle_.back());
    idle_.pop_back();
    return builder;
  }
  void give_back(std::unique_ptr<BlockBuilder> builder) {
    const std::lock_guard lock(mutex_);
    idle_.push_back(std::move(builder));
  }

 private:
  Header header_;
  BlockOptions options_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<BlockBuilder>> idle_;
};

using Infos = std::vector<CellSource::Info>;

/// Indices of the cells of each block, blocks in the order of their keys.
std::vector<std::vector<std::size_t>> blocks_of(const Infos& cells, int side, Partition partition) {
  std::vector<std::pair<CellKey, std::size_t>> sorted;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    sorted.emplace_back(block_of_cell(cells[i].key, side, partition), i);
  }
  std::sort(sorted.begin(), sorted.end());
  std::vector<std::vector<std::size_t>> blocks;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    if (i == 0 || sorted[i].first != sorted[i - 1].first) blocks.emplace_back();
    blocks.back().push_back(sorted[i].second);
  }
  return blocks;
}

}  // namespace

LevelCounts count_level(const std::vector<CellSource::Info>& cells) {
  LevelCounts counts;
  counts.cells = cells.size();
  for (const CellSource::Info& cell : cells) {
    counts.triangles += cell.triangles;
    counts.vertices += cell.vertices;
    counts.error_max_m = std::max(counts.error_max_m, double{cell.error_m});
  }
  return counts;
}

void summarise(const Mesh& mesh, const std::string& name, int threads, InputSummary& summary) {
  if (!mesh.crs_text.empty()) {
    if (summary.crs_text.empty()) summary.crs_text = mesh.crs_text;
    if (summary.crs_text != mesh.crs_text) {
      throw InputError(name, "is in " + mesh.crs_text + ", others are in " + summary.crs_text +
                                 "; bring all tiles to one reference system");
    }
  }
  for (const Vec3f& p : mesh.positions) {
    if (!(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z))) {
      throw InputError(name, "vertex " + std::to_string(&p - mesh.positions.data()) +
                                 " is not finite; repair the mesh");
    }
  }
  for (const auto& t : mesh.triangles) {
    if (std::max({t[0], t[1], t[2]}) >= mesh.positions.size()) {
      throw InputError(name, "triangle " + std::to_string(&t - mesh.triangles.data()) +
                                 " names a vertex that is not there; repair the mesh");
    }
  }
  summary.triangles += mesh.triangles.size();
  Box3d box;
  parallel_reduce(
      mesh.triangles.size(), kTriangleGrain, threads, MeshExtent{},
      [&](std::size_t begin, std::size_t end) { return extent_of(mesh, begin, end); },
      [&](MeshExtent&, const MeshExtent& part) {
        box.add(mesh.origin + part.low.cast<double>());
        box.add(mesh.origin + part.high.cast<double>());
        for (const Vec3f& p : {part.low, part.high}) {
          summary.farthest_m =
              std::max({summary.farthest_m, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
        }
        summary.plan_area_m2 += part.plan;
        summary.area_m2 += part.whole;
      });
  if (!box.empty()) {
    check_size(box, name);
    summary.box.add(box.min);
    summary.box.add(box.max);
  }
  summary.attributes |= attributes_of(mesh);
}

Header plan_header(const InputSummary& input, const BuildOptions& options) {
  if (input.triangles == 0 || input.box.empty()) {
    throw InputError("", "the input has no triangles; nothing to build");
  }
  Header header;
  header.partition = options.partition;
  header.attributes = input.attributes;
  header.edge_share = options.edge_share;
  header.normal_bits = options.normal_bits;
  header.crs_text = input.crs_text;
  const double side = chosen_side(input, input.box.max - input.box.min, options);
  const auto corner = [side](double low) { return std::floor(low / side) * side; };
  Lattice& lattice = header.lattice;
  lattice.origin = {corner(input.box.min.x), corner(input.box.min.y), corner(input.box.min.z)};
  const Vec3d size = input.box.max - lattice.origin;
  const double plan = std::max(size.x, size.y);
  const double extent = options.partition == Partition::kQuadtree ? plan : std::max(plan, size.z);
  // A vertex on the far side belongs to the next cell.
  const double cells = std::floor(extent / side) + 1;
  const int needed = static_cast<int>(std::ceil(std::log2(cells)));
  lattice.finest_level = options.levels ? *options.levels - 1 : needed;
  if (needed > kMaxLevel || lattice.finest_level > kMaxLevel || size.z / side > 65000) {
    const double most = std::max(cells, std::floor(size.z / side) + 1);
    throw InputError("", "the input is " + std::to_string(std::llround(most)) +
                             " cells wide or high, more than 65000; choose a larger --cell-side");
  }
  lattice.root_side = side * static_cast<double>(1 << lattice.finest_level);
  return header;
}

CellsInMemory::CellsInMemory(std::vector<BuildCell> cells, const Header& header, int threads)
    : cells_(std::move(cells)) {
  std::sort(cells_.begin(), cells_.end(),
            [](const BuildCell& a, const BuildCell& b) { return a.key < b.key; });
  const bool connected = std::all_of(cells_.begin(), cells_.end(), [](const BuildCell& c) {
    return c.sharers.size() == c.vertices.size();
  });
  if (!connected) connect_cells(cells_, header, threads);
  for (const BuildCell& c : cells_) {
    infos_.push_back({c.key, c.error_m, c.triangles.size(), c.vertices.size()});
  }
}

LevelCounts build_level(CellSource& source, const Header& header, const BlockOptions& options,
                        const LevelTask& task, const CellSink& parents, const PartSink& parts,
                        Progress& progress) {
  const Infos& infos = source.infos();
  LevelCounts counts = count_level(infos);
  if (infos.empty()) return counts;
  const auto blocks = blocks_of(infos, options.side, header.partition);
  counts.blocks = blocks.size();
  std::vector<std::uint64_t> locked(blocks.size());
  Builders builders(header, options);
  progress.begin("level " + std::to_string(infos.front().key.level), counts.triangles);
  parallel_for(blocks.size(), 1, task.threads, [&](std::size_t b, std::size_t) {
    check_cancelled(progress);
    std::vector<CellKey> keys;
    for (const std::size_t i : blocks[b]) keys.push_back(infos[i].key);
    if (task.skips && task.skips(keys)) return;
    std::uint64_t bytes = 0;
    for (const std::size_t i : blocks[b]) bytes += infos[i].triangles * kBytesPerBlockTriangle;
    const MemoryGate::Hold hold =
        task.gate == nullptr
            ? MemoryGate::Hold(nullptr, 0)
            : task.gate->hold("the block around " + cell_name(keys.front()), bytes);
    std::vector<BuildCell> cells;
    for (const std::size_t i : blocks[b]) cells.push_back(source.take(i));
    std::vector<const BuildCell*> pointers;
    for (const BuildCell& cell : cells) pointers.push_back(&cell);
    std::unique_ptr<BlockBuilder> builder = builders.take();
    BlockResult result = builder->run(pointers);
    // Builders keep their memory: those of unusually large blocks must not.
    const bool is_large = task.gate != nullptr && bytes > task.gate->bytes() / kLargeBlocks;
    if (!is_large) builders.give_back(std::move(builder));
    builder.reset();
    locked[b] = result.counts.locked_vertices;
    cells.clear();
    for (BuildCell& parent : result.parents) parents(std::move(parent));
    for (FinishedPart& part : result.finished) parts(std::move(part));
    progress.advance(result.counts.triangles_in);
  });
  progress.end();
  for (const std::uint64_t n : locked) counts.locked_vertices += n;
  return counts;
}

LevelCounts finish_roots(CellSource& source, const PartSink& parts) {
  PartMaker maker;
  std::vector<FinishedPart> made;
  for (std::size_t i = 0; i < source.infos().size(); ++i) {
    maker.add_parts(source.take(i), {}, {}, made);
  }
  for (FinishedPart& part : made) parts(std::move(part));
  return count_level(source.infos());
}

std::vector<LevelCounts> build_levels(std::vector<BuildCell> cells, const Header& header,
                                      const BlockOptions& options, int threads,
                                      const PartSink& sink, Progress& progress) {
  std::vector<LevelCounts> counts(static_cast<std::size_t>(header.lattice.finest_level) + 1);
  CellsInMemory source(std::move(cells), header, threads);
  const int finest = source.infos().empty() ? 0 : source.infos().front().key.level;
  for (int level = finest; level > 0; --level) {
    std::mutex mutex;
    std::vector<BuildCell> next;
    counts[static_cast<std::size_t>(level)] = build_level(
        source, header, options, {threads, {}},
        [&](BuildCell cell) {
          const std::lock_guard lock(mutex);
          next.push_back(std::move(cell));
        },
        sink, progress);
    source = CellsInMemory(std::move(next), header, threads);
  }
  counts[0] = finish_roots(source, sink);
  return counts;
}

}  // namespace cornice::hlod
