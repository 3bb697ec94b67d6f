// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/codec_bytes.h"

// For ZSTD_c_literalCompressionMode.
#define ZSTD_STATIC_LINKING_ONLY
#include <zstd.h>

#include <algorithm>
#include <memory>
#include <new>

namespace cornice::hlod {
namespace {

/// How a stream is stored: the low two bits of the number before it; the others
/// are its length.
enum StreamKind : std::uint32_t { kZeros = 0, kPlain = 1, kZstd = 2 };

/// Residuals have few repeats but long runs of zeros: a search that looks harder finds what costs
/// more bytes and time than it saves. So matches are long, few places are remembered, and every
/// third byte is looked at.
constexpr int kLevel = 1, kLeastMatch = 7, kHashBits = 6, kStep = 2;
/// ZSTD_ps_enable, or ZSTD_lcm_huffman before zstd 1.5.1.
constexpr int kCompressLiterals = 1;

struct FreeContext {
  void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

ZSTD_CCtx* make_compressor() {
  ZSTD_CCtx* const context = ZSTD_createCCtx();
  if (context == nullptr) throw std::bad_alloc();
  // Values that every zstd takes.
  ZSTD_CCtx_setParameter(context, ZSTD_c_compressionLevel, kLevel);
  ZSTD_CCtx_setParameter(context, ZSTD_c_minMatch, kLeastMatch);
  ZSTD_CCtx_setParameter(context, ZSTD_c_hashLog, kHashBits);
  // Left to itself, zstd takes steps for a wish to leave alone what does not match.
  const std::size_t kept =
      ZSTD_CCtx_setParameter(context, ZSTD_c_literalCompressionMode, kCompressLiterals);
  if (!ZSTD_isError(kept)) ZSTD_CCtx_setParameter(context, ZSTD_c_targetLength, kStep);
  return context;
}

// Contexts take long to make beside streams of a few kilobytes, and carry
// nothing over.
ZSTD_CCtx* compressor() {
  thread_local const std::unique_ptr<ZSTD_CCtx, FreeContext> context(make_compressor());
  return context.get();
}
ZSTD_DCtx* decompressor() {
  thread_local const std::unique_ptr<ZSTD_DCtx, FreeContext> context(ZSTD_createDCtx());
  if (!context) throw std::bad_alloc();
  return context.get();
}

}  // namespace

void BlockWriter::zeros() { number(kZeros); }

void BlockWriter::number(std::uint32_t value) {
  for (; value >= 128; value >>= 7) block_.push_back(static_cast<std::byte>(value | 128));
  block_.push_back(static_cast<std::byte>(value));
}

void BlockWriter::signed_number(std::int32_t value) {
  number(zigzag(static_cast<std::uint32_t>(value)));
}

void BlockWriter::stream(std::span<const std::uint8_t> bytes) {
  if (std::all_of(bytes.begin(), bytes.end(), [](std::uint8_t b) { return b == 0; })) {
    zeros();
    return;
  }
  // Kept, for it would be filled with zeros for every stream.
  thread_local std::vector<std::uint8_t> packed;
  packed.resize(std::max(packed.size(), ZSTD_compressBound(bytes.size())));
  const std::size_t size =
      ZSTD_compress2(compressor(), packed.data(), packed.size(), bytes.data(), bytes.size());
  const bool pays = !ZSTD_isError(size) && size < bytes.size();
  const std::span<const std::uint8_t> stored =
      pays ? std::span<const std::uint8_t>(packed.data(), size) : bytes;
  number(static_cast<std::uint32_t>(stored.size() << 2) | (pays ? kZstd : kPlain));
  const auto* begin = reinterpret_cast<const std::byte*>(stored.data());
  block_.insert(block_.end(), begin, begin + stored.size());
}

void BlockReader::fail() {
  ok_ = false;
  rest_ = {};
}

std::uint32_t BlockReader::number() {
  std::uint32_t value = 0;
  for (int shift = 0; shift < 35; shift += 7) {
    if (rest_.empty()) break;
    const auto byte = static_cast<std::uint32_t>(rest_.front());
    rest_ = rest_.subspan(1);
    if (shift == 28 && byte > 15) break;
    value |= (byte & 127u) << shift;
    if (byte < 128) return value;
  }
  fail();
  return 0;
}

std::int32_t BlockReader::signed_number() { return static_cast<std::int32_t>(unzigzag(number())); }

bool BlockReader::stream(std::span<std::uint8_t> bytes) {
  const std::uint32_t head = number();
  const std::size_t size = head >> 2;
  if (ok_ && size <= rest_.size()) {
    if ((head & 3) == kPlain && size == bytes.size()) {
      std::transform(rest_.begin(), rest_.begin() + static_cast<std::ptrdiff_t>(size),
                     bytes.begin(), [](std::byte b) { return static_cast<std::uint8_t>(b); });
      rest_ = rest_.subspan(size);
      return true;
    }
    if ((head & 3) == kZstd) {
      const std::size_t got =
          ZSTD_decompressDCtx(decompressor(), bytes.data(), bytes.size(), rest_.data(), size);
      rest_ = rest_.subspan(size);
      if (!ZSTD_isError(got) && got == bytes.size()) return true;
    }
  }
  if (head != kZeros) fail();
  std::fill(bytes.begin(), bytes.end(), std::uint8_t{0});
  return false;
}

}  // namespace cornice::hlod
