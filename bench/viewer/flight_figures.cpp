// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/viewer/flight_figures.h"

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>

#include "core/base/error.h"

namespace cornice::bench {
namespace {

/// What a frame may take, of the median.
constexpr double kMostOfMedian = 3.0;

double worst(const std::vector<double>& values) {
  return *std::max_element(values.begin(), values.end());
}

double share_of_slow(const std::vector<double>& times) {
  const double limit = kMostOfMedian * median(times);
  const auto slow =
      std::count_if(times.begin(), times.end(), [&](double time) { return time > limit; });
  return static_cast<double>(slow) / static_cast<double>(times.size());
}

template <class Field>
std::vector<double> all_of(const FlightResult& flight, Field FlightFrame::*field) {
  std::vector<double> values;
  for (const FlightFrame& frame : flight.frames)
    values.push_back(static_cast<double>(frame.*field));
  return values;
}

/// By frame.
std::vector<double> least_of(std::span<const FlightResult> flights, double FlightFrame::*field) {
  std::vector<double> least(flights.front().frames.size(), std::numeric_limits<double>::max());
  for (const FlightResult& flight : flights)
    for (std::size_t i = 0; i < least.size(); ++i)
      least[i] = std::min(least[i], flight.frames[i].*field);
  return least;
}

void time_figures(std::span<const FlightResult> flights, const std::string& unit,
                  const std::string& ending, double FlightFrame::*field, Result& result) {
  const std::vector<double> times = all_of(flights.front(), field);
  const std::vector<double> least = least_of(flights, field);
  result.figure("render_thread_" + unit + "_median", median(times));
  result.figure("render_thread_" + unit + "_worst", worst(times));
  result.figure("worst_over_median" + ending, worst(times) / median(times));
  result.figure("slow_frames_share" + ending, share_of_slow(times));
  result.figure("worst_over_median" + ending + "_least", worst(least) / median(least));
}

}  // namespace

void flight_figures(std::span<const FlightResult> flights, Result& result) {
  time_figures(flights, "ms", "", &FlightFrame::ms, result);
  time_figures(flights, "cpu_ms", "_cpu", &FlightFrame::cpu_ms, result);
  result.figure("flights", static_cast<double>(flights.size()));
  const FlightResult& flight = flights.front();
  double missing_most = 0.0, waiting = 0.0, uploaded = 0.0, stolen = 0.0;
  for (const FlightFrame& frame : flight.frames) {
    missing_most = std::max(missing_most, static_cast<double>(frame.missing));
    waiting += frame.missing > 0 ? 1.0 : 0.0;
    uploaded += static_cast<double>(frame.uploaded_bytes);
    stolen += static_cast<double>(frame.stolen_ticks);
  }
  result.figure("flight_cells_median", median(all_of(flight, &FlightFrame::cells)));
  result.figure("flight_triangles_median", median(all_of(flight, &FlightFrame::triangles)));
  result.figure("flight_cells_missing_most", missing_most);
  result.figure("flight_frames_waiting_share", waiting / static_cast<double>(flight.frames.size()));
  result.figure("flight_uploaded_mb", 1e-6 * uploaded);
  result.figure("flight_read_mb", 1e-6 * flight.read_bytes);
  result.figure("flight_stolen_s", 0.01 * stolen);
  result.figure("flight_waited_for_room_mb", flight.waited_for_mb);
  double gpu = 0.0, cache = 0.0;
  for (const FlightResult& each : flights) {
    gpu = std::max(gpu, each.gpu_over_budget);
    cache = std::max(cache, each.cache_over_budget);
  }
  result.figure("gpu_bytes_over_budget", gpu);
  result.figure("cache_bytes_over_budget", cache);
}

void write_frames(const std::filesystem::path& path, std::span<const FlightResult> flights) {
  std::ofstream file(path);
  file << "flight,frame,ms,cpu_ms,cells,triangles,missing,uploaded_bytes,page_faults,waits,"
          "displaced,stolen_ticks\n";
  for (std::size_t flight = 0; flight < flights.size(); ++flight)
    for (std::size_t i = 0; i < flights[flight].frames.size(); ++i) {
      const FlightFrame& f = flights[flight].frames[i];
      file << flight << ',' << i << ',' << f.ms << ',' << f.cpu_ms << ',' << f.cells << ','
           << f.triangles << ',' << f.missing << ',' << f.uploaded_bytes << ',' << f.page_faults
           << ',' << f.waits << ',' << f.displaced << ',' << f.stolen_ticks << '\n';
    }
  if (!file.flush()) throw RunError(path.string(), "cannot be written");
}

}  // namespace cornice::bench
