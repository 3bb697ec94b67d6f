// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/remesh/patches.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>

#include "core/base/parallel.h"
#include "core/base/random.h"

namespace cornice::remesh {
namespace {

/// Local number of each vertex of the whole mesh; kNoSource between uses. One for each thread at
/// work.
class NumberPool {
 public:
  explicit NumberPool(std::size_t vertices) : vertices_(vertices) {}
  std::unique_ptr<std::vector<std::uint32_t>> take() {
    const std::scoped_lock lock(mutex_);
    if (free_.empty()) return std::make_unique<std::vector<std::uint32_t>>(vertices_, kNoSource);
    auto numbers = std::move(free_.back());
    free_.pop_back();
    return numbers;
  }
  void give_back(std::unique_ptr<std::vector<std::uint32_t>> numbers) {
    const std::scoped_lock lock(mutex_);
    free_.push_back(std::move(numbers));
  }

 private:
  std::size_t vertices_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<std::vector<std::uint32_t>>> free_;
};

/// Fixes the vertices whose triangles do not close a ring within the patch. Round a closed ring the
/// vertices that follow are those that lead; sums of their hashes tell, without a sort.
void fix_rim(Patch& patch) {
  std::vector<std::uint64_t> balance(patch.vertices.size(), 0);
  for (const Triangle& t : patch.triangles) {
    for (int k = 0; k < 3; ++k) {
      balance[t[k]] += mix64(t[(k + 1) % 3] + 1ULL) - mix64(t[(k + 2) % 3] + 1ULL);
    }
  }
  for (std::size_t v = 0; v < balance.size(); ++v) {
    if (balance[v] != 0) patch.fixed[v] |= 1;
  }
}

void fill_patch(const WorkMesh& mesh, const Patches& patches, std::size_t index,
                std::vector<std::uint32_t>& numbers, Patch& patch) {
  const std::size_t begin = patches.first[index], end = patches.first[index + 1];
  patch.triangles.reserve(end - begin);
  patch.vertices.reserve((end - begin) / 2 + 64);
  for (std::size_t i = begin; i < end; ++i) {
    Triangle local{};
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t v = mesh.triangles[patches.triangles[i]][k];
      if (numbers[v] == kNoSource) {
        numbers[v] = static_cast<std::uint32_t>(patch.vertices.size());
        patch.vertices.push_back(v);
      }
      local[k] = numbers[v];
    }
    patch.triangles.push_back(local);
  }
  patch.fixed.resize(patch.vertices.size());
  for (std::size_t v = 0; v < patch.vertices.size(); ++v) {
    patch.fixed[v] = mesh.fixed[patch.vertices[v]];
    numbers[patch.vertices[v]] = kNoSource;
  }
  fix_rim(patch);
}

}  // namespace

Patches cut_patches(const WorkMesh& mesh, double side_m, double shift_x, double shift_y) {
  float low_x = std::numeric_limits<float>::infinity(), low_y = low_x;
  float high_x = -low_x, high_y = -low_x;
  for (const Triangle& t : mesh.triangles) {
    const Vec3f& p = mesh.positions[t[0]];
    low_x = std::min(low_x, p.x), high_x = std::max(high_x, p.x);
    low_y = std::min(low_y, p.y), high_y = std::max(high_y, p.y);
  }
  Patches patches;
  patches.first.assign(1, 0);
  if (mesh.triangles.empty()) return patches;
  // By the first corner: where a triangle belongs matters little, that it is quick does.
  const auto side = static_cast<float>(side_m);
  const float from_x = low_x - static_cast<float>((1.0 - shift_x) * side_m);
  const float from_y = low_y - static_cast<float>((1.0 - shift_y) * side_m);
  const auto columns = static_cast<std::uint32_t>((high_x - from_x) / side) + 1;
  const auto rows = static_cast<std::uint32_t>((high_y - from_y) / side) + 1;
  const auto patch_of = [&](const Triangle& t) {
    const Vec3f& p = mesh.positions[t[0]];
    return static_cast<std::uint32_t>((p.y - from_y) / side) * columns +
           static_cast<std::uint32_t>((p.x - from_x) / side);
  };
  patches.first.assign(static_cast<std::size_t>(columns) * rows + 1, 0);
  for (const Triangle& t : mesh.triangles) ++patches.first[patch_of(t) + 1];
  for (std::size_t p = 1; p < patches.first.size(); ++p) patches.first[p] += patches.first[p - 1];
  patches.triangles.resize(mesh.triangles.size());
  std::vector<std::uint32_t> at(patches.first.begin(), patches.first.end() - 1);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    patches.triangles[at[patch_of(mesh.triangles[t])]++] = t;
  }
  return patches;
}

void for_each_patch(const WorkMesh& mesh, const Patches& patches,
                    const std::vector<std::uint8_t>& chosen, int threads, Progress& progress,
                    const std::function<void(std::size_t index, Patch& patch)>& work) {
  const auto count = [&](std::size_t index) {
    return patches.first[index + 1] - patches.first[index];
  };
  std::vector<std::uint32_t> order;
  for (std::uint32_t index = 0; index < patches.size(); ++index) {
    if (count(index) > 0 && (chosen.empty() || chosen[index] != 0)) order.push_back(index);
  }
  // Largest first: all threads end at about the same time.
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return count(a) > count(b); });
  NumberPool pool(mesh.positions.size());
  parallel_for(order.size(), 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t index = order[i];
      check_cancelled(progress);
      auto numbers = pool.take();
      Patch patch;
      fill_patch(mesh, patches, index, *numbers, patch);
      pool.give_back(std::move(numbers));
      work(index, patch);
      progress.advance(count(index));
    }
  });
}

}  // namespace cornice::remesh
