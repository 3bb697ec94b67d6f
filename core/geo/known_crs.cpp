// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geo/known_crs.h"

#include <array>
#include <map>
#include <mutex>

namespace cornice {
namespace {

/// Answers kept by one function. More different systems than this are no survey; forgetting all
/// then keeps the memory small.
constexpr std::size_t kMostAnswers = 64;

template <class Key>
class Answers {
 public:
  /// `ask` is called without the lock: two threads may ask the same at once and hear the same.
  template <class Ask>
  std::optional<Crs> of(const Key& key, const Ask& ask) {
    {
      const std::lock_guard lock(mutex_);
      if (const auto known = answers_.find(key); known != answers_.end()) return known->second;
    }
    std::optional<Crs> answer = ask();
    const std::lock_guard lock(mutex_);
    if (answers_.size() >= kMostAnswers) answers_.clear();
    answers_.emplace(key, answer);
    return answer;
  }

 private:
  std::mutex mutex_;
  std::map<Key, std::optional<Crs>> answers_;
};

}  // namespace

Crs known_crs_from_text(const std::string& text) {
  static Answers<std::string> answers;
  return *answers.of(text, [&] { return std::optional<Crs>(crs_from_text(text)); });
}

std::optional<Crs> known_crs_from_wkt(const std::string& wkt) {
  static Answers<std::string> answers;
  return answers.of(wkt, [&] { return crs_from_wkt(wkt); });
}

std::optional<Crs> known_crs_from_geotiff_keys(const std::vector<unsigned char>& keys,
                                               const std::vector<unsigned char>& doubles,
                                               const std::string& ascii) {
  // As text: g++ 14 warns of comparing vectors of bytes, falsely.
  using Records = std::array<std::string, 3>;
  static Answers<Records> answers;
  return answers.of({{{keys.begin(), keys.end()}, {doubles.begin(), doubles.end()}, ascii}},
                    [&] { return crs_from_geotiff_keys(keys, doubles, ascii); });
}

}  // namespace cornice
