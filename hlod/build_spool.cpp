// SPDX-License-Identifier: GPL-3.0-or-later
// Layout: the mark, records, the footer (text, table of cells, table of parts, numbers), and last
// the footer's place, its checksum and the mark again.
#include "hlod/build_spool.h"

#include <fcntl.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <mutex>
#include <system_error>
#include <type_traits>
#include <utility>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/write_problem.h"

namespace cornice::hlod {
namespace {

/// At both ends, so that a file that lost its beginning is none.
constexpr std::array<char, 8> kMark{'C', 'H', 'L', 'S', 'P', 'L', '0', '3'};

struct Tail {
  std::uint64_t footer = 0, checksum = 0;
  std::array<char, 8> mark = kMark;
};

struct CellHead {
  std::uint64_t vertices = 0, triangles = 0, sums = 0, sharers = 0;
  CellKey key;
  float error_m = 0, step_error_m = 0;
};

/// A SpoolPart as it is stored: without padding, whose bytes would be anything.
struct PartRow {
  CellKey key;
  LatticePoint lowest, highest;
  float error_m = 0, step_error_m = 0;
  std::uint32_t triangles = 0, vertices = 0, parents = 0, part = 0;
  std::uint64_t offset = 0, bytes = 0, checksum = 0;
};
static_assert(sizeof(PartRow) == 88 && sizeof(SpoolCell) == 64 && sizeof(CellHead) == 56);

PartRow row_of(const SpoolPart& part) {
  const Node& n = part.node;
  return {n.key,      n.lowest,  n.highest, n.error_m,   n.step_error_m, n.triangles,
          n.vertices, n.parents, n.part,    part.offset, part.bytes,     part.checksum};
}

SpoolPart part_of(const PartRow& row) {
  SpoolPart part;
  part.node.key = row.key;
  part.node.part = static_cast<std::uint16_t>(row.part);
  part.node.lowest = row.lowest, part.node.highest = row.highest;
  part.node.error_m = row.error_m, part.node.step_error_m = row.step_error_m;
  part.node.triangles = row.triangles;
  part.node.vertices = row.vertices, part.node.parents = row.parents;
  part.offset = row.offset, part.bytes = row.bytes, part.checksum = row.checksum;
  return part;
}

/// Appends values and arrays as they lie in memory.
class Bytes {
 public:
  template <class T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    put_raw(&value, sizeof value);
  }
  template <class T>
  void put(const std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    put_raw(values.data(), values.size() * sizeof(T));
  }
  std::vector<std::byte> bytes;

 private:
  void put_raw(const void* from, std::size_t count) {
    const std::size_t at = bytes.size();
    bytes.resize(at + count);
    if (count > 0) std::memcpy(bytes.data() + at, from, count);
  }
};

/// Takes them out again; throws where they are not there.
class Taker {
 public:
  Taker(std::span<const std::byte> bytes, std::string name)
      : bytes_(bytes), name_(std::move(name)) {}

  template <class T>
  void take(T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    take_raw(&value, 1, sizeof value);
  }
  template <class T>
  void take(std::vector<T>& values, std::uint64_t count) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (count > bytes_.size() / sizeof(T)) fail();
    values.resize(count);
    take_raw(values.data(), count, sizeof(T));
  }
  [[noreturn]] void fail() const {
    throw InputError(name_, "is damaged; delete it and build again");
  }
  bool empty() const { return bytes_.empty(); }

 private:
  void take_raw(void* to, std::uint64_t count, std::size_t size) {
    if (count > bytes_.size() / size) fail();
    if (count > 0) std::memcpy(to, bytes_.data(), count * size);
    bytes_ = bytes_.subspan(count * size);
  }

  std::span<const std::byte> bytes_;
  std::string name_;
};

std::uint64_t checksum_of(std::span<const std::byte> bytes) {
  return XXH3_64bits(bytes.data(), bytes.size());
}

void write_at(int file, const std::string& name, std::span<const std::byte> bytes,
              std::uint64_t offset) {
  while (!bytes.empty()) {
    const ssize_t done = ::pwrite(file, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) throw RunError(name, "cannot be written: " + write_problem(errno));
    bytes = bytes.subspan(static_cast<std::size_t>(done));
    offset += static_cast<std::uint64_t>(done);
  }
}

std::vector<std::byte> read_at(int file, const std::string& name, std::uint64_t offset,
                               std::uint64_t count) {
  std::vector<std::byte> bytes(count);
  for (std::size_t done = 0; done < count;) {
    const ssize_t got =
        ::pread(file, bytes.data() + done, count - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) throw InputError(name, "ends early; delete it and build again");
    done += static_cast<std::size_t>(got);
  }
  return bytes;
}

}  // namespace

struct SpoolWriter::State {
  explicit State(const std::filesystem::path& path) : file(path) {}
  AtomicFile file;
  std::string text;
  int descriptor = -1;
  std::mutex mutex;
  std::uint64_t end = 0;
  std::vector<SpoolCell> cells;
  std::vector<SpoolPart> parts;
};

SpoolWriter::SpoolWriter(const std::filesystem::path& path, std::string text)
    : state_(std::make_unique<State>(path)) {
  state_->text = std::move(text);
  state_->descriptor =
      ::open(state_->file.path().c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (state_->descriptor < 0) {
    throw RunError(path.string(), "cannot be written: " + write_problem(errno));
  }
  write_at(state_->descriptor, path.string(), std::as_bytes(std::span(kMark)), 0);
  state_->end = kMark.size();
}

SpoolWriter::~SpoolWriter() {
  if (state_->descriptor >= 0) ::close(state_->descriptor);
}

void SpoolWriter::add(const BuildCell& cell) {
  CellHead head;
  head.vertices = cell.vertices.size();
  head.triangles = cell.triangles.size();
  head.sums = cell.normal_sums.size();
  head.sharers = cell.sharers.size();
  head.key = cell.key;
  head.error_m = cell.error_m;
  head.step_error_m = cell.step_error_m;
  Bytes record;
  record.put(head);
  record.put(cell.vertices);
  record.put(cell.sharers);
  record.put(cell.normal_sums);
  record.put(cell.triangles);
  SpoolCell entry{cell.key,
                  cell.error_m,
                  0,
                  0,
                  record.bytes.size(),
                  head.triangles,
                  head.vertices,
                  checksum_of(record.bytes)};
  {
    const std::lock_guard lock(state_->mutex);
    entry.offset = std::exchange(state_->end, state_->end + record.bytes.size());
    state_->cells.push_back(entry);
  }
  write_at(state_->descriptor, state_->file.target().string(), record.bytes, entry.offset);
}

void SpoolWriter::add(const Node& node, std::span<const std::byte> block) {
  SpoolPart entry{node, 0, block.size(), checksum_of(block)};
  {
    const std::lock_guard lock(state_->mutex);
    entry.offset = std::exchange(state_->end, state_->end + block.size());
    state_->parts.push_back(entry);
  }
  write_at(state_->descriptor, state_->file.target().string(), block, entry.offset);
}

void SpoolWriter::commit(const std::vector<std::uint64_t>& numbers) {
  State& s = *state_;
  std::stable_sort(s.cells.begin(), s.cells.end(),
                   [](const SpoolCell& a, const SpoolCell& b) { return a.key < b.key; });
  Bytes footer;
  footer.put(std::uint64_t{s.text.size()});
  footer.put(std::uint64_t{s.cells.size()});
  footer.put(std::uint64_t{s.parts.size()});
  footer.put(std::uint64_t{numbers.size()});
  footer.put(std::vector<char>(s.text.begin(), s.text.end()));
  footer.put(s.cells);
  for (const SpoolPart& part : s.parts) footer.put(row_of(part));
  footer.put(numbers);
  Tail tail;
  tail.footer = s.end;
  tail.checksum = checksum_of(footer.bytes);
  footer.put(tail);
  write_at(s.descriptor, s.file.target().string(), footer.bytes, s.end);
  if (::close(std::exchange(s.descriptor, -1)) != 0) {
    throw RunError(s.file.target().string(), "cannot be written: " + write_problem(errno));
  }
  s.file.commit();
}

struct Spool::State {
  std::string name, text;
  std::vector<std::uint64_t> numbers;
  int descriptor = -1;
  std::vector<SpoolCell> cells;
  std::vector<SpoolPart> parts;
};

Spool::Spool(const std::filesystem::path& path) : state_(std::make_unique<State>()) {
  State& s = *state_;
  s.name = path.string();
  s.descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (s.descriptor < 0) throw InputError(s.name, std::generic_category().message(errno));
  const off_t size = ::lseek(s.descriptor, 0, SEEK_END);
  const auto bytes = static_cast<std::uint64_t>(std::max<off_t>(size, 0));
  try {
    Tail tail;
    if (bytes < sizeof tail) throw InputError(s.name, "is no part of a hierarchy");
    const auto raw = read_at(s.descriptor, s.name, bytes - sizeof tail, sizeof tail);
    std::memcpy(&tail, raw.data(), sizeof tail);
    const auto first = read_at(s.descriptor, s.name, 0, kMark.size());
    const bool begins = std::memcmp(first.data(), kMark.data(), kMark.size()) == 0;
    if (!begins || tail.mark != kMark || tail.footer > bytes - sizeof tail) {
      throw InputError(s.name, "is no part of a hierarchy, or of another version");
    }
    const auto footer =
        read_at(s.descriptor, s.name, tail.footer, bytes - sizeof tail - tail.footer);
    Taker taker(footer, s.name);
    if (checksum_of(footer) != tail.checksum) taker.fail();
    std::uint64_t text = 0, cells = 0, parts = 0, numbers = 0;
    taker.take(text);
    taker.take(cells);
    taker.take(parts);
    taker.take(numbers);
    std::vector<char> letters;
    taker.take(letters, text);
    s.text.assign(letters.begin(), letters.end());
    taker.take(s.cells, cells);
    std::vector<PartRow> rows;
    taker.take(rows, parts);
    for (const PartRow& row : rows) s.parts.push_back(part_of(row));
    taker.take(s.numbers, numbers);
  } catch (...) {
    ::close(s.descriptor);
    throw;
  }
}

Spool::~Spool() { ::close(state_->descriptor); }

const std::string& Spool::text() const { return state_->text; }
const std::vector<std::uint64_t>& Spool::numbers() const { return state_->numbers; }
const std::vector<SpoolCell>& Spool::cells() const { return state_->cells; }
const std::vector<SpoolPart>& Spool::parts() const { return state_->parts; }

BuildCell Spool::read(const SpoolCell& entry) const {
  const auto bytes = read_at(state_->descriptor, state_->name, entry.offset, entry.bytes);
  Taker taker(bytes, state_->name);
  if (checksum_of(bytes) != entry.checksum) taker.fail();
  CellHead head;
  taker.take(head);
  BuildCell cell;
  cell.key = head.key;
  cell.error_m = head.error_m;
  cell.step_error_m = head.step_error_m;
  taker.take(cell.vertices, head.vertices);
  taker.take(cell.sharers, head.sharers);
  taker.take(cell.normal_sums, head.sums);
  taker.take(cell.triangles, head.triangles);
  const bool whole = taker.empty() && head.key == entry.key &&
                     (head.sharers == 0 || head.sharers == head.vertices) &&
                     (head.sums == 0 || head.sums == head.vertices);
  if (!whole) taker.fail();
  for (const Triangle& t : cell.triangles) {
    if (std::max({t[0], t[1], t[2]}) >= head.vertices) taker.fail();
  }
  return cell;
}

std::vector<std::byte> Spool::read(const SpoolPart& part) const {
  auto bytes = read_at(state_->descriptor, state_->name, part.offset, part.bytes);
  if (checksum_of(bytes) != part.checksum) Taker(bytes, state_->name).fail();
  return bytes;
}

}  // namespace cornice::hlod
