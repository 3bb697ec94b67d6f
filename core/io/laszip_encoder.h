// SPDX-License-Identifier: GPL-3.0-or-later
// Point clouds into LASzip's writer: the one place that fills LASzip's point structure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <memory>
#include <string>

#include "core/io/las_head_writer.h"
#include "core/points/point_cloud.h"

namespace cornice {

/// Encodes points onto a stream: no header, only the point records (and, compressed, the offset of
/// the chunk table before them and the table behind).
/// Thread contract: separate objects are independent.
class LaszipEncoder {
 public:
  /// `subject` names the file in errors. The stream must outlive the encoder, be
  /// seekable, and not fail: LASzip crashes on one that does (see PatientFileBuffer).
  LaszipEncoder(std::ostream& stream, const LasWriteOptions& options, std::string subject);
  ~LaszipEncoder();
  LaszipEncoder(const LaszipEncoder&) = delete;
  LaszipEncoder& operator=(const LaszipEncoder&) = delete;

  /// Appends points [begin, end) of `points`, or points order[begin..end) where order is given,
  /// and adds them to the tally. Throws as LasWriter::write; `first` is the index in the file of
  /// the first of them, for messages.
  void write(const PointCloud& points, std::size_t begin, std::size_t end, LasTally& tally,
             const std::uint32_t* order = nullptr);
  /// Ends the last chunk and writes the chunk table.
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The record that says how points are compressed (user id "laszip encoded", id 22204).
LasVlr laszip_record(const LasWriteOptions& options);

/// Stored integer coordinates of point i. Throws InputError naming `subject` and the point where
/// they are not finite or do not fit 32 bits.
Vec3<std::int32_t> stored_coordinates(const PointCloud& points, std::size_t i,
                                      const LasWriteOptions& options, const std::string& subject);

}  // namespace cornice
