// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/points/point_cloud.h"

#include <algorithm>
#include <cassert>
#include <cstddef>

namespace cornice {
namespace {

/// Calls visit(member) for the arrays that have one entry a point, extra bytes aside.
template <class Visit>
void for_each_array(Visit visit) {
  visit(&PointCloud::positions);
  visit(&PointCloud::exact);
  visit(&PointCloud::gps_time_s);
  visit(&PointCloud::scan_angle_deg);
  visit(&PointCloud::return_number);
  visit(&PointCloud::return_count);
  visit(&PointCloud::classification);
  visit(&PointCloud::flags);
  visit(&PointCloud::point_source_id);
  visit(&PointCloud::scanner_channel);
  visit(&PointCloud::user_data);
  visit(&PointCloud::intensity);
  visit(&PointCloud::rgb);
  visit(&PointCloud::nir);
  visit(&PointCloud::wave_packet);
}

}  // namespace

void PointCloud::clear() {
  for_each_array([&](auto member) { (this->*member).clear(); });
  extra_bytes.clear();
}

void PointCloud::reserve(std::size_t n, Attribute attributes) {
  const auto reserve_for = [&](Attribute attribute, auto& array) {
    if (has(attributes, attribute)) array.reserve(n);
  };
  positions.reserve(n);
  reserve_for(Attribute::kExact, exact);
  reserve_for(Attribute::kGpsTime, gps_time_s);
  reserve_for(Attribute::kScanAngle, scan_angle_deg);
  reserve_for(Attribute::kReturns, return_number);
  reserve_for(Attribute::kReturns, return_count);
  reserve_for(Attribute::kClassification, classification);
  reserve_for(Attribute::kFlags, flags);
  reserve_for(Attribute::kPointSource, point_source_id);
  reserve_for(Attribute::kChannel, scanner_channel);
  reserve_for(Attribute::kUserData, user_data);
  reserve_for(Attribute::kIntensity, intensity);
  reserve_for(Attribute::kColor, rgb);
  reserve_for(Attribute::kWaveform, wave_packet);
  if (has(attributes, Attribute::kExtraBytes)) extra_bytes.reserve(n * extra_stride);
}

void PointCloud::append(const PointCloud& other) {
  assert((empty() || other.empty() || origin == other.origin) && "origins differ");
  if (empty()) {
    origin = other.origin;
    extra_stride = other.extra_stride;
  }
  assert((other.empty() || extra_stride == other.extra_stride) && "extra bytes differ");
  [[maybe_unused]] const std::size_t before = size();
  for_each_array([&](auto member) {
    auto& array = this->*member;
    const auto& tail = other.*member;
    assert((array.size() == before || array.empty()) && "arrays of different length");
    assert((before == 0 || other.empty() || array.empty() == tail.empty()) &&
           "different arrays are filled");
    // Copied by index range: `other` may be this cloud itself.
    const std::size_t count = tail.size();
    array.resize(array.size() + count);
    std::copy_n(tail.begin(), count, array.end() - static_cast<std::ptrdiff_t>(count));
  });
  const std::size_t count = other.extra_bytes.size();
  extra_bytes.resize(extra_bytes.size() + count);
  std::copy_n(other.extra_bytes.begin(), count,
              extra_bytes.end() - static_cast<std::ptrdiff_t>(count));
}

void PointCloud::filter(const std::vector<std::uint8_t>& keep) {
  assert(keep.size() == size() && "one entry a point");
  const std::size_t count = size();
  for_each_array([&](auto member) {
    auto& array = this->*member;
    if (array.empty()) return;
    std::size_t to = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (keep[i] != 0) array[to++] = array[i];
    }
    array.resize(to);
  });
  if (extra_bytes.empty()) return;
  std::size_t to = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (keep[i] == 0) continue;
    std::copy_n(extra_bytes.begin() + static_cast<std::ptrdiff_t>(i * extra_stride), extra_stride,
                extra_bytes.begin() + static_cast<std::ptrdiff_t>(to));
    to += extra_stride;
  }
  extra_bytes.resize(to);
}

std::size_t PointCloud::memory_bytes() const {
  std::size_t bytes = extra_bytes.capacity();
  for_each_array([&](auto member) {
    const auto& array = this->*member;
    bytes += array.capacity() * sizeof(array[0]);
  });
  return bytes;
}

}  // namespace cornice
