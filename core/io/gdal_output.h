// SPDX-License-Identifier: GPL-3.0-or-later
// What writing rasters through GDAL shares. For .cpp files that use GDAL.
#pragma once

#include <cpl_string.h>
#include <gdal.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/io/gdal_messages.h"

namespace cornice {

struct StringListDeleter {
  void operator()(char** list) const { CSLDestroy(list); }
};
using StringList = std::unique_ptr<char*, StringListDeleter>;

/// Options as GDAL takes them, "NAME=VALUE" each.
StringList string_list(const std::vector<std::string>& lines);

/// Throws RunError where this GDAL lacks it.
GDALDriverH gdal_driver(const char* name);

/// Writes a dataset as a cloud-optimised GeoTIFF (DEFLATE, predictor 3, tiles of 512 pixels,
/// averaged overviews) to `path`. Throws RunError about `target` where it cannot be written.
void copy_to_cog(GDALDatasetH dataset, const std::filesystem::path& path,
                 const std::filesystem::path& target, const GdalMessages& messages);

}  // namespace cornice
