// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>

#include "core/base/error.h"
#include "core/geo/file_crs.h"
#include "core/io/ply.h"
#include "core/io/ply_header.h"
#include "core/io/ply_stream.h"
#include "stages/info/examine.h"
#include "stages/info/wording.h"

namespace cornice::info {
namespace {

constexpr std::uint64_t kReportEvery = 1'000'000;
constexpr float kUnitTolerance = 1e-3f;

/// Where the values of a vertex stand among its properties.
struct VertexLayout {
  std::optional<std::size_t> x, y, z, nx, ny, nz;

  explicit VertexLayout(const PlyElement& vertex)
      : x(vertex.find({"x"})),
        y(vertex.find({"y"})),
        z(vertex.find({"z"})),
        nx(vertex.find({"nx", "normal_x"})),
        ny(vertex.find({"ny", "normal_y"})),
        nz(vertex.find({"nz", "normal_z"})) {}
  bool has_position() const { return x && y && z; }
  bool has_normals() const { return nx && ny && nz; }
};

void add_vertex(const std::vector<double>& values, const VertexLayout& layout, PlyFacts& facts) {
  if (layout.has_position()) {
    const Vec3d p{values[*layout.x], values[*layout.y], values[*layout.z]};
    if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)) {
      facts.bounds.add(facts.header.origin + p);
    } else {
      ++facts.not_finite;
    }
  }
  if (layout.has_normals()) {
    const double length = norm(Vec3d{values[*layout.nx], values[*layout.ny], values[*layout.nz]});
    facts.normals_not_unit += std::abs(length - 1.0) <= kUnitTolerance ? 0 : 1;
  }
}

void read_vertices(PlyStream& stream, const PlyElement& vertex, PlyFacts& facts,
                   Progress& progress) {
  const VertexLayout layout(vertex);
  facts.has_normals = layout.has_normals();
  std::vector<double> values(vertex.properties.size());
  for (std::uint64_t i = 0; i < vertex.count; ++i) {
    stream.at(vertex.name, i);
    for (std::size_t k = 0; k < vertex.properties.size(); ++k) {
      const PlyProperty& property = vertex.properties[k];
      if (property.is_list()) {
        stream.skip(property);
      } else {
        values[k] = stream.number(property.type);
      }
    }
    add_vertex(values, layout, facts);
    if (i % kReportEvery == kReportEvery - 1) {
      check_cancelled(progress);
      progress.advance(kReportEvery);
    }
  }
}

}  // namespace

PlyFacts examine_ply(const std::filesystem::path& path, const ExamineOptions& options,
                     Progress& progress) {
  PlyFacts facts;
  facts.header = read_ply_info(path);
  const PlyHeader header = read_ply_header(path);
  if (!options.crs_text.empty()) {
    facts.crs = crs_from_text(options.crs_text);
  } else if (!facts.header.crs_text.empty()) {
    facts.crs = crs_of_file(path, facts.header.crs_text);
  }
  PlyStream stream(path, header);
  for (const PlyElement& element : header.elements) {
    if (element.name == "face") facts.faces = element.count;
    if (element.name == "vertex") facts.vertices = element.count;
  }
  // Only elements before the vertices have to be passed over.
  for (const PlyElement& element : header.elements) {
    if (element.name == "vertex") {
      progress.begin("vertices", element.count);
      read_vertices(stream, element, facts, progress);
      progress.end();
      break;
    }
    for (std::uint64_t i = 0; i < element.count; ++i) {
      stream.at(element.name, i);
      for (const PlyProperty& property : element.properties) stream.skip(property);
    }
  }
  return facts;
}

std::vector<Defect> find_defects(const PlyFacts& facts) {
  std::vector<Defect> defects;
  const auto add = [&](const char* id, std::string text) {
    defects.push_back({id, std::move(text)});
  };
  if (facts.vertices == 0) add("empty", "the file has no vertices");
  if (facts.not_finite > 0) {
    add("not_finite", counted(facts.not_finite, "vertex position") + " are no numbers");
  }
  if (facts.normals_not_unit > 0) {
    add("normals_not_unit", counted(facts.normals_not_unit, "normal") + " are not of length 1");
  }
  if (facts.crs.empty()) {
    add("crs_missing", "no coordinate reference system (comment cornice crs); give it with --crs");
  }
  const double far = std::max(std::abs(facts.bounds.min.x - facts.header.origin.x),
                              std::abs(facts.bounds.max.y - facts.header.origin.y));
  constexpr double kFloatLimit = 1e5;  // floats beyond it are coarser than 1 cm
  if (!facts.bounds.empty() && far > kFloatLimit) {
    add("far_from_origin",
        "positions reach " + shortest(far, 6) + " from their origin: as floats they are coarse");
  }
  return defects;
}

}  // namespace cornice::info
