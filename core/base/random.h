// SPDX-License-Identifier: GPL-3.0-or-later
// Random numbers by counter: value i of stream s is a function of (seed, s, i) alone, so parallel
// work needs no shared state and gives the same numbers in any order.
#pragma once

#include <cmath>
#include <cstdint>

namespace cornice {

/// Mixes 64 bits (Steele, Lea, Flood 2014, SplitMix64 finaliser).
constexpr std::uint64_t mix64(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

/// Uniform and normal deviates of one (seed, stream, item).
class CounterRandom {
 public:
  constexpr CounterRandom(std::uint64_t seed, std::uint64_t stream, std::uint64_t item)
      : state_(mix64(mix64(mix64(seed + 0x9e3779b97f4a7c15ULL) + stream) + item)) {}

  constexpr std::uint64_t bits() { return mix64(state_ += 0x9e3779b97f4a7c15ULL); }
  /// In [0, 1).
  constexpr double uniform() { return static_cast<double>(bits() >> 11) * 0x1.0p-53; }
  constexpr double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// Mean 0, standard deviation 1 (Box and Muller 1958; one of the pair is dropped).
  double normal() {
    const double u = 1.0 - uniform();
    return std::sqrt(-2.0 * std::log(u)) * std::cos(6.283185307179586 * uniform());
  }

 private:
  std::uint64_t state_;
};

}  // namespace cornice
