// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/extract.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/base/random.h"
#include "hlod/octahedral.h"

namespace cornice::hlod {
namespace {

/// Blocks read at one time.
constexpr std::size_t kBatch = 256;

struct PointHash {
  std::size_t operator()(const FinePoint& p) const {
    const auto word = [](std::int32_t x) { return std::uint64_t{static_cast<std::uint32_t>(x)}; };
    return mix64(mix64(word(p.x) | word(p.y) << 32) + word(p.z));
  }
};

/// A vertex to be: fine steps from the lattice's origin, and its attributes.
struct Corner {
  FinePoint position;
  Vec3f normal;
  std::array<float, 7> values{};  ///< support in metres, source, colour, texture in 0..1
};

Corner corner_of(const CellVertex& v, FinePoint position, int normal_bits) {
  return {position,
          decode_octahedral(v.normal, normal_bits),
          {static_cast<float>(v.support) * 0.01f, static_cast<float>(v.source),
           static_cast<float>(v.colour[0]), static_cast<float>(v.colour[1]),
           static_cast<float>(v.colour[2]), static_cast<float>(v.texture[0]) / 65535.0f,
           static_cast<float>(v.texture[1]) / 65535.0f}};
}

/// share of `own`, the rest of `parent`; a source has nothing in between.
Corner mix(const Corner& own, const Corner& parent, float share, FinePoint position) {
  Corner result;
  result.position = position;
  result.normal = normalized(share * own.normal + (1.0f - share) * parent.normal);
  for (std::size_t n = 0; n < own.values.size(); ++n) {
    result.values[n] = share * own.values[n] + (1.0f - share) * parent.values[n];
  }
  if (share < 0.5f) result.values[1] = parent.values[1];
  if (share >= 0.5f) result.values[1] = own.values[1];
  return result;
}

/// Collects cells into one mesh.
class MeshMaker {
 public:
  explicit MeshMaker(const File& file) : header_(file.header()) {
    mesh_.crs_text = header_.crs_text;
    const Vec3d low = file.bounds().min;
    mesh_.origin = {std::floor(low.x), std::floor(low.y), std::floor(low.z)};
  }

  void add(const std::vector<Corner>& corners,
           const std::vector<std::array<std::uint16_t, 3>>& triangles) {
    std::vector<std::uint32_t> number(corners.size());
    for (std::size_t c = 0; c < corners.size(); ++c) number[c] = number_of(corners[c]);
    for (const auto& t : triangles) {
      const std::array<std::uint32_t, 3> named{number[t[0]], number[t[1]], number[t[2]]};
      if (named[0] == named[1] || named[1] == named[2] || named[2] == named[0]) continue;
      mesh_.triangles.push_back(named);
    }
  }

  Mesh take() {
    add_property(kHasSupport, "support", 0);
    add_bytes(kHasSource, "source", 1);
    add_bytes(kHasColour, "red", 2);
    add_bytes(kHasColour, "green", 3);
    add_bytes(kHasColour, "blue", 4);
    add_property(kHasTexture, "s", 5);
    add_property(kHasTexture, "t", 6);
    return std::move(mesh_);
  }

 private:
  std::uint32_t number_of(const Corner& corner) {
    const auto [entry, is_new] =
        numbers_.emplace(corner.position, static_cast<std::uint32_t>(mesh_.positions.size()));
    if (!is_new) return entry->second;
    if (mesh_.positions.size() == 0xffffffffu) {
      throw InputError("", "has more vertices than one mesh holds; extract a coarser level");
    }
    const Vec3d at = header_.lattice.position(corner.position, header_.lattice.finest_level);
    mesh_.positions.push_back((at - mesh_.origin).cast<float>());
    mesh_.normals.push_back(corner.normal);
    values_.push_back(corner.values);
    return entry->second;
  }
  void add_property(std::uint32_t attribute, const std::string& name, std::size_t which) {
    if ((header_.attributes & attribute) == 0) return;
    mesh_.float_properties.push_back({name, {}});
    for (const auto& v : values_) mesh_.float_properties.back().values.push_back(v[which]);
  }
  void add_bytes(std::uint32_t attribute, const std::string& name, std::size_t which) {
    if ((header_.attributes & attribute) == 0) return;
    mesh_.byte_properties.push_back({name, {}});
    for (const auto& v : values_) {
      mesh_.byte_properties.back().values.push_back(static_cast<std::uint8_t>(v[which] + 0.5f));
    }
  }

  Header header_;
  Mesh mesh_;
  std::vector<std::array<float, 7>> values_;
  std::unordered_map<FinePoint, std::uint32_t, PointHash> numbers_;
};

/// Reads the nodes in parallel and hands them over in their order.
template <class Add>
void for_each_mesh(const File& file, const std::vector<std::uint32_t>& nodes, int threads,
                   Progress& progress, const Add& add) {
  progress.begin("reading cells", nodes.size());
  for (std::size_t first = 0; first < nodes.size(); first += kBatch) {
    check_cancelled(progress);
    std::vector<CellMesh> meshes(std::min(kBatch, nodes.size() - first));
    parallel_for(meshes.size(), 1, threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t n = begin; n < end; ++n) {
        meshes[n] = file.read(file.nodes()[nodes[first + n]]);
      }
    });
    for (const CellMesh& mesh : meshes) add(mesh);
    progress.advance(meshes.size());
  }
  progress.end();
}

}  // namespace

int level_for_error(const File& file, double error_m) {
  const int finest = file.header().lattice.finest_level;
  for (int level = 0; level < finest; ++level) {
    const LevelStatistics& s = file.levels()[static_cast<std::size_t>(level)];
    if (s.cells > 0 && s.error_max_m <= error_m) return level;
  }
  return finest;
}

Mesh extract_level(const File& file, int level, int threads, Progress& progress) {
  std::vector<std::uint32_t> nodes;
  for (std::uint32_t n = 0; n < file.nodes().size(); ++n) {
    if (file.nodes()[n].key.level == level) nodes.push_back(n);
  }
  MeshMaker maker(file);
  const int bits = file.header().normal_bits;
  const int finer = file.header().lattice.finest_level - level;
  for_each_mesh(file, nodes, threads, progress, [&](const CellMesh& mesh) {
    std::vector<Corner> corners;
    for (const CellVertex& v : mesh.vertices) {
      corners.push_back(corner_of(v, seen_from({}, v.position, finer), bits));
    }
    maker.add(corners, mesh.triangles);
  });
  return maker.take();
}

Mesh extract_view(const File& file, const Tree& tree, const Radii& radii, FinePoint eye,
                  int threads, Progress& progress) {
  Selection selection;
  select(tree, radii, eye, {}, selection);
  std::vector<std::uint32_t> nodes;
  for (const std::uint32_t c : selection.cells) {
    const TreeCell& cell = tree.cells[c];
    for (std::uint32_t n = 0; n < cell.parts; ++n) nodes.push_back(cell.first_node + n);
  }
  MeshMaker maker(file);
  const Metric& metric = tree.metric;
  const int bits = file.header().normal_bits;
  const std::int32_t slab = slab_distance(eye, metric);
  for_each_mesh(file, nodes, threads, progress, [&](const CellMesh& mesh) {
    std::vector<Corner> corners;
    const int level = mesh.key.level;
    const MorphBand band = level > 0 ? morph_band(radii, level, metric) : MorphBand{};
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
      const CellVertex& own = mesh.vertices[v];
      const FinePoint at = seen_from({}, own.position, metric.finest_level - level);
      corners.push_back(corner_of(own, at, bits));
      if (level == 0) continue;
      const CellVertex& parent = mesh.parents[mesh.parent_of[v]];
      const std::int32_t distance = eye_distance(at - eye, slab, metric.partition);
      const float share = static_cast<float>(morph_weight(distance, band)) / 32768.0f;
      const FinePoint place =
          morphed(own.position, parent.position, eye, slab, metric.partition, band) + eye;
      corners.back() = mix(corners.back(), corner_of(parent, {}, bits), share, place);
    }
    maker.add(corners, mesh.triangles);
  });
  return maker.take();
}

}  // namespace cornice::hlod
