// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/normals/beams.h"

#include <algorithm>
#include <limits>

#include "core/base/error.h"
#include "core/base/parallel.h"

namespace cornice::normals {
namespace {

/// A LineFinder holds a table over all point source ids: worth it for this many points.
constexpr std::size_t kGrain = 1u << 16;

template <class T>
T value_at(const std::vector<T>& values, std::size_t i) {
  return values.empty() ? T{} : values[i];
}

/// The lines without what is better than `best`.
FlightLines limited(const FlightLines& lines, BeamSource best) {
  FlightLines copy = lines;
  for (FlightLine& line : copy.lines) {
    line.beam_source = std::max(line.beam_source, best);
    if (line.beam_source != BeamSource::kTrajectory) line.nodes.clear();
  }
  return copy;
}

struct Counts {
  std::array<std::size_t, 3> by_source{};
  std::size_t without_line = 0;
};

}  // namespace

PointBeams find_beams(const PointCloud& points, const FlightLines& lines, BeamSource best,
                      int threads) {
  const FlightLines usable = limited(lines, best);
  for (const FlightLine& line : usable.lines) {
    if (line.id > std::numeric_limits<std::uint16_t>::max()) {
      throw InputError("--flightlines", "line id " + std::to_string(line.id) +
                                            " does not fit 16 bits; number the lines from 1");
    }
  }
  PointBeams found;
  found.beams.direction.resize(points.size());
  found.beams.source.resize(points.size());
  found.line_id.resize(points.size());
  const auto find_range = [&](std::size_t begin, std::size_t end) {
    Counts counts;
    LineFinder finder(usable);
    for (std::size_t i = begin; i < end; ++i) {
      const double time = value_at(points.gps_time_s, i);
      const auto line =
          finder.find(value_at(points.point_source_id, i), value_at(points.scanner_channel, i),
                      time, value_at(points.user_data, i));
      Vec3d beam{0.0, 0.0, -1.0};
      BeamSource source = BeamSource::kVertical;
      if (line) {
        const auto angle_deg = static_cast<double>(value_at(points.scan_angle_deg, i));
        beam = beam_at(usable.lines[*line], time, points.position(i), angle_deg, &source);
        found.line_id[i] = static_cast<std::uint16_t>(usable.lines[*line].id);
      }
      counts.without_line += line ? 0 : 1;
      ++counts.by_source[static_cast<std::size_t>(source)];
      found.beams.direction[i] = beam.cast<float>();
      found.beams.source[i] = source;
    }
    return counts;
  };
  const Counts total = parallel_reduce(points.size(), kGrain, threads, Counts{}, find_range,
                                       [](Counts& sum, const Counts& part) {
                                         for (std::size_t s = 0; s < 3; ++s) {
                                           sum.by_source[s] += part.by_source[s];
                                         }
                                         sum.without_line += part.without_line;
                                       });
  found.by_source = total.by_source;
  found.without_line = total.without_line;
  return found;
}

}  // namespace cornice::normals
