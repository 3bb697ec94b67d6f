// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/io/byte_source.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>

#include "core/base/error.h"
#include "core/base/input_file.h"

namespace cornice {
namespace {

class FileSource : public ByteSource {
 public:
  explicit FileSource(const std::filesystem::path& path) : name_(path.string()) {
    descriptor_ = ::open(name_.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor_ < 0) {
      const std::string reason = std::strerror(errno);
      throw InputError(name_, "cannot be opened (" + reason + "); check the path and permissions");
    }
    struct stat facts {};
    if (::fstat(descriptor_, &facts) == 0) size_ = static_cast<std::uint64_t>(facts.st_size);
  }
  ~FileSource() override { ::close(descriptor_); }
  FileSource(const FileSource&) = delete;
  FileSource& operator=(const FileSource&) = delete;

  std::uint64_t size() const override { return size_; }

  std::size_t read_at(std::uint64_t offset, void* to, std::size_t count) override {
    if (offset >= size_) return 0;
    std::size_t done = 0;
    while (done < count) {
      const ssize_t got = ::pread(descriptor_, static_cast<char*>(to) + done, count - done,
                                  static_cast<off_t>(offset + done));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) {
        const std::string reason = std::strerror(errno);
        throw InputError(name_, "cannot be read at byte " + std::to_string(offset + done) + " (" +
                                    reason + "); check the disk and copy the file again");
      }
      if (got == 0) break;
      done += static_cast<std::size_t>(got);
    }
    return done;
  }

 private:
  std::string name_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

void check_is_point_file(ByteSource& source, const std::string& name) {
  if (source.size() == 0) throw InputError(name, "is empty (0 bytes); copy or download it again");
  std::array<char, 48> start{};
  const std::size_t got = source.read_at(0, start.data(), start.size());
  const std::string_view text(start.data(), got);
  if (text.starts_with("version https://git-lfs")) {
    throw InputError(
        name, "is a git-lfs pointer of " + std::to_string(source.size()) +
                  " bytes, not the point file itself; run 'git lfs pull' where it came from");
  }
}

}  // namespace

std::size_t MemorySource::read_at(std::uint64_t offset, void* to, std::size_t count) {
  if (offset >= data_.size()) return 0;
  const std::size_t there = std::min<std::size_t>(count, data_.size() - offset);
  if (there > 0) std::memcpy(to, data_.data() + offset, there);
  return there;
}

OpenedSource open_point_file(const std::filesystem::path& path) {
  check_input_file(path);
  OpenedSource opened{std::make_unique<FileSource>(path), ""};
  check_is_point_file(*opened.bytes, path.string());
  std::array<char, 4> magic{};
  const bool is_zip = opened.bytes->read_at(0, magic.data(), 4) == 4 &&
                      std::memcmp(magic.data(), "PK\x03\x04", 4) == 0;
  return is_zip ? open_zip_member(path) : std::move(opened);
}

std::vector<std::uint8_t> read_bytes(ByteSource& source, std::uint64_t offset, std::size_t count) {
  if (offset >= source.size()) return {};
  const std::uint64_t there = std::min<std::uint64_t>(count, source.size() - offset);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(there));
  bytes.resize(source.read_at(offset, bytes.data(), bytes.size()));
  return bytes;
}

}  // namespace cornice
