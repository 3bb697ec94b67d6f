// SPDX-License-Identifier: GPL-3.0-or-later
// Turns a dense mesh into few, well-shaped triangles that stay within a distance of it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/mesh/mesh.h"
#include "core/mesh/quality.h"

namespace cornice::remesh {

struct Options {
  double max_error_m = 0.05;  ///< two-sided distance between input and result
  double min_edge_m = 0.1;    ///< asked of edges; shorter ones stay where the error needs them
  double max_edge_m = 20.0;
  double grading = 0.35;  ///< growth of edge length per metre away from short edges
  int passes = 3;         ///< of splitting, collapsing, flipping and smoothing
  int threads = 0;
};

/// What a part of the work took, wall clock.
struct Step {
  std::string name;
  double seconds = 0.0;
};

/// What was measured on the result.
struct Figures {
  std::uint64_t input_triangles = 0;
  std::uint64_t decimated_triangles = 0;  ///< after the first, error-bounded collapse
  std::uint64_t dropped_triangles = 0;    ///< of the input: a vertex named twice, or a duplicate
  std::uint64_t fixed_vertices = 0;       ///< on borders and where the input is no manifold
  std::uint64_t bad_input_edges = 0;      ///< half-edges of edges that are no manifold
  int repair_rounds = 0;
  int attempts = 1;  ///< more than one: some of the input was kept as it is to keep the bound
  double input_to_result_m = 0.0;  ///< largest distance, samples about sample_spacing_m apart
  double result_to_input_m = 0.0;
  double sample_spacing_m = 0.0;
  QualityReport quality;        ///< of all triangles
  QualityReport inner_quality;  ///< of those without a fixed vertex
  std::vector<Step> steps;

  double hausdorff_m() const { return std::max(input_to_result_m, result_to_input_m); }
};

struct Result {
  Mesh mesh;
  Figures figures;
};

/// Attributes are taken from the nearest place of the input: floats and normals interpolated, bytes
/// of the nearest corner; border vertices keep theirs. Memory: about 120 bytes an input triangle.
/// The same bytes with any number of threads.
///
/// Garland, Heckbert 1997, "Surface simplification using quadric error metrics" (as half-edge
/// collapses); Botsch, Kobbelt 2004, "A remeshing approach to multiresolution modeling"; Dunyach et
/// al. 2013, "Adaptive remeshing for real-time mesh deformation".
Result remesh(const Mesh& mesh, const Options& options, Progress& progress = no_progress());

}  // namespace cornice::remesh
