#pragma once

// Random block matrices and their dense equivalents.

#include <cstdint>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <wayfare/core/random.hpp>
#include <wayfare/graph/linear_solver.hpp>

namespace wayfare::tests {

/// Pairs in either order, with repeats.
inline std::vector<std::pair<int, int>> random_pairs(Rng& rng, int columns, int couplings) {
  std::vector<std::pair<int, int>> pairs;
  for (int k = 0; k < couplings; ++k) {
    const int a = static_cast<int>(rng.below(static_cast<std::uint64_t>(columns)));
    const int b = static_cast<int>(rng.below(static_cast<std::uint64_t>(columns)));
    if (a != b) pairs.emplace_back(a, b);
  }
  return pairs;
}

/// The dense symmetric matrix of the upper triangle's blocks.
template <int N>
Eigen::MatrixXd dense(const BlockSparse<N>& h) {
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(h.columns() * N, h.columns() * N);
  for (int c = 0; c < h.columns(); ++c)
    for (int i = h.starts()[static_cast<std::size_t>(c)]; i <= h.diagonal_index(c); ++i)
      all.block<N, N>(h.rows()[static_cast<std::size_t>(i)] * N, c * N) = h.block(i);
  return all.selfadjointView<Eigen::Upper>();
}

/// Fills the pattern with a diagonally dominant matrix; returns it dense.
template <int N>
Eigen::MatrixXd fill(BlockSparse<N>& h, Rng& rng) {
  const int n = h.columns() * N;
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(n, n);
  for (int c = 0; c < h.columns(); ++c) {
    for (int i = h.starts()[static_cast<std::size_t>(c)]; i < h.diagonal_index(c); ++i) {
      for (double& v : h.block(i).reshaped()) v = rng.uniform(-1, 1);
      const int r = h.rows()[static_cast<std::size_t>(i)];
      dense.block<N, N>(r * N, c * N) = h.block(i);
      dense.block<N, N>(c * N, r * N) = h.block(i).transpose();
    }
  }
  for (int k = 0; k < n; ++k) dense(k, k) = dense.row(k).cwiseAbs().sum() + rng.uniform(0.1, 1.0);
  for (int c = 0; c < h.columns(); ++c) {
    h.block(h.diagonal_index(c)) = dense.block<N, N>(c * N, c * N);
  }
  return dense;
}

/// Expects the solutions of a dense factorisation, twice on one pattern with different values.
template <class Solver>
void expect_solves(Solver& solver, BlockSparse<Solver::kBlock>& h, Rng& rng) {
  solver.analyse(h);
  for (int again = 0; again < 2; ++again) {
    const Eigen::MatrixXd dense = fill(h, rng);
    ASSERT_TRUE(solver.factorise(h).ok);
    const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(dense.rows(), -1.0, 2.0);
    Eigen::VectorXd x = b;
    solver.solve_in_place(x);
    EXPECT_LT((dense.llt().solve(b) - x).norm(), 1e-12 * b.norm());
  }
}

/// Fills a pattern that is too large for a dense matrix; diagonally dominant.
template <int N>
void fill_dominant(BlockSparse<N>& h, Rng& rng) {
  std::vector<int> met(static_cast<std::size_t>(h.columns()), 1);
  for (int c = 0; c < h.columns(); ++c) {
    for (int i = h.starts()[static_cast<std::size_t>(c)]; i < h.diagonal_index(c); ++i) {
      for (double& v : h.block(i).reshaped()) v = rng.uniform(-1, 1);
      ++met[static_cast<std::size_t>(c)];
      ++met[static_cast<std::size_t>(h.rows()[static_cast<std::size_t>(i)])];
    }
  }
  for (int c = 0; c < h.columns(); ++c) {
    h.block(h.diagonal_index(c)).setIdentity();
    h.block(h.diagonal_index(c)) *= static_cast<double>(N * met[static_cast<std::size_t>(c)]);
  }
}

}  // namespace wayfare::tests
