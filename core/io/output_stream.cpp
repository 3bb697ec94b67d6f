// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/io/output_stream.h"

#include <cerrno>
#include <system_error>
#include <utility>

#include "core/base/error.h"

namespace cornice {
namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 20;

}  // namespace

void throw_cannot_write(const std::string& name, int error) {
  const std::string reason =
      error != 0 ? std::generic_category().message(error) : std::string("the stream failed");
  throw RunError(name, "cannot be written: " + reason +
                           "; free some space or write elsewhere, then run again");
}

OutputStream::OutputStream(std::filesystem::path target)
    : file_(std::move(target)), buffer_(kBufferBytes) {
  stream_.rdbuf()->pubsetbuf(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
  errno = 0;
  stream_.open(file_.path(), std::ios::binary | std::ios::trunc);
  check();
}

void OutputStream::check() const {
  if (!stream_.good()) throw_cannot_write(name(), errno);
}

void OutputStream::put(std::span<const std::uint8_t> bytes) {
  errno = 0;
  stream_.write(reinterpret_cast<const char*>(bytes.data()),
                static_cast<std::streamsize>(bytes.size()));
  check();
}

void OutputStream::seek(std::uint64_t position) {
  errno = 0;
  stream_.seekp(static_cast<std::streamoff>(position));
  check();
}

std::uint64_t OutputStream::seek_end() {
  errno = 0;
  stream_.seekp(0, std::ios::end);
  check();
  return static_cast<std::uint64_t>(stream_.tellp());
}

void OutputStream::commit() {
  errno = 0;
  stream_.close();
  check();
  file_.commit();
}

}  // namespace cornice
