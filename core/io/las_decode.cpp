// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/io/las_decode.h"

#include <algorithm>
#include <cmath>
#include <deque>

#include "core/base/error.h"
#include "core/io/copc_hierarchy.h"
#include "core/io/lax_reader.h"
#include "core/io/ordered_work.h"

namespace cornice {
namespace {

/// Points a byte of compressed data can hold before the count looks made up. Real tiles have less
/// than 1; beyond it arrays grow as points are decoded instead of being allocated at once.
constexpr std::uint64_t kPlausiblePointsPerByte = 16;
constexpr std::uint64_t kAlwaysPlausiblePoints = 1'000'000;
/// Chunks beyond these are decoded piece by piece on one thread.
constexpr std::uint64_t kGiantChunkPoints = 1u << 20;
constexpr std::uint64_t kGiantChunkBytes = 64u << 20;
constexpr std::size_t kBlockPoints = 1u << 16;
/// Distance in the file's units up to which a float holds millimetres.
constexpr double kOriginReach = 65536.0;

std::string chunk_text(const PointChunk& chunk) {
  return "chunk at byte " + std::to_string(chunk.offset) + " (points " +
         std::to_string(chunk.first) + " to " + std::to_string(chunk.first + chunk.points - 1) +
         ") ";
}

constexpr const char* kRemedy = "; download or copy the file again";

}  // namespace

/// Fetches and decodes one chunk after another, each with its own LASzip.
class LasPass::ChunkReader {
 public:
  explicit ChunkReader(const LasPass& pass)
      : pass_(pass), decoder_(pass.info_, pass.plan_.laz, pass.decoded_attributes_, pass.origin_) {}

  void fetch(const PointChunk& chunk) {
    bytes_ = read_bytes(*pass_.source_, chunk.offset, static_cast<std::size_t>(chunk.bytes));
  }
  /// Opens what fetch has read. A problem goes to `summary`.
  bool open(const PointChunk& chunk, DecodeSummary& summary) {
    std::string problem = bytes_.size() < chunk.bytes ? "is cut short by the end of the file"
                                                      : decoder_.open(chunk, bytes_);
    return check(chunk, problem, summary);
  }
  bool open_stream(const PointChunk& chunk, DecodeSummary& summary) {
    return check(chunk, decoder_.open_stream(chunk, *pass_.source_), summary);
  }
  /// Decodes up to `count` points to `to[at...]`; false where that failed.
  bool decode(PointCloud& to, std::size_t at, std::size_t count, DecodeSummary& summary) {
    const std::size_t got = decoder_.decode(to, at, count, summary.bounds);
    summary.decoded += got;
    if (got == count) return true;
    summary.problem = decoder_.problem() + kRemedy;
    return false;
  }

 private:
  static bool check(const PointChunk& chunk, const std::string& problem, DecodeSummary& summary) {
    if (!problem.empty()) summary.problem = chunk_text(chunk) + problem + kRemedy;
    return problem.empty();
  }

  const LasPass& pass_;
  LaszipDecoder decoder_;
  std::vector<std::uint8_t> bytes_;
};

/// State of a chunk between fetch and deliver.
struct LasPass::Slot {
  explicit Slot(const LasPass& pass) : reader(pass) {}
  ChunkReader reader;
  DecodeSummary summary;
  PointCloud points;
};

LasPass::LasPass(const LasInfo& info, const LasReadOptions& options)
    : info_(info), options_(options), source_(open_point_file(info.path).bytes) {
  plan_ = plan_chunks(*source_, info);
  if (!plan_.problem.empty() && !options.keep_readable_part) {
    throw InputError(info.path.string(), plan_.problem);
  }
  attributes_ = attributes_in(info, options.attributes);
  decoded_attributes_ = options.window ? attributes_ | Attribute::kExact : attributes_;
  choose_origin();
  if (options.window) {
    whole_file_ = info.container == LasContainer::kCopc
                      ? !keep_copc_chunks_in(*source_, info, *options.window, plan_)
                      : !keep_lax_chunks_in(info, *options.window, plan_);
  }
}

void LasPass::choose_origin() {
  if (options_.origin) {
    origin_ = *options_.origin;
    return;
  }
  const auto floor_of = [](Vec3d p) {
    return Vec3d{std::floor(p.x), std::floor(p.y), std::floor(p.z)};
  };
  const Vec3d low = info_.bounds.min;
  origin_ = std::isfinite(low.x + low.y + low.z) ? floor_of(low) : floor_of(info_.offset);
  if (plan_.chunks.empty()) return;
  // A header whose minimum is wrong would cost the positions their precision.
  ChunkReader reader(*this);
  DecodeSummary summary;
  PointCloud first;
  resize_points(first, 1, info_, decoded_attributes_);
  if (!reader.open_stream(plan_.chunks.front(), summary) || !reader.decode(first, 0, 1, summary)) {
    return;
  }
  const Vec3<std::int32_t> stored = summary.bounds.min;
  const Vec3d p{stored.x * info_.scale.x + info_.offset.x,
                stored.y * info_.scale.y + info_.offset.y,
                stored.z * info_.scale.z + info_.offset.z};
  const bool near = std::abs(p.x - origin_.x) < kOriginReach &&
                    std::abs(p.y - origin_.y) < kOriginReach &&
                    std::abs(p.z - origin_.z) < kOriginReach;
  if (!near) origin_ = floor_of(p);
}

std::uint64_t LasPass::points() const {
  std::uint64_t total = 0;
  for (const PointChunk& chunk : plan_.chunks) total += chunk.points;
  return total;
}

bool LasPass::has_giant() const {
  return plan_.one_stream ||
         std::any_of(plan_.chunks.begin(), plan_.chunks.end(), [](const PointChunk& chunk) {
           return chunk.points > kGiantChunkPoints || chunk.bytes > kGiantChunkBytes;
         });
}

bool LasPass::has_known_places() const {
  std::uint64_t bytes = 0;
  for (const PointChunk& chunk : plan_.chunks) bytes += chunk.bytes;
  const bool plausible =
      points() <= kAlwaysPlausiblePoints || points() / kPlausiblePointsPerByte <= bytes;
  return plausible && !has_giant() && !options_.window;
}

DecodeSummary LasPass::run_chunks(
    const std::function<void(const PointChunk& chunk, Slot& slot)>& decode,
    const std::function<void(const PointChunk& chunk, Slot& slot)>& deliver, Progress& progress) {
  progress.begin("reading points", points());
  std::deque<Slot> slots;
  while (slots.size() < ordered_slots(options_.threads)) slots.emplace_back(*this);
  DecodeSummary all;
  OrderedWork work;
  work.count = plan_.chunks.size();
  work.threads = options_.threads;
  work.fetch = [&](std::size_t i, std::size_t s) { slots[s].reader.fetch(plan_.chunks[i]); };
  work.work = [&](std::size_t i, std::size_t s) {
    slots[s].summary = {};
    slots[s].points = PointCloud{};
    if (slots[s].reader.open(plan_.chunks[i], slots[s].summary)) decode(plan_.chunks[i], slots[s]);
  };
  work.deliver = [&](std::size_t i, std::size_t s) {
    const DecodeSummary& part = slots[s].summary;
    all.decoded += part.decoded;
    all.bounds.add(part.bounds);
    all.problem = part.problem;
    deliver(plan_.chunks[i], slots[s]);
    progress.advance(part.decoded);
    check_cancelled(progress);
    return all.problem.empty();
  };
  run_ordered(work);
  finish(all);
  progress.end();
  return all;
}

DecodeSummary LasPass::decode_to(PointCloud& to, Progress& progress) {
  return run_chunks(
      [&](const PointChunk& chunk, Slot& slot) {
        slot.reader.decode(to, static_cast<std::size_t>(chunk.first),
                           static_cast<std::size_t>(chunk.points), slot.summary);
      },
      [](const PointChunk&, Slot&) {}, progress);
}

void LasPass::decode_to_slot(const PointChunk& chunk, Slot& slot) const {
  slot.points.origin = origin_;
  // The count is the file's claim: arrays grow with what is really there.
  while (slot.summary.decoded < chunk.points) {
    const auto at = static_cast<std::size_t>(slot.summary.decoded);
    const std::size_t n =
        std::min<std::size_t>(kBlockPoints, static_cast<std::size_t>(chunk.points) - at);
    resize_points(slot.points, at + n, info_, decoded_attributes_);
    if (!slot.reader.decode(slot.points, at, n, slot.summary)) break;
  }
  resize_points(slot.points, static_cast<std::size_t>(slot.summary.decoded), info_,
                decoded_attributes_);
  keep_inside(slot.points, slot.summary.bounds);
}

DecodeSummary LasPass::decode_blocks(
    const std::function<void(PointCloud& block, std::uint64_t first)>& sink, Progress& progress) {
  if (has_giant()) return decode_in_line(sink, progress);
  return run_chunks([&](const PointChunk& chunk, Slot& slot) { decode_to_slot(chunk, slot); },
                    [&](const PointChunk& chunk, Slot& slot) {
                      if (!slot.points.empty()) sink(slot.points, chunk.first);
                    },
                    progress);
}

DecodeSummary LasPass::decode_in_line(
    const std::function<void(PointCloud& block, std::uint64_t first)>& sink, Progress& progress) {
  progress.begin("reading points", points());
  ChunkReader reader(*this);
  DecodeSummary all;
  for (const PointChunk& chunk : plan_.chunks) {
    if (!reader.open_stream(chunk, all)) break;
    for (std::uint64_t done = 0; done < chunk.points && all.problem.empty();) {
      const auto n =
          static_cast<std::size_t>(std::min<std::uint64_t>(kBlockPoints, chunk.points - done));
      DecodeSummary part;
      PointCloud block;
      block.origin = origin_;
      resize_points(block, n, info_, decoded_attributes_);
      reader.decode(block, 0, n, part);
      resize_points(block, static_cast<std::size_t>(part.decoded), info_, decoded_attributes_);
      keep_inside(block, part.bounds);
      if (!block.empty()) sink(block, chunk.first + done);
      done += part.decoded;
      all.decoded += part.decoded;
      all.bounds.add(part.bounds);
      all.problem = part.problem;
      progress.advance(part.decoded);
      check_cancelled(progress);
    }
    if (!all.problem.empty()) break;
  }
  finish(all);
  progress.end();
  return all;
}

void LasPass::keep_inside(PointCloud& block, const StoredBounds& bounds) const {
  if (!options_.window || block.empty()) return;
  const Box2d& window = *options_.window;
  const auto inside = [&](Vec3<std::int32_t> p) {
    return window.contains(p.x * info_.scale.x + info_.offset.x,
                           p.y * info_.scale.y + info_.offset.y);
  };
  if (!inside(bounds.min) || !inside(bounds.max)) {
    std::vector<std::uint8_t> keep(block.size());
    for (std::size_t i = 0; i < block.size(); ++i) keep[i] = inside(block.exact[i]) ? 1 : 0;
    block.filter(keep);
  }
  if (!has(attributes_, Attribute::kExact)) block.exact = {};
}

void LasPass::finish(DecodeSummary& summary) const {
  // What is wrong with the file as a whole says more than where decoding then stopped.
  if (!plan_.problem.empty()) summary.problem = plan_.problem;
  if (!summary.problem.empty() && !options_.keep_readable_part) {
    throw InputError(info_.path.string(), summary.problem);
  }
}

}  // namespace cornice
