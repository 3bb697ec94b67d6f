// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/property/las_writer/clouds.h"

#include <cmath>

#include "core/base/random.h"

namespace cornice::test {
namespace {

bool has_time(int format) { return format != 0 && format != 2; }
bool has_color(int format) {
  return format == 2 || format == 3 || format == 5 || format == 7 || format == 8 || format == 10;
}
bool has_nir(int format) { return format == 8 || format == 10; }
bool has_waves(int format) { return format == 4 || format == 5 || format == 9 || format == 10; }

std::uint8_t below(CounterRandom& random, unsigned end) {
  return static_cast<std::uint8_t>(random.bits() % end);
}
std::uint16_t word(CounterRandom& random) { return static_cast<std::uint16_t>(random.bits()); }

}  // namespace

std::vector<ExtraByte> sample_extra_bytes() {
  ExtraByte height{"height", "above ground", 5, 0, 4, 0.01, 10.0, std::nullopt};
  ExtraByte amplitude{"amplitude", "", 10, 4, 8, 1.0, 0.0, -1.0};
  ExtraByte raw{"raw", "three bytes", 0, 12, 3, 1.0, 0.0, std::nullopt};
  return {height, amplitude, raw};
}

PointCloud sample_cloud(std::size_t count, const LasWriteOptions& options, std::uint64_t seed,
                        double side) {
  PointCloud cloud;
  cloud.origin = options.offset;
  const bool extended = options.point_format >= 6;
  for (const ExtraByte& attribute : options.extra_bytes) cloud.extra_stride += attribute.size;
  for (std::size_t i = 0; i < count; ++i) {
    CounterRandom random(seed, 0, i);
    const Vec3<std::int32_t> exact{
        static_cast<std::int32_t>(random.uniform() * side / options.scale.x),
        static_cast<std::int32_t>(random.uniform() * side / options.scale.y),
        static_cast<std::int32_t>(random.uniform(-50.0, 300.0) / options.scale.z)};
    cloud.exact.push_back(exact);
    cloud.positions.push_back(
        Vec3d{exact.x * options.scale.x, exact.y * options.scale.y, exact.z * options.scale.z}
            .cast<float>());
    cloud.gps_time_s.push_back(3.4e8 + 1e-5 * static_cast<double>(i) + random.uniform() * 1e-6);
    const unsigned returns = 1 + below(random, extended ? 15 : 7);
    cloud.return_count.push_back(static_cast<std::uint8_t>(returns));
    cloud.return_number.push_back(static_cast<std::uint8_t>(1 + below(random, returns)));
    cloud.classification.push_back(below(random, extended ? 256 : 32));
    cloud.flags.push_back(below(random, 64));
    cloud.scan_angle_deg.push_back(
        extended ? static_cast<float>((static_cast<int>(random.bits() % 60001) - 30000) * 0.006)
                 : static_cast<float>(random.bits() % 181) - 90.0f);
    cloud.point_source_id.push_back(word(random));
    cloud.scanner_channel.push_back(below(random, 4));
    cloud.user_data.push_back(below(random, 256));
    cloud.intensity.push_back(word(random));
    cloud.rgb.push_back({word(random), word(random), word(random)});
    cloud.nir.push_back(word(random));
    cloud.wave_packet.emplace_back();
    for (std::uint8_t& byte : cloud.wave_packet.back()) byte = below(random, 256);
    for (std::size_t b = 0; b < cloud.extra_stride; ++b) {
      cloud.extra_bytes.push_back(below(random, 256));
    }
  }
  return cloud;
}

std::vector<OraclePoint> expected_points(const PointCloud& cloud, const LasWriteOptions& options) {
  const int format = options.point_format;
  const bool extended = format >= 6;
  std::vector<OraclePoint> points;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    OraclePoint p{};
    p.x = cloud.exact[i].x, p.y = cloud.exact[i].y, p.z = cloud.exact[i].z;
    p.intensity = cloud.intensity[i];
    p.return_number = cloud.return_number[i];
    p.return_count = cloud.return_count[i];
    p.classification = cloud.classification[i];
    p.flags = extended ? cloud.flags[i] : cloud.flags[i] & ~kOverlap;
    p.channel = extended ? cloud.scanner_channel[i] : 0;
    const double step = extended ? 0.006 : 1.0;
    p.scan_angle = static_cast<int>(std::lround(cloud.scan_angle_deg[i] / step));
    p.user_data = cloud.user_data[i];
    p.point_source_id = cloud.point_source_id[i];
    if (has_time(format)) p.gps_time = cloud.gps_time_s[i];
    if (has_color(format)) {
      p.rgb = {cloud.rgb[i][0], cloud.rgb[i][1], cloud.rgb[i][2],
               has_nir(format) ? cloud.nir[i] : std::uint16_t{0}};
    }
    if (has_waves(format)) p.wave_packet = cloud.wave_packet[i];
    const auto extra =
        cloud.extra_bytes.begin() + static_cast<std::ptrdiff_t>(i * cloud.extra_stride);
    p.extra_bytes.assign(extra, extra + static_cast<std::ptrdiff_t>(cloud.extra_stride));
    points.push_back(std::move(p));
  }
  return points;
}

}  // namespace cornice::test
