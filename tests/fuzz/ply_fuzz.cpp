// SPDX-License-Identifier: GPL-3.0-or-later
// Whatever the bytes, the PLY reader gives a valid mesh or throws InputError.
#include <sys/mman.h>
#include <unistd.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "core/base/error.h"
#include "core/io/ply.h"

namespace {

void require(bool good) {
  if (!good) std::abort();
}

void check(const cornice::Mesh& mesh) {
  for (const auto& p : mesh.positions) {
    require(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
  }
  require(mesh.normals.empty() || mesh.normals.size() == mesh.positions.size());
  for (const auto& property : mesh.float_properties) {
    require(property.values.size() == mesh.positions.size());
  }
  for (const auto& property : mesh.byte_properties) {
    require(property.values.size() == mesh.positions.size());
  }
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t corner : triangle) require(corner < mesh.positions.size());
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const int file = memfd_create("input", MFD_CLOEXEC);
  require(file >= 0);
  require(write(file, data, size) == static_cast<ssize_t>(size));
  const std::string path = "/proc/self/fd/" + std::to_string(file);
  try {
    check(cornice::read_ply_mesh(path));
  } catch (const cornice::InputError&) {
  }
  try {
    const cornice::OrientedPoints points = cornice::read_ply_points(path);
    require(points.normals.size() == points.positions.size());
    require(points.quality.empty() || points.quality.size() == points.positions.size());
    require(points.line_id.empty() || points.line_id.size() == points.positions.size());
  } catch (const cornice::InputError&) {
  }
  close(file);
  return 0;
}
