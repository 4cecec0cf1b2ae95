#pragma once

// The laws of the LinearSolver concept, and of ThreadedSolver and SelectedInverse where a solver is
// one, as checks on any type:
//
//   TEST(MySolver, IsALinearSolver) { wayfare::testing::SolverLaws<MySolver>{}.check(); }

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <wayfare/core/random.hpp>
#include <wayfare/graph/linear_solver.hpp>
#include <wayfare/testing/detail/block_matrices.hpp>

namespace wayfare::testing {

/// Expects solutions known beforehand, for two matrices of one pattern.
template <LinearSolver S>
void expect_solves(S& solver, BlockSparse<S::kBlock>& h, Rng& rng, double tolerance = 1e-12) {
  solver.analyse(h);
  for (int again = 0; again < 2; ++again) {
    const Eigen::MatrixXd dense = fill(h, rng);
    ASSERT_TRUE(solver.factorise(h).ok) << "a diagonally dominant matrix";
    for (const double first : {-1.0, 3.0}) {
      const Eigen::VectorXd want = Eigen::VectorXd::LinSpaced(dense.rows(), first, 2.0);
      Eigen::VectorXd x = dense * want;
      solver.solve_in_place(x);
      ASSERT_EQ(x.size(), want.size());
      EXPECT_LT((x - want).norm(), tolerance * want.norm()) << "the solution is wrong";
    }
  }
}

/// Fails the current test where a solver breaks the semantics of LinearSolver or the rule of
/// FactorOutcome.
template <LinearSolver S>
struct SolverLaws {
  static constexpr int kBlock = S::kBlock;               ///< side of a block
  using Matrix = BlockSparse<kBlock>;                    ///< H
  using Square = Eigen::Matrix<double, kBlock, kBlock>;  ///< a block
  using Vector = Eigen::Matrix<double, kBlock, 1>;       ///< of a block's row

  bool names_block = true;      ///< whether the solver reports FactorOutcome::block
  bool names_direction = true;  ///< and FactorOutcome::direction
  double tolerance = 1e-12;     ///< of solutions, relative, where H is diagonally dominant
  /// Information that determines a part of H, relative to that of its couplings.
  double little = 1e-7;
  std::uint64_t seed = 1;  ///< of the matrices

  /// All laws; those of threads and of selected inverses where the solver offers them.
  void check() const {
    solves_every_pattern();
    keeps_what_it_factorised();
    refuses_what_is_not_positive();
    refuses_what_is_undetermined();
    if constexpr (ThreadedSolver<S>) does_not_depend_on_threads();
    if constexpr (SelectedInverse<S>) inverts_selected_blocks();
  }

  /// One solver, pattern after pattern.
  void solves_every_pattern() const {
    Rng rng(seed);
    S solver;
    for (const Shape& shape : all_shapes(rng)) {
      SCOPED_TRACE(shape.name + " of " + std::to_string(shape.columns));
      Matrix h(shape.columns, shape.pairs);
      expect_solves(solver, h, rng, tolerance);
    }
  }

  /// `analyse` reads the pattern only; solutions are those of the last factorised values, whatever
  /// became of the matrix; equal calls give equal bits.
  void keeps_what_it_factorised() const {
    Rng rng(seed);
    const Shape shape = grid(6, 5);
    Matrix h(shape.columns, shape.pairs);
    const Eigen::MatrixXd dense = fill(h, rng);
    const Eigen::VectorXd want = Eigen::VectorXd::LinSpaced(dense.rows(), -1.0, 2.0);
    const Eigen::VectorXd b = dense * want;
    const Matrix given = h;
    S solver;
    set_all(h, kNone);
    solver.analyse(h);
    h = given;
    ASSERT_TRUE(solver.factorise(h).ok);
    set_all(h, kNone);
    const Eigen::VectorXd x = solved(solver, b);
    EXPECT_LT((x - want).norm(), tolerance * want.norm()) << "the matrix changed after factorise";
    EXPECT_TRUE(same_bits(solved(solver, b), x)) << "solve_in_place again";
    EXPECT_TRUE(solved(solver, Eigen::VectorXd::Zero(b.size())).isZero(0.0)) << "b = 0";
    ASSERT_TRUE(solver.factorise(given).ok);
    EXPECT_TRUE(same_bits(solved(solver, b), x)) << "factorise again";
    S other;
    other.analyse(given);
    ASSERT_TRUE(other.factorise(given).ok);
    EXPECT_TRUE(same_bits(solved(other, b), x)) << "another solver";
  }

  /// Each number of the diagonal in turn; all other columns are diagonally dominant, so that none
  /// fails before.
  void refuses_what_is_not_positive() const {
    Rng rng(seed);
    const Shape shape = grid(5, 4);
    Matrix h(shape.columns, shape.pairs);
    const Eigen::VectorXd b = fill(h, rng).col(0);
    S solver;
    solver.analyse(h);
    ASSERT_TRUE(solver.factorise(h).ok);
    const Eigen::VectorXd expected = solved(solver, b);
    for (int column = 0; column < shape.columns; ++column) {
      for (int k = 0; k < kBlock; ++k) {
        double& entry = h.data(h.diagonal_index(column))[k * (kBlock + 1)];
        for (const double bad :
             {-1.0, 0.0, kInfinity, -kInfinity, kNone, -std::numeric_limits<double>::max()}) {
          const double good = std::exchange(entry, bad);
          const FactorOutcome outcome = solver.factorise(h);
          entry = good;
          EXPECT_FALSE(outcome.ok) << bad << " on the diagonal of column " << column;
          EXPECT_TRUE(outcome.block == column || (!names_block && outcome.block == -1))
              << bad << " on the diagonal of column " << column << ", reported " << outcome.block;
          EXPECT_TRUE(direction(outcome).isZero(0.0)) << "not positive semi-definite";
          ASSERT_TRUE(solver.factorise(h).ok);
          EXPECT_TRUE(same_bits(solved(solver, b), expected)) << "after a failure";
        }
      }
    }
  }

  /// Two parts, one of them open along one direction, at any scale and in any units.
  void refuses_what_is_undetermined() const {
    Rng rng(seed);
    S solver;
    for (const double scale : {1e-8, 1.0, 1e8}) {
      for (const double unit : {1.0, 1e3}) {
        for (const int part : {0, 1}) {
          SCOPED_TRACE("part " + std::to_string(part) + ", scale " + std::to_string(scale) +
                       ", other unit " + std::to_string(unit));
          OpenMatrix open(rng, part, scale, unit, 0.0);
          solver.analyse(open.h);
          expect_named(solver.factorise(open.h), open);
          expect_determined(solver, OpenMatrix(rng, part, scale, unit, little).h);
        }
      }
    }
    Matrix h(12, chain(12).pairs);
    solver.analyse(h);
    EXPECT_FALSE(solver.factorise(h).ok) << "H = 0";
    fill_relative(h, rng);
    EXPECT_FALSE(solver.factorise(h).ok) << "no direction is determined";
  }

  /// Solutions, inverses and failures on large matrices, with the pattern kept.
  void does_not_depend_on_threads() const {
    Rng rng(seed);
    for (const Shape& shape : large_shapes(kBlock, rng)) {
      SCOPED_TRACE(shape.name);
      Matrix h(shape.columns, shape.pairs);
      S one, several;
      one.analyse(h);
      several.analyse(h);
      for (const int bad_columns : {0, 3, 3}) {
        fill_dominant(h, rng);
        for (int k = 0; k < bad_columns; ++k)
          h.block(h.diagonal_index(any_of(h, rng)))(0, 0) = k == 0 ? -1.0 : k == 1 ? 0.0 : kNone;
        const FactorOutcome want = one.factorise(h);
        EXPECT_EQ(want.ok, bad_columns == 0);
        for (const int threads : {2, 2, 3, 8, 1, 8}) {
          several.set_threads(threads);
          const FactorOutcome outcome = several.factorise(h);
          ASSERT_EQ(outcome.ok, want.ok) << threads << " threads";
          EXPECT_EQ(outcome.block, want.block) << threads << " threads";
          if (!outcome.ok) continue;
          const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(h.columns() * kBlock, -1.0, 2.0);
          EXPECT_TRUE(same_bits(solved(several, b), solved(one, b))) << threads << " threads";
        }
        if constexpr (SelectedInverse<S>)
          if (want.ok) expect_same_inverse(one, several, h.columns());
      }
    }
  }

  /// Those of the pattern and all others there are, against a dense inverse.
  void inverts_selected_blocks() const {
    Rng rng(seed);
    for (const Shape& shape : all_shapes(rng)) {
      SCOPED_TRACE(shape.name + " of " + std::to_string(shape.columns));
      Matrix h(shape.columns, shape.pairs);
      S solver;
      solver.analyse(h);
      const Eigen::MatrixXd dense = fill(h, rng);
      const Eigen::MatrixXd inverse =
          dense.ldlt().solve(Eigen::MatrixXd::Identity(dense.rows(), dense.rows()));
      ASSERT_TRUE(solver.factorise(h).ok);
      Square block;
      EXPECT_FALSE(solver.inverse_block(0, 0, block)) << "before invert()";
      solver.invert();
      expect_blocks(solver, h, inverse);
      const Eigen::VectorXd b = Eigen::VectorXd::Ones(inverse.rows());
      EXPECT_LT((inverse * b - solved(solver, b)).norm(), tolerance * (inverse * b).norm())
          << "the solution after invert()";
      ASSERT_TRUE(solver.factorise(h).ok);
      EXPECT_FALSE(solver.inverse_block(0, 0, block)) << "not inverted since factorise";
    }
  }

 private:
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();

  /// Two connected parts. One of them may move along `direction`, the same in all its columns, but
  /// for the information `held`.
  struct OpenMatrix {
    Matrix h;
    int first, end;  // columns of the part
    Vector direction;

    OpenMatrix(Rng& rng, int part, double scale, double unit, double held) {
      const int begins[] = {0, 12, 20};
      BlockPairs pairs;
      for (int p = 0; p < 2; ++p) {
        const int columns = begins[p + 1] - begins[p];
        for (const BlockPairs& some : {chain(columns).pairs, random_pairs(rng, columns, columns)})
          for (const auto& [r, c] : some) pairs.emplace_back(begins[p] + r, begins[p] + c);
      }
      h = Matrix(begins[2], pairs);
      first = begins[part];
      end = begins[part + 1];
      for (double& v : direction) v = (rng.below(2) == 0 ? -1.0 : 1.0) * rng.uniform(0.3, 1.0);
      direction.normalize();
      fill_relative(h, rng);
      for (int p = 0; p < 2; ++p) h.block(h.diagonal_index(begins[p])) += Square::Identity();
      h.block(h.diagonal_index(first)) -= (1.0 - held) * direction * direction.transpose();
      Vector units = Vector::Constant(std::sqrt(scale));
      units.template tail<kBlock - kLeadingUnits<kBlock>>() *= unit;
      for (int i = 0; i < h.blocks(); ++i)
        h.block(i) = (units.asDiagonal() * h.block(i) * units.asDiagonal()).eval();
      direction = direction.cwiseQuotient(units).normalized();
    }
  };

  static void set_all(Matrix& h, double value) {
    for (int i = 0; i < h.blocks(); ++i) h.block(i).setConstant(value);
  }
  static int any_of(const Matrix& h, Rng& rng) { return static_cast<int>(rng.below(h.columns())); }
  static Eigen::VectorXd solved(S& solver, const Eigen::VectorXd& b) {
    Eigen::VectorXd x = b;
    solver.solve_in_place(x);
    return x;
  }
  static bool same_bits(const auto& a, const auto& b) {
    return a.size() == b.size() &&
           std::memcmp(a.data(), b.data(), static_cast<std::size_t>(a.size()) * sizeof(double)) ==
               0;
  }
  static Vector direction(const FactorOutcome& outcome) {
    return Eigen::Map<const Vector>(outcome.direction.data());
  }

  void expect_named(const FactorOutcome& outcome, const OpenMatrix& open) const {
    EXPECT_FALSE(outcome.ok) << "nothing determines columns " << open.first << " to "
                             << open.end - 1 << " along " << open.direction.transpose();
    if (names_block) {
      EXPECT_GE(outcome.block, open.first) << "the block that is not determined";
      EXPECT_LT(outcome.block, open.end) << "the block that is not determined";
    }
    if (names_direction) {
      const Vector named = direction(outcome);
      EXPECT_NEAR(named.norm(), 1.0, 1e-9) << "the length of the direction";
      EXPECT_LT((named - named.dot(open.direction) * open.direction).norm(), 1e-5)
          << "the direction " << named.transpose() << " is not " << open.direction.transpose();
    }
  }

  /// Only the residual is small where H is nearly singular.
  void expect_determined(S& solver, const Matrix& h) const {
    solver.analyse(h);
    ASSERT_TRUE(solver.factorise(h).ok) << "a little information is enough";
    const Eigen::MatrixXd all = dense(h);
    const Eigen::VectorXd b = all * Eigen::VectorXd::LinSpaced(all.rows(), -1.0, 2.0);
    const Eigen::VectorXd x = solved(solver, b);
    EXPECT_LT((all * x - b).norm(), tolerance * all.norm() * x.norm()) << "the residual";
  }

  static void expect_same_inverse(S& one, S& several, int columns) {
    one.invert();
    several.invert();
    Square want = Square::Zero(), got = Square::Ones();
    for (int c = 0; c < columns; ++c) {
      EXPECT_TRUE(one.inverse_block(c, c, want) && several.inverse_block(c, c, got));
      EXPECT_TRUE(same_bits(got, want)) << "the inverse depends on the number of threads";
    }
  }

  static void expect_blocks(const S& solver, const Matrix& h, const Eigen::MatrixXd& inverse) {
    Square block;
    for (int c = 0; c < h.columns(); ++c) {
      for (int r = 0; r < h.columns(); ++r) {
        if (!solver.inverse_block(r, c, block)) continue;
        EXPECT_LT((block - inverse.block<kBlock, kBlock>(r * kBlock, c * kBlock)).norm(),
                  1e-13 * inverse.norm())
            << "block (" << r << ", " << c << ") of the inverse";
      }
      EXPECT_TRUE(solver.inverse_block(c, c, block)) << "block of the diagonal";
    }
    each_coupling(h, [&](int r, int c, int) {
      EXPECT_TRUE(solver.inverse_block(r, c, block)) << "block of the pattern";
    });
  }
};

}  // namespace wayfare::testing
