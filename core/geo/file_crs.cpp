// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geo/file_crs.h"

#include "core/base/error.h"

namespace cornice {

Crs crs_of_file(const std::filesystem::path& file, const std::string& text) {
  try {
    return crs_from_text(text);
  } catch (const UsageError& error) {
    throw InputError(file.string(), "its CRS, " + error.problem());
  }
}

}  // namespace cornice
