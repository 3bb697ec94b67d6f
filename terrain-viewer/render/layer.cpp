// SPDX-License-Identifier: GPL-3.0-or-later
// Prefetch along the motion of the eye: Borgeat, Godin, Blais, Massicotte and Lahanier, "GoLD:
// interactive display of huge colored and textured models", ACM TOG 24(3), 2005, 4.1.
#include "terrain-viewer/render/layer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "core/base/error.h"
#include "terrain-viewer/render/ground_query.h"

namespace cornice::viewer {
namespace {

constexpr std::uint32_t kNoParent = std::numeric_limits<std::uint32_t>::max();
/// Of the error that a surface may have on the screen, what radii are made for: light shows relief
/// that is flatter than that (decision 600).
constexpr double kErrorShare = 0.85;
/// Radii reach what they should be within some such times; slow enough not to be seen.
constexpr double kRadiiSeconds = 0.35;
/// How far ahead of the eye's motion is read.
constexpr double kAheadSeconds = 0.8;
/// What is to be taken to the GPU is spread over about so long, so that frames differ little: what
/// is needed less than radii take to get there, what is read ahead half of the time that there is.
constexpr double kUploadSeconds = 0.1, kUploadAheadSeconds = 0.5 * kAheadSeconds;
/// Budgets are taken back at once and given back slowly, so that the level of detail does not
/// swing.
constexpr double kShareRisePerSecond = 0.25;
/// Cells are read for a view this much wider than what is seen, so that a turn finds them there.
constexpr double kWiderDeg = 30.0;
/// Part of the GPU's room that one view may need; the rest is for what comes next.
constexpr double kRoomShare = 0.85;
/// By what radii are cut, again and again, until a view fits into that.
constexpr double kRoomFactor = 0.9;
constexpr int kRoomStepLimit = 100, kLikelySteps = 3;

/// Cells that a frame asks for at most: more than are read or taken up until the next one, and not
/// more work for the frame because the view has jumped.
constexpr std::size_t kMostAsked = 512;

std::uint64_t packed_vertices(const hlod::Node& node) {
  return std::uint64_t{node.vertices} + (node.key.level > 0 ? node.parents : node.vertices);
}

std::uint64_t packed_bytes(const hlod::Node& node) {
  return packed_vertices(node) * kWordsPerVertex * 4 + std::uint64_t{node.triangles} * 6;
}

hlod::Frustum frustum_of(const LayerView& view, double wider_deg) {
  const CameraAxes axes = axes_of(view.camera);
  const double up = std::tan(0.5 * view.camera.field_of_view_deg * std::numbers::pi / 180.0);
  const double horizontal =
      2.0 * std::atan(up * view.width / view.height) * 180.0 / std::numbers::pi;
  return hlod::make_frustum(axes.forward, axes.up, std::min(horizontal + wider_deg, 170.0),
                            std::min(view.camera.field_of_view_deg + wider_deg, 170.0));
}

}  // namespace

Layer::Layer(const std::filesystem::path& path, std::uint32_t id, const CellStoreOptions& options,
             GpuCells& cells)
    : id_(id),
      name_(path.filename().string()),
      file_(std::make_shared<const hlod::File>(path)),
      tree_(hlod::make_tree(file_->header(), file_->nodes())),
      store_(file_, options) {
  if (tree_.cells.empty()) throw InputError(path.string(), "holds no cell");
  cell_of_row_.resize(file_->nodes().size());
  parent_.assign(tree_.cells.size(), kNoParent);
  is_present_.assign(tree_.cells.size(), 0);
  is_loaded_.assign(tree_.cells.size(), 0);
  bytes_.assign(tree_.cells.size(), 0);
  const hlod::Lattice& lattice = tree_.lattice;
  lowest_ = lattice.position(tree_.cells.front().lowest, lattice.finest_level);
  highest_ = lattice.position(tree_.cells.front().highest, lattice.finest_level);
  for (std::uint32_t c = 0; c < tree_.cells.size(); ++c) {
    const hlod::TreeCell& cell = tree_.cells[c];
    for (std::uint32_t part = 0; part < cell.parts; ++part) {
      const hlod::Node& node = file_->nodes()[cell.first_node + part];
      cell_of_row_[cell.first_node + part] = c;
      bytes_[c] += static_cast<std::uint32_t>(packed_bytes(node));
      cells.expect(packed_vertices(node), 3 * std::uint64_t{node.triangles});
    }
    all_bytes_ += bytes_[c];
    for (std::uint32_t n = 0; n < cell.children; ++n) parent_[cell.first_child + n] = c;
    if (parent_[c] != kNoParent) continue;
    const Vec3d low = lattice.position(cell.lowest, lattice.finest_level);
    const Vec3d high = lattice.position(cell.highest, lattice.finest_level);
    lowest_ = {std::min(lowest_.x, low.x), std::min(lowest_.y, low.y), std::min(lowest_.z, low.z)};
    highest_ = {std::max(highest_.x, high.x), std::max(highest_.y, high.y),
                std::max(highest_.z, high.z)};
  }
  std::vector<std::uint32_t> roots, rows;
  for (std::uint32_t c = 0; c < tree_.level(0).size(); ++c) {
    roots.push_back(c);
    for (std::uint32_t part = 0; part < tree_.cells[c].parts; ++part)
      rows.push_back(tree_.cells[c].first_node + part);
  }
  store_.want(rows);
  store_.wait();
  if (const auto failures = store_.take_failures(); !failures.empty())
    throw InputError(path.string(), failures.front());
  for (const std::uint32_t root : roots)
    if (!upload(root, no_limit(), cells, 0))
      throw RunError("GPU", "has no room for the coarsest level of " + path.string() +
                                "; give a larger --gpu-memory-mib");
  list_.header = &file_->header();
  list_.nodes = &file_->nodes();
}

void Layer::look(const LayerView& view) {
  eye_ = hlod::fine_eye(view.camera.eye, tree_.lattice);
  wider_ = frustum_of(view, kWiderDeg);
  frustum_ = frustum_of(view, 0.0);
  // A box beside or behind the eye can be on the right side of every plane without being in sight,
  // and of these planes without being so of the wider ones. What is not held ready must not count
  // as seen, or it would hold the level of detail back for good.
  frustum_.add(wider_);
}

/// Finds what radii take, in need_.
bool Layer::fits(const hlod::Radii& radii, std::uint64_t room) {
  hlod::needed_cells(tree_, radii, eye_, wider_, need_);
  if (all_bytes_ <= room) return true;
  std::uint64_t bytes = 0;
  for (const std::uint32_t c : need_) bytes += bytes_[c];
  return bytes <= room;
}

/// Finds the most urgent of what the view needs and lacks, and counts all of that.
void Layer::find_missing(std::size_t most) {
  missing_.clear();
  for (const std::uint32_t c : need_)
    if (is_loaded_[c] == 0) missing_.push_back(c);
  counts_.cells_missing = static_cast<std::uint32_t>(missing_.size());
  hlod::keep_most_urgent(tree_, eye_, most, missing_, urgency_);
}

/// Finds what the eye will need and lack.
void Layer::look_ahead(const LayerView& view) {
  const hlod::FinePoint ahead =
      hlod::fine_eye(view.camera.eye + kAheadSeconds * view.velocity, tree_.lattice);
  const hlod::Radii radii =
      hlod::scaled(hlod::radii_for_eye(tree_, scale_, ahead), share_, tree_.metric);
  hlod::needed_cells(tree_, radii, ahead, wider_, missing_);
  std::erase_if(missing_, [&](std::uint32_t c) { return is_loaded_[c] != 0; });
  hlod::keep_most_urgent(tree_, ahead, kMostAsked, missing_, urgency_);
}

/// Whether radii_ draw nothing but what need_, found with `target`, holds: no radius is larger.
bool Layer::shows_only_need(const hlod::Radii& target) const {
  for (std::size_t l = 0; l < target.of.size(); ++l)
    if (radii_.of[l] > target.of[l]) return false;
  return true;
}

/// How often radii are cut so that what they take has room, and finds that in need_. A walk or two
/// as a rule; a dozen where the view has jumped, which might have taken a hundred one by one.
int Layer::find_room_step(const hlod::Radii& radii, double share, std::uint64_t room) {
  const auto has_room = [&](int step) {
    const double cut = std::min(share, std::pow(kRoomFactor, step));
    return fits(hlod::scaled(radii, cut, tree_.metric), room);
  };
  // Where the frame before had to be cut, this one tries one step less.
  const int first = has_radii_ ? std::max(0, room_step_ - 1) : 0;
  for (int step = first; step < first + kLikelySteps; ++step)
    if (has_room(step)) return step;
  int low = first + kLikelySteps - 1, high = std::max(kRoomStepLimit, low + 1);
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    (has_room(middle) ? high : low) = middle;
  }
  has_room(high);
  return high;
}

hlod::Radii Layer::wanted_radii(const LayerView& view, std::uint64_t capacity_bytes) {
  scale_ = hlod::error_scale(kErrorShare * view.error_pixels, view.height,
                             view.camera.field_of_view_deg);
  const hlod::Radii radii = hlod::radii_for_eye(tree_, scale_, eye_);
  double share = 1.0;
  if (view.triangle_budget > 0)
    share = hlod::share_for_budget(tree_, radii, eye_, frustum_, view.triangle_budget, scratch_);
  if (has_radii_) share = std::min(share, share_ + kShareRisePerSecond * view.seconds);
  const auto room = static_cast<std::uint64_t>(kRoomShare * static_cast<double>(capacity_bytes));
  room_step_ = find_room_step(radii, share, room);
  share_ = std::min(share, std::pow(kRoomFactor, room_step_));
  return hlod::scaled(radii, share_, tree_.metric);
}

void Layer::set_present(std::uint32_t tree_cell, bool is_present) {
  is_present_[tree_cell] = is_present ? 1 : 0;
  std::vector<std::uint32_t> stack{tree_cell};
  while (!stack.empty()) {
    const std::uint32_t c = stack.back();
    stack.pop_back();
    const bool has_parent = parent_[c] == kNoParent || is_loaded_[parent_[c]] != 0;
    // A cell of which nothing is left at its level has nothing to load.
    const std::uint8_t loaded =
        has_parent && (is_present_[c] != 0 || tree_.cells[c].parts == 0) ? 1 : 0;
    if (loaded == is_loaded_[c] && c != tree_cell) continue;
    counts_.cells_loaded += loaded;
    counts_.cells_loaded -= is_loaded_[c];
    is_loaded_[c] = loaded;
    for (std::uint32_t n = 0; n < tree_.cells[c].children; ++n)
      stack.push_back(tree_.cells[c].first_child + n);
  }
}

Layer::UploadLimit Layer::no_limit() {
  constexpr double kForever = std::numeric_limits<double>::infinity();
  return {kForever, kForever, Growth::kAtOnce};
}

/// Bytes that this frame may still take to the GPU in one step.
std::uint64_t Layer::next_upload(const UploadLimit& limit) const {
  const std::uint64_t done = counts_.uploaded_bytes;
  if (done < kLeastUpload) return kLeastUpload - done;
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - limit.start;
  const double left = limit.bytes - static_cast<double>(done);
  if (left < 1.0 || spent.count() >= limit.seconds) return 0;
  return static_cast<std::uint64_t>(std::min(left, static_cast<double>(kLeastUpload)));
}

/// Takes as much of a cell to the GPU as the frame may; true once all of it is there.
bool Layer::upload(std::uint32_t tree_cell, const UploadLimit& limit, GpuCells& cells,
                   std::uint64_t frame) {
  const hlod::TreeCell& cell = tree_.cells[tree_cell];
  dropped_.clear();
  bool is_whole = true;
  for (std::uint32_t part = 0; part < cell.parts && is_whole; ++part) {
    const CellId id{id_, cell.first_node + part};
    if (cells.holds(id)) continue;
    const auto packed = store_.find(id.row);
    std::uint64_t bytes = packed != nullptr ? next_upload(limit) : 0;
    while (bytes > 0 && !cells.holds(id)) {
      bytes = cells.put_part(id, *packed, bytes, frame, dropped_, limit.growth);
      counts_.uploaded_bytes += bytes;
      if (bytes > 0) bytes = next_upload(limit);
    }
    is_whole = cells.holds(id);
  }
  for (const CellId id : dropped_)
    if (id.layer == id_) set_present(cell_of_row_[id.row], false);
  if (is_whole) set_present(tree_cell, true);
  return is_whole;
}

void Layer::stream(const UploadLimit& limit, GpuCells& cells, std::uint64_t frame) {
  counts_.uploaded_bytes = 0;
  rows_.clear();
  for (const std::uint32_t c : missing_) {
    const bool may_upload = next_upload(limit) > 0;
    bool is_held = true;
    for (std::uint32_t part = 0; part < tree_.cells[c].parts; ++part) {
      const std::uint32_t row = tree_.cells[c].first_node + part;
      if (cells.holds({id_, row})) continue;
      // The store knows best what it has: it is asked about each only where that is of use now.
      if (may_upload && store_.find(row)) continue;
      is_held = false;
      rows_.push_back(row);
    }
    if (is_held && may_upload) upload(c, limit, cells, frame);
  }
  store_.want(rows_);
}

void Layer::keep_need(GpuCells& cells, std::uint64_t frame) {
  // The coarsest last: what is left longest unused goes first, and a child is of no use without its
  // parent.
  for (auto c = need_.rbegin(); c != need_.rend(); ++c)
    for (std::uint32_t part = 0; part < tree_.cells[*c].parts; ++part)
      cells.use({id_, tree_.cells[*c].first_node + part}, frame);
}

void Layer::choose(GpuCells& cells, std::uint64_t frame) {
  hlod::select(tree_, radii_, eye_, frustum_, selection_);
  order_.clear();
  for (const std::uint32_t c : selection_.cells) {
    const auto distance =
        static_cast<std::uint64_t>(hlod::cell_distance(tree_, tree_.cells[c], eye_));
    order_.push_back((distance << 32) | c);
  }
  std::sort(order_.begin(), order_.end());
  for (std::size_t i = 0; i < order_.size(); ++i)
    selection_.cells[i] = static_cast<std::uint32_t>(order_[i]);
  list_.eye = eye_;
  list_.slab_distance = hlod::slab_distance(eye_, tree_.metric);
  list_.bands.assign(static_cast<std::size_t>(tree_.metric.finest_level) + 1, {});
  for (int level = 1; level <= tree_.metric.finest_level; ++level)
    if (radii_.of[static_cast<std::size_t>(level) - 1] > 0)
      list_.bands[static_cast<std::size_t>(level)] = hlod::morph_band(radii_, level, tree_.metric);
  list_.items.clear();
  for (const std::uint32_t c : selection_.cells)
    for (std::uint32_t part = 0; part < tree_.cells[c].parts; ++part) {
      const std::uint32_t row = tree_.cells[c].first_node + part;
      if (const auto cell = cells.use({id_, row}, frame)) list_.items.push_back({row, *cell});
    }
  counts_.triangles = selection_.triangles;
  counts_.cells = static_cast<std::uint32_t>(selection_.cells.size());
  counts_.share = share_;
  counts_.store = store_.counts();
}

const DrawList& Layer::update(const LayerView& view, GpuCells& cells, std::uint64_t frame) {
  look(view);
  const hlod::Radii target = wanted_radii(view, cells.capacity_bytes());
  keep_need(cells, frame);
  find_missing(kMostAsked);
  double upload_seconds = view.seconds, spread_seconds = kUploadSeconds;
  if (missing_.empty() && norm(view.velocity) > 0.0) {
    upload_seconds *= view.ahead_share;
    spread_seconds = kUploadAheadSeconds;
    look_ahead(view);
  }
  double missing_bytes = 0.0;
  for (const std::uint32_t c : missing_) missing_bytes += bytes_[c];
  stream({std::min(view.upload_bytes_per_s * upload_seconds,
                   missing_bytes * view.seconds / spread_seconds),
          view.upload_time_share * upload_seconds},
         cells, frame);
  const double share = has_radii_ ? 1.0 - std::exp(-view.seconds / kRadiiSeconds) : 1.0;
  radii_ = hlod::blended(has_radii_ ? radii_ : target, target, share, tree_.metric);
  has_radii_ = true;
  if (counts_.cells_missing > 0 || !shows_only_need(target))
    hlod::hold_to_loaded(tree_, is_loaded_, eye_, frustum_, radii_, walk_);
  choose(cells, frame);
  return list_;
}

bool Layer::settle(const LayerView& view, GpuCells& cells, std::uint64_t frame) {
  look(view);
  has_radii_ = false;
  const hlod::Radii target = wanted_radii(view, cells.capacity_bytes());
  std::size_t missing_before = std::numeric_limits<std::size_t>::max();
  while (true) {
    keep_need(cells, frame);
    find_missing(need_.size());
    if (missing_.empty() || missing_.size() >= missing_before) break;
    missing_before = missing_.size();
    // In batches that the store can hold.
    stream(no_limit(), cells, frame);
    store_.wait();
    stream(no_limit(), cells, frame);
  }
  radii_ = target;
  has_radii_ = true;
  hlod::hold_to_loaded(tree_, is_loaded_, eye_, frustum_, radii_, walk_);
  choose(cells, frame);
  return counts_.cells_missing == 0;
}

std::optional<double> Layer::ground_at(double x, double y, double below) {
  const hlod::Lattice& lattice = tree_.lattice;
  const hlod::FinePoint at = hlod::fine_eye({x, y, below}, lattice);
  std::vector<double> heights;
  std::vector<std::uint32_t> stack;
  for (std::uint32_t c = 0; c < tree_.level(0).size(); ++c) stack.push_back(c);
  while (!stack.empty()) {
    const std::uint32_t c = stack.back();
    stack.pop_back();
    const hlod::TreeCell& cell = tree_.cells[c];
    if (at.x < cell.lowest.x || at.x > cell.highest.x || at.y < cell.lowest.y ||
        at.y > cell.highest.y || is_loaded_[c] == 0)
      continue;
    const auto children = std::span(is_loaded_).subspan(cell.first_child, cell.children);
    if (!children.empty() && std::find(children.begin(), children.end(), 0) == children.end()) {
      for (std::uint32_t n = 0; n < cell.children; ++n) stack.push_back(cell.first_child + n);
      continue;
    }
    const double step = lattice.step(cell.key.level);
    for (std::uint32_t part = 0; part < cell.parts; ++part) {
      const auto packed = store_.find(cell.first_node + part);
      if (!packed) continue;
      const std::size_t first = heights.size();
      heights_at(*packed, file_->nodes()[cell.first_node + part].lowest,
                 (x - lattice.origin.x) / step, (y - lattice.origin.y) / step, heights);
      for (std::size_t i = first; i < heights.size(); ++i)
        heights[i] = lattice.origin.z + step * heights[i];
    }
  }
  std::optional<double> under, over;
  for (const double z : heights) {
    if (z <= below) under = std::max(under.value_or(z), z);
    if (z > below) over = std::min(over.value_or(z), z);
  }
  return under ? under : over;
}

}  // namespace cornice::viewer
