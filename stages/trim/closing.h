// SPDX-License-Identifier: GPL-3.0-or-later
// Which unmeasured vertices of a surface are kept: the gaps that measured surface encloses.
#pragma once

#include <cstdint>
#include <vector>

#include "core/mesh/topology.h"

namespace cornice::trim {

/// What becomes of a vertex.
enum class Fate : std::uint8_t { kDropped = 0, kMeasured = 1, kBridged = 2 };

/// Judges the vertices of a surface. measured: one byte per vertex. twins: of the half-edges.
std::vector<Fate> judge_vertices(const std::vector<Vec3f>& positions,
                                 const std::vector<Triangle>& triangles,
                                 const std::vector<std::uint32_t>& twins,
                                 const std::vector<std::uint8_t>& measured, double bridge_m);

}  // namespace cornice::trim
