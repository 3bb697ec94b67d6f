// SPDX-License-Identifier: GPL-3.0-or-later
// Looks into one file of any kind that Cornice reads or writes.
#pragma once

#include <filesystem>

#include "core/base/progress.h"
#include "stages/info/facts.h"

namespace cornice::info {

/// Everything about a file, read once from end to end with bounded memory. Throws InputError where
/// nothing can be said: no such file, a folder, no known format, a header that cannot be read.
/// Points that cannot be read to their end are a defect.
FileFacts examine(const std::filesystem::path& path, const ExamineOptions& options = {},
                  Progress& progress = no_progress());

/// The kinds by themselves.
PointFacts examine_points(const std::filesystem::path& path, const ExamineOptions& options,
                          Progress& progress);
PlyFacts examine_ply(const std::filesystem::path& path, const ExamineOptions& options,
                     Progress& progress);
RasterFacts examine_raster(const std::filesystem::path& path, const ExamineOptions& options,
                           Progress& progress);

/// What is wrong with a file of known facts, the gravest first.
std::vector<Defect> find_defects(const PointFacts& facts);
std::vector<Defect> find_defects(const PlyFacts& facts);
std::vector<Defect> find_defects(const RasterFacts& facts);

}  // namespace cornice::info
