// SPDX-License-Identifier: GPL-3.0-or-later
// A whole survey: flies over a scene and writes tiles and truth.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/base/memory.h"
#include "core/base/progress.h"
#include "stages/simulate/scene.h"
#include "stages/simulate/survey_block.h"
#include "stages/simulate/survey_options.h"
#include "stages/simulate/truth.h"

namespace cornice::simulate {

/// A survey that can be flown: all that its points depend on. Refers to the scene.
struct Survey {
  /// Plans flight and pulse rate so that the tiles get the density asked for, by a thin trial
  /// flight. Throws UsageError where the options contradict each other or the scene.
  Survey(const SurveyOptions& options, const Scene& scene);
  Survey(const Survey&) = delete;
  Survey& operator=(const Survey&) = delete;

  SurveyOptions options;
  GroundRange ground;
  Trajectory trajectory;
  Scanner scanner;
  SurveySetup setup;  ///< refers to the members above
};

/// What was written.
struct SurveyResult {
  std::uint64_t pulses = 0;
  std::uint64_t points = 0;
  std::uint64_t virtual_points = 0;
  std::vector<LineTally> tallies;  ///< one per line
  std::vector<std::uint64_t> points_of_tile;
  std::vector<std::filesystem::path> files;  ///< relative to the folder
};

/// Part of the scene that a survey over `grid` can see.
Box2d scene_extent(const TileGrid& grid);

/// Flies, and writes the tiles into `folder` and the points' truth into folder/truth. The same
/// survey gives the same bytes with any number of threads.
SurveyResult fly_survey(const Survey& survey, const std::filesystem::path& folder, int threads,
                        MemoryBudget& memory, Progress& progress = no_progress());

/// Writes what is true of the survey beside the points: lines, trajectory, ground, parameters.
/// Adds its files to result.files; truth/survey.json comes last and says that all is there.
void write_survey_truth(const Survey& survey, const std::filesystem::path& folder,
                        SurveyResult& result, Progress& progress = no_progress());

/// Removes the files of an earlier survey in `folder`, those that its truth/survey.json lists.
void remove_earlier_survey(const std::filesystem::path& folder);

/// Takes away, at its end, the folders that a failed survey made and left empty.
class EmptyFolderRemover {
 public:
  explicit EmptyFolderRemover(std::filesystem::path folder);
  ~EmptyFolderRemover();
  EmptyFolderRemover(const EmptyFolderRemover&) = delete;
  EmptyFolderRemover& operator=(const EmptyFolderRemover&) = delete;

 private:
  std::filesystem::path folder_;
  bool was_there_;
};

}  // namespace cornice::simulate
