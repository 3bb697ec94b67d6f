// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled with normals=one_version and CORNICE_ONE_VERSION, as are the sources it calls.
#include "tests/unit/normals/one_version.h"

#include "stages/normals/morton_order.h"
#include "stages/normals/orient.h"

namespace cornice::test {

PlainOrientation orient_without_clones(const std::vector<Vec3f>& positions,
                                       const std::vector<Vec3f>& beams) {
  const one_version::MortonOrder sorted = one_version::sort_along_curve(positions, 1);
  const one_version::PointTree tree(positions, sorted.keys, 1);
  const one_version::Beams all{beams,
                               std::vector<BeamSource>(positions.size(), BeamSource::kTrajectory)};
  one_version::OrientOptions options;
  options.threads = 1;
  const one_version::OrientedNormals found = orient_normals(tree, all, options);
  PlainOrientation plain{found.normals, found.quality, {}};
  for (const one_version::SettledBy by : found.settled_by) {
    plain.settled_by.push_back(static_cast<std::uint8_t>(by));
  }
  return plain;
}

}  // namespace cornice::test
