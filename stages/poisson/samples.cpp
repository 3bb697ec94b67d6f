// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/poisson/samples.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/base/radix_sort.h"

namespace cornice::poisson {
namespace {

constexpr std::size_t kPointsAtATime = std::size_t{1} << 16;
constexpr std::size_t kBricksAtATime = 64;
constexpr std::size_t kPointsAhead = 16;  ///< asked for early: a brick's points lie far apart
constexpr double kFarthest = 0x1p30;  ///< steps; node numbers are 32 bits, with room for borders

using Cell = Vec3<std::int64_t>;

/// Where a point lies on the lattice.
struct Place {
  Cell cell;
  Vec3d fraction;
};

/// Positions in steps, whatever the origin; one formula for every use, so that all agree.
class Placing {
 public:
  Placing(Vec3d origin, double step_m) : origin_(origin), step_m_(step_m) {}
  Place operator()(Vec3f position) const {
    const Vec3d steps = (origin_ + position.cast<double>()) / step_m_;
    const Vec3d floor{std::floor(steps.x), std::floor(steps.y), std::floor(steps.z)};
    return {floor.cast<std::int64_t>(), steps - floor};
  }

 private:
  Vec3d origin_;
  double step_m_;
};

bool finite(Vec3f v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

/// Numbers the bricks of a box in the order of their keys.
class BrickCodes {
 public:
  /// Throws UsageError where codes and `count` points do not fit 64 bits together.
  BrickCodes(const Box3d& domain, double step_m, std::size_t count) {
    const auto brick = [&](Vec3d corner) {
      const Vec3d c = corner / step_m;
      if (!(std::abs(c.x) < kFarthest && std::abs(c.y) < kFarthest && std::abs(c.z) < kFarthest))
        throw UsageError("--step",
                         "the domain reaches beyond 2^30 steps from the survey's origin; "
                         "use a larger step or check the coordinates");
      // As for points: the last cell's brick, so that no point in the domain lies beyond.
      const auto down = [](double v) { return static_cast<std::int32_t>(std::floor(v)) >> 3; };
      return BrickKey{down(c.x), down(c.y), down(c.z)};
    };
    const auto low = brick(domain.min), high = brick(domain.max);
    first_ = low;
    size_ = {high.x - low.x + 1, high.y - low.y + 1, high.z - low.z + 1};
    index_bits_ = static_cast<int>(std::bit_width(count));
    const double codes = static_cast<double>(size_.x) * size_.y * size_.z;
    if (codes >= std::ldexp(1.0, 63 - index_bits_))
      throw UsageError("--step", "the domain has too many bricks of this step (" +
                                     std::to_string(codes) + "); use a larger one");
    code_bits_ = static_cast<int>(std::bit_width(static_cast<std::uint64_t>(codes)));
  }
  int index_bits() const { return index_bits_; }
  int code_bits() const { return code_bits_; }
  std::uint64_t code(const Cell& cell) const {
    const auto x = static_cast<std::uint64_t>((cell.x >> 3) - first_.x),
               y = static_cast<std::uint64_t>((cell.y >> 3) - first_.y),
               z = static_cast<std::uint64_t>((cell.z >> 3) - first_.z);
    return (x * static_cast<std::uint64_t>(size_.y) + y) * static_cast<std::uint64_t>(size_.z) + z;
  }
  BrickKey key(std::uint64_t code) const {
    const auto z = code % static_cast<std::uint64_t>(size_.z),
               xy = code / static_cast<std::uint64_t>(size_.z);
    return {first_.x + static_cast<std::int32_t>(xy / static_cast<std::uint64_t>(size_.y)),
            first_.y + static_cast<std::int32_t>(xy % static_cast<std::uint64_t>(size_.y)),
            first_.z + static_cast<std::int32_t>(z)};
  }

 private:
  BrickKey first_, size_;
  int index_bits_ = 0, code_bits_ = 0;
};

/// Points of a cell beyond which more of them change nothing but the mean.
struct CellLimits {
  double counted, weighed;
};
constexpr CellLimits kFinestLimits{kCellCountMax, kCellWeightMax};
constexpr CellLimits kNoLimits{HUGE_VAL, HUGE_VAL};

/// Sums of one brick's cells. Doubles: a cell may hold a million points.
class CellSums {
 public:
  void add(int cell, Vec3d fraction, Vec3d normal, double weight, double count) {
    Sum& sum = sums_[static_cast<std::size_t>(cell)];
    if (sum.weight == 0.0) touched_.push_back(static_cast<std::uint16_t>(cell));
    sum.position += weight * fraction;
    sum.normal += normal;
    sum.weight += weight;
    sum.count += count;
  }
  /// Appends the samples in order of cells and forgets them.
  void flush(const CellLimits& limits, std::vector<Sample>& samples) {
    std::sort(touched_.begin(), touched_.end());
    for (const std::uint16_t cell : touched_) {
      Sum& sum = sums_[cell];
      Sample sample;
      sample.fraction = (sum.position / sum.weight).cast<float>();
      const double share = std::min(1.0, limits.weighed / sum.count);
      sample.normal = (share * sum.normal).cast<float>();
      sample.weight = static_cast<float>(share * sum.weight);
      sample.count = static_cast<float>(std::min(sum.count, limits.counted));
      sample.cell = cell;
      samples.push_back(sample);
      sum = {};
    }
    touched_.clear();
  }

 private:
  struct Sum {
    Vec3d position, normal;
    double weight = 0.0, count = 0.0;
  };
  std::array<Sum, kBrickNodes> sums_{};
  std::vector<std::uint16_t> touched_;
};

/// Fills `first` and `samples` of a level whose bricks are known; fill(brick, sums) adds up brick
/// after brick.
template <class Fill>
void fill_bricks(SampleLevel& level, const CellLimits& limits, int threads, Fill fill) {
  struct Part {
    std::vector<std::uint32_t> counts;
    std::vector<Sample> samples;
  };
  std::vector<Part> parts((level.bricks.size() + kBricksAtATime - 1) / kBricksAtATime);
  parallel_for(level.bricks.size(), kBricksAtATime, threads,
               [&](std::size_t begin, std::size_t end) {
                 const auto sums = std::make_unique<CellSums>();
                 Part& part = parts[begin / kBricksAtATime];
                 for (std::size_t b = begin; b < end; ++b) {
                   const std::size_t before = part.samples.size();
                   fill(b, *sums);
                   sums->flush(limits, part.samples);
                   part.counts.push_back(static_cast<std::uint32_t>(part.samples.size() - before));
                 }
               });
  level.first.assign(1, 0);
  level.first.reserve(level.bricks.size() + 1);
  for (const Part& part : parts) {
    for (const std::uint32_t count : part.counts) level.first.push_back(level.first.back() + count);
  }
  level.samples.resize(level.first.back());
  parallel_for(parts.size(), 16, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      std::copy(
          parts[p].samples.begin(), parts[p].samples.end(),
          level.samples.begin() + static_cast<std::ptrdiff_t>(level.first[p * kBricksAtATime]));
      std::vector<Sample>().swap(parts[p].samples);
    }
  });
  level.index = BrickIndex(level.bricks);
}

float quality_of(const OrientedPoints& points, std::size_t i) {
  return points.quality.empty() ? 1.0f : points.quality[i];
}

void prefetch(const OrientedPoints& points, std::size_t i) {
  __builtin_prefetch(&points.positions[i]);
  __builtin_prefetch(&points.normals[i]);
  if (!points.quality.empty()) __builtin_prefetch(&points.quality[i]);
}

/// Brick code and index of every point that counts, sorted by brick.
std::vector<std::uint64_t> sorted_points(const OrientedPoints& points, const Box3d& domain,
                                         const Placing& place, const BrickCodes& codes, int threads,
                                         LeftOut& left_out) {
  struct Part {
    std::vector<std::uint64_t> words;
    LeftOut left_out;
  };
  const auto map = [&](std::size_t begin, std::size_t end) {
    Part part;
    part.words.reserve(end - begin);
    for (std::size_t i = begin; i < end; ++i) {
      const float quality = quality_of(points, i);
      const Vec3f normal = points.normals[i];
      if (!finite(points.positions[i]) || !finite(normal) || !std::isfinite(quality)) {
        ++part.left_out.not_finite;
      } else if (!(quality > 0.0f) || !(dot(normal, normal) > 0.0f)) {
        ++part.left_out.without_normal;
      } else if (!domain.contains(points.origin + points.positions[i].cast<double>())) {
        ++part.left_out.outside;
      } else {
        part.words.push_back(codes.code(place(points.positions[i]).cell) << codes.index_bits() | i);
      }
    }
    return part;
  };
  Part all;
  all.words.reserve(points.positions.size());
  all = parallel_reduce(points.positions.size(), kPointsAtATime, threads, std::move(all), map,
                        [](Part& sum, Part& part) {
                          sum.words.insert(sum.words.end(), part.words.begin(), part.words.end());
                          std::vector<std::uint64_t>().swap(part.words);
                          sum.left_out.not_finite += part.left_out.not_finite;
                          sum.left_out.without_normal += part.left_out.without_normal;
                          sum.left_out.outside += part.left_out.outside;
                        });
  left_out = all.left_out;
  std::vector<std::uint64_t> words = std::move(all.words);
  radix_sort(words, codes.index_bits(), codes.index_bits() + codes.code_bits(), threads,
             [](std::uint64_t word) { return word; });
  return words;
}

}  // namespace

SampleLevel gather_samples(const OrientedPoints& points, const Box3d& domain, double step_m,
                           int threads, LeftOut& left_out) {
  SampleLevel level;
  level.first.assign(1, 0);
  if (points.positions.empty() || domain.empty()) {
    left_out.outside += points.positions.size();
    return level;
  }
  const Placing place(points.origin, step_m);
  const BrickCodes codes(domain, step_m, points.positions.size());
  const std::vector<std::uint64_t> words =
      sorted_points(points, domain, place, codes, threads, left_out);
  std::vector<std::size_t> begins;
  for (std::size_t w = 0; w < words.size(); ++w) {
    if (w > 0 && words[w] >> codes.index_bits() == words[w - 1] >> codes.index_bits()) continue;
    begins.push_back(w);
    level.bricks.push_back(codes.key(words[w] >> codes.index_bits()));
  }
  begins.push_back(words.size());
  const std::uint64_t index_mask = (std::uint64_t{1} << codes.index_bits()) - 1;
  fill_bricks(level, kFinestLimits, threads, [&](std::size_t b, CellSums& sums) {
    for (std::size_t w = begins[b]; w < begins[b + 1]; ++w) {
      if (w + kPointsAhead < words.size()) prefetch(points, words[w + kPointsAhead] & index_mask);
      const std::size_t i = words[w] & index_mask;
      const Place at = place(points.positions[i]);
      const double quality = quality_of(points, i);
      sums.add(static_cast<int>((at.cell.x & 7) | (at.cell.y & 7) << 3 | (at.cell.z & 7) << 6),
               at.fraction, quality * normalized(points.normals[i].cast<double>()), quality, 1.0);
    }
  });
  return level;
}

SampleLevel coarser_samples(const SampleLevel& finer, int threads) {
  SampleLevel level;
  for (const BrickKey brick : finer.bricks) {
    if (level.bricks.empty() || level.bricks.back() != parent(brick))
      level.bricks.push_back(parent(brick));
  }
  std::sort(level.bricks.begin(), level.bricks.end());
  level.bricks.erase(std::unique(level.bricks.begin(), level.bricks.end()), level.bricks.end());
  fill_bricks(level, kNoLimits, threads, [&](std::size_t b, CellSums& sums) {
    const BrickKey key = level.bricks[b];
    for (int o = 0; o < 8; ++o) {
      const int ox = o & 1, oy = o >> 1 & 1, oz = o >> 2;
      const std::uint32_t child =
          finer.index.find(finer.bricks, {2 * key.x + ox, 2 * key.y + oy, 2 * key.z + oz});
      if (child == BrickIndex::kNone) continue;
      for (std::uint64_t s = finer.first[child]; s < finer.first[child + 1]; ++s) {
        const Sample& sample = finer.samples[s];
        const int x = 8 * ox + (sample.cell & 7), y = 8 * oy + (sample.cell >> 3 & 7),
                  z = 8 * oz + (sample.cell >> 6);
        const Vec3d fraction =
            0.5 * (sample.fraction.cast<double>() + Vec3<int>{x & 1, y & 1, z & 1}.cast<double>());
        sums.add((x >> 1) | (y >> 1) << 3 | (z >> 1) << 6, fraction, sample.normal.cast<double>(),
                 static_cast<double>(sample.weight), static_cast<double>(sample.count));
      }
    }
  });
  return level;
}

}  // namespace cornice::poisson
