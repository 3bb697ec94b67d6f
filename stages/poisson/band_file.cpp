// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/poisson/band_file.h"

#include <xxhash.h>

#include <array>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <memory>
#include <system_error>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/input_file.h"
#include "core/base/write_problem.h"

namespace cornice {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they are");

constexpr std::array<char, 8> kMagic{'C', 'O', 'R', 'N', 'F', 'L', 'D', '\n'};
constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kHeadBytes = 96;
constexpr std::uint64_t kBytesPerBrick = sizeof(BrickKey) + kBrickNodes * sizeof(float);
constexpr std::uint32_t kMostLevels = 24;
constexpr std::uint32_t kMostCrsBytes = 1 << 20;
/// Nodes farther from 0 than this are refused: sums of a few coordinates stay within 32 bits.
constexpr std::int32_t kFarthestNode = kHighestNode;

static_assert(sizeof(BrickKey) == 12, "keys are three numbers of 32 bits, without gaps");

/// The first bytes of a file, as docs/formats/field.md lists them.
struct Head {
  std::array<char, 8> magic = kMagic;
  std::uint32_t version = kVersion;
  std::uint32_t is_band = 0;
  double step_m = 0.0;
  std::int32_t x0 = 0, y0 = 0, x1 = 0, y1 = 0, z0 = 0, z1 = 0;
  std::int32_t ramp = 0;
  std::uint32_t levels = 0;
  std::uint32_t crs_bytes = 0;
  std::uint32_t reserved = 0;
  std::uint64_t bricks = 0;
  std::uint64_t body_bytes = 0;
  std::uint64_t body_checksum = 0;
};
static_assert(sizeof(Head) == kHeadBytes - sizeof(std::uint64_t), "the head has no gaps");

class Checksum {
 public:
  Checksum() : state_(XXH3_createState()) { XXH3_64bits_reset(state_.get()); }
  void add(const void* bytes, std::size_t count) { XXH3_64bits_update(state_.get(), bytes, count); }
  std::uint64_t value() const { return XXH3_64bits_digest(state_.get()); }

 private:
  struct Free {
    void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
  };
  std::unique_ptr<XXH3_state_t, Free> state_;
};

/// The body, front to back, with its checksum.
class Input {
 public:
  explicit Input(const std::filesystem::path& path) : name_(path.string()) {
    check_input_file(path);
    size_ = std::filesystem::file_size(path);
    stream_.open(path, std::ios::binary);
    if (!stream_) fail("cannot be read: " + std::generic_category().message(errno));
  }
  std::uint64_t size() const { return size_; }
  void read(void* to, std::size_t count) {
    stream_.read(static_cast<char*>(to), static_cast<std::streamsize>(count));
    if (static_cast<std::size_t>(stream_.gcount()) != count) fail("is truncated; make it again");
    checksum_.add(to, count);
  }
  void restart_checksum() { checksum_ = Checksum(); }
  std::uint64_t checksum() const { return checksum_.value(); }
  [[noreturn]] void fail(const std::string& problem) const { throw InputError(name_, problem); }

 private:
  std::string name_;
  std::ifstream stream_;
  std::uint64_t size_ = 0;
  Checksum checksum_;
};

void check_head(const Head& head, const Input& input) {
  const auto bad = [&](const std::string& what) { input.fail("has a damaged head: " + what); };
  if (head.is_band > 1 || head.reserved != 0) bad("a field that must be 0 or 1");
  if (!(head.step_m >= 1e-6 && head.step_m <= 1e6)) bad("its lattice step");
  for (const std::int32_t plane : {head.x0, head.y0, head.x1, head.y1, head.z0, head.z1}) {
    if (plane < -kFarthestNode || plane > kFarthestNode) bad("its tile");
  }
  if (head.x0 >= head.x1 || head.y0 >= head.y1 || head.z0 > head.z1) bad("its tile is empty");
  if (head.ramp < kLeastRamp || head.ramp > kFarthestNode / 16) bad("its band width");
  if (head.levels > kMostLevels) bad("its number of levels");
  if (head.crs_bytes > kMostCrsBytes) bad("the length of its CRS");
  if (head.bricks > input.size() / kBytesPerBrick) {
    input.fail("is truncated: it promises " + std::to_string(head.bricks) +
               " bricks; make it again");
  }
  const std::uint64_t body =
      head.crs_bytes + 8 * std::uint64_t{head.levels} + kBytesPerBrick * head.bricks;
  if (head.body_bytes != body) bad("its length");
  if (kHeadBytes + body != input.size()) {
    input.fail("has " + std::to_string(input.size()) + " bytes instead of " +
               std::to_string(kHeadBytes + body) + "; make it again");
  }
}

Head read_head(Input& input) {
  Head head;
  std::uint64_t checksum = 0;
  if (input.size() < kHeadBytes) input.fail("is no field of cornice-poisson: it is too short");
  input.read(&head, sizeof(head));
  if (head.magic != kMagic) input.fail("is no field of cornice-poisson");
  if (head.version != kVersion) {
    input.fail("has version " + std::to_string(head.version) + ", but only version " +
               std::to_string(kVersion) + " is known");
  }
  const std::uint64_t expected = input.checksum();
  input.read(&checksum, sizeof(checksum));
  if (checksum != expected) input.fail("has a damaged head: its checksum is wrong");
  check_head(head, input);
  input.restart_checksum();
  return head;
}

void check_keys(const std::vector<BrickKey>& bricks, std::size_t level, const Input& input) {
  const std::int32_t farthest = (kFarthestNode / kBrickSide) >> level;
  for (std::size_t b = 0; b < bricks.size(); ++b) {
    for (const std::int32_t c : {bricks[b].x, bricks[b].y, bricks[b].z}) {
      if (c < -farthest || c >= farthest) input.fail("has a brick too far from 0");
    }
    if (b > 0 && !(bricks[b - 1] < bricks[b])) input.fail("has bricks out of order");
  }
}

FieldLevel read_level(Input& input, std::size_t level, std::uint64_t& bricks_left) {
  std::uint64_t count = 0;
  input.read(&count, sizeof(count));
  if (count > bricks_left) input.fail("has more bricks in a level than in all");
  bricks_left -= count;
  FieldLevel read;
  read.bricks.resize(count);
  read.values.resize(count * kBrickNodes);
  input.read(read.bricks.data(), count * sizeof(BrickKey));
  input.read(read.values.data(), read.values.size() * sizeof(float));
  check_keys(read.bricks, level, input);
  float sum = 0.0f;
  // A number times 0 is 0; anything else times 0 is NaN, and stays so in the sum.
  for (const float value : read.values) sum += 0.0f * value;
  if (!(sum == 0.0f)) input.fail("holds values that are no numbers");
  return read;
}

std::string read_crs(Input& input, const Head& head) {
  std::string text(head.crs_bytes, '\0');
  input.read(text.data(), text.size());
  return text;
}

/// A file that is written front to back, with a checksum.
class Output {
 public:
  explicit Output(const AtomicFile& file)
      : name_(file.target().string()), stream_(file.path(), std::ios::binary) {
    check();
  }
  void write(const void* bytes, std::size_t count) {
    stream_.write(static_cast<const char*>(bytes), static_cast<std::streamsize>(count));
    check();
    checksum_.add(bytes, count);
  }
  std::uint64_t checksum() const { return checksum_.value(); }
  void restart_checksum() { checksum_ = Checksum(); }
  void seek_start() {
    stream_.seekp(0);
    check();
  }
  void close() {
    stream_.close();
    check();
  }

 private:
  void check() const {
    if (!stream_) throw RunError(name_, "cannot be written: " + write_problem(errno));
  }
  std::string name_;
  std::ofstream stream_;
  Checksum checksum_;
};

}  // namespace

void write_field(const std::filesystem::path& path, const TileField& tile) {
  Head head;
  head.is_band = tile.is_band ? 1 : 0;
  head.step_m = tile.field.lattice().step_m;
  head.x0 = tile.tile.x0, head.y0 = tile.tile.y0, head.x1 = tile.tile.x1, head.y1 = tile.tile.y1;
  head.z0 = tile.z0, head.z1 = tile.z1;
  head.ramp = tile.ramp;
  head.levels = static_cast<std::uint32_t>(tile.field.levels().size());
  head.crs_bytes = static_cast<std::uint32_t>(tile.crs_text.size());
  for (const FieldLevel& level : tile.field.levels()) head.bricks += level.bricks.size();
  head.body_bytes = head.crs_bytes + 8 * std::uint64_t{head.levels} + kBytesPerBrick * head.bricks;

  AtomicFile file(path);
  Output output(file);
  const std::array<char, kHeadBytes> room{};
  output.write(room.data(), room.size());
  output.restart_checksum();
  output.write(tile.crs_text.data(), tile.crs_text.size());
  for (const FieldLevel& level : tile.field.levels()) {
    const std::uint64_t count = level.bricks.size();
    output.write(&count, sizeof(count));
    output.write(level.bricks.data(), count * sizeof(BrickKey));
    output.write(level.values.data(), level.values.size() * sizeof(float));
  }
  head.body_checksum = output.checksum();
  output.seek_start();
  output.restart_checksum();
  output.write(&head, sizeof(head));
  const std::uint64_t checksum = output.checksum();
  output.write(&checksum, sizeof(checksum));
  output.close();
  file.commit();
}

FieldHead read_field_head(const std::filesystem::path& path) {
  Input input(path);
  const Head head = read_head(input);
  return {{head.step_m},
          {head.x0, head.y0, head.x1, head.y1},
          head.ramp,
          head.is_band == 1,
          read_crs(input, head),
          head.bricks};
}

TileField read_field(const std::filesystem::path& path) {
  Input input(path);
  const Head head = read_head(input);
  TileField tile;
  tile.crs_text = read_crs(input, head);
  std::uint64_t bricks_left = head.bricks;
  std::vector<FieldLevel> levels;
  for (std::uint32_t l = 0; l < head.levels; ++l) {
    levels.push_back(read_level(input, l, bricks_left));
  }
  if (bricks_left != 0) input.fail("has fewer bricks than it promises");
  if (input.checksum() != head.body_checksum) {
    input.fail("is damaged: its checksum is wrong; make it again");
  }
  tile.field = Field({head.step_m}, std::move(levels));
  tile.tile = {head.x0, head.y0, head.x1, head.y1};
  tile.z0 = head.z0, tile.z1 = head.z1;
  tile.ramp = head.ramp;
  tile.is_band = head.is_band == 1;
  return tile;
}

}  // namespace cornice
