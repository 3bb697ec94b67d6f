// SPDX-License-Identifier: GPL-3.0-or-later
// How fast point files are decoded, next to LASzip's own loop on one thread.
#include <laszip/laszip_api.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <limits>

#include "bench/bench_json.h"
#include "bench/programs.h"
#include "core/base/error.h"
#include "core/base/random.h"
#include "core/io/las.h"

namespace cornice::bench {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kPoints = 6'000'000;
constexpr std::size_t kQuickPoints = 600'000;
constexpr int kRepeats = 7;
constexpr int kQuickRepeats = 3;

/// Scan lines over rolling ground with some vegetation: what survey files compress like.
PointCloud survey_points(std::size_t count, std::uint64_t seed, Vec3d origin) {
  constexpr std::size_t kLinePoints = 600;  // across the swath
  constexpr double kSpacing = 0.25;         // metres
  PointCloud cloud;
  cloud.origin = origin;
  cloud.reserve(count, Attribute::kAll);
  double time = 3.4e8;
  while (cloud.size() < count) {
    const std::size_t i = cloud.size();
    CounterRandom random(seed, 1, i);
    const std::size_t line = i / kLinePoints;
    const std::size_t place = line % 2 == 0 ? i % kLinePoints : kLinePoints - 1 - i % kLinePoints;
    const double x = kSpacing * static_cast<double>(place) + 0.05 * random.normal();
    const double y = kSpacing * static_cast<double>(line % 4000) + 0.05 * random.normal();
    const double ground = 400.0 + 20.0 * std::sin(x / 40.0) * std::cos(y / 55.0) + 0.1 * x;
    const bool tree = std::sin(x / 15.0) * std::sin(y / 13.0) > 0.4;
    const auto returns = static_cast<std::uint8_t>(tree ? 1 + random.bits() % 4 : 1);
    time += 2e-6 + (i % kLinePoints == 0 ? 1e-4 : 0.0);
    for (std::uint8_t r = 1; r <= returns && cloud.size() < count; ++r) {
      const double height = tree && r < returns ? random.uniform(2.0, 18.0) : 0.0;
      cloud.positions.push_back(
          Vec3d{x + 0.02 * height, y, ground + height + 0.03 * random.normal()}.cast<float>());
      cloud.gps_time_s.push_back(time);
      cloud.scan_angle_deg.push_back(
          static_cast<float>(std::round((static_cast<double>(place) / kLinePoints - 0.5) * 40.0)));
      cloud.return_number.push_back(r);
      cloud.return_count.push_back(returns);
      cloud.classification.push_back(height > 0.0 ? 5 : 2);
      cloud.flags.push_back(line % 2 == 0 ? kScanDirection : 0);
      cloud.point_source_id.push_back(static_cast<std::uint16_t>(1 + line / 4000));
      cloud.scanner_channel.push_back(0);
      cloud.user_data.push_back(0);
      cloud.intensity.push_back(
          static_cast<std::uint16_t>(std::clamp(900.0 + 250.0 * random.normal(), 0.0, 65535.0)));
    }
  }
  return cloud;
}

void write_points(const fs::path& path, const PointCloud& points, int format, bool compress) {
  LasWriteOptions options;
  options.point_format = format;
  options.version_minor = format < 6 ? 2 : 4;
  options.compress = compress;
  options.offset = points.origin;
  options.spatial_index = compress;
  LasWriter writer(path, options);
  writer.write(points);
  writer.close();
}

/// LASzip as it comes: one thread, every attribute of every point. Returns the points read.
std::uint64_t read_by_laszip(const fs::path& path) {
  laszip_POINTER reader = nullptr;
  laszip_BOOL compressed = 0;
  laszip_point_struct* point = nullptr;
  laszip_header_struct* header = nullptr;
  if (laszip_create(&reader) != 0 || laszip_open_reader(reader, path.c_str(), &compressed) != 0 ||
      laszip_get_header_pointer(reader, &header) != 0 ||
      laszip_get_point_pointer(reader, &point) != 0) {
    throw InputError(path.string(), "LASzip cannot open it");
  }
  const std::uint64_t count = std::max<std::uint64_t>(header->number_of_point_records,
                                                      header->extended_number_of_point_records);
  // Used below, so that no compiler can leave the loop out.
  std::uint64_t sum = 0;
  for (std::uint64_t i = 0; i < count; ++i) {
    if (laszip_read_point(reader) != 0) throw InputError(path.string(), "LASzip cannot read it");
    sum += static_cast<std::uint64_t>(point->X) ^ point->intensity;
  }
  laszip_close_reader(reader);
  laszip_destroy(reader);
  return sum == std::numeric_limits<std::uint64_t>::max() ? 0 : count;
}

struct Rates {
  double ratio = 0.0;   ///< median over the turns
  double ours = 0.0;    ///< points/s, median
  double laszip = 0.0;  ///< points/s, median
  double bytes_a_point = 0.0;
};

/// Both in turns, so that what else the machine does hits both alike.
Rates compare_with_laszip(const fs::path& path, const Options& options) {
  const LasInfo info = read_las_info(path);
  const LasReadOptions read{.attributes = Attribute::kAll, .threads = options.threads};
  std::vector<double> ratios, ours, laszip;
  Rates rates;
  for (int turn = 0; turn < (options.quick ? kQuickRepeats : kRepeats); ++turn) {
    const double theirs_s = seconds_of([&] { read_by_laszip(path); });
    std::size_t bytes = 0;
    const double ours_s = seconds_of([&] { bytes = read_las(info, read).points.memory_bytes(); });
    const auto count = static_cast<double>(info.point_count);
    ratios.push_back(theirs_s / ours_s);
    ours.push_back(count / ours_s);
    laszip.push_back(count / theirs_s);
    rates.bytes_a_point = static_cast<double>(bytes) / count;
  }
  rates.ratio = median(ratios);
  rates.ours = median(ours);
  rates.laszip = median(laszip);
  return rates;
}

/// Median points/s of `call`, which returns the points it decoded.
template <class Call>
double rate_of(const Options& options, Call call) {
  std::vector<double> rates;
  for (int turn = 0; turn < (options.quick ? kQuickRepeats : kRepeats); ++turn) {
    std::uint64_t points = 0;
    const double seconds = seconds_of([&] { points = call(); });
    rates.push_back(static_cast<double>(points) / seconds);
  }
  return median(rates);
}

void measure_others(const fs::path& laz, const Options& options, Result& result) {
  const LasInfo info = read_las_info(laz);
  constexpr Attribute kForNormals = Attribute::kGpsTime | Attribute::kScanAngle |
                                    Attribute::kReturns | Attribute::kClassification |
                                    Attribute::kFlags | Attribute::kPointSource;
  result.figure("laz_normals_points_per_s", rate_of(options, [&] {
                  return read_las(info, {.attributes = kForNormals, .threads = options.threads})
                      .points_decoded;
                }));
  result.figure(
      "stream_points_per_s", rate_of(options, [&] {
        const LasReadOptions all{.attributes = Attribute::kAll, .threads = options.threads};
        return stream_las(info, all, 500'000, [](PointCloud&, std::uint64_t) {}).points_decoded;
      }));
  Box2d window = info.bounds.plan();
  window.max_x = 0.5 * (window.min_x + window.max_x);
  window.max_y = 0.5 * (window.min_y + window.max_y);
  const LasReadOptions quarter{
      .attributes = Attribute::kAll, .window = window, .threads = options.threads};
  const auto seconds_of_window = [&] {
    return 1.0 / rate_of(options, [&] {
             read_las(info, quarter);
             return 1;
           });
  };
  fs::path index = laz;
  index.replace_extension(".lax");
  if (fs::exists(index)) {
    result.figure("window_indexed_s", seconds_of_window());
    const fs::path aside = index.string() + ".aside";
    fs::rename(index, aside);
    result.figure("window_s", seconds_of_window());
    fs::rename(aside, index);
  } else {
    result.figure("window_s", seconds_of_window());
  }
}

double measure_format(const std::string& format, const fs::path& laz, const Options& options,
                      Result& result) {
  const Rates rates = compare_with_laszip(laz, options);
  result.figure("laz_decode_ratio" + format, rates.ratio);
  result.figure("laz_points_per_s" + format, rates.ours);
  result.figure("laszip_points_per_s" + format, rates.laszip);
  result.figure("memory_bytes_per_point" + format, rates.bytes_a_point);
  return rates.ratio;
}

void measure_made_files(const Options& options, Result& result) {
  const ScratchFolder scratch("io");
  const std::size_t count = options.quick ? kQuickPoints : kPoints;
  result.parameter("points", static_cast<std::int64_t>(count));
  {
    const PointCloud points = survey_points(count, options.seed, {2'746'000.0, 1'234'000.0, 0.0});
    write_points(scratch / "format1.laz", points, 1, true);
    write_points(scratch / "format6.laz", points, 6, true);
    write_points(scratch / "uncompressed.las", points, 6, false);
  }
  const double ratio1 = measure_format("_format1", scratch / "format1.laz", options, result);
  const double ratio6 = measure_format("_format6", scratch / "format6.laz", options, result);
  result.figure("laz_decode_ratio", std::min(ratio1, ratio6));
  const LasInfo las = read_las_info(scratch / "uncompressed.las");
  result.figure("las_points_per_s", rate_of(options, [&] {
                  return read_las(las, {.attributes = Attribute::kAll, .threads = options.threads})
                      .points_decoded;
                }));
  measure_others(scratch / "format6.laz", options, result);
}

}  // namespace
}  // namespace cornice::bench

int main(int argc, char** argv) {
  using namespace cornice;
  std::string input;
  return bench::run(
      "io", "Rates of reading point files, next to LASzip's own on one thread.", argc, argv,
      [&](CLI::App& app) {
        app.add_option("--input", input, "a .laz file to measure on instead of made ones")
            ->check(CLI::ExistingFile);
      },
      [&](const bench::Options& options, bench::Result& result) {
        if (input.empty()) return bench::measure_made_files(options, result);
        result.parameter("input", std::filesystem::path(input).filename().string());
        bench::measure_format("", input, options, result);
        bench::measure_others(input, options, result);
      });
}
