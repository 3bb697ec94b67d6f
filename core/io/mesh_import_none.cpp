// SPDX-License-Identifier: GPL-3.0-or-later
// In place of mesh_import.cpp where OpenMesh is not there.
#include "core/base/error.h"
#include "core/io/mesh_import.h"

namespace cornice {

bool can_import_meshes() { return false; }

ImportedMesh import_mesh(const std::filesystem::path& path, const std::string&) {
  throw InputError(path.string(), "needs OpenMesh, which this program was built without");
}

}  // namespace cornice
