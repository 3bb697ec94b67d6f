// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/stitch/output.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/io/ply.h"
#include "stages/stitch/merged_ply.h"

namespace cornice::stitch {
namespace {

namespace fs = std::filesystem;

/// One file per tile.
class TileFolder : public Output {
 public:
  TileFolder(fs::path folder, std::string format)
      : folder_(std::move(folder)), format_(std::move(format)) {}

  void add(const fs::path& path, EditedTile& tile) override {
    write_ply(folder_ / (path.stem().string() + "." + format_), tile.mesh);
  }

 private:
  fs::path folder_;
  std::string format_;
};

class OnePly : public Output {
 public:
  OnePly(const fs::path& path, const Survey& survey, Vec3d origin, double largest_m)
      : ply_(path, origin, survey.crs_text, largest_m, survey.borders.vertex_count()) {}
  void add(const fs::path&, EditedTile& tile) override { ply_.add(tile); }
  void finish() override { ply_.commit(); }

 private:
  MergedPly ply_;
};

/// Whole metres in the middle of the survey, at its lowest: the origin of one mesh.
Vec3d survey_origin(const Survey& survey) {
  if (survey.box.empty()) return {};
  const Vec3d middle = (survey.box.min + survey.box.max) * 0.5;
  return {std::round(middle.x), std::round(middle.y), std::floor(survey.box.min.z)};
}

double largest_from(const Survey& survey, Vec3d origin) {
  if (survey.box.empty()) return 0.0;
  const Vec3d low = survey.box.min - origin, high = survey.box.max - origin;
  return std::max({std::abs(low.x), std::abs(low.y), std::abs(low.z), std::abs(high.x),
                   std::abs(high.y), std::abs(high.z)});
}

}  // namespace

std::unique_ptr<Output> open_output(const Command& command, const Survey& survey) {
  const std::string extension = command.mesh_extension();
  if (extension.empty()) return std::make_unique<TileFolder>(command.output, command.format);
  const Vec3d origin = survey_origin(survey);
  return std::make_unique<OnePly>(command.output, survey, origin, largest_from(survey, origin));
}

std::uint64_t bytes_of_largest(const std::vector<fs::path>& tiles) {
  // The mesh, its edges and the twins of its half-edges.
  constexpr std::uint64_t kBytesPerTriangle = 80;
  std::uint64_t most = 0;
  for (const fs::path& tile : tiles) {
    for (const PlyInfo::Element& element : read_ply_info(tile).elements) {
      if (element.name == "face") most = std::max(most, element.count * kBytesPerTriangle);
    }
  }
  return most;
}

}  // namespace cornice::stitch
