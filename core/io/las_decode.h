// SPDX-License-Identifier: GPL-3.0-or-later
// One pass over the chunks of a file: on several threads, results in file order.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/io/byte_source.h"
#include "core/io/las.h"
#include "core/io/las_chunks.h"
#include "core/io/laszip_decoder.h"

namespace cornice {

/// What a pass decoded.
struct DecodeSummary {
  std::uint64_t decoded = 0;
  StoredBounds bounds;  ///< of all decoded points, in the window or not
  std::string problem;  ///< why it ended early
};

/// A file opened for one pass. Not for use from several threads.
class LasPass {
 public:
  /// Opens the file, plans its chunks and, where a window allows it, drops those that cannot have
  /// points in it. Throws InputError as read_las does.
  LasPass(const LasInfo& info, const LasReadOptions& options);

  const LasInfo& info() const { return info_; }
  Vec3d origin() const { return origin_; }
  /// Attributes that are asked for and that the format has.
  Attribute attributes() const { return attributes_; }
  std::uint64_t points() const;  ///< in the chosen chunks
  bool is_whole_file() const { return whole_file_; }
  /// True where an array of points() entries can be allocated without trusting a wild header, and
  /// the chunks can be decoded in any order.
  bool has_known_places() const;

  /// Decodes all points to their places in `to`, which has points() entries.
  DecodeSummary decode_to(PointCloud& to, Progress& progress);
  /// Hands the points inside the window to `sink` in file order, a chunk or a part of it at a
  /// time; `first` is the index in the file of the first point decoded for it.
  DecodeSummary decode_blocks(
      const std::function<void(PointCloud& block, std::uint64_t first)>& sink, Progress& progress);

 private:
  class ChunkReader;
  struct Slot;
  void choose_origin();
  bool has_giant() const;
  DecodeSummary run_chunks(const std::function<void(const PointChunk& chunk, Slot& slot)>& decode,
                           const std::function<void(const PointChunk& chunk, Slot& slot)>& deliver,
                           Progress& progress);
  void decode_to_slot(const PointChunk& chunk, Slot& slot) const;
  DecodeSummary decode_in_line(
      const std::function<void(PointCloud& block, std::uint64_t first)>& sink, Progress& progress);
  void keep_inside(PointCloud& block, const StoredBounds& bounds) const;
  void finish(DecodeSummary& summary) const;

  const LasInfo& info_;
  const LasReadOptions& options_;
  std::unique_ptr<ByteSource> source_;
  ChunkPlan plan_;
  Attribute attributes_ = Attribute::kNone;
  Attribute decoded_attributes_ = Attribute::kNone;  ///< with what the window test needs
  Vec3d origin_;
  bool whole_file_ = true;
};

}  // namespace cornice
