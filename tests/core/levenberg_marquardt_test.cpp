#include <wayfare/core/levenberg_marquardt.hpp>

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/se2.hpp>

namespace wayfare {
namespace {

using Vector1 = Eigen::Matrix<double, 1, 1>;
using Eigen::Vector2d;
using Eigen::Vector4d;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(StopReason, EveryReasonHasTextOfItsOwn) {
  EXPECT_EQ(to_string(StopReason::converged), "converged");
  EXPECT_EQ(to_string(StopReason::max_iterations), "iteration limit");
  EXPECT_EQ(to_string(StopReason::stopped), "stopped on request");
  EXPECT_EQ(to_string(StopReason::no_progress), "no step lowers the cost");
}

// Nielsen 1999: λ decreases by max(⅓, 1 − (2q − 1)³), grows by 2, 4, 8, … for consecutive
// rejections.
TEST(NielsenDamping, FollowsTheGainRatio) {
  NielsenDamping damping(1.0);
  damping.step_taken(1.0);
  EXPECT_DOUBLE_EQ(damping.value(), 1.0 / 3.0);
  damping.step_taken(0.5);  // a gain ratio of one half: unchanged
  EXPECT_DOUBLE_EQ(damping.value(), 1.0 / 3.0);
  damping.step_taken(0.25);
  EXPECT_DOUBLE_EQ(damping.value(), 1.125 / 3.0);
  damping.step_taken(0.0);
  EXPECT_DOUBLE_EQ(damping.value(), 2.25 / 3.0);
  for (const double growth : {2.0, 4.0, 8.0}) {
    const double before = damping.value();
    damping.step_refused();
    EXPECT_DOUBLE_EQ(damping.value(), growth * before);
  }
  damping.step_taken(1.0);
  const double before = damping.value();
  damping.step_refused();
  EXPECT_DOUBLE_EQ(damping.value(), 2.0 * before);  // a new sequence
}

TEST(NielsenDamping, IsExhaustedAboveItsMaximum) {
  NielsenDamping damping(1.0, 2.0);
  damping.step_refused();
  EXPECT_FALSE(damping.exhausted());  // 2, the maximum itself
  damping.step_refused();
  EXPECT_TRUE(damping.exhausted());  // 8
}

TEST(TenfoldDamping, StaysWithinItsBounds) {
  TenfoldDamping damping(1e-3, 1e-4, 1e-2);
  damping.step_taken();
  damping.step_taken();
  EXPECT_EQ(damping.value(), 1e-4);
  for (int i = 0; i < 2; ++i) damping.step_refused();
  EXPECT_DOUBLE_EQ(damping.value(), 1e-2);
  EXPECT_FALSE(damping.exhausted());
  damping.step_refused();
  EXPECT_TRUE(damping.exhausted());
}

/// A problem of the user's own: none of its steps lowers the cost, or none exists.
struct Refusing {
  bool solvable = true;
  double stepped = 1.0;
  int solved = 0, rejected = 0, accepted = 0;

  bool solve(double) { return ++solved, solvable; }
  [[nodiscard]] static double cost() { return 1.0; }
  [[nodiscard]] double stepped_cost() const { return stepped; }
  bool accept() { return ++accepted, false; }
  bool reject() { return ++rejected, false; }
};
static_assert(DampedProblem<Refusing> && !ModelledProblem<Refusing>);
static_assert(DampingSchedule<TenfoldDamping> && !GainRatioDamping<TenfoldDamping>);
static_assert(DampingSchedule<NielsenDamping> && GainRatioDamping<NielsenDamping>);

// λ = 1e-3, 1e-2, … 1e4: eight steps, then 1e5 is above the maximum.
TEST(DampedLeastSquares, RaisesTheDampingUntilItIsExhausted) {
  for (Refusing problem : {Refusing{}, Refusing{.stepped = kNaN}, Refusing{.solvable = false}}) {
    const DampedReport r = damped_least_squares(problem, TenfoldDamping(1e-3, 1e-6, 1e4), 100);
    EXPECT_EQ(r.iterations, 8);
    EXPECT_EQ(r.reason, StopReason::no_progress);
    EXPECT_EQ(problem.solved, 8);
    EXPECT_EQ(problem.rejected, 8);
    EXPECT_EQ(problem.accepted, 0);
  }
}

TEST(DampedLeastSquares, TakesNoMoreIterationsThanAllowed) {
  for (const int most : {0, 1, 5}) {
    Refusing falling{.stepped = 0.5};
    const DampedReport r = damped_least_squares(falling, TenfoldDamping(1.0, 1e-6, 1e4), most);
    EXPECT_EQ(r.iterations, most);
    EXPECT_EQ(r.reason, StopReason::max_iterations);
    EXPECT_EQ(falling.accepted, most);
  }
}

ResidualAndJacobian<Vector2d, 2> rosenbrock(const Vector2d& x) {
  ResidualAndJacobian<Vector2d, 2> at;
  at.residual << 10 * (x[1] - x[0] * x[0]), 1 - x[0];
  at.jacobian << -20 * x[0], 10, -1, 0;
  return at;
}

// Both residuals are zero at (1, 1) and nowhere else; JᵀJ there from J = (−20, 10; −1, 0).
TEST(LevenbergMarquardt, SolvesRosenbrock) {
  const auto r = levenberg_marquardt(Vector2d(-1.2, 1), rosenbrock);
  ASSERT_TRUE(r);
  EXPECT_EQ(r->reason, StopReason::converged);
  EXPECT_LT((r->estimate - Vector2d(1, 1)).norm(), 1e-9);
  EXPECT_LT(r->cost, 1e-18);
  EXPECT_NEAR(r->information(0, 0), 401, 1e-6);
  EXPECT_NEAR(r->information(0, 1), -200, 1e-6);
  EXPECT_NEAR(r->information(1, 1), 100, 1e-6);
}

TEST(LevenbergMarquardt, NeedsNoStepFromTheSolution) {
  const auto r = levenberg_marquardt(Vector2d(1, 1), rosenbrock);
  ASSERT_TRUE(r);
  EXPECT_EQ(r->reason, StopReason::converged);
  EXPECT_EQ(r->iterations, 0);
  EXPECT_EQ(r->estimate, Vector2d(1, 1));
}

TEST(LevenbergMarquardt, StopsAtTheIterationLimitWithTheBestEstimate) {
  const Vector2d start(-1.2, 1);
  double before = 0.5 * rosenbrock(start).residual.squaredNorm();
  for (int most = 0; most < 8; ++most) {
    const auto r = levenberg_marquardt(start, rosenbrock, {.max_iterations = most});
    ASSERT_TRUE(r);
    EXPECT_EQ(r->iterations, most);
    EXPECT_EQ(r->reason, StopReason::max_iterations);
    EXPECT_LE(r->cost, before);
    EXPECT_EQ(r->cost, 0.5 * rosenbrock(r->estimate).residual.squaredNorm());
    before = r->cost;
  }
}

// Powell 1962: zero at the origin, where J has rank 2, so the convergence is only linear.
// ½ Σ r² at the start: (7² + 5 + 1 + 10·2⁴)/2 = 107.5.
TEST(LevenbergMarquardt, SolvesPowellsSingularFunction) {
  const auto powell = [](const Vector4d& x) {
    const double a = x[1] - 2 * x[2], b = x[0] - x[3], r5 = std::sqrt(5.0), r10 = std::sqrt(10.0);
    ResidualAndJacobian<Vector4d, 4> at;
    at.residual << x[0] + 10 * x[1], r5 * (x[2] - x[3]), a * a, r10 * b * b;
    at.jacobian << 1, 10, 0, 0,  //
        0, 0, r5, -r5,           //
        0, 2 * a, -4 * a, 0,     //
        2 * r10 * b, 0, 0, -2 * r10 * b;
    return at;
  };
  const Vector4d start(3, -1, 0, 1);
  const auto at_start = levenberg_marquardt(start, powell, {.max_iterations = 0});
  ASSERT_TRUE(at_start);
  EXPECT_NEAR(at_start->cost, 107.5, 1e-12);
  const auto r = levenberg_marquardt(start, powell);
  ASSERT_TRUE(r);
  EXPECT_EQ(r->reason, StopReason::converged);
  EXPECT_LT(r->estimate.norm(), 1e-6);
  EXPECT_LT(r->cost, 1e-20);
}

// The expected pose is the closed form of Procrustes in the plane: θ = atan2(Σ p̃×q̃, Σ p̃·q̃),
// t = q̄ − R p̄.
TEST(LevenbergMarquardt, FitsAPoseToPairsOfPoints) {
  const std::vector<Vector2d> p{{0, 0}, {4, 1}, {2, 5}, {-3, 2}, {1, -4}};
  const std::vector<Vector2d> q{{2.1, 0.9}, {1.2, 4.9}, {-3.1, 3.2}, {-0.2, -2.1}, {5.9, 1.8}};
  Vector2d p_mean(0, 0), q_mean(0, 0);
  for (std::size_t i = 0; i < p.size(); ++i) {
    p_mean += p[i] / 5;
    q_mean += q[i] / 5;
  }
  double cross = 0, dot = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Vector2d a = p[i] - p_mean, b = q[i] - q_mean;
    cross += a.x() * b.y() - a.y() * b.x();
    dot += a.dot(b);
  }
  const SO2d rotation(Angle::radians(std::atan2(cross, dot)));
  const SE2d expected(Vector2d(q_mean - rotation * p_mean), rotation);
  double cost = 0;
  for (std::size_t i = 0; i < p.size(); ++i) cost += 0.5 * (expected * p[i] - q[i]).squaredNorm();

  // Right perturbation: T (p + v + θ p⊥), so J = R (I, p⊥).
  const auto residuals = [&](const SE2d& x) {
    ResidualAndJacobian<SE2d> at{Eigen::VectorXd(10),
                                 Eigen::Matrix<double, Eigen::Dynamic, 3>(10, 3)};
    const Eigen::Matrix2d r = x.rotation().matrix();
    for (std::size_t i = 0; i < p.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(2 * i);
      at.residual.segment<2>(row) = x * p[i] - q[i];
      at.jacobian.block<2, 2>(row, 0) = r;
      at.jacobian.block<2, 1>(row, 2) = r * Vector2d(-p[i].y(), p[i].x());
    }
    return at;
  };
  for (const double heading : {0.0, 1.0, -1.0}) {
    const auto r = levenberg_marquardt(SE2d(-5, 7, Angle::radians(heading)), residuals);
    ASSERT_TRUE(r);
    EXPECT_EQ(r->reason, StopReason::converged);
    EXPECT_LT(expected.minus(r->estimate).norm(), 1e-7);
    EXPECT_NEAR(r->cost, cost, 1e-12);
    EXPECT_NEAR(r->information(0, 0), 5, 1e-12);  // one for each point
  }
}

// r = x − 5 from 0: a step leaves λ/(1 + λ) of the error; the model is exact, so that λ falls to a
// third.
TEST(LevenbergMarquardt, DampsALineAsTheFormulaSays) {
  const auto line = [](const Vector1& x) {
    return ResidualAndJacobian<Vector1, 1>{x - Vector1(5.0), Vector1(1.0)};
  };
  const double first = 0.3, second = 0.1;
  const double left = 5 * first / (1 + first) * second / (1 + second);
  const auto r =
      levenberg_marquardt(Vector1(0.0), line, {.max_iterations = 2, .initial_damping = first});
  ASSERT_TRUE(r);
  EXPECT_NEAR(r->estimate[0], 5 - left, 1e-14);
}

// Σ (x − 1)² + (x − 3)² is least at 2, where the residuals are not zero but their gradient is.
TEST(LevenbergMarquardt, ConvergesByTheGradientWhereResidualsRemain) {
  const auto two = [](const Vector1& x) {
    return ResidualAndJacobian<Vector1, 2>{Vector2d(x[0] - 1, x[0] - 3), Vector2d(1, 1)};
  };
  const auto r = levenberg_marquardt(Vector1(100.0), two);
  ASSERT_TRUE(r);
  EXPECT_EQ(r->reason, StopReason::converged);
  EXPECT_NEAR(r->estimate[0], 2, 1e-7);
  EXPECT_NEAR(r->cost, 1, 1e-14);
  const auto again = levenberg_marquardt(Vector1(2.0), two);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->iterations, 0);
  EXPECT_EQ(again->reason, StopReason::converged);
}

// ln x from 20: the full step leads to 20 − 20 ln 20 < 0, where the logarithm is NaN.
TEST(LevenbergMarquardt, RefusesStepsToWhereTheFunctionIsNaN) {
  const auto logarithm = [](const Vector1& x) {
    return ResidualAndJacobian<Vector1, 1>{Vector1(x[0] > 0 ? std::log(x[0]) : kNaN),
                                           Vector1(1 / x[0])};
  };
  const auto r = levenberg_marquardt(Vector1(20.0), logarithm);
  ASSERT_TRUE(r);
  EXPECT_EQ(r->reason, StopReason::converged);
  EXPECT_NEAR(r->estimate[0], 1, 1e-9);

  for (const bool in_jacobian : {false, true}) {
    const auto only_at_one = [&](const Vector1& x) {
      const double nan_elsewhere = x[0] == 1 ? 1 : kNaN;
      return ResidualAndJacobian<Vector1, 1>{Vector1(in_jacobian ? x[0] : nan_elsewhere),
                                             Vector1(in_jacobian ? nan_elsewhere : 1)};
    };
    const auto stuck = levenberg_marquardt(Vector1(1.0), only_at_one, {.max_damping = 1e6});
    ASSERT_TRUE(stuck);
    EXPECT_EQ(stuck->reason, StopReason::no_progress);
    EXPECT_EQ(stuck->estimate[0], 1);
    const auto refused = levenberg_marquardt(Vector1(2.0), only_at_one);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::numerical);
  }
}

TEST(LevenbergMarquardt, GivesUpWhereTheJacobianHasTheWrongSign) {
  const auto wrong = [](const Vector1& x) {
    return ResidualAndJacobian<Vector1, 1>{x, Vector1(-1.0)};
  };
  const auto r = levenberg_marquardt(Vector1(3.0), wrong, {.max_damping = 1e6});
  ASSERT_TRUE(r);
  EXPECT_EQ(r->reason, StopReason::no_progress);
  EXPECT_EQ(r->estimate[0], 3);
}

// What no residual depends on stays where it is; of x + y = 3 with equal damping of x and y the
// solution nearest to the start is found, (0, 0) + (1.5, 1.5).
TEST(LevenbergMarquardt, SolvesWhatASingularJacobianLeavesOpenBySmallSteps) {
  const auto first_only = [](const Vector2d& x) {
    return ResidualAndJacobian<Vector2d, 1>{Vector1(x[0] * x[0] - 4), {2 * x[0], 0}};
  };
  const auto r = levenberg_marquardt(Vector2d(5, 7), first_only);
  ASSERT_TRUE(r);
  EXPECT_EQ(r->reason, StopReason::converged);
  EXPECT_NEAR(r->estimate[0], 2, 1e-9);
  EXPECT_EQ(r->estimate[1], 7);
  EXPECT_EQ(r->information(1, 1), 0);

  const auto sum_only = [](const Vector2d& x) {
    return ResidualAndJacobian<Vector2d, 1>{Vector1(x[0] + x[1] - 3), {1, 1}};
  };
  const auto s = levenberg_marquardt(Vector2d(0, 0), sum_only);
  ASSERT_TRUE(s);
  EXPECT_EQ(s->reason, StopReason::converged);
  EXPECT_LT((s->estimate - Vector2d(1.5, 1.5)).norm(), 1e-9);
}

}  // namespace
}  // namespace wayfare
