// SPDX-License-Identifier: GPL-3.0-or-later
// Symmetric positive definite systems that are block tridiagonal (a state per node of a path) with
// a few unknowns common to all nodes at the border:
//
//   | A0 U0          B0 |
//   | U0' A1 U1      B1 |      solved in one sweep down and one up, with the diagonal
//   |     U1' A2 ... B2 |      blocks of the inverse, which are the covariances.
//   | B0' B1' B2 ... C  |
#pragma once

#include <Eigen/Dense>
#include <cstddef>
#include <vector>

namespace cornice::flightlines {

/// `Size` unknowns a node, `Common` unknowns at the border.
template <int Size, int Common>
struct BlockSystem {
  using Block = Eigen::Matrix<double, Size, Size>;
  using Column = Eigen::Matrix<double, Size, 1>;
  using Border = Eigen::Matrix<double, Size, Common>;
  std::vector<Block> diagonal;
  std::vector<Block> upper;  ///< one fewer than nodes
  std::vector<Border> border;
  std::vector<Column> right;
  Eigen::Matrix<double, Common, Common> corner;
  Eigen::Matrix<double, Common, 1> corner_right;

  explicit BlockSystem(std::size_t nodes)
      : diagonal(nodes, Block::Zero()),
        upper(nodes > 0 ? nodes - 1 : 0, Block::Zero()),
        border(nodes, Border::Zero()),
        right(nodes, Column::Zero()) {
    corner.setZero();
    corner_right.setZero();
  }
};

template <int Size, int Common>
struct BlockSolution {
  std::vector<Eigen::Matrix<double, Size, 1>> nodes;
  Eigen::Matrix<double, Common, 1> common;
  std::vector<Eigen::Matrix<double, Size, 1>> variances;  ///< diagonal of the inverse
  Eigen::Matrix<double, Common, 1> common_variances;
};

/// Solves the system; variances only where asked. The system is left factored.
template <int Size, int Common>
BlockSolution<Size, Common> solve_blocks(BlockSystem<Size, Common>& system, bool with_variances) {
  using Block = typename BlockSystem<Size, Common>::Block;
  using Wide = Eigen::Matrix<double, Size, Common + 1>;
  const std::size_t n = system.diagonal.size();
  std::vector<Block> inverse(n), link(n);
  std::vector<Wide> wide(n);
  for (std::size_t k = 0; k < n; ++k) {
    wide[k] << system.right[k], system.border[k];
    if (k > 0) {
      system.diagonal[k] -= system.upper[k - 1].transpose() * link[k - 1];
      wide[k] -= link[k - 1].transpose() * wide[k - 1];
    }
    inverse[k] = system.diagonal[k].llt().solve(Block::Identity());
    if (k + 1 < n) link[k] = inverse[k] * system.upper[k];
  }
  for (std::size_t k = n; k-- > 0;) {
    wide[k] = (inverse[k] * wide[k]).eval();
    if (k + 1 < n) wide[k] -= link[k] * wide[k + 1];
  }
  Eigen::Matrix<double, Common, Common> schur = system.corner;
  Eigen::Matrix<double, Common, 1> rest = system.corner_right;
  for (std::size_t k = 0; k < n; ++k) {
    schur -= system.border[k].transpose() * wide[k].template rightCols<Common>();
    rest -= system.border[k].transpose() * wide[k].col(0);
  }
  const Eigen::Matrix<double, Common, Common> schur_inverse = schur.inverse();
  BlockSolution<Size, Common> solution;
  solution.common = schur_inverse * rest;
  solution.common_variances = schur_inverse.diagonal();
  solution.nodes.resize(n);
  for (std::size_t k = 0; k < n; ++k)
    solution.nodes[k] = wide[k].col(0) - wide[k].template rightCols<Common>() * solution.common;
  if (!with_variances) return solution;
  solution.variances.resize(n);
  Block covariance = inverse[n - 1];
  for (std::size_t k = n; k-- > 0;) {
    if (k + 1 < n) covariance = (inverse[k] + link[k] * covariance * link[k].transpose()).eval();
    const auto common_part = wide[k].template rightCols<Common>();
    solution.variances[k] =
        covariance.diagonal() + (common_part * schur_inverse * common_part.transpose()).diagonal();
  }
  return solution;
}

}  // namespace cornice::flightlines
