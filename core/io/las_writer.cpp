// SPDX-License-Identifier: GPL-3.0-or-later
#include <optional>
#include <utility>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/io/las.h"
#include "core/io/las_head_writer.h"
#include "core/io/laszip_encoder.h"
#include "core/io/lax_writer.h"
#include "core/io/output_stream.h"

namespace cornice {
namespace {

/// What 32-bit counts hold: files before 1.4, and spatial indices.
constexpr std::uint64_t kMost32Bit = 0xffffffffu;

std::vector<LasVlr> compression_records(const LasWriteOptions& options) {
  if (!options.compress) return {};
  return {laszip_record(options)};
}

bool is_in_degrees(const Crs& crs) { return !crs.empty() && crs.metres_per_unit == 0.0; }

}  // namespace

struct LasWriter::Impl {
  Impl(std::filesystem::path path, const LasWriteOptions& write_options)
      : options(write_options),
        head(options, {}, compression_records(options)),
        file(std::move(path)) {
    file.put(head.bytes({}, 0));
    encoder.emplace(file.stream(), options, file.name());
    if (options.spatial_index) lax.emplace(is_in_degrees(options.crs));
  }

  void check_count(std::uint64_t total) const {
    if (total <= kMost32Bit) return;
    if (options.version_minor < 4) {
      throw InputError(file.name(), "more than 4294967295 points need LAS 1.4; write that version");
    }
    if (lax) {
      throw InputError(file.name(),
                       "more than 4294967295 points have no spatial index; write without one");
    }
  }

  void index(const PointCloud& points) {
    const std::string subject = file.name();
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vec3<std::int32_t> p = stored_coordinates(points, i, options, subject);
      lax->add(p.x * options.scale.x + options.offset.x, p.y * options.scale.y + options.offset.y);
    }
  }

  LasWriteOptions options;
  LasHead head;
  OutputStream file;
  LasTally tally;
  std::optional<LaszipEncoder> encoder;
  std::optional<LaxIndex> lax;
};

LasWriter::LasWriter(std::filesystem::path path, const LasWriteOptions& options) {
  check_las_write_options(options);
  impl_ = std::make_unique<Impl>(std::move(path), options);
}

LasWriter::~LasWriter() = default;

void LasWriter::write(const PointCloud& points) {
  impl_->check_count(impl_->tally.points + points.size());
  impl_->encoder->write(points, 0, points.size(), impl_->tally);
  impl_->file.check();
  if (impl_->lax) impl_->index(points);
}

void LasWriter::close() {
  Impl& impl = *impl_;
  impl.encoder->finish();
  const std::uint64_t extended_at = impl.file.seek_end();
  impl.file.put(impl.head.extended_bytes());
  impl.file.seek(0);
  impl.file.put(impl.head.bytes(impl.tally, extended_at));
  remove_stale_lax(impl.file.target());
  impl.file.commit();
  if (impl.lax) write_file_atomically(lax_path_of(impl.file.target()), impl.lax->bytes());
}

std::uint64_t LasWriter::points_written() const { return impl_->tally.points; }

}  // namespace cornice
