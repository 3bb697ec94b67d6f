// SPDX-License-Identifier: GPL-3.0-or-later
// LAS 1.0-1.4, LAZ and COPC files: what they say of themselves, and their points.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/vec.h"
#include "core/geo/crs.h"
#include "core/points/point_cloud.h"

namespace cornice {

/// A variable length record, or an extended one (at the end of a 1.4 file).
struct LasVlr {
  std::string user_id;
  std::uint16_t record_id = 0;
  std::string description;
  std::vector<std::uint8_t> data;
  bool extended = false;
};

/// One attribute of the extra bytes (LAS 1.4 R15, table 24).
struct ExtraByte {
  std::string name;  ///< up to 31 characters
  std::string description;
  std::uint8_t data_type = 0;  ///< 0 raw bytes, 1 uint8, 2 int8, 3 uint16 ... 9 float, 10 double
  std::size_t offset = 0;      ///< bytes from the start of the point's extra bytes
  std::size_t size = 0;        ///< bytes
  double scale = 1.0;          ///< value = stored * scale + offset_value
  double offset_value = 0.0;
  std::optional<double> no_data;
};

enum class GpsTimeType { kNone, kWeekSeconds, kAdjustedStandard };
enum class LasContainer { kLas, kLaz, kCopc };

/// What the header and the records of a file say, checked for consistency with the file's size but
/// not yet with its points.
struct LasInfo {
  std::filesystem::path path;
  LasContainer container = LasContainer::kLas;
  bool zipped = false;     ///< read from inside a .zip
  std::string zip_member;  ///< its name there
  std::uint64_t file_bytes = 0;
  int version_minor = 2;  ///< of LAS 1.x
  int point_format = 0;   ///< 0-10
  std::size_t record_bytes = 0;
  std::uint64_t point_count = 0;
  std::array<std::uint64_t, 15> points_by_return{};
  Vec3d scale{0.01, 0.01, 0.01};
  Vec3d offset;
  Box3d bounds;  ///< as the header has it
  std::uint16_t global_encoding = 0;
  GpsTimeType gps_time_type = GpsTimeType::kNone;  ///< as the header says; values may disagree
  std::uint16_t file_source_id = 0;
  std::string system_identifier;
  std::string generating_software;
  int creation_day = 0;
  int creation_year = 0;
  std::uint64_t point_data_offset = 0;
  std::uint64_t point_data_end = 0;  ///< start of the extended records, or the file's end
  std::vector<LasVlr> vlrs;
  std::vector<ExtraByte> extra_bytes;
  std::size_t extra_stride = 0;
  Crs crs;                            ///< may be empty
  std::string crs_source;             ///< "wkt", "geotiff keys", "file name", "option" or empty
  std::vector<std::string> warnings;  ///< defects that do not prevent reading, one line each
  /// Why not all points can be read (cut short, chunk table missing); empty where they can.
  /// read_las throws it as InputError unless asked for the readable part.
  std::string data_problem;
};

struct LasOpenOptions {
  std::string crs_override;  ///< --crs: replaces what the file says; empty: the file's own
  /// False: a coordinate system that is there but cannot be read is a warning instead of an error.
  bool require_readable_crs = true;
};

/// Reads header, VLRs and EVLRs. A `.zip` with one .las or .laz inside is read as it is.
/// Throws InputError for files that are no LAS, are truncated before their points, or whose header
/// contradicts itself; what is wrong with the points themselves is in data_problem.
LasInfo read_las_info(const std::filesystem::path& path, const LasOpenOptions& options = {});

/// What to read. Attributes that the format lacks stay empty, but for GPS time and channel, which
/// are then 0.
struct LasReadOptions {
  Attribute attributes = Attribute::kNone;
  /// Keep only the points inside (closed), in the file's CRS.
  std::optional<Box2d> window = std::nullopt;
  /// Of the cloud. Default: floor of the header's minimum, or of the first point where the header's
  /// minimum is further than 65,536 units from it, so that float positions keep their precision.
  std::optional<Vec3d> origin = std::nullopt;
  int threads = 1;  ///< 0: all cores
  /// Gives the points before the place where a file ends early or is corrupt, instead of throwing.
  bool keep_readable_part = false;
};

/// What became of a read.
struct LasReadResult {
  PointCloud points;  ///< in file order
  std::uint64_t points_decoded = 0;
  std::string problem;   ///< why decoding stopped early; empty where the file was whole
  Box3d decoded_bounds;  ///< of all points decoded, in the file's CRS
  std::vector<std::string> warnings;  ///< the header's bounds disagree with the points
};

/// Reads the points of a file, or of a window of it (COPC octree, .lax index or full scan).
/// Throws InputError where a record cannot be decoded, naming the point's index.
LasReadResult read_las(const LasInfo& info, const LasReadOptions& options = {},
                       Progress& progress = no_progress());

/// Streams the points in file order through `sink` in chunks of about `chunk_points`, decoded on
/// options.threads threads; never holds more than a few chunks. `first` is the index in the file of
/// the chunk's first decoded point. Returns as read_las does, without points.
LasReadResult stream_las(const LasInfo& info, const LasReadOptions& options,
                         std::size_t chunk_points,
                         const std::function<void(PointCloud& chunk, std::uint64_t first)>& sink,
                         Progress& progress = no_progress());

/// How a file is written. Defaults: LAZ 1.4 of point format 6 at 1 cm.
struct LasWriteOptions {
  int version_minor = 4;
  int point_format = 6;
  Vec3d scale{0.01, 0.01, 0.01};
  Vec3d offset;
  bool compress = true;
  std::uint32_t chunk_points = 50000;  ///< LAZ chunk
  bool spatial_index = false;          ///< write FILE.lax beside it
  GpsTimeType gps_time_type = GpsTimeType::kAdjustedStandard;
  std::uint16_t file_source_id = 0;
  std::string system_identifier = "cornice";
  std::string generating_software = "cornice";
  int creation_day = 1;  ///< fixed unless given, so that the same input gives the same bytes
  int creation_year = 2024;
  Crs crs;                             ///< written as WKT for 1.4, GeoTIFF keys below; may be empty
  std::vector<ExtraByte> extra_bytes;  ///< layout of PointCloud::extra_bytes, in order
  /// Further records, written as they are. Those that the writer makes itself (CRS where `crs` is
  /// given, extra bytes, LASzip, COPC) are left out, so that a file's own records can be passed on.
  std::vector<LasVlr> vlrs;
  int threads = 0;  ///< of write_copc; 0: all cores. The bytes do not depend on it
};

/// Writes one LAS or LAZ file point by point. The file appears under its name only when close()
/// returns; destroying an unclosed writer removes what was written. One thread at a time.
/// Fields that the point format does not have are left out: the overlap flag (but class 12) and
/// the channel in formats 0-5, time, colour and wave packets where the format has none.
class LasWriter {
 public:
  /// Throws UsageError for options that no LAS file can have, RunError where the file cannot be
  /// made.
  LasWriter(std::filesystem::path path, const LasWriteOptions& options);
  ~LasWriter();
  LasWriter(const LasWriter&) = delete;
  LasWriter& operator=(const LasWriter&) = delete;
  /// Appends points. Where `exact` is filled it is stored as it is; otherwise positions are rounded
  /// to scale and offset. Attributes without an array are stored as 0 (return 1 of 1).
  /// Throws InputError where a coordinate is not finite or does not fit 32 bits, and where another
  /// value does not fit the point format; RunError where the disk is full. After a throw the
  /// writer can only be destroyed.
  void write(const PointCloud& points);
  void close();
  std::uint64_t points_written() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Writes a COPC 1.0 file (always LAZ 1.4, format 6, 7 or 8): an octree of nodes, each one LAZ
/// chunk; nodes of more than options.chunk_points points are split. Holds all points in memory, and
/// 16 bytes more for each. The order of the points changes: nodes from coarse to fine, within a
/// node as given. Throws as LasWriter does.
/// order: where given, receives the index in `points` of every point of the file, in file order.
void write_copc(const std::filesystem::path& path, const PointCloud& points,
                const LasWriteOptions& options, Progress& progress = no_progress(),
                std::vector<std::uint64_t>* order = nullptr);

}  // namespace cornice
