// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/simulate/survey_tiles.h"

#include <cpl_vsi.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <numeric>
#include <span>
#include <type_traits>
#include <utility>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/base/write_problem.h"

namespace cornice::simulate {
namespace {

/// Points handed on at a time where a tile is written from its temporary file.
constexpr std::size_t kBatchPoints = 1u << 18;
/// Side of the squares that unordered tiles are written by, as the nodes of a COPC file are.
constexpr double kSquareM = 62.5;

static_assert(std::is_trivially_copyable_v<SurveyPoint>);

[[noreturn]] void cannot_write(const std::filesystem::path& path) {
  throw RunError(path.string(), "cannot be written: " + write_problem(errno));
}

void append(PointCloud& cloud, const TileTarget& target, const SurveyPoint& point) {
  const std::int32_t dx = point.at.x - to_steps(target.box.min_x);
  const std::int32_t dy = point.at.y - to_steps(target.box.min_y);
  const bool is_local = target.las.offset.x != 0.0;
  cloud.positions.push_back({static_cast<float>(dx * kScaleM), static_cast<float>(dy * kScaleM),
                             static_cast<float>(point.at.z * kScaleM)});
  cloud.exact.push_back({is_local ? dx : point.at.x, is_local ? dy : point.at.y, point.at.z});
  append_attributes(point, cloud);
  cloud.intensity.push_back(point.intensity);
  if (target.truth == PointTruth::kExtraBytes) append_truth_extra_bytes(point, cloud.extra_bytes);
}

PointCloud cloud_for(const TileTarget& target, std::size_t count) {
  PointCloud cloud;
  cloud.origin = {target.box.min_x, target.box.min_y, 0.0};
  if (target.truth == PointTruth::kExtraBytes) cloud.extra_stride = truth_extra_size();
  cloud.reserve(count, Attribute::kExact | Attribute::kGpsTime | Attribute::kScanAngle |
                           Attribute::kReturns | Attribute::kClassification | Attribute::kFlags |
                           Attribute::kPointSource | Attribute::kChannel | Attribute::kUserData |
                           Attribute::kIntensity);
  return cloud;
}

/// A file's bytes as points, read where they are looked at.
class MappedPoints {
 public:
  MappedPoints(const std::filesystem::path& path, std::uint64_t count)
      : bytes_(count * sizeof(SurveyPoint)) {
    if (bytes_ == 0) return;
    const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (file < 0) cannot_write(path);
    data_ = mmap(nullptr, bytes_, PROT_READ, MAP_PRIVATE, file, 0);
    ::close(file);
    if (data_ == MAP_FAILED) cannot_write(path);
  }
  ~MappedPoints() {
    if (bytes_ > 0) munmap(data_, bytes_);
  }
  MappedPoints(const MappedPoints&) = delete;
  MappedPoints& operator=(const MappedPoints&) = delete;
  std::span<const SurveyPoint> points() const {
    return {static_cast<const SurveyPoint*>(data_), bytes_ / sizeof(SurveyPoint)};
  }

 private:
  std::size_t bytes_;
  void* data_ = nullptr;
};

/// Square by square, at random within one: no time order is left.
std::vector<std::uint64_t> spatial_order(const TileTarget& target,
                                         std::span<const SurveyPoint> points) {
  std::vector<std::pair<std::uint64_t, std::uint64_t>> keys(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto square = [](std::int32_t at, double from) {
      return static_cast<std::uint64_t>(
          std::max(0.0, (at - to_steps(from)) * (kScaleM / kSquareM)));
    };
    const std::uint64_t at =
        (square(points[i].at.y, target.box.min_y) << 16) | square(points[i].at.x, target.box.min_x);
    const std::uint64_t shuffled = random_of(target.seed, Stream::kOrder, i).bits() >> 32;
    keys[i] = {(at << 32) | shuffled, i};
  }
  std::sort(keys.begin(), keys.end());
  std::vector<std::uint64_t> order(points.size());
  std::transform(keys.begin(), keys.end(), order.begin(),
                 [](const auto& key) { return key.second; });
  return order;
}

}  // namespace

void append_attributes(const SurveyPoint& point, PointCloud& cloud) {
  cloud.gps_time_s.push_back(point.gps_time_s);
  cloud.scan_angle_deg.push_back(point.scan_angle_deg);
  cloud.return_number.push_back(point.return_number);
  cloud.return_count.push_back(point.return_count);
  cloud.classification.push_back(point.classification);
  cloud.flags.push_back(point.flags);
  cloud.point_source_id.push_back(point.point_source_id);
  cloud.scanner_channel.push_back(point.channel);
  cloud.user_data.push_back(point.user_data);
}

TilePart make_part(const TileTarget& target, std::size_t tile, std::vector<SurveyPoint> points) {
  TilePart part;
  part.tile = tile;
  if (target.waits_for_all()) {
    part.points = std::move(points);
    return part;
  }
  part.cloud = cloud_for(target, points.size());
  for (const SurveyPoint& point : points) append(part.cloud, target, point);
  if (target.truth == PointTruth::kPly)
    for (const SurveyPoint& point : points)
      TruthPly::append_row(point, target.origin, part.truth_rows);
  return part;
}

/// Points of a tile on disk until all are there.
struct TileWriter::Waiting {
  explicit Waiting(const std::filesystem::path& tile)
      : file(tile.string() + ".points"), stream(file.path(), std::ios::binary | std::ios::trunc) {}
  AtomicFile file;  ///< never committed: its end removes it
  std::ofstream stream;
  std::uint64_t count = 0;
};

TileWriter::TileWriter(const TileTarget& target) : target_(target) {
  if (target_.truth == PointTruth::kExtraBytes) target_.las.extra_bytes = truth_extra_bytes();
  if (target_.is_zipped) {
    std::filesystem::path inner = target_.path;
    unzipped_.emplace(inner.replace_extension());
  }
  if (target_.waits_for_all()) {
    waiting_ = std::make_unique<Waiting>(target_.path);
  } else {
    las_ = std::make_unique<LasWriter>(unzipped_ ? unzipped_->path() : target_.path, target_.las);
  }
  if (target_.truth == PointTruth::kPly)
    ply_ = std::make_unique<TruthPly>(target_.truth_path, target_.origin, target_.crs_text);
}

TileWriter::~TileWriter() = default;

void TileWriter::write_points(const TilePart& part) {
  if (!waiting_) {
    las_->write(part.cloud);
    return;
  }
  errno = 0;
  waiting_->stream.write(reinterpret_cast<const char*>(part.points.data()),
                         static_cast<std::streamsize>(part.points.size() * sizeof(SurveyPoint)));
  if (!waiting_->stream) cannot_write(target_.path);
  waiting_->count += part.points.size();
}

void TileWriter::write_truth(const TilePart& part) {
  if (ply_ && !waiting_) ply_->write(part.truth_rows);
}

void TileWriter::close(MemoryBudget& memory, Progress& progress) {
  if (waiting_) finish_waiting(memory, progress);
  if (las_) las_->close();
  if (unzipped_) zip();
  if (ply_) ply_->close();
}

void TileWriter::finish_waiting(MemoryBudget& memory, Progress& progress) {
  errno = 0;
  waiting_->stream.close();
  if (!waiting_->stream) cannot_write(target_.path);
  const MappedPoints mapped(waiting_->file.path(), waiting_->count);
  const std::span<const SurveyPoint> points = mapped.points();
  std::vector<std::uint64_t> order;
  if (target_.is_copc) {
    constexpr std::size_t kCloudBytes = 46;
    const std::uint64_t bytes = points.size() * (kCloudBytes + target_.las.extra_bytes.size() * 4);
    memory.charge("the points of " + target_.path.filename().string(), bytes);
    PointCloud cloud = cloud_for(target_, points.size());
    for (const SurveyPoint& point : points) append(cloud, target_, point);
    write_copc(target_.path, cloud, target_.las, progress, &order);
    memory.release(bytes);
  } else {
    order = spatial_order(target_, points);
    LasWriter las(unzipped_ ? unzipped_->path() : target_.path, target_.las);
    for (std::size_t first = 0; first < order.size(); first += kBatchPoints) {
      PointCloud cloud = cloud_for(target_, kBatchPoints);
      for (std::size_t i = first; i < std::min(first + kBatchPoints, order.size()); ++i)
        append(cloud, target_, points[order[i]]);
      las.write(cloud);
    }
    las.close();
  }
  if (!ply_) return;
  for (std::size_t first = 0; first < order.size(); first += kBatchPoints) {
    std::vector<char> rows;
    for (std::size_t i = first; i < std::min(first + kBatchPoints, order.size()); ++i)
      TruthPly::append_row(points[order[i]], target_.origin, rows);
    ply_->write(rows);
  }
}

/// Packs the finished .las into the .zip that swisstopo delivers.
void TileWriter::zip() {
  AtomicFile archive(target_.path);
  const std::string inside =
      "/vsizip/{" + archive.path().string() + "}/" + target_.path.stem().string();
  const auto fail = [&] { cannot_write(target_.path); };
  errno = 0;
  std::ifstream las(unzipped_->path(), std::ios::binary);
  VSILFILE* out = VSIFOpenL(inside.c_str(), "wb");
  if (!las || out == nullptr) fail();
  std::vector<char> buffer(std::size_t{1} << 20);
  bool is_whole = true;
  while (las && is_whole) {
    las.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
    const auto size = static_cast<std::size_t>(las.gcount());
    is_whole = VSIFWriteL(buffer.data(), 1, size, out) == size;
  }
  if (VSIFCloseL(out) != 0 || !is_whole) fail();
  archive.commit();
}

}  // namespace cornice::simulate
