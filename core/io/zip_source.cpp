// SPDX-License-Identifier: GPL-3.0-or-later
// The point file inside a .zip, read through GDAL's /vsizip without unpacking it to disk.
#include <cpl_string.h>
#include <cpl_vsi.h>

#include <algorithm>
#include <cctype>
#include <cstring>

#include "core/base/error.h"
#include "core/geo/gdal_handles.h"
#include "core/io/byte_source.h"

namespace cornice {
namespace {

class ZipSource : public ByteSource {
 public:
  ZipSource(std::string name, const std::string& gdal_path) : name_(std::move(name)) {
    const QuietGdal quiet;
    file_ = VSIFOpenL(gdal_path.c_str(), "rb");
    VSIStatBufL facts;
    if (file_ == nullptr || VSIStatL(gdal_path.c_str(), &facts) != 0) {
      if (file_ != nullptr) VSIFCloseL(file_);
      throw InputError(name_, "holds a point file that cannot be opened; unpack it by hand");
    }
    size_ = static_cast<std::uint64_t>(facts.st_size);
  }
  ~ZipSource() override { VSIFCloseL(file_); }
  ZipSource(const ZipSource&) = delete;
  ZipSource& operator=(const ZipSource&) = delete;

  std::uint64_t size() const override { return size_; }

  std::size_t read_at(std::uint64_t offset, void* to, std::size_t count) override {
    const QuietGdal quiet;
    if (offset >= size_) return 0;
    // Seeking where the stream already is would still restart the inflation of a big file.
    if (offset != position_ && VSIFSeekL(file_, offset, SEEK_SET) != 0) fail(offset);
    const std::size_t wanted =
        static_cast<std::size_t>(std::min<std::uint64_t>(count, size_ - offset));
    const std::size_t got = VSIFReadL(to, 1, wanted, file_);
    position_ = offset + got;
    if (got < wanted) fail(position_);
    return got;
  }

 private:
  [[noreturn]] void fail(std::uint64_t offset) const {
    throw InputError(name_, "is damaged: its point file cannot be unpacked at byte " +
                                std::to_string(offset) + " of " + std::to_string(size_) +
                                "; download it again");
  }

  std::string name_;
  VSILFILE* file_ = nullptr;
  std::uint64_t size_ = 0;
  std::uint64_t position_ = 0;
};

bool is_point_file_name(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return name.ends_with(".las") || name.ends_with(".laz");
}

}  // namespace

OpenedSource open_zip_member(const std::filesystem::path& path) {
  const QuietGdal quiet;
  // Braces let the archive have any name; relative names are not allowed inside them.
  const std::string root = "/vsizip/{" + std::filesystem::absolute(path).string() + "}";
  std::vector<std::string> members;
  char** entries = VSIReadDirRecursive(root.c_str());
  for (int i = 0; i < CSLCount(entries); ++i) {
    if (is_point_file_name(entries[i])) members.emplace_back(entries[i]);
  }
  CSLDestroy(entries);
  if (members.size() != 1) {
    throw InputError(path.string(), "is a .zip with " + std::to_string(members.size()) +
                                        " .las or .laz files in it where one is expected; unpack "
                                        "it and give the files");
  }
  return {std::make_unique<ZipSource>(path.string(), root + "/" + members.front()),
          members.front()};
}

}  // namespace cornice
