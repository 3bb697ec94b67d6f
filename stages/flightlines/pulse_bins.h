// SPDX-License-Identifier: GPL-3.0-or-later
// What is kept of a tile for flight lines: half-second bins of each line id and channel, each with
// counts and a small random sample of its pulses. Bins of neighbouring tiles merge, so a survey of
// any size is seen at once while no tile is held.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <unordered_map>
#include <vector>

#include "core/base/vec.h"
#include "core/points/point_cloud.h"

namespace cornice::flightlines {

/// Length of a bin, seconds: an aircraft moves some 30 m, its attitude by a few tenths of a degree.
inline constexpr double kBinSeconds = 0.5;
/// Index of the bin that holds points without a usable time.
inline constexpr std::int64_t kTimelessBin = std::numeric_limits<std::int64_t>::min();

/// floor(x) for what fits 64 bits; without SSE 4.1 std::floor is a call.
inline std::int64_t floor_of(double x) {
  const auto whole = static_cast<std::int64_t>(x);
  return whole - (static_cast<double>(whole) > x);
}

/// What points of one line share, as far as a single point tells.
struct LineKey {
  std::uint16_t id = 0;  ///< point source id
  std::uint8_t channel = 0;
  std::uint8_t user_data = 0;
  friend auto operator<=>(const LineKey&, const LineKey&) = default;
};

/// First and last known return of one emitted pulse. Positions relative to the bin's origin.
struct Pulse {
  double time_s = 0.0;
  Vec3f first;
  Vec3f last;
  float angle_deg = 0.0f;  ///< as recorded
  std::uint32_t hash = 0;  ///< of the time: the sample keeps the smallest
  std::uint8_t first_return = 0;
  std::uint8_t last_return = 0;
  std::uint8_t return_count = 0;
  bool conflicting = false;  ///< two returns of one number at different places
};

/// Why points take no part.
enum class Invalid : std::uint8_t {
  kVirtualClass,     ///< class 66
  kSynthetic,        ///< synthetic flag
  kWithheld,         ///< withheld flag
  kZeroTime,         ///< GPS time 0 (or none in the format)
  kNotFiniteTime,    ///< NaN or infinite
  kNegativeTime,     ///< below 0 among points above 0
  kAbsurdAngle,      ///< beyond 75 degrees
  kReturnNumber,     ///< return 0, or above the number of returns: kept as a single return
  kDuplicateReturn,  ///< sampled pulses with two returns of one number: not used as a pair
};
inline constexpr std::size_t kInvalidKinds = 9;
const char* invalid_name(Invalid kind);

/// Points of one key within one half second.
struct PulseBin {
  LineKey key;
  std::int64_t index = 0;  ///< floor(time / kBinSeconds)
  Vec3d origin;            ///< projected CRS, metres
  std::uint64_t points = 0;
  double first_time_s = std::numeric_limits<double>::infinity();
  double last_time_s = -std::numeric_limits<double>::infinity();
  float min_angle_deg = std::numeric_limits<float>::infinity();
  float max_angle_deg = -std::numeric_limits<float>::infinity();
  bool fractional_angles = false;  ///< some angle is no whole degree
  std::vector<Pulse> any;          ///< max-heap on hash; smallest hashes among all pulses
  std::vector<Pulse> multiple;     ///< the same among pulses of two and more returns
  std::vector<float>
      burst_offset;  ///< seconds into the bin of the pulses in its first milliseconds
};

/// How much a bin keeps.
struct SampleSize {
  std::size_t any = 192;
  std::size_t multiple = 384;  ///< crops of a second or two need them
};

using InvalidCounts = std::array<std::uint64_t, kInvalidKinds>;

/// All bins of a tile or of a survey.
struct BinSet {
  std::vector<PulseBin> bins;  ///< sorted by key, then index
  InvalidCounts invalid{};
  std::uint64_t points = 0;        ///< seen
  std::uint64_t valid_points = 0;  ///< in bins
  bool user_data_ignored = false;  ///< too many values to be a channel
};

/// Fills bins from the points of one tile, in any order. The sample is the same for any order of
/// points and any cutting into tiles: pulses are kept by a hash of their time.
class TileBinner {
 public:
  explicit TileBinner(const SampleSize& size = {}) : size_(size) {}
  /// Adds points. `metres` scales coordinates to metres (feet), horizontally and vertically.
  /// Needs kGpsTime (or none, then every point is timeless), kScanAngle, kReturns,
  /// kClassification, kFlags, kPointSource, kChannel, kUserData.
  void add(const PointCloud& points, double metres = 1.0, double metres_up = 1.0);
  /// Hands the bins over; the binner is empty then. Throws InputError(file, ...) where times are
  /// scattered over more bins than any survey has.
  BinSet finish(const std::string& file);

 private:
  PulseBin& bin_of(const LineKey& key, std::int64_t index, Vec3d origin);
  bool check(const PointCloud& points, std::size_t i, double& time_s, bool& timeless);

  SampleSize size_;
  BinSet set_;
  std::unordered_map<std::uint64_t, std::uint32_t> bin_index_;
  std::uint64_t last_code_ = ~0ull;
  std::uint32_t last_bin_ = 0;
  std::array<bool, 256> user_data_seen_{};
  int user_data_values_ = 0;
};

/// Adds the bins of `part` to `whole`, bins of one key and index merged.
void merge_bins(BinSet& whole, BinSet&& part, const SampleSize& size);

/// Keeps at most `size` pulses a bin (a subset of what was kept before).
void thin_bins(BinSet& set, const SampleSize& size);

/// Bytes held by samples and bins.
std::size_t memory_bytes(const BinSet& set);

/// Merges bins that differ in user data only, unless user data tells channels apart: two values
/// have a first return at one time, in a twentieth of the sampled pulses of half seconds that have
/// both (often one channel looks past the tiles). Returns whether it does.
bool settle_user_data(BinSet& set, const SampleSize& size);

}  // namespace cornice::flightlines
