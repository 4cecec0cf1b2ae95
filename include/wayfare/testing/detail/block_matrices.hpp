#pragma once

// Symmetric block matrices of many patterns, for the laws of linear solvers.

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/random.hpp>
#include <wayfare/graph/linear_solver.hpp>

namespace wayfare::testing {

/// (row, column) of off-diagonal blocks.
using BlockPairs = std::vector<std::pair<int, int>>;

/// A pattern with a name.
struct Shape {
  std::string name;
  int columns = 0;
  BlockPairs pairs;
};

/// Pairs in either order, with repeats.
[[nodiscard]] inline BlockPairs random_pairs(Rng& rng, int columns, int couplings) {
  BlockPairs pairs;
  for (int k = 0; k < couplings; ++k) {
    const int a = static_cast<int>(rng.below(columns));
    const int b = static_cast<int>(rng.below(columns));
    if (a != b) pairs.emplace_back(a, b);
  }
  return pairs;
}

/// Columns a … b − 1, all coupled to each other.
inline void join_all(int a, int b, BlockPairs& pairs) {
  for (int i = a; i < b; ++i)
    for (int j = i + 1; j < b; ++j) pairs.emplace_back(j, i);
}

[[nodiscard]] inline Shape chain(int n) {
  Shape s{"chain", n, {}};
  for (int i = 1; i < n; ++i) s.pairs.emplace_back(i - 1, i);
  return s;
}

/// All coupled only to column `hub`.
[[nodiscard]] inline Shape arrow(int n, int hub) {
  Shape s{"arrow", n, {}};
  for (int i = 0; i < n; ++i)
    if (i != hub) s.pairs.emplace_back(i, hub);
  return s;
}

[[nodiscard]] inline Shape grid(int width, int height) {
  Shape s{"grid", width * height, {}};
  for (int i = 0; i < s.columns; ++i) {
    if (i % width > 0) s.pairs.emplace_back(i, i - 1);
    if (i >= width) s.pairs.emplace_back(i, i - width);
  }
  return s;
}

/// Special cases of a factorisation.
[[nodiscard]] inline std::vector<Shape> all_shapes(Rng& rng) {
  std::vector<Shape> shapes = {
      {"one block", 1, {}}, {"diagonal", 7, {}}, chain(2),      chain(40),
      arrow(30, 0),         arrow(30, 29),       arrow(90, 40), grid(7, 6)};
  Shape dense{"dense", 23, {}};
  join_all(0, 23, dense.pairs);
  shapes.push_back(dense);
  Shape apart = grid(4, 4);  // with a clique and isolated columns
  apart.name = "disconnected";
  apart.columns = 30;
  join_all(20, 26, apart.pairs);
  shapes.push_back(apart);
  for (const auto& [n, couplings] : {std::pair{12, 14}, {30, 45}, {50, 200}, {40, 700}})
    shapes.push_back({"random", n, random_pairs(rng, n, couplings)});
  return shapes;
}

/// Large enough for several threads, small enough for a quick test.
[[nodiscard]] inline std::vector<Shape> large_shapes(int block, Rng& rng) {
  const int side = block == 6 ? 36 : 80, half = side * side;
  const Shape one = grid(side, side);
  Shape apart = one;  // with a copy of it and isolated columns
  apart.name = "disconnected";
  apart.columns = 2 * half + 50;
  for (const auto& [a, b] : one.pairs) apart.pairs.emplace_back(a + half, b + half);
  return {one, apart, {"random", 300, random_pairs(rng, 300, 450)}};
}

/// visit(row, column, index) for every off-diagonal block.
template <int N, class Visit>
void each_coupling(const BlockSparse<N>& h, const Visit& visit) {
  h.each_block([&](int r, int c, int i) {
    if (r != c) visit(r, c, i);
  });
}

/// The dense symmetric matrix of the upper triangle's blocks.
template <int N>
[[nodiscard]] Eigen::MatrixXd dense(const BlockSparse<N>& h) {
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(h.columns() * N, h.columns() * N);
  h.each_block([&](int r, int c, int i) { all.block<N, N>(r * N, c * N) = h.block(i); });
  return all.selfadjointView<Eigen::Upper>();
}

/// Fills the pattern with a diagonally dominant matrix; returns it dense.
template <int N>
Eigen::MatrixXd fill(BlockSparse<N>& h, Rng& rng) {
  const int n = h.columns() * N;
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(n, n);
  each_coupling(h, [&](int r, int c, int i) {
    for (double& v : h.block(i).reshaped()) v = rng.uniform(-1, 1);
    dense.block<N, N>(r * N, c * N) = h.block(i);
    dense.block<N, N>(c * N, r * N) = h.block(i).transpose();
  });
  for (int k = 0; k < n; ++k) dense(k, k) = dense.row(k).cwiseAbs().sum() + rng.uniform(0.1, 1.0);
  for (int c = 0; c < h.columns(); ++c)
    h.block(h.diagonal_index(c)) = dense.block<N, N>(c * N, c * N);
  return dense;
}

/// Fills a pattern that is too large for a dense matrix; diagonally dominant.
template <int N>
void fill_dominant(BlockSparse<N>& h, Rng& rng) {
  std::vector<int> met(static_cast<std::size_t>(h.columns()), 1);
  each_coupling(h, [&](int r, int c, int i) {
    for (double& v : h.block(i).reshaped()) v = rng.uniform(-1, 1);
    ++met[static_cast<std::size_t>(c)];
    ++met[static_cast<std::size_t>(r)];
  });
  for (int c = 0; c < h.columns(); ++c) {
    h.block(h.diagonal_index(c)).setIdentity();
    h.block(h.diagonal_index(c)) *= static_cast<double>(N * met[static_cast<std::size_t>(c)]);
  }
}

/// Fills the pattern with couplings alone, as of relative measurements with random information:
/// H = Σ (e_r − e_c)(e_r − e_c)ᵀ ⊗ Ω_rc. Its null vectors have the same numbers in every block of
/// a connected part.
template <int N>
void fill_relative(BlockSparse<N>& h, Rng& rng) {
  h.set_zero();
  each_coupling(h, [&](int r, int c, int i) {
    Eigen::Matrix<double, N, N> root;
    for (double& v : root.reshaped()) v = rng.uniform(-1, 1);
    const Eigen::Matrix<double, N, N> information =
        root * root.transpose() + Eigen::Matrix<double, N, N>::Identity();
    h.block(i) -= information;
    h.block(h.diagonal_index(r)) += information;
    h.block(h.diagonal_index(c)) += information;
  });
}

}  // namespace wayfare::testing
