// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/fuzz/las_seeds.h"

#include "tests/property/las_writer/clouds.h"
#include "tests/support/temporary_folder.h"

namespace cornice::test {
namespace {

LasWriteOptions options_of(int format, bool compress) {
  LasWriteOptions options;
  options.point_format = format;
  options.version_minor = 4;
  options.compress = compress;
  options.chunk_points = 7;
  options.extra_bytes = sample_extra_bytes();
  const std::string wkt = "PROJCS[\"made up\"]";
  options.vlrs.push_back({"LASF_Projection", 2112, "", {wkt.begin(), wkt.end()}, false});
  options.vlrs.push_back({"somebody", 1, "behind the points", Bytes(40, 7), true});
  return options;
}

}  // namespace

std::vector<std::pair<std::string, Bytes>> las_seeds() {
  std::vector<std::pair<std::string, Bytes>> seeds;
  for (const int format : {0, 1, 3, 5, 6, 8, 10}) {
    for (const bool compress : {false, true}) {
      const std::string name = std::string(compress ? "laz" : "las") + std::to_string(format);
      seeds.emplace_back(name, point_file(options_of(format, compress), 20));
    }
  }
  LasWriteOptions old = options_of(1, false);
  old.version_minor = 2;
  old.vlrs.clear();
  old.extra_bytes.clear();
  seeds.emplace_back("las12", point_file(old, 3));
  const TemporaryFolder folder;
  LasWriteOptions copc;
  write_copc(folder / "a.copc.laz", sample_cloud(300, copc, 1), copc);
  seeds.emplace_back("copc", read_file(folder / "a.copc.laz"));
  LasWriteOptions indexed = options_of(6, true);
  indexed.spatial_index = true;
  LasWriter writer(folder / "a.laz", indexed);
  writer.write(sample_cloud(1000, indexed, 1, 100.0));
  writer.close();
  seeds.emplace_back("lax", read_file(folder / "a.lax"));
  return seeds;
}

}  // namespace cornice::test
