// SPDX-License-Identifier: GPL-3.0-or-later
// The table is coded as LASzip codes 32-bit integers: each value is predicted by the one before,
// the correction falls in one of 33 intervals [2^(k-1), 2^k) on either side of 0, k is coded with
// an adaptive model, its upper 8 bits with one model for each k, the rest as they are. Sources:
// Said, Introduction to arithmetic coding - theory and practice, 2004 (coder and model updates);
// Isenburg, LASzip: lossless compression of LiDAR data, 2013, section 4 (integers).
#include "core/io/laz_chunk_table.h"

#include <algorithm>
#include <array>

#include "core/io/little_endian.h"

namespace cornice {
namespace {

constexpr std::uint32_t kMinLength = 1u << 24;  // below it the interval is renormalised
constexpr int kSymbolShift = 15;                // precision of symbol probabilities
constexpr int kBitShift = 13;                   // precision of bit probabilities
constexpr int kBitsHigh = 8;                    // modelled upper bits of a correction
constexpr std::size_t kTableHead = 8;           // version, number of chunks

/// Adaptive probabilities of `n` symbols.
class SymbolModel {
 public:
  explicit SymbolModel(std::uint32_t n)
      : counts_(n, 1), distribution_(n, 0), update_cycle_(n), until_update_(0) {
    update();
    until_update_ = update_cycle_ = (n + 6) >> 1;
  }
  std::uint32_t last() const { return static_cast<std::uint32_t>(counts_.size()) - 1; }
  std::uint32_t low(std::uint32_t symbol) const { return distribution_[symbol]; }

  void count(std::uint32_t symbol) {
    ++counts_[symbol];
    if (--until_update_ == 0) update();
  }

 private:
  void update() {
    constexpr std::uint32_t kMaxCount = 1u << kSymbolShift;
    total_ += update_cycle_;
    if (total_ > kMaxCount) {
      total_ = 0;
      for (std::uint32_t& n : counts_) total_ += (n = (n + 1) >> 1);
    }
    const std::uint32_t scale = 0x80000000u / total_;
    std::uint32_t sum = 0;
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      distribution_[i] = (scale * sum) >> (31 - kSymbolShift);
      sum += counts_[i];
    }
    const auto most = static_cast<std::uint32_t>(counts_.size() + 6) << 3;
    update_cycle_ = std::min((5 * update_cycle_) >> 2, most);
    until_update_ = update_cycle_;
  }

  std::vector<std::uint32_t> counts_;
  std::vector<std::uint32_t> distribution_;
  std::uint32_t total_ = 0;
  std::uint32_t update_cycle_;
  std::uint32_t until_update_;
};

/// Adaptive probability of a bit.
class BitModel {
 public:
  std::uint32_t zero_probability() const { return zero_probability_; }
  void count(bool bit) {
    if (!bit) ++zeros_;
    if (--until_update_ == 0) update();
  }

 private:
  void update() {
    constexpr std::uint32_t kMaxCount = 1u << kBitShift;
    total_ += update_cycle_;
    if (total_ > kMaxCount) {
      total_ = (total_ + 1) >> 1;
      zeros_ = (zeros_ + 1) >> 1;
      if (zeros_ == total_) ++total_;
    }
    const std::uint32_t scale = 0x80000000u / total_;
    zero_probability_ = (zeros_ * scale) >> (31 - kBitShift);
    update_cycle_ = std::min((5 * update_cycle_) >> 2, 64u);
    until_update_ = update_cycle_;
  }

  std::uint32_t zeros_ = 1;
  std::uint32_t total_ = 2;
  std::uint32_t zero_probability_ = 1u << (kBitShift - 1);
  std::uint32_t update_cycle_ = 4;
  std::uint32_t until_update_ = 4;
};

class Encoder {
 public:
  void symbol(SymbolModel& model, std::uint32_t value) {
    const std::uint32_t step = length_ >> kSymbolShift;
    const std::uint32_t low = model.low(value) * step;
    length_ = value == model.last() ? length_ - low : model.low(value + 1) * step - low;
    add(low);
    model.count(value);
  }
  void bit(BitModel& model, bool value) {
    const std::uint32_t low = model.zero_probability() * (length_ >> kBitShift);
    length_ = value ? length_ - low : low;
    add(value ? low : 0);
    model.count(value);
  }
  void raw(int bits, std::uint32_t value) {
    if (bits > 19) {  // keeps the interval wide enough
      raw(16, value & 0xffffu);
      value >>= 16;
      bits -= 16;
    }
    length_ >>= bits;
    add(value * length_);
  }
  std::vector<std::uint8_t> finish() {
    // The shortest number inside the interval, then the bytes a decoder reads ahead.
    const bool wide = length_ > 2 * kMinLength;
    length_ = wide ? kMinLength >> 1 : kMinLength >> 9;
    add(wide ? kMinLength : kMinLength >> 1);
    bytes_.insert(bytes_.end(), wide ? 3 : 2, 0);
    return std::move(bytes_);
  }

 private:
  void add(std::uint32_t low) {
    const std::uint32_t before = base_;
    base_ += low;
    if (before > base_) carry();
    for (; length_ < kMinLength; length_ <<= 8) {
      bytes_.push_back(static_cast<std::uint8_t>(base_ >> 24));
      base_ <<= 8;
    }
  }
  void carry() {
    std::size_t i = bytes_.size();
    while (i > 0 && bytes_[i - 1] == 0xff) bytes_[--i] = 0;
    if (i > 0) ++bytes_[i - 1];
  }

  std::uint32_t base_ = 0;
  std::uint32_t length_ = 0xffffffffu;
  std::vector<std::uint8_t> bytes_;
};

class Decoder {
 public:
  explicit Decoder(std::span<const std::uint8_t> bytes) : bytes_(bytes) {
    for (int i = 0; i < 4; ++i) value_ = value_ << 8 | next_byte();
  }
  /// True where more bytes were needed than there are.
  bool overran() const { return overran_; }

  std::uint32_t symbol(SymbolModel& model) {
    const std::uint32_t step = length_ >> kSymbolShift;
    std::uint32_t low = 0;
    std::uint32_t high = model.last() + 1;
    while (high - low > 1) {
      const std::uint32_t middle = (low + high) / 2;
      (model.low(middle) * step > value_ ? high : low) = middle;
    }
    const std::uint32_t start = model.low(low) * step;
    length_ = low == model.last() ? length_ - start : model.low(low + 1) * step - start;
    take(start);
    model.count(low);
    return low;
  }
  bool bit(BitModel& model) {
    const std::uint32_t start = model.zero_probability() * (length_ >> kBitShift);
    const bool value = value_ >= start;
    length_ = value ? length_ - start : start;
    take(value ? start : 0);
    model.count(value);
    return value;
  }
  std::uint32_t raw(int bits) {
    if (bits > 19) {
      const std::uint32_t lower = raw(16);
      return raw(bits - 16) << 16 | lower;
    }
    length_ >>= bits;
    const std::uint32_t value = value_ / length_;
    take(value * length_);
    return value;
  }

 private:
  void take(std::uint32_t start) {
    value_ -= start;
    // A corrupt stream can leave the interval empty; stop instead of shifting 0 for ever.
    if (length_ == 0) {
      overran_ = true;
      length_ = 0xffffffffu;
    }
    for (; length_ < kMinLength; length_ <<= 8) value_ = value_ << 8 | next_byte();
  }
  std::uint32_t next_byte() {
    if (at_ < bytes_.size()) return bytes_[at_++];
    overran_ = true;
    return 0;
  }

  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
  std::uint32_t value_ = 0;
  std::uint32_t length_ = 0xffffffffu;
  bool overran_ = false;
};

/// Models of one table: which interval a correction falls in (one model for the counts, one for
/// the bytes), and where in it (shared).
struct IntegerModels {
  IntegerModels() {
    for (std::uint32_t k = 1; k < 32; ++k) upper.emplace_back(1u << std::min<int>(k, kBitsHigh));
  }
  SymbolModel& upper_of(std::uint32_t k) { return upper[k - 1]; }

  std::array<SymbolModel, 2> interval{SymbolModel(33), SymbolModel(33)};
  BitModel zero_or_one;            // interval 0 holds the corrections 0 and 1
  std::vector<SymbolModel> upper;  // intervals 1 to 31
};

void encode_integer(Encoder& encoder, IntegerModels& models, std::size_t context,
                    std::uint32_t predicted, std::uint32_t actual) {
  const auto correction = static_cast<std::int32_t>(actual - predicted);
  // Interval k holds -(2^k - 1) ... -2^(k-1) and 2^(k-1) + 1 ... 2^k.
  std::uint32_t magnitude = correction <= 0 ? 0u - static_cast<std::uint32_t>(correction)
                                            : static_cast<std::uint32_t>(correction) - 1;
  std::uint32_t k = 0;
  for (; magnitude != 0; magnitude >>= 1) ++k;
  encoder.symbol(models.interval[context], k);
  if (k == 0) return encoder.bit(models.zero_or_one, correction != 0);
  if (k == 32) return;  // only the smallest 32-bit integer
  auto position = static_cast<std::uint32_t>(correction);
  position += correction < 0 ? (1u << k) - 1 : 0u - 1u;
  const int lower = static_cast<int>(k) - kBitsHigh;
  if (lower <= 0) return encoder.symbol(models.upper_of(k), position);
  encoder.symbol(models.upper_of(k), position >> lower);
  encoder.raw(lower, position & ((1u << lower) - 1));
}

std::uint32_t decode_integer(Decoder& decoder, IntegerModels& models, std::size_t context,
                             std::uint32_t predicted) {
  const std::uint32_t k = decoder.symbol(models.interval[context]);
  if (k == 0) return predicted + (decoder.bit(models.zero_or_one) ? 1 : 0);
  if (k == 32) return predicted + 0x80000000u;
  std::uint32_t position = decoder.symbol(models.upper_of(k));
  const int lower = static_cast<int>(k) - kBitsHigh;
  if (lower > 0) position = position << lower | decoder.raw(lower);
  return predicted + (position >= (1u << (k - 1)) ? position + 1 : position - ((1u << k) - 1));
}

}  // namespace

std::vector<std::uint8_t> encode_chunk_table(std::span<const LazChunk> chunks, bool with_counts) {
  std::vector<std::uint8_t> table;
  append_le<std::uint32_t>(table, 0);
  append_le<std::uint32_t>(table, static_cast<std::uint32_t>(chunks.size()));
  if (chunks.empty()) return table;
  Encoder encoder;
  IntegerModels models;
  LazChunk before;
  for (const LazChunk& chunk : chunks) {
    if (with_counts) encode_integer(encoder, models, 0, before.points, chunk.points);
    encode_integer(encoder, models, 1, before.bytes, chunk.bytes);
    before = chunk;
  }
  const std::vector<std::uint8_t> coded = encoder.finish();
  table.insert(table.end(), coded.begin(), coded.end());
  return table;
}

std::optional<std::vector<LazChunk>> decode_chunk_table(std::span<const std::uint8_t> bytes,
                                                        bool with_counts, std::size_t most_chunks) {
  if (bytes.size() < kTableHead || load_le<std::uint32_t>(bytes, 0) != 0) return std::nullopt;
  const std::size_t count = load_le<std::uint32_t>(bytes, 4);
  if (count > most_chunks) return std::nullopt;
  std::vector<LazChunk> chunks(count);
  if (count == 0) return chunks;
  Decoder decoder(bytes.subspan(kTableHead));
  IntegerModels models;
  LazChunk before;
  for (LazChunk& chunk : chunks) {
    if (with_counts) chunk.points = decode_integer(decoder, models, 0, before.points);
    chunk.bytes = decode_integer(decoder, models, 1, before.bytes);
    if (decoder.overran()) return std::nullopt;
    before = chunk;
  }
  return chunks;
}

}  // namespace cornice
