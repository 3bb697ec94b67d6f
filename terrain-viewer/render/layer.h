// SPDX-License-Identifier: GPL-3.0-or-later
// One .hlod file in a scene: what of it to draw, what to read, what to keep on the GPU.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hlod/file.h"
#include "hlod/select.h"
#include "terrain-viewer/render/gpu_cells.h"
#include "terrain-viewer/render/terrain_renderer.h"
#include "terrain-viewer/scene/camera.h"
#include "terrain-viewer/stream/cell_store.h"

namespace cornice::viewer {

/// What a frame asks of a layer.
struct LayerView {
  Camera camera;
  int width = 0, height = 0;
  double error_pixels = 2.0;          ///< that the surface may be off on the screen
  std::uint64_t triangle_budget = 0;  ///< 0: none
  double seconds = 0.0;               ///< since the frame before
  Vec3d velocity;                     ///< of the eye, metres a second: what comes is read ahead
  double upload_bytes_per_s = 192e6;  ///< to the GPU, but Layer::kLeastUpload a frame at least
  double upload_time_share = 0.015;   ///< of `seconds` that uploads may take up, likewise
  double ahead_share = 0.4;           ///< of both, for what is not needed yet
};

struct LayerCounts {
  std::uint64_t triangles = 0;  ///< selected
  std::uint32_t cells = 0;      ///< selected
  std::uint32_t cells_loaded = 0;
  std::uint32_t cells_missing = 0;   ///< that the view needs
  std::uint64_t uploaded_bytes = 0;  ///< in this frame
  double share = 1.0;                ///< of the radii that budgets leave
  CellStoreCounts store;
};

/// All functions are for the thread of the OpenGL context.
class Layer {
 public:
  /// Opens the file and puts its coarsest level on the GPU. Throws InputError for a damaged file
  /// and RunError where the GPU has no room for that level.
  Layer(const std::filesystem::path& path, std::uint32_t id, const CellStoreOptions& options,
        GpuCells& cells);

  /// Of the file, without its folder.
  const std::string& name() const { return name_; }
  const hlod::File& file() const { return *file_; }
  const hlod::Tree& tree() const { return tree_; }
  /// Box of everything, projected CRS.
  Vec3d lowest() const { return lowest_; }
  Vec3d highest() const { return highest_; }

  /// Bytes that a frame may take to the GPU whatever its time, and in one step: large cells come in
  /// parts.
  static constexpr std::uint64_t kLeastUpload = 64u << 10;

  /// Chooses and streams for one frame; frame numbers rise.
  const DrawList& update(const LayerView& view, GpuCells& cells, std::uint64_t frame);
  /// The same, waiting for all that the view needs: for pictures. False where the GPU's room or a
  /// damaged cell kept it from being all.
  bool settle(const LayerView& view, GpuCells& cells, std::uint64_t frame);
  /// Height of the ground in plan, of the finest loaded cells: the highest surface that is at most
  /// `below`, else the lowest above it. Nothing where there is no ground.
  std::optional<double> ground_at(double x, double y, double below);
  /// Chosen last.
  const DrawList& list() const { return list_; }
  /// Indices into the tree of what was chosen last, the nearest first.
  const std::vector<std::uint32_t>& chosen() const { return selection_.cells; }
  const LayerCounts& counts() const { return counts_; }
  std::vector<std::string> take_failures() { return store_.take_failures(); }

 private:
  hlod::Radii wanted_radii(const LayerView& view, std::uint64_t capacity_bytes);
  void look(const LayerView& view);
  bool fits(const hlod::Radii& radii, std::uint64_t room);
  int find_room_step(const hlod::Radii& radii, double share, std::uint64_t room);
  void find_missing(std::size_t most);
  void look_ahead(const LayerView& view);
  bool shows_only_need(const hlod::Radii& target) const;
  /// What a frame may take up to the GPU.
  struct UploadLimit {
    double bytes = 0.0, seconds = 0.0;
    Growth growth = Growth::kSoon;
    std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
  };
  static UploadLimit no_limit();
  std::uint64_t next_upload(const UploadLimit& limit) const;
  void stream(const UploadLimit& limit, GpuCells& cells, std::uint64_t frame);
  bool upload(std::uint32_t tree_cell, const UploadLimit& limit, GpuCells& cells,
              std::uint64_t frame);
  void keep_need(GpuCells& cells, std::uint64_t frame);
  void set_present(std::uint32_t tree_cell, bool is_present);
  void choose(GpuCells& cells, std::uint64_t frame);

  std::uint32_t id_;
  std::string name_;
  std::shared_ptr<const hlod::File> file_;
  hlod::Tree tree_;
  Vec3d lowest_, highest_;
  CellStore store_;
  std::vector<std::uint32_t> cell_of_row_;  ///< index into the tree by row of the node table
  std::vector<std::uint32_t> parent_;       ///< by index into the tree
  std::vector<std::uint8_t> is_present_;    ///< all parts are on the GPU
  std::vector<std::uint8_t> is_loaded_;     ///< present, and so are all ancestors
  std::vector<std::uint32_t> bytes_;        ///< on the GPU, by index into the tree
  std::uint64_t all_bytes_ = 0;
  std::vector<std::uint32_t> need_;  ///< what this frame's view takes, coarse before fine
  double scale_ = 0.0;               ///< hlod::error_scale of the view
  double share_ = 1.0;
  int room_step_ = 0;  ///< times that kRoomFactor was needed to fit the GPU's room
  hlod::FinePoint eye_;
  hlod::Frustum frustum_;  ///< of what is seen
  hlod::Frustum wider_;    ///< of what is held ready
  hlod::Radii radii_;
  bool has_radii_ = false;
  std::vector<std::uint32_t> missing_;  ///< what stream() is to get, the most urgent first
  hlod::Selection selection_, scratch_;
  hlod::UrgencyMemory urgency_;  ///< memory that is used again, as all below
  hlod::WalkMemory walk_;
  std::vector<std::uint64_t> order_;  ///< of choose()
  std::vector<std::uint32_t> rows_;   ///< of stream()
  std::vector<CellId> dropped_;       ///< of upload()
  DrawList list_;
  LayerCounts counts_;
};

}  // namespace cornice::viewer
