#include <wayfare/graph/detail/incremental_cholesky.hpp>

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include <wayfare/core/random.hpp>

namespace wayfare {
namespace {

/// The dense equivalent of the system, and terms for both.
template <int N>
struct Dense {
  Eigen::MatrixXd a;
  Eigen::VectorXd b;

  void grow() {
    const Eigen::Index n = b.size() + N;
    a.conservativeResizeLike(Eigen::MatrixXd::Zero(n, n));
    b.conservativeResizeLike(Eigen::VectorXd::Zero(n));
  }
  void add(int i, int j, const IncrementalTerm<N>& t, double sign = 1.0) {
    if (i >= 0) a.block<N, N>(i * N, i * N) += sign * t.aa;
    if (i >= 0) b.segment<N>(i * N) += sign * t.ra;
    if (j < 0) return;
    a.block<N, N>(j * N, j * N) += sign * t.bb;
    b.segment<N>(j * N) += sign * t.rb;
    if (i < 0) return;
    a.block<N, N>(i * N, j * N) += sign * t.ab;
    a.block<N, N>(j * N, i * N) += sign * t.ab.transpose();
  }
  [[nodiscard]] Eigen::VectorXd solution() const { return a.llt().solve(b); }
};

/// Positive definite on its own.
template <int N>
IncrementalTerm<N> random_term(Rng& rng) {
  Eigen::Matrix<double, 2 * N, 2 * N> root;
  for (double& v : root.reshaped()) v = rng.uniform(-1.0, 1.0);
  const Eigen::Matrix<double, 2 * N, 2 * N> m =
      root * root.transpose() + 0.1 * Eigen::Matrix<double, 2 * N, 2 * N>::Identity();
  IncrementalTerm<N> t;
  t.aa = m.template topLeftCorner<N, N>();
  t.ab = m.template topRightCorner<N, N>();
  t.bb = m.template bottomRightCorner<N, N>();
  for (double& v : t.ra) v = rng.uniform(-1.0, 1.0);
  for (double& v : t.rb) v = rng.uniform(-1.0, 1.0);
  return t;
}

template <int N>
double distance_to(const IncrementalCholesky<N>& system, const Eigen::VectorXd& x) {
  double most = 0.0;
  for (int v = 0; v < system.variables(); ++v)
    most = std::max(most, (system.x(v) - x.segment<N>(v * N)).norm());
  return most;
}

template <class Size>
class IncrementalCholeskyTest : public ::testing::Test {};
template <int N>
struct Size {
  static constexpr int value = N;
};
using Sizes = ::testing::Types<Size<3>, Size<6>>;
TYPED_TEST_SUITE(IncrementalCholeskyTest, Sizes);

// Variables, terms, changed values, resets and reorderings in random sequence: after each the
// solution equals the dense one.
TYPED_TEST(IncrementalCholeskyTest, FollowsADenseSystemThroughEveryKindOfChange) {
  constexpr int N = TypeParam::value;
  Rng rng(4);
  IncrementalCholesky<N> system;
  Dense<N> dense;
  std::vector<std::array<int, 2>> ends;
  std::vector<IncrementalTerm<N>> terms;
  const auto add_term = [&](int i, int j) {
    terms.push_back(random_term<N>(rng));
    ends.push_back({i, j});
    EXPECT_EQ(system.add_term(i, j, terms.back()), static_cast<int>(terms.size()) - 1);
    dense.add(i, j, terms.back());
  };
  const auto any = [&](int n) { return static_cast<int>(rng.below(n)); };
  for (int step = 0; step < 120; ++step) {
    const int kind = step < 3 ? 0 : any(6);
    if (kind <= 2) {  // a variable, coupled to the last one or a random one
      const int added = system.add_variable();
      dense.grow();
      add_term(added == 0 ? -1 : kind == 0 ? added - 1 : any(added), added);
    } else if (kind == 3) {  // a term between existing variables
      const int i = any(system.variables()), j = any(system.variables());
      add_term(i, i == j ? -1 : j);
    } else if (kind == 4) {  // a changed term
      const auto t = static_cast<std::size_t>(any(system.terms()));
      dense.add(ends[t][0], ends[t][1], terms[t], -1.0);
      terms[t] = random_term<N>(rng);
      dense.add(ends[t][0], ends[t][1], terms[t]);
      system.set_term(static_cast<int>(t), terms[t]);
    } else {
      system.reset(any(system.variables()), IncrementalCholesky<N>::Vector::Constant(3.0));
      if (any(3) == 0) system.touch_all();
    }
    ASSERT_TRUE(system.refactor().ok);
    system.solve(0.0);
    ASSERT_LT(distance_to(system, dense.solution()), 1e-10) << "step " << step;
  }
  EXPECT_GT(system.variables(), 40);
}

TYPED_TEST(IncrementalCholeskyTest, NamesTheVariableThatIsNotDeterminedAndKeepsTheRest) {
  constexpr int N = TypeParam::value;
  Rng rng(9);
  IncrementalCholesky<N> system;
  Dense<N> dense;
  for (int v = 0; v < 12; ++v) {
    dense.grow();
    const auto term = random_term<N>(rng);
    system.add_term(system.add_variable() - 1, v, term);
    dense.add(v - 1, v, term);
  }
  ASSERT_TRUE(system.refactor().ok);
  system.solve(0.0);
  const double flops = system.total_flops();
  IncrementalTerm<N> weak = random_term<N>(rng);
  weak.ab.setZero();
  weak.bb.setZero();
  system.add_term(5, system.add_variable(), weak);
  const FactorOutcome outcome = system.refactor();
  EXPECT_FALSE(outcome.ok);
  EXPECT_EQ(outcome.block, 12);
  system.roll_back(12, 12);
  EXPECT_EQ(system.total_flops(), flops);
  ASSERT_TRUE(system.refactor().ok);
  EXPECT_EQ(system.last_columns(), 0);
  const auto term = random_term<N>(rng);
  system.add_term(2, 9, term);
  dense.add(2, 9, term);
  ASSERT_TRUE(system.refactor().ok);
  system.solve(0.0);
  EXPECT_LT(distance_to(system, dense.solution()), 1e-10);
}

// A change at the end of a long chain: the rest is neither refactorised nor visited.
TYPED_TEST(IncrementalCholeskyTest, AffectsOnlyTheEndOfAChain) {
  constexpr int N = TypeParam::value;
  Rng rng(3);
  IncrementalCholesky<N> system;
  for (int v = 0; v < 400; ++v) {
    auto term = random_term<N>(rng);
    term.ra.setZero();
    term.rb.setZero();
    system.add_term(system.add_variable() - 1, v, term);
    ASSERT_TRUE(system.refactor().ok);
    system.solve(0.0);
    EXPECT_LE(system.last_columns(), 2) << v;
    EXPECT_LE(system.last_solved(), 2) << v;
  }
}

}  // namespace
}  // namespace wayfare
