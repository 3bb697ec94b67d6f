// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/io/laszip_encoder.h"

// LASzip's header sets namespace std loose upon whoever includes it; it stays in this file.
#include <laszip/laszip_api.h>

#include <cmath>
#include <cstring>
#include <ostream>
#include <utility>

#include "core/base/error.h"
#include "core/io/las_header.h"

namespace cornice {
namespace {

constexpr double kScanAngleStep = 0.006;  // degrees, formats 6 to 10

/// Owner of a LASzip handle.
class Laszip {
 public:
  Laszip() {
    if (laszip_create(&handle_) != 0) throw RunError("LASzip", "cannot be started");
  }
  ~Laszip() { laszip_destroy(handle_); }
  Laszip(const Laszip&) = delete;
  Laszip& operator=(const Laszip&) = delete;
  laszip_POINTER get() const { return handle_; }
  std::string error() const {
    laszip_CHAR* text = nullptr;
    laszip_get_error(handle_, &text);
    return text != nullptr ? text : "no reason given";
  }
  void check(laszip_I32 failure, const std::string& subject) const {
    if (failure != 0) throw RunError(subject, "LASzip: " + error());
  }

 private:
  laszip_POINTER handle_ = nullptr;
};

void configure(const Laszip& laszip, const LasWriteOptions& options, const std::string& subject) {
  const std::size_t record =
      las_base_record_bytes(options.point_format) + extra_stride_of(options.extra_bytes);
  laszip.check(laszip_request_native_extension(laszip.get(), 1), subject);
  laszip.check(laszip_set_chunk_size(laszip.get(), options.chunk_points), subject);
  laszip.check(
      laszip_set_point_type_and_size(laszip.get(), static_cast<laszip_U8>(options.point_format),
                                     static_cast<laszip_U16>(record)),
      subject);
}

[[noreturn]] void refuse(const std::string& subject, std::size_t i, const std::string& problem) {
  throw InputError(subject, "point " + std::to_string(i) + ": " + problem);
}

std::int32_t stored(double coordinate, double scale, double offset, std::size_t i,
                    const std::string& subject) {
  const double steps = (coordinate - offset) / scale;
  // Also false for NaN.
  if (!(steps >= -2147483648.5 && steps < 2147483647.5)) {
    refuse(subject, i,
           "coordinate " + std::to_string(coordinate) + " is not within 32 bits of offset " +
               std::to_string(offset) + " at scale " + std::to_string(scale) +
               "; choose a nearer offset or a coarser scale");
  }
  return static_cast<std::int32_t>(std::llround(steps));
}

/// Value i of an attribute, or a default where the attribute has no array.
template <class T>
T value_or(const std::vector<T>& array, std::size_t i, T otherwise) {
  return array.empty() ? otherwise : array[i];
}

}  // namespace

Vec3<std::int32_t> stored_coordinates(const PointCloud& points, std::size_t i,
                                      const LasWriteOptions& options, const std::string& subject) {
  if (!points.exact.empty()) return points.exact[i];
  const Vec3d p = points.position(i);
  return {stored(p.x, options.scale.x, options.offset.x, i, subject),
          stored(p.y, options.scale.y, options.offset.y, i, subject),
          stored(p.z, options.scale.z, options.offset.z, i, subject)};
}

LasVlr laszip_record(const LasWriteOptions& options) {
  const Laszip laszip;
  configure(laszip, options, "LASzip");
  laszip_U8* bytes = nullptr;
  laszip_U32 size = 0;
  laszip.check(laszip_create_laszip_vlr(laszip.get(), &bytes, &size), "LASzip");
  constexpr std::size_t kHeader = 54;  // LASzip gives the whole record
  if (size < kHeader) throw RunError("LASzip", "gave no record for its compression");
  LasVlr record;
  record.user_id = "laszip encoded";
  record.record_id = 22204;
  record.description = "LASzip compression";
  record.data.assign(bytes + kHeader, bytes + size);
  return record;
}

struct LaszipEncoder::Impl {
  Impl(std::ostream& out, const LasWriteOptions& write_options, std::string file)
      : stream(out), options(write_options), subject(std::move(file)) {
    options.vlrs.clear();
    stride = extra_stride_of(options.extra_bytes);
    is_extended = options.point_format >= 6;
    configure(laszip, options, subject);
    check(laszip_open_writer_stream(laszip.get(), stream, options.compress ? 1 : 0, 1));
    check(laszip_get_point_pointer(laszip.get(), &point));
  }

  void check(laszip_I32 failure) const { laszip.check(failure, subject); }

  void fill(const PointCloud& points, std::size_t i);
  void fill_legacy(const PointCloud& points, std::size_t i);
  void fill_extended(const PointCloud& points, std::size_t i);
  void check_arrays(const PointCloud& points) const;

  std::ostream& stream;
  LasWriteOptions options;
  std::string subject;
  std::size_t stride = 0;
  bool is_extended = false;
  bool finished = false;
  Laszip laszip;
  laszip_point_struct* point = nullptr;
};

void LaszipEncoder::Impl::fill_legacy(const PointCloud& points, std::size_t i) {
  const unsigned number = value_or<std::uint8_t>(points.return_number, i, 1);
  const unsigned count = value_or<std::uint8_t>(points.return_count, i, 1);
  const unsigned code = value_or<std::uint8_t>(points.classification, i, 0);
  const float angle = value_or(points.scan_angle_deg, i, 0.0f);
  if (number > 7 || count > 7) {
    refuse(subject, i,
           "return " + std::to_string(number) + " of " + std::to_string(count) +
               " does not fit point formats 0-5 (7 at most); write format 6");
  }
  if (code > 31) {
    refuse(subject, i,
           "class " + std::to_string(code) +
               " does not fit point formats 0-5 (31 at most); write format 6");
  }
  if (!(angle > -128.5f && angle < 127.5f)) {
    refuse(subject, i, "scan angle " + std::to_string(angle) + " does not fit point formats 0-5");
  }
  point->return_number = number & 7u;
  point->number_of_returns = count & 7u;
  point->classification = code & 31u;
  point->scan_angle_rank = static_cast<laszip_I8>(std::lround(angle));
}

void LaszipEncoder::Impl::fill_extended(const PointCloud& points, std::size_t i) {
  const unsigned number = value_or<std::uint8_t>(points.return_number, i, 1);
  const unsigned count = value_or<std::uint8_t>(points.return_count, i, 1);
  const unsigned channel = value_or<std::uint8_t>(points.scanner_channel, i, 0);
  const unsigned flags = value_or<std::uint8_t>(points.flags, i, 0);
  const double steps = value_or(points.scan_angle_deg, i, 0.0f) / kScanAngleStep;
  if (number > 15 || count > 15) {
    refuse(subject, i,
           "return " + std::to_string(number) + " of " + std::to_string(count) +
               " does not fit any point format (15 at most)");
  }
  if (channel > 3) {
    refuse(subject, i, "scanner channel " + std::to_string(channel) + " does not fit (3 at most)");
  }
  if (!(steps > -32768.5 && steps < 32767.5)) {
    refuse(subject, i,
           "scan angle " + std::to_string(points.scan_angle_deg[i]) +
               " does not fit 16 bits of 0.006 degrees");
  }
  point->extended_point_type = 1;
  point->extended_return_number = number & 15u;
  point->extended_number_of_returns = count & 15u;
  point->extended_scanner_channel = channel & 3u;
  point->extended_classification = value_or<std::uint8_t>(points.classification, i, 0);
  point->extended_classification_flags = flags & 15u;
  point->extended_scan_angle = static_cast<laszip_I16>(std::lround(steps));
}

void LaszipEncoder::Impl::fill(const PointCloud& points, std::size_t i) {
  const Vec3<std::int32_t> p = stored_coordinates(points, i, options, subject);
  const unsigned flags = value_or<std::uint8_t>(points.flags, i, 0);
  point->X = p.x;
  point->Y = p.y;
  point->Z = p.z;
  point->intensity = value_or<std::uint16_t>(points.intensity, i, 0);
  point->user_data = value_or<std::uint8_t>(points.user_data, i, 0);
  point->point_source_ID = value_or<std::uint16_t>(points.point_source_id, i, 0);
  point->gps_time = value_or(points.gps_time_s, i, 0.0);
  point->scan_direction_flag = (flags & kScanDirection) != 0;
  point->edge_of_flight_line = (flags & kEdgeOfFlightLine) != 0;
  // LASzip takes these three from here for every format, the overlap from the extended flags.
  point->synthetic_flag = (flags & kSynthetic) != 0;
  point->keypoint_flag = (flags & kKeyPoint) != 0;
  point->withheld_flag = (flags & kWithheld) != 0;
  if (is_extended) {
    fill_extended(points, i);
  } else {
    fill_legacy(points, i);
  }
  if (!points.rgb.empty()) {
    for (std::size_t c = 0; c < 3; ++c) point->rgb[c] = points.rgb[i][c];
  }
  point->rgb[3] = value_or<std::uint16_t>(points.nir, i, 0);
  if (!points.wave_packet.empty()) {
    std::memcpy(point->wave_packet, points.wave_packet[i].data(), sizeof point->wave_packet);
  }
  if (stride != 0 && !points.extra_bytes.empty()) {
    std::memcpy(point->extra_bytes, &points.extra_bytes[i * stride], stride);
  }
}

void LaszipEncoder::Impl::check_arrays(const PointCloud& points) const {
  if (stride != 0 && !points.extra_bytes.empty() && points.extra_stride != stride) {
    throw UsageError("extra bytes", "are " + std::to_string(points.extra_stride) +
                                        " a point, but the options describe " +
                                        std::to_string(stride));
  }
}

LaszipEncoder::LaszipEncoder(std::ostream& stream, const LasWriteOptions& options,
                             std::string subject)
    : impl_(std::make_unique<Impl>(stream, options, std::move(subject))) {}

LaszipEncoder::~LaszipEncoder() {
  // LASzip frees its compressors only on closing; the file is given up by then.
  if (!impl_->finished) laszip_close_writer(impl_->laszip.get());
}

void LaszipEncoder::write(const PointCloud& points, std::size_t begin, std::size_t end,
                          LasTally& tally, const std::uint32_t* order) {
  impl_->check_arrays(points);
  const laszip_POINTER handle = impl_->laszip.get();
  laszip_point_struct& point = *impl_->point;
  for (std::size_t k = begin; k < end; ++k) {
    const std::size_t i = order != nullptr ? order[k] : k;
    impl_->fill(points, i);
    tally.add({point.X, point.Y, point.Z},
              impl_->is_extended ? point.extended_return_number : point.return_number);
    impl_->check(laszip_write_point(handle));
  }
}

void LaszipEncoder::finish() {
  impl_->finished = true;
  impl_->check(laszip_close_writer(impl_->laszip.get()));
}

}  // namespace cornice
