// SPDX-License-Identifier: GPL-3.0-or-later
// What the fuzzer and the mutation test throw bytes at.
#pragma once

#include <cstdint>
#include <span>

namespace cornice::test {

/// Parses the bytes as a LAS, LAZ or COPC file (header, records, chunk table, octree) and as a .lax
/// index. Returns true where they pass for a point file. Aborts where a promise of the parsers is
/// broken; an InputError is no broken promise.
bool parse_hostile_bytes(std::span<const std::uint8_t> bytes);

}  // namespace cornice::test
