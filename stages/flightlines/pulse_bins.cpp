// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/flightlines/pulse_bins.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <utility>

#include "core/base/error.h"
#include "core/base/random.h"

namespace cornice::flightlines {
namespace {

constexpr double kAbsurdAngleDeg = 75.0;  // airborne scanners end at 60
constexpr double kBurstSeconds = 1e-3;
constexpr std::size_t kBurstLimit = 192;
constexpr int kUserDataLimit = 2;  // more values than this are no channel number
/// Whole degrees in the 16-bit field of formats 6-10 lie on its grid of 0.006 degree.
constexpr float kWholeDegreeSlack = 0.0035f;
constexpr std::size_t kBinLimit = 2'000'000;
constexpr std::uint8_t kVirtual = 66;

bool by_hash(const Pulse& a, const Pulse& b) { return a.hash < b.hash; }

/// Adds a return to a pulse that is already kept.
void add_return(Pulse& pulse, const Pulse& one) {
  if (one.first_return < pulse.first_return) {
    pulse.first = one.first;
    pulse.first_return = one.first_return;
  } else if (one.last_return > pulse.last_return) {
    pulse.last = one.last;
    pulse.last_return = one.last_return;
  } else if (!(one.first == pulse.first) && !(one.last == pulse.last) &&
             (one.first_return == pulse.first_return || one.last_return == pulse.last_return)) {
    pulse.conflicting = true;
  }
}

std::uint32_t hash_of(double time_s) {
  return static_cast<std::uint32_t>(mix64(std::bit_cast<std::uint64_t>(time_s)) >> 32);
}

/// Points without times are told apart by their place.
std::uint32_t hash_of(Vec3f p) {
  const std::uint64_t high = std::uint64_t{std::bit_cast<std::uint32_t>(p.y)} << 32;
  return static_cast<std::uint32_t>(mix64(mix64(std::bit_cast<std::uint32_t>(p.x)) ^
                                          (high | std::bit_cast<std::uint32_t>(p.z))) >>
                                    32);
}

bool is_fractional(float angle_deg) {
  const auto nearest = static_cast<int>(angle_deg < 0.0f ? angle_deg - 0.5f : angle_deg + 0.5f);
  return std::abs(angle_deg - static_cast<float>(nearest)) > kWholeDegreeSlack;
}

/// False where a full sample holds smaller hashes only.
bool may_enter(const std::vector<Pulse>& heap, std::size_t capacity, std::uint32_t hash) {
  return heap.size() < capacity || (capacity > 0 && hash <= heap.front().hash);
}

/// Keeps the pulses with the smallest hashes: a uniform sample that does not depend on the order.
void offer(std::vector<Pulse>& heap, std::size_t capacity, const Pulse& pulse) {
  if (!may_enter(heap, capacity, pulse.hash)) return;
  for (Pulse& kept : heap) {
    if (kept.hash == pulse.hash && kept.time_s == pulse.time_s) {
      add_return(kept, pulse);
      return;
    }
  }
  heap.push_back(pulse);
  std::push_heap(heap.begin(), heap.end(), by_hash);
  if (heap.size() > capacity) {
    std::pop_heap(heap.begin(), heap.end(), by_hash);
    heap.pop_back();
  }
}

void offer_moved(std::vector<Pulse>& heap, std::size_t capacity, const std::vector<Pulse>& from,
                 Vec3d shift) {
  for (Pulse pulse : from) {
    pulse.first = (pulse.first.cast<double>() + shift).cast<float>();
    pulse.last = (pulse.last.cast<double>() + shift).cast<float>();
    offer(heap, capacity, pulse);
  }
}

/// Merges `part` into `bin`, which has the same key and index.
void merge_bin(PulseBin& bin, const PulseBin& part, const SampleSize& size) {
  const Vec3d shift = part.origin - bin.origin;
  bin.points += part.points;
  bin.first_time_s = std::min(bin.first_time_s, part.first_time_s);
  bin.last_time_s = std::max(bin.last_time_s, part.last_time_s);
  bin.min_angle_deg = std::min(bin.min_angle_deg, part.min_angle_deg);
  bin.max_angle_deg = std::max(bin.max_angle_deg, part.max_angle_deg);
  bin.fractional_angles |= part.fractional_angles;
  offer_moved(bin.any, size.any, part.any, shift);
  offer_moved(bin.multiple, size.multiple, part.multiple, shift);
  bin.burst_offset.insert(bin.burst_offset.end(), part.burst_offset.begin(),
                          part.burst_offset.end());
  std::sort(bin.burst_offset.begin(), bin.burst_offset.end());
  bin.burst_offset.erase(std::unique(bin.burst_offset.begin(), bin.burst_offset.end()),
                         bin.burst_offset.end());
  if (bin.burst_offset.size() > kBurstLimit) bin.burst_offset.resize(kBurstLimit);
}

bool before(const PulseBin& a, const PulseBin& b) {
  return std::tie(a.key, a.index) < std::tie(b.key, b.index);
}

/// Merges neighbours of equal key and index in a sorted list.
void merge_equal(std::vector<PulseBin>& bins, const SampleSize& size) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < bins.size(); ++i) {
    if (kept > 0 && bins[kept - 1].key == bins[i].key && bins[kept - 1].index == bins[i].index) {
      merge_bin(bins[kept - 1], bins[i], size);
    } else {
      if (kept != i) bins[kept] = std::move(bins[i]);
      ++kept;
    }
  }
  bins.erase(bins.begin() + static_cast<std::ptrdiff_t>(kept), bins.end());
}

void drop_user_data(std::vector<PulseBin>& bins, const SampleSize& size) {
  for (PulseBin& bin : bins) bin.key.user_data = 0;
  std::stable_sort(bins.begin(), bins.end(), before);
  merge_equal(bins, size);
}

}  // namespace

const char* invalid_name(Invalid kind) {
  static constexpr std::array<const char*, kInvalidKinds> names = {
      "virtual_class_66", "synthetic",    "withheld",      "zero_time",       "not_finite_time",
      "negative_time",    "absurd_angle", "return_number", "duplicate_return"};
  return names[static_cast<std::size_t>(kind)];
}

PulseBin& TileBinner::bin_of(const LineKey& key, std::int64_t index, Vec3d origin) {
  // The index wraps at 32 bits, which is 68 years of half seconds.
  const std::uint64_t code =
      mix64((std::uint64_t{key.id} << 48) ^ (std::uint64_t{key.channel} << 40) ^
            (std::uint64_t{key.user_data} << 32) ^ static_cast<std::uint32_t>(index));
  if (code != last_code_) {
    const auto [found, is_new] =
        bin_index_.try_emplace(code, static_cast<std::uint32_t>(set_.bins.size()));
    if (is_new) {
      PulseBin bin;
      bin.key = key;
      bin.index = index;
      bin.origin = origin;
      set_.bins.push_back(std::move(bin));
    }
    last_code_ = code;
    last_bin_ = found->second;
  }
  return set_.bins[last_bin_];
}

bool TileBinner::check(const PointCloud& points, std::size_t i, double& time_s, bool& timeless) {
  const auto reject = [&](Invalid kind) {
    ++set_.invalid[static_cast<std::size_t>(kind)];
    return false;
  };
  if (points.classification[i] == kVirtual) return reject(Invalid::kVirtualClass);
  if (points.flags[i] & kSynthetic) return reject(Invalid::kSynthetic);
  if (points.flags[i] & kWithheld) return reject(Invalid::kWithheld);
  if (std::abs(points.scan_angle_deg[i]) > kAbsurdAngleDeg) return reject(Invalid::kAbsurdAngle);
  time_s = points.gps_time_s.empty() ? 0.0 : points.gps_time_s[i];
  if (!std::isfinite(time_s) || std::abs(time_s) > 1e10) return reject(Invalid::kNotFiniteTime);
  timeless = time_s == 0.0;
  if (timeless) reject(Invalid::kZeroTime);
  return true;
}

void TileBinner::add(const PointCloud& points, double metres, double metres_up) {
  set_.points += points.size();
  const Vec3d origin{points.origin.x * metres, points.origin.y * metres,
                     points.origin.z * metres_up};
  const auto scale = static_cast<float>(metres);
  const auto scale_up = static_cast<float>(metres_up);
  for (std::size_t i = 0; i < points.size(); ++i) {
    double time_s = 0.0;
    bool timeless = false;
    if (!check(points, i, time_s, timeless)) continue;
    ++set_.valid_points;
    const std::uint8_t user_data = points.user_data[i];
    if (!user_data_seen_[user_data]) {
      user_data_seen_[user_data] = true;
      ++user_data_values_;
    }
    const LineKey key{points.point_source_id[i], points.scanner_channel[i],
                      user_data_values_ > kUserDataLimit ? std::uint8_t{0} : user_data};
    const std::int64_t index = timeless ? kTimelessBin : floor_of(time_s / kBinSeconds);
    PulseBin& bin = bin_of(key, index, origin);
    ++bin.points;
    bin.first_time_s = std::min(bin.first_time_s, time_s);
    bin.last_time_s = std::max(bin.last_time_s, time_s);
    const float angle = points.scan_angle_deg[i];
    bin.min_angle_deg = std::min(bin.min_angle_deg, angle);
    bin.max_angle_deg = std::max(bin.max_angle_deg, angle);
    bin.fractional_angles = bin.fractional_angles || is_fractional(angle);

    const std::uint8_t number = points.return_number[i], count = points.return_count[i];
    const bool plausible = number > 0 && number <= count;
    set_.invalid[static_cast<std::size_t>(Invalid::kReturnNumber)] += !plausible;
    const std::uint32_t hash = timeless ? hash_of(points.positions[i]) : hash_of(time_s);
    if (!timeless) {
      const double into = time_s - static_cast<double>(index) * kBinSeconds;
      if (into < kBurstSeconds && bin.burst_offset.size() < kBurstLimit)
        bin.burst_offset.push_back(static_cast<float>(into));
    }
    // Of a dense survey nearly every pulse ends here.
    const bool multiple = !timeless && plausible && count > 1;
    const bool into_any = may_enter(bin.any, size_.any, hash);
    const bool into_multiple = multiple && may_enter(bin.multiple, size_.multiple, hash);
    if (!into_any && !into_multiple) continue;
    Pulse pulse;
    pulse.time_s = time_s;
    const Vec3f p = points.positions[i];
    pulse.first = {p.x * scale, p.y * scale, p.z * scale_up};
    // A tile is read in chunks that may differ in origin; a bin keeps its first.
    if (!(origin == bin.origin))
      pulse.first = (pulse.first.cast<double>() + (origin - bin.origin)).cast<float>();
    pulse.last = pulse.first;
    pulse.angle_deg = angle;
    pulse.first_return = pulse.last_return = number;
    pulse.return_count = count;
    pulse.hash = hash;
    if (into_any) offer(bin.any, size_.any, pulse);
    if (into_multiple) offer(bin.multiple, size_.multiple, pulse);
  }
}

BinSet TileBinner::finish(const std::string& file) {
  if (set_.bins.size() > kBinLimit)
    throw InputError(file, "its GPS times are scattered over more than " +
                               std::to_string(kBinLimit) +
                               " half seconds; they are no times of flight");
  set_.user_data_ignored = user_data_values_ > kUserDataLimit;
  if (set_.user_data_ignored) drop_user_data(set_.bins, size_);
  std::sort(set_.bins.begin(), set_.bins.end(), before);
  for (PulseBin& bin : set_.bins) {
    std::sort(bin.burst_offset.begin(), bin.burst_offset.end());
    bin.burst_offset.erase(std::unique(bin.burst_offset.begin(), bin.burst_offset.end()),
                           bin.burst_offset.end());
  }
  bin_index_.clear();
  last_code_ = ~0ull;
  return std::exchange(set_, {});
}

void merge_bins(BinSet& whole, BinSet&& part, const SampleSize& size) {
  whole.points += part.points;
  whole.valid_points += part.valid_points;
  for (std::size_t i = 0; i < kInvalidKinds; ++i) whole.invalid[i] += part.invalid[i];
  whole.user_data_ignored |= part.user_data_ignored;
  const auto middle = static_cast<std::ptrdiff_t>(whole.bins.size());
  whole.bins.insert(whole.bins.end(), std::make_move_iterator(part.bins.begin()),
                    std::make_move_iterator(part.bins.end()));
  std::inplace_merge(whole.bins.begin(), whole.bins.begin() + middle, whole.bins.end(), before);
  merge_equal(whole.bins, size);
}

void thin_bins(BinSet& set, const SampleSize& size) {
  const auto thin = [](std::vector<Pulse>& heap, std::size_t capacity) {
    if (heap.size() <= capacity) return;
    std::sort(heap.begin(), heap.end(), by_hash);
    heap.resize(capacity);
    heap.shrink_to_fit();
    std::make_heap(heap.begin(), heap.end(), by_hash);
  };
  for (PulseBin& bin : set.bins) {
    thin(bin.any, size.any);
    thin(bin.multiple, size.multiple);
  }
}

std::size_t memory_bytes(const BinSet& set) {
  std::size_t bytes = set.bins.capacity() * sizeof(PulseBin);
  for (const PulseBin& bin : set.bins)
    bytes += (bin.any.capacity() + bin.multiple.capacity()) * sizeof(Pulse) +
             bin.burst_offset.capacity() * sizeof(float);
  return bytes;
}

bool settle_user_data(BinSet& set, const SampleSize& size) {
  std::map<std::pair<std::uint32_t, std::int64_t>, std::vector<const PulseBin*>> groups;
  for (const PulseBin& bin : set.bins)
    if (bin.index != kTimelessBin)
      groups[{std::uint32_t{bin.key.id} << 8 | bin.key.channel, bin.index}].push_back(&bin);
  std::size_t shared = 0;
  std::size_t sampled = 0;
  for (const auto& [place, bins] : groups) {
    // Where only one value is seen the other channel looks past the tiles.
    if (bins.size() < 2) continue;
    std::map<double, int> times;
    for (const PulseBin* bin : bins)
      for (const Pulse& pulse : bin->any) times[pulse.time_s] += pulse.first_return <= 1;
    for (const auto& [time, count] : times) {
      ++sampled;
      shared += count > 1;
    }
  }
  const bool tells = !set.user_data_ignored && shared * 20 > sampled;
  if (!tells) drop_user_data(set.bins, size);
  return tells;
}

}  // namespace cornice::flightlines
