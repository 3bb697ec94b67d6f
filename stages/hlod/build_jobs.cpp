// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/hlod/build_jobs.h"

#include <algorithm>
#include <charconv>
#include <mutex>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/base/error.h"
#include "core/base/memory.h"
#include "core/cli/version.h"
#include "core/io/ply.h"
#include "hlod/build_disk.h"
#include "hlod/build_region.h"
#include "hlod/build_spool.h"
#include "hlod/file.h"

namespace cornice::hlod {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// Bytes that building in memory takes per triangle, measured on grids and on LiDAR meshes, with
/// some room.
constexpr std::uint64_t kBytesInMemory = 150;

/// What is the same for every way to build the same file.
Json provenance_of(const BuildCommand& command, const Header& header) {
  Json json;
  json["program"] = "cornice-hlod build";
  json["version"] = version_text();
  json["cell_side_m"] = header.lattice.cell_side(header.lattice.finest_level);
  json["block_side"] = command.options.block.side;
  json["keep_share"] = command.options.block.keep_share;
  json["attribute_weight"] = command.options.block.attribute_weight;
  json["max_error_share"] = command.options.block.max_error_share;
  for (const fs::path& tile : command.tiles) json["inputs"].push_back(tile.filename().string());
  return json;
}

Json json_of(const Header& h) {
  const Lattice& l = h.lattice;
  return {{"origin", {l.origin.x, l.origin.y, l.origin.z}},
          {"root_side", l.root_side},
          {"finest_level", l.finest_level},
          {"cell_bits", l.cell_bits},
          {"octree", h.partition == Partition::kOctree},
          {"attributes", h.attributes},
          {"edge_share", h.edge_share},
          {"normal_bits", h.normal_bits},
          {"crs", h.crs_text},
          {"provenance", h.provenance}};
}

Header header_of(const Json& json) {
  Header h;
  h.lattice.origin = {json.at("origin").at(0), json.at("origin").at(1), json.at("origin").at(2)};
  h.lattice.root_side = json.at("root_side");
  h.lattice.finest_level = json.at("finest_level");
  h.lattice.cell_bits = json.at("cell_bits");
  h.partition = json.at("octree").get<bool>() ? Partition::kOctree : Partition::kQuadtree;
  h.attributes = json.at("attributes");
  h.edge_share = json.at("edge_share");
  h.normal_bits = json.at("normal_bits");
  h.crs_text = json.at("crs");
  h.provenance = json.at("provenance");
  return h;
}

void report_leaves(const LeafCounts& leaves, Report& report) {
  report.count("triangles_in", leaves.triangles);
  report.count("degenerate_left_out", leaves.degenerate);
  report.count("duplicates_left_out", leaves.duplicate);
  report.count("pieces_of_long_triangles", leaves.split_pieces);
}

void report_levels(const std::vector<LevelCounts>& levels, Report& report) {
  std::uint64_t all = 0, cells = 0;
  Json rows = Json::array();
  for (std::size_t level = 0; level < levels.size(); ++level) {
    const LevelCounts& l = levels[level];
    all += l.triangles;
    cells += l.cells;
    rows.push_back({{"level", level},
                    {"cells", l.cells},
                    {"triangles", l.triangles},
                    {"blocks", l.blocks},
                    {"locked_vertices", l.locked_vertices},
                    {"error_max_m", l.error_max_m}});
  }
  report.count("triangles_all_levels", all);
  report.count("cells", cells);
  report.quality("levels", rows);
}

/// The tiles, kept in memory as long as building there would fit.
struct Input {
  InputSummary summary;
  std::vector<Mesh> meshes;  ///< empty where they do not fit
  bool fits = true;
};

Input read_tiles(const BuildCommand& command, StageContext& context, std::uint64_t limit_bytes) {
  Input input;
  input.fits = !command.out_of_core;
  context.progress.begin("read", command.tiles.size());
  for (const fs::path& tile : command.tiles) {
    check_cancelled(context.progress);
    context.report.add_input(tile);
    Mesh mesh = read_ply_mesh(tile);
    summarise(mesh, tile.string(), context.options.threads, input.summary);
    input.fits = input.fits && input.summary.triangles * kBytesInMemory < limit_bytes;
    if (input.fits) {
      input.meshes.push_back(std::move(mesh));
    } else {
      input.meshes = {};
    }
    context.progress.advance(1);
  }
  context.progress.end();
  return input;
}

/// Calls act(mesh) for every tile in order; tiles are read again where they were not kept.
void for_each_tile(const BuildCommand& command, Input& input, StageContext& context,
                   const std::function<void(const Mesh&)>& act) {
  context.progress.begin("sort into cells", command.tiles.size());
  for (std::size_t i = 0; i < command.tiles.size(); ++i) {
    check_cancelled(context.progress);
    act(input.meshes.empty() ? read_ply_mesh(command.tiles[i]) : std::move(input.meshes[i]));
    if (!input.meshes.empty()) input.meshes[i] = {};
    context.progress.advance(1);
  }
  context.progress.end();
}

void build_in_memory(const BuildCommand& command, const Header& header, Input& input,
                     StageContext& context) {
  const int threads = context.options.threads;
  LeafMaker maker(header, command.options.max_pieces, threads);
  LeafCounts counts;
  std::vector<BuildCell> leaves;
  context.report.step("leaves", [&] {
    std::vector<std::vector<BuildCell>> pieces;
    for_each_tile(command, input, context,
                  [&](const Mesh& mesh) { pieces.push_back(maker.pieces(mesh)); });
    counts = maker.counts();
    leaves = finish_leaves(std::move(pieces), header, threads, counts);
  });
  FileWriter writer(command.output, header);
  std::vector<LevelCounts> levels;
  context.report.step("levels", [&] {
    levels = build_levels(
        std::move(leaves), header, command.options.block, threads,
        [&](const FinishedPart& part) { writer.add(part.node, encode_cell(part.mesh, header)); },
        context.progress);
  });
  context.report.step("finish", [&] { writer.finish(); });
  report_leaves(counts, context.report);
  report_levels(levels, context.report);
}

/// Names a build, so that what a killed one left is used by its like alone.
std::string build_text(const BuildCommand& command, const Header& header) {
  Json json = json_of(header);
  for (const fs::path& tile : command.tiles) {
    json["files"].push_back({fs::absolute(tile).string(), fs::file_size(tile),
                             fs::last_write_time(tile).time_since_epoch().count()});
  }
  return json.dump();
}

void build_on_disk(const BuildCommand& command, const Header& header, Input& input,
                   StageContext& context) {
  const int threads = context.options.threads;
  const fs::path beside =
      command.output.parent_path() / ("." + command.output.filename().string() + ".work");
  const WorkFolder folder(command.work.empty() ? beside : command.work,
                          build_text(command, header));
  if (!folder.has(folder.leaves())) {
    context.report.step("leaves", [&] {
      DiskLeaves leaves(folder, header, command.options.max_pieces, threads);
      for_each_tile(command, input, context, [&](const Mesh& mesh) { leaves.add(mesh); });
      report_leaves(leaves.finish(context.progress), context.report);
    });
  }
  input.meshes = {};
  FileWriter writer(command.output, header);
  std::vector<LevelCounts> levels;
  context.report.step("levels", [&] {
    levels = build_levels_on_disk(
        folder, header, command.options.block, threads,
        [&](const Node& node, std::span<const std::byte> block) { writer.add(node, block); },
        context.progress);
  });
  context.report.step("finish", [&] { writer.finish(); });
  folder.remove();
  report_levels(levels, context.report);
}

std::pair<int, int> parse_region(const std::string& text) {
  int index = 0, count = 0;
  const char* const end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, index);
  const bool slash = first.ptr != end && *first.ptr == '/';
  const auto second = std::from_chars(slash ? first.ptr + 1 : end, end, count);
  if (!slash || second.ec != std::errc() || second.ptr != end || index < 1 || index > count) {
    throw UsageError("--region", "must be I/N with 1 <= I <= N, but is " + text);
  }
  return {index, count};
}

/// Cells of the finest level that the region needs, with those around them, which share vertices.
std::vector<BuildCell> region_leaves(const BuildCommand& command, const Header& header,
                                     const Region& region, Input& input, StageContext& context) {
  const int threads = context.options.threads;
  const Columns needed = region.needed[static_cast<std::size_t>(header.lattice.finest_level)];
  const Columns read = needed.grown();
  LeafMaker maker(header, command.options.max_pieces, threads);
  std::vector<std::vector<BuildCell>> pieces;
  for_each_tile(command, input, context, [&](const Mesh& mesh) {
    pieces.push_back(maker.pieces(mesh));
    std::erase_if(pieces.back(), [&](const BuildCell& c) { return !read.contains(c.key.i); });
  });
  LeafCounts counts = maker.counts();
  std::vector<BuildCell> leaves = finish_leaves(std::move(pieces), header, threads, counts);
  std::erase_if(leaves, [&](const BuildCell& c) { return !needed.contains(c.key.i); });
  report_leaves(counts, context.report);
  return leaves;
}

void build_region(const BuildCommand& command, const Header& header, Input& input,
                  StageContext& context) {
  const auto [index, count] = parse_region(command.region);
  const BlockOptions& block = command.options.block;
  const Region region = plan_region(header, input.summary.box, block.side, index - 1, count);
  Json text = json_of(header);
  text["region"] = index;
  text["regions"] = count;
  text["block"] = {block.side, block.keep_share, block.max_error_share, block.attribute_weight};
  SpoolWriter writer(command.output, text.dump());
  CellsInMemory source(region_leaves(command, header, region, input, context), header,
                       context.options.threads);
  for (int level = header.lattice.finest_level; level > region.level; --level) {
    std::mutex mutex;
    std::vector<BuildCell> next;
    const Columns needed = region.needed[static_cast<std::size_t>(level)];
    const Columns wanted = region.needed[static_cast<std::size_t>(level) - 1];
    LevelTask task{context.options.threads, [&](const std::vector<CellKey>& cells) {
                     return !needed.contains(cells.front().i);
                   }};
    build_level(
        source, header, block, task,
        [&](BuildCell cell) {
          if (!wanted.grown().contains(cell.key.i)) return;
          const std::lock_guard lock(mutex);
          next.push_back(std::move(cell));
        },
        [&](const FinishedPart& part) {
          if (region.owns(part.node.key)) writer.add(part.node, encode_cell(part.mesh, header));
        },
        context.progress);
    source = CellsInMemory(std::move(next), header, context.options.threads);
  }
  for (std::size_t i = 0; i < source.infos().size(); ++i) {
    const BuildCell cell = source.take(i);
    if (region.owns(cell.key)) writer.add(cell);
  }
  writer.commit();
}

/// The regions' files in their order, all of one build and none missing.
std::vector<std::unique_ptr<Spool>> open_regions(const std::vector<fs::path>& files, Json& plan) {
  std::vector<std::unique_ptr<Spool>> regions(files.size());
  for (const fs::path& file : files) {
    auto spool = std::make_unique<Spool>(file);
    Json text = Json::parse(spool->text(), nullptr, false);
    if (!text.is_object() || !text.contains("region")) {
      throw InputError(file.string(), "is no region of a hierarchy");
    }
    const std::size_t index = text["region"].get<std::size_t>() - 1;
    if (text["regions"].get<std::size_t>() != files.size() || regions[index] != nullptr) {
      throw InputError(file.string(), "is region " + std::to_string(index + 1) + " of " +
                                          text["regions"].dump() + "; give each of them once, " +
                                          "not " + std::to_string(files.size()) + " files");
    }
    text.erase("region");
    if (plan.is_null()) plan = text;
    if (plan != text) throw InputError(file.string(), "is of another build than the others");
    regions[index] = std::move(spool);
  }
  return regions;
}

void join_regions(const BuildCommand& command, StageContext& context) {
  for (const fs::path& file : command.tiles) context.report.add_input(file);
  Json plan;
  const auto regions = open_regions(command.tiles, plan);
  const Header header = header_of(plan);
  BlockOptions block;
  block.side = plan.at("block").at(0);
  block.keep_share = plan.at("block").at(1);
  block.max_error_share = plan.at("block").at(2);
  block.attribute_weight = plan.at("block").at(3);
  FileWriter writer(command.output, header);
  std::vector<BuildCell> cells;
  std::vector<LevelCounts> counts(static_cast<std::size_t>(header.lattice.finest_level) + 1);
  for (const auto& region : regions) {
    for (const SpoolPart& part : region->parts()) {
      check_cancelled(context.progress);
      writer.add(part.node, region->read(part));
      LevelCounts& level = counts[static_cast<std::size_t>(part.node.key.level)];
      level.cells += part.node.part == 0;
      level.triangles += part.node.triangles;
      level.error_max_m = std::max(level.error_max_m, double{part.node.error_m});
    }
    for (const SpoolCell& cell : region->cells()) {
      cells.push_back(region->read(cell));
      // What lies beyond the region may share vertices that happen to coincide.
      cells.back().sharers.clear();
    }
  }
  const std::vector<LevelCounts> upper = build_levels(
      std::move(cells), header, block, context.options.threads,
      [&](const FinishedPart& part) { writer.add(part.node, encode_cell(part.mesh, header)); },
      context.progress);
  for (std::size_t level = 0; level < counts.size(); ++level) {
    if (upper[level].cells > 0) counts[level] = upper[level];
  }
  writer.finish();
  report_levels(counts, context.report);
}

}  // namespace

void run_build_job(const BuildCommand& command, StageContext& context) {
  if (command.join) return join_regions(command, context);
  Input input;
  context.report.step("read",
                      [&] { input = read_tiles(command, context, context.memory.limit_bytes()); });
  Header header = plan_header(input.summary, command.options);
  header.provenance = provenance_of(command, header).dump();
  if (!command.region.empty()) return build_region(command, header, input, context);
  context.report.quality("in_memory", input.fits);
  if (input.fits) {
    build_in_memory(command, header, input, context);
  } else {
    build_on_disk(command, header, input, context);
  }
}

}  // namespace cornice::hlod
