// SPDX-License-Identifier: GPL-3.0-or-later
// The folder of a comparison: rasters, meshes, pictures, tables and the page.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "stages/compare/compare.h"
#include "stages/compare/view.h"

namespace cornice::compare {

/// What the property "difference" of coloured meshes holds where there is no counterpart: PLY files
/// of this program hold finite numbers only.
inline constexpr float kNoDifference = -9999.0f;

struct OutputOptions {
  std::filesystem::path folder;
  bool meshes = true;         ///< coloured ones
  double heading_deg = -1.0;  ///< of the views; below 0: towards the overhangs
};

/// A picture or drawing of the page.
struct Figure {
  std::string file;  ///< its name in the folder
  std::string caption;
};

/// Takes parts as they are measured, then the result. Files appear under their names one by one.
class Output {
 public:
  explicit Output(OutputOptions options) : options_(std::move(options)) {}

  void add(const MeasuredPart& part);
  /// Everything else. Returns what could not be done: "no font ...".
  std::vector<std::string> finish(const Result& result, const Options& options);
  const std::vector<std::filesystem::path>& files() const { return files_; }

 private:
  std::filesystem::path file(const std::string& name);
  void write_mesh(const MeasuredPart& part, const std::vector<Rgb>& colours);
  void draw(const MeasuredPart& part, const std::vector<Rgb>& colours);
  void write_pictures(const Result& result);
  void write_profiles(const Result& result);

  OutputOptions options_;
  std::vector<std::filesystem::path> files_;
  std::array<std::unique_ptr<View>, 2> distance_views_, overhang_views_;
  std::vector<Figure> figures_;
  bool has_text_ = true;
};

/// comparison.json, as docs/formats/comparison.md has it.
std::string comparison_json(const Result& result, const Options& options);
/// One row for each group of each measurement.
std::string statistics_csv(const Result& result, const Options& options);
std::string overhangs_csv(const Result& result);
void write_overhangs(const std::filesystem::path& path, const Result& result);
/// The page, with every figure in `folder` inside it.
std::string comparison_page(const Result& result, const Options& options,
                            const std::filesystem::path& folder,
                            const std::vector<Figure>& figures);

/// What was measured, in the order of the tables.
struct Measurement {
  std::string name;   ///< "vertical", "a_to_b", "b_to_a", "m3c2"
  std::string title;  ///< for people
  const Statistics* statistics;
  bool by_place;
};
std::vector<Measurement> measurements_of(const Result& result);

}  // namespace cornice::compare
