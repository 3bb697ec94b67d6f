// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/remesh/attributes.h"

#include "core/base/parallel.h"

namespace cornice::remesh {
namespace {

constexpr std::size_t kGrain = 4096;

/// A vertex of the result as a mean of three of the input.
struct Mixture {
  Triangle corners{};
  float weights[3] = {1.0f, 0.0f, 0.0f};

  float of(const std::vector<float>& values) const {
    return values[corners[0]] * weights[0] + values[corners[1]] * weights[1] +
           values[corners[2]] * weights[2];
  }
  std::uint32_t nearest_corner() const {
    int best = 0;
    for (int k = 1; k < 3; ++k) best = weights[k] > weights[best] ? k : best;
    return corners[best];
  }
};

Mixture mixture_at(const Reference& reference, const WorkMesh& work, std::uint32_t v) {
  Mixture m;
  const std::uint32_t source = work.source[v];
  if (source != kNoSource) {
    m.corners = {source, source, source};
    return m;
  }
  NearestQuery query;
  query.guess = work.hint[v];
  const NearestPoint near = reference.tree().nearest(work.positions[v], query);
  m.corners = reference.triangles()[near.triangle];
  m.weights[0] = 1.0f - near.u - near.v, m.weights[1] = near.u, m.weights[2] = near.v;
  return m;
}

}  // namespace

void transfer_attributes(const Mesh& input, const Reference& reference, const WorkMesh& work,
                         Mesh& result, int threads) {
  const std::size_t n = work.positions.size();
  result.normals.resize(input.normals.empty() ? 0 : n);
  for (const FloatProperty& p : input.float_properties) {
    result.float_properties.push_back({p.name, std::vector<float>(n)});
  }
  for (const ByteProperty& p : input.byte_properties) {
    result.byte_properties.push_back({p.name, std::vector<std::uint8_t>(n)});
  }
  parallel_for(n, kGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      const Mixture m = mixture_at(reference, work, static_cast<std::uint32_t>(v));
      if (!input.normals.empty()) {
        Vec3f sum{};
        for (int k = 0; k < 3; ++k) sum += input.normals[m.corners[k]] * m.weights[k];
        const bool exact = m.weights[0] == 1.0f || !(norm(sum) > 1e-6f);
        result.normals[v] = exact ? input.normals[m.nearest_corner()] : normalized(sum);
      }
      for (std::size_t p = 0; p < result.float_properties.size(); ++p) {
        const std::vector<float>& values = input.float_properties[p].values;
        result.float_properties[p].values[v] =
            m.weights[0] == 1.0f ? values[m.corners[0]] : m.of(values);
      }
      for (std::size_t p = 0; p < result.byte_properties.size(); ++p) {
        result.byte_properties[p].values[v] = input.byte_properties[p].values[m.nearest_corner()];
      }
    }
  });
}

}  // namespace cornice::remesh
