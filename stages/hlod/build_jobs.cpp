// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/hlod/build_jobs.h"

#include <algorithm>
#include <charconv>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/cli/version.h"
#include "hlod/build_disk.h"
#include "hlod/build_region.h"
#include "hlod/build_spool.h"
#include "hlod/file.h"
#include "stages/hlod/build_input.h"

namespace cornice::hlod {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

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

/// Without --memory a machine, or a job of a cluster, that has little is tried all the same.
MemoryPlan memory_plan(const StageContext& context) {
  const std::uint64_t limit = context.memory.limit_bytes();
  return plan_memory(context.options.memory_gib > 0 ? limit : std::max(limit, kLeastMemory));
}

/// Where cells on disk go.
fs::path work_folder(const BuildCommand& command) {
  if (!command.work.empty()) return command.work;
  return command.output.parent_path() / ("." + command.output.filename().string() + ".work");
}

void require_leaves(bool has_any) {
  if (!has_any) {
    throw InputError("", "no triangle of the input has an area on the lattice; nothing to build");
  }
}

/// Does what needs the folder of a build. Where it fails, says what the folder is good for.
template <class Work>
void work_in(const WorkFolder& folder, Report& report, const Work& work) {
  try {
    work();
  } catch (const InputError&) {
    folder.remove();
    throw;
  } catch (...) {
    // Only an empty folder can be removed so.
    std::error_code not_empty;
    fs::remove(folder.path(), not_empty);
    if (not_empty) {
      report.warn(folder.path().string() +
                  " keeps what is done: the same command goes on from there; else delete it");
    }
    throw;
  }
  folder.remove();
}

/// False where long triangles made more pieces than memory holds; nothing is written then.
bool build_in_memory(const BuildCommand& command, const Header& header, const MemoryPlan& plan,
                     BuildInput& input, StageContext& context) {
  const int threads = context.options.threads;
  const std::uint64_t most = context.memory.limit_bytes() / kBytesInMemory;
  LeafMaker maker(header, command.options.max_pieces, threads);
  LeafCounts counts;
  std::vector<BuildCell> leaves;
  std::uint64_t triangles = 0;
  context.report.step("leaves", [&] {
    std::vector<std::vector<BuildCell>> pieces(1);
    input.for_each([&](const Mesh& mesh) {
      if (triangles > most) return;
      maker.pieces(mesh, plan.piece_triangles, [&](BuildCell piece) {
        triangles += piece.triangles.size();
        if (triangles <= most) pieces.front().push_back(std::move(piece));
      });
    });
    if (triangles > most) return;
    counts = maker.counts();
    leaves = finish_leaves(std::move(pieces), header, threads, counts);
  });
  if (triangles > most) return false;
  require_leaves(!leaves.empty());
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
  return true;
}

/// Names a build, so that what a killed one left is used by its like alone.
Json build_text(const BuildCommand& command, const Header& header) {
  Json json = json_of(header);
  for (const fs::path& tile : command.tiles) {
    json["files"].push_back({fs::absolute(tile).string(), fs::file_size(tile),
                             fs::last_write_time(tile).time_since_epoch().count()});
  }
  return json;
}

/// The finest level, unless a killed build left it; its counts, which go to the report.
LeafCounts leaves_on_disk(const BuildCommand& command, const WorkFolder& folder,
                          const Header& header, const DiskTask& task, BuildInput& input,
                          StageContext& context) {
  context.report.step("leaves", [&] {
    if (folder.has(folder.leaves())) return;
    DiskLeaves leaves(folder, header, command.options.max_pieces, task);
    if (leaves.wants_meshes()) input.for_each([&](const Mesh& mesh) { leaves.add(mesh); });
    leaves.finish(context.progress);
  });
  const LeafCounts counts = counts_of_leaves(folder);
  report_leaves(counts, context.report);
  return counts;
}

void build_on_disk(const BuildCommand& command, const Header& header, const MemoryPlan& plan,
                   BuildInput& input, StageContext& context) {
  MemoryGate gate(plan.work_bytes);
  DiskTask task;
  task.threads = context.options.threads;
  task.piece_triangles = plan.piece_triangles;
  task.gate = &gate;
  const WorkFolder folder(work_folder(command), build_text(command, header).dump());
  std::vector<LevelCounts> levels;
  work_in(folder, context.report, [&] {
    leaves_on_disk(command, folder, header, task, input, context);
    FileWriter writer(command.output, header);
    context.report.step("levels", [&] {
      levels = build_levels_on_disk(
          folder, header, command.options.block, task,
          [&](const Node& node, std::span<const std::byte> block) { writer.add(node, block); },
          context.progress);
    });
    require_leaves(levels.back().cells > 0);
    context.report.step("finish", [&] { writer.finish(); });
  });
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

/// What a region's file says of the input, all of which every region reads. Copies are not in it:
/// a region sees those near it.
std::vector<std::uint64_t> numbers_of_input(const LeafCounts& counts) {
  return {counts.triangles, counts.degenerate, counts.split_pieces};
}

/// Cells of the finest level that the region needs; `counts` are those of the input.
std::vector<BuildCell> region_leaves(const BuildCommand& command, const Header& header,
                                     const Region& region, const MemoryPlan& plan,
                                     BuildInput& input, StageContext& context, LeafCounts& counts) {
  const int threads = context.options.threads;
  const Columns needed = region.needed[static_cast<std::size_t>(header.lattice.finest_level)];
  // With those around them, which share vertices.
  const Columns read = needed.grown();
  LeafMaker maker(header, command.options.max_pieces, threads);
  std::vector<std::vector<BuildCell>> pieces(1);
  input.for_each([&](const Mesh& mesh) {
    maker.pieces(mesh, plan.piece_triangles, [&](BuildCell piece) {
      if (read.contains(piece.key.i)) pieces.front().push_back(std::move(piece));
    });
  });
  counts = maker.counts();
  std::vector<BuildCell> leaves = finish_leaves(std::move(pieces), header, threads, counts);
  std::erase_if(leaves, [&](const BuildCell& c) { return !needed.contains(c.key.i); });
  report_leaves(counts, context.report);
  return leaves;
}

/// The cells of the region's level are joined with those of others, whom they share vertices with.
void add_top(const Region& region, BuildCell cell, SpoolWriter& writer) {
  if (!region.owns(cell.key)) return;
  cell.sharers.clear();
  writer.add(cell);
}

void region_in_memory(const BuildCommand& command, const Header& header, const Region& region,
                      const MemoryPlan& plan, BuildInput& input, SpoolWriter& writer,
                      StageContext& context) {
  LeafCounts leaves;
  CellsInMemory source(region_leaves(command, header, region, plan, input, context, leaves), header,
                       context.options.threads);
  for (int level = header.lattice.finest_level; level > region.level; --level) {
    std::mutex mutex;
    std::vector<BuildCell> next;
    const Columns needed = region.needed[static_cast<std::size_t>(level)];
    const Columns wanted = region.needed[static_cast<std::size_t>(level) - 1];
    LevelTask task;
    task.threads = context.options.threads;
    task.skips = [&](const std::vector<CellKey>& cells) {
      return !needed.contains(cells.front().i);
    };
    build_level(
        source, header, command.options.block, task,
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
    add_top(region, source.take(i), writer);
  }
  writer.commit(numbers_of_input(leaves));
}

void region_on_disk(const BuildCommand& command, const Header& header, const Region& region,
                    const MemoryPlan& plan, BuildInput& input, SpoolWriter& writer,
                    StageContext& context) {
  MemoryGate gate(plan.work_bytes);
  DiskTask task;
  task.threads = context.options.threads;
  task.piece_triangles = plan.piece_triangles;
  task.gate = &gate;
  task.region = &region;
  Json text = build_text(command, header);
  text["region"] = command.region;
  const WorkFolder folder(work_folder(command), text.dump());
  work_in(folder, context.report, [&] {
    const LeafCounts leaves = leaves_on_disk(command, folder, header, task, input, context);
    build_levels_on_disk(
        folder, header, command.options.block, task,
        [&](const Node& node, std::span<const std::byte> block) { writer.add(node, block); },
        context.progress);
    const bool has_levels = region.level < header.lattice.finest_level;
    const Spool top(has_levels ? folder.level(region.level) : folder.leaves());
    for (const SpoolCell& cell : top.cells()) add_top(region, top.read(cell), writer);
    writer.commit(numbers_of_input(leaves));
  });
}

void build_region(const BuildCommand& command, const Header& header, const MemoryPlan& plan,
                  BuildInput& input, StageContext& context) {
  const auto [index, count] = parse_region(command.region);
  const BlockOptions& block = command.options.block;
  const Region region = plan_region(header, input.summary().box, block.side, index - 1, count);
  Json text = json_of(header);
  text["region"] = index;
  text["regions"] = count;
  text["block"] = {block.side, block.keep_share, block.max_error_share, block.attribute_weight};
  SpoolWriter writer(command.output, text.dump());
  if (input.fits()) {
    region_in_memory(command, header, region, plan, input, writer, context);
  } else {
    region_on_disk(command, header, region, plan, input, writer, context);
  }
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

/// The levels from the regions' cells on, in memory where they fit.
std::vector<LevelCounts> levels_of_regions(const BuildCommand& command, const Header& header,
                                           const BlockOptions& block,
                                           const std::vector<std::unique_ptr<Spool>>& regions,
                                           const std::string& text, FileWriter& writer,
                                           StageContext& context) {
  const int threads = context.options.threads;
  const MemoryPlan plan = memory_plan(context);
  std::uint64_t triangles = 0;
  std::optional<int> level;
  for (const auto& region : regions) {
    for (const SpoolCell& cell : region->cells())
      triangles += cell.triangles, level = cell.key.level;
  }
  if (!level ||
      (!command.out_of_core && triangles * kBytesInMemory < context.memory.limit_bytes())) {
    std::vector<BuildCell> cells;
    for (const auto& region : regions) {
      for (const SpoolCell& cell : region->cells()) cells.push_back(region->read(cell));
    }
    return build_levels(
        std::move(cells), header, block, threads,
        [&](const FinishedPart& part) { writer.add(part.node, encode_cell(part.mesh, header)); },
        context.progress);
  }
  MemoryGate gate(plan.work_bytes);
  DiskTask task;
  task.threads = threads;
  task.gate = &gate;
  task.first_level = level;
  const WorkFolder folder(work_folder(command), text);
  std::vector<LevelCounts> counts;
  work_in(folder, context.report, [&] {
    if (!folder.has(folder.level(*level))) {
      SpoolWriter all(folder.level(*level), text);
      for (const auto& region : regions) {
        for (const SpoolCell& cell : region->cells()) all.add(region->read(cell));
      }
      all.commit();
    }
    counts = build_levels_on_disk(
        folder, header, block, task,
        [&](const Node& node, std::span<const std::byte> bytes) { writer.add(node, bytes); },
        context.progress);
  });
  return counts;
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
  }
  const std::string text = build_text(command, header).dump();
  const std::vector<LevelCounts> upper =
      levels_of_regions(command, header, block, regions, text, writer, context);
  for (std::size_t level = 0; level < counts.size(); ++level) {
    if (upper[level].cells > 0) counts[level] = upper[level];
  }
  require_leaves(counts.back().cells > 0);
  writer.finish();
  if (const auto& input = regions.front()->numbers(); input.size() == 3) {
    context.report.count("triangles_in", input[0]);
    context.report.count("degenerate_left_out", input[1]);
    context.report.count("pieces_of_long_triangles", input[2]);
  }
  report_levels(counts, context.report);
}

}  // namespace

void run_build_job(const BuildCommand& command, StageContext& context) {
  if (command.join) return join_regions(command, context);
  const MemoryPlan plan = memory_plan(context);
  std::optional<BuildInput> input;
  context.report.step("read", [&] { input.emplace(command, plan, context); });
  Header header = plan_header(input->summary(), command.options);
  header.provenance = provenance_of(command, header).dump();
  if (!command.region.empty()) return build_region(command, header, plan, *input, context);
  bool in_memory = input->fits();
  if (in_memory) in_memory = build_in_memory(command, header, plan, *input, context);
  context.report.quality("in_memory", in_memory);
  if (in_memory) return;
  input->drop();
  build_on_disk(command, header, plan, *input, context);
}

}  // namespace cornice::hlod
