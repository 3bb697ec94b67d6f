// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/small_files.h"

#include <cpl_vsi.h>

#include <fstream>
#include <iterator>
#include <stdexcept>

#include "tests/property/las_writer/clouds.h"
#include "tests/support/temporary_folder.h"

namespace cornice::test {

Bytes read_file(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void write_file(const std::filesystem::path& path, const Bytes& bytes) {
  std::ofstream stream(path, std::ios::binary);
  stream.write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
  if (!stream) throw std::runtime_error("cannot write " + path.string());
}

Bytes point_file(const LasWriteOptions& options, std::size_t count) {
  const TemporaryFolder folder;
  const auto path = folder / (options.compress ? "points.laz" : "points.las");
  LasWriter writer(path, options);
  writer.write(sample_cloud(count, options, 1));
  writer.close();
  return read_file(path);
}

void write_zip(const std::filesystem::path& path,
               const std::vector<std::pair<std::string, Bytes>>& members) {
  const std::string root = "/vsizip/" + path.string();
  VSILFILE* archive = VSIFOpenL(root.c_str(), "wb");  // open while its members are written
  for (const auto& [name, bytes] : members) {
    VSILFILE* file = VSIFOpenL((root + "/" + name).c_str(), "wb");
    if (file == nullptr) throw std::runtime_error("cannot write " + path.string());
    VSIFWriteL(bytes.data(), 1, bytes.size(), file);
    VSIFCloseL(file);
  }
  if (archive != nullptr) VSIFCloseL(archive);
}

Bytes cut(Bytes bytes, std::size_t count) {
  bytes.resize(std::min(count, bytes.size()));
  return bytes;
}

}  // namespace cornice::test
