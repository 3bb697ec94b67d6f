// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <mutex>
#include <optional>
#include <system_error>
#include <tuple>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/input_file.h"
#include "core/base/write_problem.h"
#include "hlod/file_layout.h"

namespace cornice::hlod {
namespace {

constexpr std::size_t kCopyBytes = std::size_t{4} << 20;

std::string last_error() { return std::generic_category().message(errno); }

/// An open file descriptor with whole reads and writes.
class Descriptor {
 public:
  Descriptor(const std::filesystem::path& path, int flags) : path_(path) {
    file_ = ::open(path.c_str(), flags | O_CLOEXEC, 0666);
  }
  ~Descriptor() {
    if (file_ >= 0) ::close(file_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  bool is_open() const { return file_ >= 0; }
  std::uint64_t size() const {
    struct stat status {};
    return ::fstat(file_, &status) == 0 ? static_cast<std::uint64_t>(status.st_size) : 0;
  }
  /// How many bytes there were, up to bytes.size().
  std::size_t read(std::span<std::byte> bytes, std::uint64_t offset) const {
    std::size_t done = 0;
    while (done < bytes.size()) {
      const ssize_t got = ::pread(file_, bytes.data() + done, bytes.size() - done,
                                  static_cast<off_t>(offset + done));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) break;
      done += static_cast<std::size_t>(got);
    }
    return done;
  }
  /// `target` names the file in messages.
  void write(std::span<const std::byte> bytes, std::uint64_t offset,
             const std::filesystem::path& target) {
    while (!bytes.empty()) {
      const ssize_t put = ::pwrite(file_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
      if (put < 0 && errno == EINTR) continue;
      if (put < 0) throw RunError(target.string(), "cannot be written: " + write_problem(errno));
      bytes = bytes.subspan(static_cast<std::size_t>(put));
      offset += static_cast<std::uint64_t>(put);
    }
  }

 private:
  std::filesystem::path path_;
  int file_;
};

/// A file that is being written under a temporary name.
struct Draft {
  AtomicFile file;
  Descriptor descriptor;

  explicit Draft(const std::filesystem::path& target)
      : file(target), descriptor(file.path(), O_RDWR | O_CREAT | O_TRUNC) {
    if (!descriptor.is_open()) {
      throw RunError(target.string(), "cannot be written: " + write_problem(errno));
    }
  }
};

/// Copies blocks in order of `nodes`, neighbours in one go, and sets their offsets anew.
void copy_blocks(const Draft& from, Draft& to, std::vector<Node>& nodes, std::uint64_t offset) {
  std::vector<std::byte> buffer;
  const auto flush = [&] {
    to.descriptor.write(buffer, offset, to.file.target());
    offset += buffer.size();
    buffer.clear();
  };
  std::uint64_t next = offset;
  for (Node& node : nodes) {
    if (!buffer.empty() && buffer.size() + node.bytes > kCopyBytes) flush();
    const std::size_t begin = buffer.size();
    buffer.resize(begin + node.bytes);
    if (from.descriptor.read(std::span(buffer).subspan(begin), node.offset) != node.bytes) {
      throw RunError(from.file.path().string(), "cannot be read back: " + last_error());
    }
    node.offset = next;
    next += node.bytes;
  }
  flush();
}

}  // namespace

std::string cell_name(const CellKey& key, int part) {
  const std::string name = "cell " + std::to_string(key.level) + "/" + std::to_string(key.i) + "/" +
                           std::to_string(key.j) + "/" + std::to_string(key.k);
  return part == 0 ? name : name + " part " + std::to_string(part);
}

Node make_node(const CellMesh& mesh, float error_m, float step_error_m) {
  Node node;
  node.key = mesh.key;
  node.error_m = error_m, node.step_error_m = step_error_m;
  node.triangles = static_cast<std::uint32_t>(mesh.triangles.size());
  node.vertices = static_cast<std::uint32_t>(mesh.vertices.size());
  node.parents = static_cast<std::uint32_t>(mesh.parents.size());
  if (mesh.vertices.empty()) return node;
  node.lowest = node.highest = mesh.vertices.front().position;
  const auto add = [&](LatticePoint p) {
    node.lowest = {std::min(node.lowest.x, p.x), std::min(node.lowest.y, p.y),
                   std::min(node.lowest.z, p.z)};
    node.highest = {std::max(node.highest.x, p.x), std::max(node.highest.y, p.y),
                    std::max(node.highest.z, p.z)};
  };
  for (const CellVertex& v : mesh.vertices) add(v.position);
  for (const CellVertex& v : mesh.parents) add(refined(v.position));
  return node;
}

struct FileWriter::State {
  explicit State(const std::filesystem::path& path, const Header& h) : header(h), draft(path) {}

  Header header;
  Draft draft;
  std::mutex mutex;
  std::vector<Node> nodes;
  std::uint64_t end = 0;  ///< where the next block goes
};

FileWriter::FileWriter(const std::filesystem::path& path, const Header& header)
    : state_(std::make_unique<State>(path, header)) {
  [[maybe_unused]] const std::string fault = fault_of(header);
  assert(fault.empty() && "a header that the reader would refuse");
  state_->end = head_bytes(header);
}

FileWriter::~FileWriter() = default;

void FileWriter::add(Node node, std::span<const std::byte> block) {
  node.bytes = static_cast<std::uint32_t>(block.size());
  node.checksum = XXH3_64bits(block.data(), block.size());
  assert(fault_of(node, state_->header).empty() && "a node that the reader would refuse");
  {
    const std::lock_guard lock(state_->mutex);
    node.offset = state_->end;
    state_->end += block.size();
    state_->nodes.push_back(node);
  }
  state_->draft.descriptor.write(block, node.offset, state_->draft.file.target());
}

void FileWriter::finish() {
  State& s = *state_;
  const auto order = [](const Node& node) { return std::tie(node.key, node.part); };
  const auto is_before = [&](const Node& a, const Node& b) { return order(a) < order(b); };
  const auto by_offset = [](const Node& a, const Node& b) { return a.offset < b.offset; };
  std::sort(s.nodes.begin(), s.nodes.end(), is_before);
  for (std::size_t n = 0; n < s.nodes.size(); ++n) {
    const bool continues = n > 0 && s.nodes[n].key == s.nodes[n - 1].key;
    if (s.nodes[n].part == (continues ? s.nodes[n - 1].part + 1 : 0)) continue;
    throw RunError(s.draft.file.target().string(),
                   cell_name(s.nodes[n].key, s.nodes[n].part) +
                       " was written twice, or the part before it never");
  }
  std::optional<Draft> sorted;
  if (!std::is_sorted(s.nodes.begin(), s.nodes.end(), by_offset)) {
    sorted.emplace(s.draft.file.target());
    copy_blocks(s.draft, *sorted, s.nodes, head_bytes(s.header));
  }
  Draft& draft = sorted ? *sorted : s.draft;
  const std::vector<std::byte> table = pack_nodes(s.nodes, s.header.lattice);
  draft.descriptor.write(table, s.end, draft.file.target());
  Head head;
  head.header = s.header;
  head.bounds = bounds_of(s.nodes, s.header.lattice);
  head.file_bytes = s.end + table.size();
  head.node_count = s.nodes.size();
  head.table_offset = s.end;
  head.table_checksum = XXH3_64bits(table.data(), table.size());
  const std::vector<std::uint8_t> bytes = pack_head(head);
  draft.descriptor.write(std::as_bytes(std::span(bytes)), 0, draft.file.target());
  draft.file.commit();
}

struct File::State {
  explicit State(const std::filesystem::path& p) : path(p), descriptor(p, O_RDONLY) {}

  std::filesystem::path path;
  Descriptor descriptor;
  Head head;
  std::vector<Node> nodes;
  std::vector<LevelStatistics> levels;
};

namespace {

Head read_head(const Descriptor& descriptor, const std::filesystem::path& path) {
  std::vector<std::uint8_t> bytes(kFixedHeadBytes);
  const auto as_bytes = [&] { return std::as_writable_bytes(std::span(bytes)); };
  bytes.resize(descriptor.read(as_bytes(), 0));
  bytes.resize(head_length(path, bytes));
  bytes.resize(descriptor.read(as_bytes(), 0));
  return unpack_head(path, bytes);
}

std::vector<Node> read_nodes(const Descriptor& descriptor, const std::filesystem::path& path,
                             const Head& head, std::uint64_t file_bytes) {
  if (file_bytes != head.file_bytes) {
    throw InputError(path.string(), "has " + std::to_string(file_bytes) + " bytes instead of " +
                                        std::to_string(head.file_bytes) +
                                        ": it was cut or added to; write it anew");
  }
  const std::uint64_t first = head_bytes(head.header);
  // Every node has a block of one byte at least, so a count beyond that is a lie.
  if (head.table_offset < first || head.table_offset > file_bytes ||
      head.node_count > head.table_offset - first) {
    throw InputError(path.string(), "has a damaged head; write it anew");
  }
  std::vector<std::byte> table(file_bytes - head.table_offset);
  if (descriptor.read(table, head.table_offset) != table.size() ||
      XXH3_64bits(table.data(), table.size()) != head.table_checksum) {
    throw InputError(path.string(),
                     "has a damaged node table: its checksum does not fit; write it anew");
  }
  return unpack_nodes(path, table, head);
}

}  // namespace

File::File(const std::filesystem::path& path) {
  check_input_file(path);
  state_ = std::make_unique<State>(path);
  State& s = *state_;
  if (!s.descriptor.is_open()) {
    throw InputError(path.string(), "cannot be opened: " + last_error());
  }
  s.head = read_head(s.descriptor, path);
  s.nodes = read_nodes(s.descriptor, path, s.head, s.descriptor.size());
  s.levels = statistics_of(s.nodes, s.head.header.lattice.finest_level);
}

File::~File() = default;

const Header& File::header() const { return state_->head.header; }
const std::vector<Node>& File::nodes() const { return state_->nodes; }
const std::vector<LevelStatistics>& File::levels() const { return state_->levels; }
const Box3d& File::bounds() const { return state_->head.bounds; }
std::uint64_t File::bytes() const { return state_->head.file_bytes; }

CellMesh File::read(const Node& node) const {
  std::vector<std::byte> block(node.bytes);
  const std::string name = cell_name(node.key, node.part);
  if (state_->descriptor.read(block, node.offset) != block.size()) {
    throw InputError(state_->path.string(), name + " is gone: the file was cut; write it anew");
  }
  if (XXH3_64bits(block.data(), block.size()) != node.checksum) {
    throw InputError(state_->path.string(),
                     name + " is damaged: its checksum does not fit; write the file anew");
  }
  try {
    return decode_cell(block, node, state_->head.header);
  } catch (const InputError& error) {
    throw InputError(state_->path.string(), error.what());
  }
}

}  // namespace cornice::hlod
