// SPDX-License-Identifier: GPL-3.0-or-later
#include <cerrno>
#include <cstring>
#include <fstream>
#include <utility>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/io/las.h"
#include "core/io/las_head_writer.h"
#include "core/io/laszip_encoder.h"
#include "core/io/lax_writer.h"

namespace cornice {
namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 20;
constexpr std::uint64_t kMostLegacyPoints = 0xffffffffu;

std::vector<LasVlr> compression_records(const LasWriteOptions& options) {
  if (!options.compress) return {};
  return {laszip_record(options)};
}

}  // namespace

struct LasWriter::Impl {
  Impl(std::filesystem::path path, const LasWriteOptions& write_options)
      : options(write_options),
        file(std::move(path)),
        head(options, {}, compression_records(options)),
        buffer(kBufferBytes) {
    stream.rdbuf()->pubsetbuf(buffer.data(), static_cast<std::streamsize>(buffer.size()));
    errno = 0;
    stream.open(file.path(), std::ios::binary | std::ios::trunc);
    check();
    put(head.bytes({}, 0));
    encoder.emplace(stream, options, file.target().string());
    const bool is_degrees = !options.crs.empty() && options.crs.metres_per_unit == 0.0;
    if (options.spatial_index) lax.emplace(is_degrees);
  }

  void index(const PointCloud& points) {
    const std::string subject = file.target().string();
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vec3<std::int32_t> p = stored_coordinates(points, i, options, subject);
      lax->add(p.x * options.scale.x + options.offset.x, p.y * options.scale.y + options.offset.y);
    }
  }

  void put(const std::vector<std::uint8_t>& bytes) {
    errno = 0;
    stream.write(reinterpret_cast<const char*>(bytes.data()),
                 static_cast<std::streamsize>(bytes.size()));
    check();
  }

  void check() const {
    if (stream.good()) return;
    const std::string reason = errno != 0 ? std::strerror(errno) : "the stream failed";
    throw RunError(file.target().string(), "cannot be written: " + reason +
                                               "; free some space or write elsewhere, then run "
                                               "again");
  }

  LasWriteOptions options;
  AtomicFile file;
  LasHead head;
  std::vector<char> buffer;
  std::ofstream stream;
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
  const std::uint64_t total = impl_->tally.points + points.size();
  if (impl_->options.version_minor < 4 && total > kMostLegacyPoints) {
    throw InputError(impl_->file.target().string(),
                     "more than 4294967295 points need LAS 1.4; write that version");
  }
  if (impl_->lax && total > kMostLegacyPoints) {
    throw InputError(impl_->file.target().string(),
                     "more than 4294967295 points have no spatial index; write without one");
  }
  impl_->encoder->write(points, 0, points.size(), impl_->tally);
  if (impl_->lax) impl_->index(points);
}

void LasWriter::close() {
  Impl& impl = *impl_;
  impl.encoder->finish();
  impl.stream.seekp(0, std::ios::end);
  const auto extended_at = static_cast<std::uint64_t>(impl.stream.tellp());
  impl.put(impl.head.extended_bytes());
  impl.stream.seekp(0);
  impl.put(impl.head.bytes(impl.tally, extended_at));
  errno = 0;
  impl.stream.close();
  impl.check();
  // The index of a file replaced here would lead to wrong points: it goes first.
  const std::filesystem::path lax_path =
      std::filesystem::path(impl.file.target()).replace_extension(".lax");
  std::error_code ignored;
  std::filesystem::remove(lax_path, ignored);
  impl.file.commit();
  if (!impl.lax) return;
  write_file_atomically(lax_path, impl.lax->bytes());
}

std::uint64_t LasWriter::points_written() const { return impl_->tally.points; }

}  // namespace cornice
