// SPDX-License-Identifier: GPL-3.0-or-later
// LASzip behind a wall: it sees one chunk at a time, under a header written here, never a file's
// own header or chunk table.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/io/las.h"
#include "core/io/las_chunks.h"

namespace cornice {

/// Extremes of the stored integer coordinates. Empty until something is added.
struct StoredBounds {
  Vec3<std::int32_t> min{INT32_MAX, INT32_MAX, INT32_MAX};
  Vec3<std::int32_t> max{INT32_MIN, INT32_MIN, INT32_MIN};

  bool empty() const { return min.x > max.x; }
  void add(Vec3<std::int32_t> p) {
    min = {p.x < min.x ? p.x : min.x, p.y < min.y ? p.y : min.y, p.z < min.z ? p.z : min.z};
    max = {p.x > max.x ? p.x : max.x, p.y > max.y ? p.y : max.y, p.z > max.z ? p.z : max.z};
  }
  void add(const StoredBounds& o) {
    if (!o.empty()) add(o.min), add(o.max);
  }
};

/// Of `attributes`, those that the point format has. GPS time and channel are kept for every
/// format (0 where it has none), because most consumers want them whatever the file.
Attribute attributes_in(const LasInfo& info, Attribute attributes);

/// Resizes the arrays of `attributes` to `count` points as the reader fills them, several arrays at
/// once on `threads` threads.
void resize_points(PointCloud& points, std::size_t count, const LasInfo& info, Attribute attributes,
                   int threads = 1);

/// Decodes chunks of one file. Separate objects are independent of each other.
class LaszipDecoder {
 public:
  /// `info` must outlive the decoder. Attributes not in `attributes` are not decompressed where
  /// the compressor allows that.
  LaszipDecoder(const LasInfo& info, const LazVlr& laz, Attribute attributes, Vec3d origin);
  ~LaszipDecoder();
  LaszipDecoder(const LaszipDecoder&) = delete;
  LaszipDecoder& operator=(const LaszipDecoder&) = delete;

  /// Starts a chunk whose bytes are in memory and must stay there while it is decoded. Returns the
  /// problem where the chunk cannot be decoded, else an empty text.
  std::string open(const PointChunk& chunk, std::span<const std::uint8_t> bytes);
  /// Starts a plan that is one stream, read piece by piece from `source`.
  std::string open_stream(const PointChunk& chunk, ByteSource& source);
  /// Decodes the next `count` points to the indices from `at` on of arrays that resize_points has
  /// made large enough. Returns how many there were; problem() says why fewer.
  std::size_t decode(PointCloud& to, std::size_t at, std::size_t count, StoredBounds& bounds);
  const std::string& problem() const { return problem_; }

 private:
  struct Session;
  std::string check(const PointChunk& chunk, ByteSource& source, std::uint64_t start) const;
  LazVlr record_for(const PointChunk& chunk) const;
  std::string start(std::unique_ptr<Session> session);

  const LasInfo& info_;
  const LazVlr& laz_;
  Attribute attributes_;
  Vec3d origin_;
  std::unique_ptr<Session> session_;
  std::string problem_;
};

}  // namespace cornice
