// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/trim/trim.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/mesh/select.h"
#include "core/mesh/topology.h"
#include "stages/trim/closing.h"

namespace cornice::trim {
namespace {

constexpr std::size_t kGrain = std::size_t{1} << 16;

std::vector<std::uint8_t> measured_vertices(const Mesh& mesh, const Options& options) {
  const std::vector<float>* support = find_float_property(mesh, "support");
  const std::vector<float>* density = find_float_property(mesh, "density");
  if (support == nullptr) {
    throw InputError("", "the mesh has no vertex property \"support\"; give the measured points");
  }
  std::vector<std::uint8_t> measured(mesh.positions.size());
  parallel_for(measured.size(), kGrain, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      double limit = options.max_support_m;
      if (density != nullptr && (*density)[v] > 0.0f) {
        const double spacing = 1.0 / std::sqrt(static_cast<double>((*density)[v]));
        limit = std::min(limit, std::max(options.min_support_m, options.spacings * spacing));
      }
      measured[v] = (*support)[v] <= limit;  // false where support is not a number
    }
  });
  return measured;
}

/// What holds each vertex up, if it is kept.
std::vector<std::uint8_t> vertex_sources(const std::vector<std::uint8_t>& measured,
                                         const std::vector<std::uint8_t>& on_model) {
  std::vector<std::uint8_t> sources(measured.size());
  for (std::size_t v = 0; v < sources.size(); ++v) {
    const bool model = !on_model.empty() && on_model[v] != 0;
    const Source source = measured[v] != 0 ? Source::kMeasured
                          : model          ? Source::kModel
                                           : Source::kBridged;
    sources[v] = static_cast<std::uint8_t>(source);
  }
  return sources;
}

/// One byte per triangle.
std::vector<std::uint8_t> choose_triangles(const Mesh& mesh,
                                           const std::vector<std::uint32_t>& twins,
                                           const std::vector<Fate>& fates) {
  std::vector<std::uint8_t> choice(mesh.triangles.size());
  const auto kept = [&](std::uint32_t v) { return fates[v] != Fate::kDropped; };
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const Triangle& c = mesh.triangles[t];
    // The tile next door has a border edge too, and knows no more of it than its two ends.
    bool keep = true, at_border = false;
    for (std::uint32_t k = 0; k < 3; ++k) {
      if (twins[3 * t + k] != kOpenEdge) continue;
      at_border = true;
      keep = keep && kept(c[k]) && kept(c[(k + 1) % 3]);
    }
    if (!at_border) keep = kept(c[0]) && kept(c[1]) && kept(c[2]);
    choice[t] = keep;
  }
  return choice;
}

/// Drops parts that are small and do not reach the open border of the whole, where they may go on.
void drop_small_parts(const Mesh& mesh, const std::vector<std::uint32_t>& twins,
                      const Options& options, std::vector<std::uint8_t>& keep, Counts& counts) {
  std::vector<std::uint32_t> inner = twins;
  for (std::size_t h = 0; h < inner.size(); ++h) {
    if (keep[h / 3] == 0 || (inner[h] < kNoTwin && keep[inner[h] / 3] == 0)) inner[h] = kOpenEdge;
  }
  std::uint32_t count = 0;
  const std::vector<std::uint32_t> part = triangle_components(mesh.triangles, inner, count);
  std::vector<double> area(count, 0.0);
  std::vector<std::uint8_t> goes_on(count, 0);
  for (std::size_t t = 0; t < keep.size(); ++t) {
    if (keep[t] == 0) continue;
    area[part[t]] += triangle_area(mesh, mesh.triangles[t]);
    for (std::size_t h = 3 * t; h < 3 * t + 3; ++h) {
      if (twins[h] == kOpenEdge) goes_on[part[t]] = 1;
    }
  }
  const auto is_small = [&](std::uint32_t p) {
    return goes_on[p] == 0 && area[p] > 0.0 && area[p] < options.min_area_m2;
  };
  for (std::uint32_t p = 0; p < count; ++p) counts.small_parts += is_small(p);
  for (std::size_t t = 0; t < keep.size(); ++t) {
    if (keep[t] != 0 && is_small(part[t])) keep[t] = 0;
  }
}

/// Gives every fan of triangles a vertex of its own where two fans met in a point.
std::uint64_t split_touching_vertices(Mesh& mesh, int threads) {
  const auto twins = match_half_edges(mesh.triangles, mesh.positions.size(), threads);
  std::vector<std::uint8_t> bad;
  border_vertices(mesh.triangles, twins, mesh.positions.size(), &bad);
  std::vector<std::uint32_t> rows(mesh.positions.size());
  for (std::uint32_t v = 0; v < rows.size(); ++v) rows[v] = v;
  std::vector<std::uint8_t> has_fan(mesh.positions.size(), 0);
  std::vector<Triangle> triangles = mesh.triangles;
  for (std::uint32_t h = 0; h < twins.size(); ++h) {
    const std::uint32_t v = mesh.triangles[h / 3][h % 3];
    if (bad[v] == 0 || twins[h] != kOpenEdge) continue;
    // An open edge that leaves v starts a fan.
    if (has_fan[v] == 0) {
      has_fan[v] = 1;
      continue;
    }
    const auto copy = static_cast<std::uint32_t>(rows.size());
    rows.push_back(v);
    for (std::uint32_t g = h; g < kNoTwin; g = twins[previous_half_edge(g)]) {
      triangles[g / 3][g % 3] = copy;
    }
  }
  const std::uint64_t added = rows.size() - mesh.positions.size();
  if (added == 0) return 0;
  Mesh split = gather_vertices(mesh, rows);
  split.triangles = std::move(triangles);
  mesh = std::move(split);
  return added;
}

void count_sources(const Mesh& mesh, const std::vector<std::uint8_t>& sources, Counts& counts) {
  for (const std::uint8_t source : sources) {
    counts.measured_vertices += source == static_cast<std::uint8_t>(Source::kMeasured);
    counts.bridged_vertices += source == static_cast<std::uint8_t>(Source::kBridged);
    counts.model_vertices += source == static_cast<std::uint8_t>(Source::kModel);
  }
  for (const Triangle& t : mesh.triangles) {
    const double area = triangle_area(mesh, t);
    const auto worst = static_cast<Source>(std::max({sources[t[0]], sources[t[1]], sources[t[2]]}));
    counts.area_m2 += area;
    if (worst == Source::kBridged) counts.bridged_area_m2 += area;
    if (worst == Source::kModel) counts.model_area_m2 += area;
  }
}

}  // namespace

Result trim(const Mesh& mesh, const Options& options, const std::vector<std::uint8_t>& on_model,
            Progress& progress) {
  Result result;
  Counts& counts = result.counts;
  const std::vector<std::uint8_t> measured = measured_vertices(mesh, options);
  const std::vector<std::uint8_t> sources = vertex_sources(measured, on_model);
  std::vector<std::uint8_t> held(sources.size());
  std::transform(sources.begin(), sources.end(), held.begin(), [](std::uint8_t s) {
    return std::uint8_t{s != static_cast<std::uint8_t>(Source::kBridged)};
  });
  const double bridge_m =
      on_model.empty() ? options.bridge_m : std::max(options.bridge_m, kModelBridgeM);
  const auto twins = match_half_edges(mesh.triangles, mesh.positions.size(), options.threads);
  check_cancelled(progress);
  const std::vector<Fate> fates =
      judge_vertices(mesh.positions, mesh.triangles, twins, held, bridge_m);
  check_cancelled(progress);
  std::vector<std::uint8_t> keep = choose_triangles(mesh, twins, fates);
  for (std::size_t t = 0; t < keep.size(); ++t) {
    if (keep[t] != 0) continue;
    ++counts.dropped_triangles;
    counts.dropped_area_m2 += triangle_area(mesh, mesh.triangles[t]);
  }
  drop_small_parts(mesh, twins, options, keep, counts);
  std::vector<std::uint32_t> rows;
  result.mesh = select_triangles(mesh, keep, &rows);
  std::erase_if(result.mesh.byte_properties, [](const auto& p) { return p.name == "source"; });
  ByteProperty source{"source", {}};
  for (const std::uint32_t row : rows) source.values.push_back(sources[row]);
  count_sources(result.mesh, source.values, counts);
  result.mesh.byte_properties.push_back(std::move(source));
  counts.split_vertices = split_touching_vertices(result.mesh, options.threads);
  return result;
}

}  // namespace cornice::trim
