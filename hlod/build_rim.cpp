// SPDX-License-Identifier: GPL-3.0-or-later
// Who else uses a vertex: every cell reports those of its vertices that lie in another cell to
// that cell, which knows whether it has them itself and tells all of them.
#include <algorithm>
#include <array>
#include <mutex>
#include <tuple>
#include <utility>

#include "core/base/parallel.h"
#include "hlod/build_leaves.h"
#include "hlod/octahedral_lanes.h"
#include "hlod/position_table.h"

namespace cornice::hlod {
namespace {

CellKey cell_of_point(LatticePoint p, const CellKey& like, const Header& header) {
  const int bits = header.lattice.cell_bits;
  return {like.level, p.x >> bits, p.y >> bits,
          header.partition == Partition::kQuadtree ? 0 : p.z >> bits};
}

Vec3f sum_of(const BuildCell& cell, std::uint32_t vertex) {
  return cell.normal_sums.empty() ? Vec3f{} : cell.normal_sums[vertex];
}

auto place_of(const RimVertex& r) {
  return std::tuple(r.data.position.x, r.data.position.y, r.data.position.z);
}

}  // namespace

std::vector<RimVertex> rim_of(const BuildCell& cell, const Header& header) {
  std::vector<RimVertex> rim;
  for (std::uint32_t v = 0; v < cell.vertices.size(); ++v) {
    const CellKey home = cell_of_point(cell.vertices[v].position, cell.key, header);
    if (home != cell.key) rim.push_back({home, cell.key, v, cell.vertices[v], sum_of(cell, v)});
  }
  return rim;
}

std::vector<RimAnswer> answer_rim(const BuildCell& home, std::vector<RimVertex> rim) {
  PositionTable table;
  table.reset(home.vertices.size());
  const auto position = [&](std::uint32_t v) { return home.vertices[v].position; };
  for (std::uint32_t v = 0; v < home.vertices.size(); ++v) {
    table.find_or_add(home.vertices[v].position, v, position);
  }
  const std::size_t reported = rim.size();
  for (std::size_t i = 0; i < reported; ++i) {
    const std::uint32_t own = table.find(rim[i].data.position, position);
    if (own != PositionTable::kEmpty) {
      rim.push_back({home.key, home.key, own, home.vertices[own], sum_of(home, own)});
    }
  }
  std::sort(rim.begin(), rim.end(), [](const RimVertex& a, const RimVertex& b) {
    return std::tuple(place_of(a), a.cell) < std::tuple(place_of(b), b.cell);
  });
  const auto same = [](const RimVertex& a, const RimVertex& b) {
    return a.data.position == b.data.position && a.cell == b.cell;
  };
  rim.erase(std::unique(rim.begin(), rim.end(), same), rim.end());
  std::vector<RimAnswer> answers;
  for (std::size_t begin = 0, end = 0; begin < rim.size(); begin = end) {
    Vec3f sum;
    for (end = begin; end < rim.size() && rim[end].data.position == rim[begin].data.position;
         ++end) {
      sum += rim[end].normal_sum;
    }
    for (std::size_t user = begin; user < end; ++user) {
      std::uint32_t sharers = 0;
      for (std::size_t other = begin; other < end; ++other) {
        if (other != user) sharers |= sharer_bit(rim[user].cell, rim[other].cell);
      }
      answers.push_back({rim[user].cell, rim[user].vertex, sharers, rim[begin].data, sum});
    }
  }
  return answers;
}

std::vector<RimAnswer> answer_all(std::vector<RimVertex> rim, const FindCell& find, int threads) {
  std::sort(rim.begin(), rim.end(), [](const RimVertex& a, const RimVertex& b) {
    return std::tie(a.home, a.cell, a.vertex) < std::tie(b.home, b.cell, b.vertex);
  });
  std::vector<std::size_t> begins;
  for (std::size_t i = 0; i < rim.size(); ++i) {
    if (i == 0 || rim[i].home != rim[i - 1].home) begins.push_back(i);
  }
  begins.push_back(rim.size());
  std::mutex mutex;
  std::vector<RimAnswer> answers;
  parallel_for(begins.size() - 1, 1, threads, [&](std::size_t h, std::size_t) {
    BuildCell buffer;
    const BuildCell* const home = find(rim[begins[h]].home, buffer);
    const std::vector<RimAnswer> own =
        answer_rim(*home, {rim.begin() + static_cast<std::ptrdiff_t>(begins[h]),
                           rim.begin() + static_cast<std::ptrdiff_t>(begins[h + 1])});
    const std::lock_guard lock(mutex);
    answers.insert(answers.end(), own.begin(), own.end());
  });
  std::sort(answers.begin(), answers.end(), [](const RimAnswer& a, const RimAnswer& b) {
    return std::tie(a.cell, a.vertex) < std::tie(b.cell, b.vertex);
  });
  return answers;
}

std::span<const RimAnswer> answers_for(const CellKey& cell, const std::vector<RimAnswer>& all) {
  const auto [begin, end] =
      std::equal_range(all.begin(), all.end(), RimAnswer{cell, 0, 0, {}, {}},
                       [](const RimAnswer& a, const RimAnswer& b) { return a.cell < b.cell; });
  return {begin, end};
}

void put_sharers(BuildCell& cell, std::span<const RimAnswer> answers) {
  cell.sharers.assign(cell.vertices.size(), 0);
  for (const RimAnswer& answer : answers) cell.sharers[answer.vertex] = answer.sharers;
}

void finish_leaf(BuildCell& cell, std::span<const RimAnswer> answers, int normal_bits) {
  put_sharers(cell, answers);
  for (const RimAnswer& answer : answers) {
    cell.vertices[answer.vertex] = answer.data;
    if (!cell.normal_sums.empty()) cell.normal_sums[answer.vertex] = answer.normal_sum;
  }
  encode_octahedral(
      0, cell.normal_sums.size(), normal_bits, [&](std::size_t v) { return cell.normal_sums[v]; },
      [&](std::size_t v, std::array<std::int16_t, 2> n) { cell.vertices[v].normal = n; });
  cell.normal_sums = {};
}

namespace {

/// Rims of cells in memory, and the answers to them.
std::vector<RimAnswer> answers_in_memory(const std::vector<BuildCell>& cells, const Header& header,
                                         int threads) {
  std::vector<std::vector<RimVertex>> rims(cells.size());
  parallel_for(cells.size(), 8, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) rims[c] = rim_of(cells[c], header);
  });
  std::vector<RimVertex> rim;
  for (auto& part : rims) rim.insert(rim.end(), part.begin(), part.end());
  rims = {};
  const auto find = [&](const CellKey& key, BuildCell& buffer) -> const BuildCell* {
    const auto found =
        std::lower_bound(cells.begin(), cells.end(), key,
                         [](const BuildCell& cell, const CellKey& k) { return cell.key < k; });
    if (found != cells.end() && found->key == key) return &*found;
    buffer.key = key;
    return &buffer;
  };
  return answer_all(std::move(rim), find, threads);
}

}  // namespace

void connect_cells(std::vector<BuildCell>& cells, const Header& header, int threads) {
  const std::vector<RimAnswer> answers = answers_in_memory(cells, header, threads);
  parallel_for(cells.size(), 8, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      put_sharers(cells[c], answers_for(cells[c].key, answers));
    }
  });
}

std::vector<BuildCell> finish_leaves(std::vector<std::vector<BuildCell>> pieces,
                                     const Header& header, int threads, LeafCounts& counts) {
  std::vector<BuildCell> all;
  for (auto& part : pieces) {
    for (BuildCell& piece : part) all.push_back(std::move(piece));
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const BuildCell& a, const BuildCell& b) { return a.key < b.key; });
  std::vector<std::size_t> begins;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (i == 0 || all[i].key != all[i - 1].key) begins.push_back(i);
  }
  begins.push_back(all.size());
  const std::size_t count = begins.size() - 1;
  std::vector<BuildCell> cells(count);
  std::vector<LeafCounts> cell_counts(count);
  parallel_for(count, 8, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      std::vector<BuildCell> own(
          std::make_move_iterator(all.begin() + static_cast<std::ptrdiff_t>(begins[c])),
          std::make_move_iterator(all.begin() + static_cast<std::ptrdiff_t>(begins[c + 1])));
      cells[c] = join_pieces(std::move(own), cell_counts[c]);
    }
  });
  for (const LeafCounts& c : cell_counts) counts.duplicate += c.duplicate;
  const std::vector<RimAnswer> answers = answers_in_memory(cells, header, threads);
  parallel_for(count, 8, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      finish_leaf(cells[c], answers_for(cells[c].key, answers), header.normal_bits);
    }
  });
  return cells;
}

}  // namespace cornice::hlod
