// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/io/gdal_output.h"

#include <mutex>

#include "core/base/error.h"
#include "core/geo/gdal_handles.h"

namespace cornice {

StringList string_list(const std::vector<std::string>& lines) {
  char** list = nullptr;
  for (const std::string& line : lines) list = CSLAddString(list, line.c_str());
  return StringList(list);
}

GDALDriverH gdal_driver(const char* name) {
  static std::once_flag once;
  std::call_once(once, [] { GDALAllRegister(); });
  GDALDriverH found = GDALGetDriverByName(name);
  if (found == nullptr) throw RunError(name, "this GDAL has no such driver; install libgdal-dev");
  return found;
}

void copy_to_cog(GDALDatasetH dataset, const std::filesystem::path& path,
                 const std::filesystem::path& target, const GdalMessages& messages) {
  const StringList options =
      string_list({"COMPRESS=DEFLATE", "PREDICTOR=FLOATING_POINT", "BLOCKSIZE=512",
                   "OVERVIEW_RESAMPLING=AVERAGE", "BIGTIFF=IF_SAFER", "NUM_THREADS=1"});
  DatasetPtr written(GDALCreateCopy(gdal_driver("COG"), path.c_str(), dataset, FALSE, options.get(),
                                    nullptr, nullptr));
  const bool is_there = written != nullptr;
  written.reset();
  // GDAL tells of a full disk at the end, and only so.
  if (is_there && messages.tail().empty()) return;
  throw RunError(target.string(), "cannot be written" + messages.tail());
}

}  // namespace cornice
