// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/io/output_stream.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "core/base/error.h"
#include "core/base/write_problem.h"

namespace cornice {
namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 20;

}  // namespace

PatientFileBuffer::PatientFileBuffer(const std::filesystem::path& path) : buffer_(kBufferBytes) {
  file_ = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file_ < 0) error_ = errno;
  setp(buffer_.data(), buffer_.data() + buffer_.size());
}

PatientFileBuffer::~PatientFileBuffer() {
  if (file_ >= 0) ::close(file_);
}

void PatientFileBuffer::write_out(const char* bytes, std::size_t count) {
  while (count > 0 && error_ == 0) {
    const ssize_t written = pwrite(file_, bytes, count, static_cast<off_t>(start_));
    if (written < 0) {
      if (errno != EINTR) error_ = errno;
      continue;
    }
    bytes += written;
    count -= static_cast<std::size_t>(written);
    start_ += static_cast<std::uint64_t>(written);
  }
  start_ += count;  // dropped bytes keep their place
  end_ = std::max(end_, start_);
}

void PatientFileBuffer::flush_buffer() {
  write_out(pbase(), static_cast<std::size_t>(pptr() - pbase()));
  setp(buffer_.data(), buffer_.data() + buffer_.size());
}

PatientFileBuffer::int_type PatientFileBuffer::overflow(int_type c) {
  flush_buffer();
  if (!traits_type::eq_int_type(c, traits_type::eof())) sputc(traits_type::to_char_type(c));
  return traits_type::not_eof(c);
}

std::streamsize PatientFileBuffer::xsputn(const char* bytes, std::streamsize count) {
  if (count <= 0) return 0;
  const auto size = static_cast<std::size_t>(count);
  if (static_cast<std::size_t>(epptr() - pptr()) < size) flush_buffer();
  if (size >= buffer_.size()) {
    write_out(bytes, size);
  } else {
    std::memcpy(pptr(), bytes, size);
    pbump(static_cast<int>(size));
  }
  return count;
}

int PatientFileBuffer::sync() {
  flush_buffer();
  return 0;
}

PatientFileBuffer::pos_type PatientFileBuffer::seekoff(off_type offset, std::ios_base::seekdir from,
                                                       std::ios_base::openmode /*mode*/) {
  const auto here = static_cast<off_type>(start_) + (pptr() - pbase());
  if (from == std::ios_base::cur && offset == 0) return here;  // asking for the position
  flush_buffer();
  const off_type base = from == std::ios_base::beg   ? 0
                        : from == std::ios_base::cur ? here
                                                     : static_cast<off_type>(end_);
  if (base + offset < 0) return pos_type(off_type(-1));
  start_ = static_cast<std::uint64_t>(base + offset);
  return base + offset;
}

PatientFileBuffer::pos_type PatientFileBuffer::seekpos(pos_type position,
                                                       std::ios_base::openmode mode) {
  return seekoff(off_type(position), std::ios_base::beg, mode);
}

void PatientFileBuffer::close() {
  flush_buffer();
  if (file_ < 0) return;
  if (::close(file_) != 0 && error_ == 0) error_ = errno;
  file_ = -1;
}

OutputStream::OutputStream(std::filesystem::path target)
    : file_(std::move(target)), buffer_(file_.path()), stream_(&buffer_) {
  check();
}

void OutputStream::check() const {
  if (buffer_.error() == 0) return;
  throw RunError(name(), "cannot be written: " + write_problem(buffer_.error()));
}

void OutputStream::put(std::span<const std::uint8_t> bytes) {
  stream_.write(reinterpret_cast<const char*>(bytes.data()),
                static_cast<std::streamsize>(bytes.size()));
  check();
}

void OutputStream::seek(std::uint64_t position) {
  stream_.seekp(static_cast<std::streamoff>(position));
  check();
}

std::uint64_t OutputStream::seek_end() {
  stream_.seekp(0, std::ios::end);
  check();
  return static_cast<std::uint64_t>(stream_.tellp());
}

void OutputStream::commit() {
  buffer_.close();
  check();
  file_.commit();
}

}  // namespace cornice
