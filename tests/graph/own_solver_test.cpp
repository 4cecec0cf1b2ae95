// What the optimiser makes of a linear solver of one's own that fails.

#include <limits>
#include <string>

#include <gtest/gtest.h>

#include <wayfare/graph/optimise.hpp>

#include "tangle.hpp"

namespace wayfare {
namespace {

/// The default solver, with a fault.
class FaultySolver {
 public:
  enum class Fault { none, not_finite, other_size, no_block, no_such_block };
  static inline Fault fault = Fault::none;
  static inline int good_solutions = 0;  // before it

  static constexpr int kBlock = 3;
  void analyse(const BlockSparse<3>& h) { solver_.analyse(h); }
  FactorOutcome factorise(const BlockSparse<3>& h) {
    const FactorOutcome outcome = solver_.factorise(h);
    if (fault == Fault::no_block) return {false};
    return fault == Fault::no_such_block ? FactorOutcome{false, h.columns(), {1.0}} : outcome;
  }
  void solve_in_place(Eigen::VectorXd& x) {
    solver_.solve_in_place(x);
    if (good_solutions > 0 && good_solutions-- > 0) return;
    if (fault == Fault::not_finite) x[x.size() - 1] = std::numeric_limits<double>::quiet_NaN();
    if (fault == Fault::other_size) x.conservativeResize(x.size() - 1);
  }

 private:
  MultifrontalCholesky<3> solver_;
};
using SolverFault = FaultySolver::Fault;

class OwnSolver : public ::testing::Test {
 protected:
  /// Fails with this error, and the poses stay.
  void expect_refused(const OptimiseOptions& options, ErrorCode code, const std::string& message) {
    auto graph = graph_;
    const auto report = optimiser_.optimise(graph, options);
    ASSERT_FALSE(report) << message;
    EXPECT_EQ(report.error().code, code);
    EXPECT_EQ(report.error().message, message);
    EXPECT_EQ(optimiser_.undetermined().variable, -1);
    for (std::size_t i = 0; i < graph.poses.size(); ++i)
      EXPECT_EQ(graph.poses[i].minus(graph_.poses[i]).norm(), 0.0);
  }
  void expect_no_covariances(ErrorCode code, const std::string& message) {
    const auto covariances = optimiser_.covariances(graph_);
    ASSERT_FALSE(covariances) << message;
    EXPECT_EQ(covariances.error().code, code);
    EXPECT_EQ(covariances.error().message, message);
  }

  Rng rng_{3};
  PoseGraph2 graph_ = tests::tangle<SE2d>(rng_);
  PoseGraphOptimiser<SE2d, FaultySolver> optimiser_;
  const OptimiseOptions damped_{.method = OptimiseMethod::levenberg_marquardt};
};

// Pose 4 is the last that is free: its last number is not finite. A solution of another size has no
// numbers of any pose.
TEST_F(OwnSolver, IsRefusedWhereItsSolutionIsNotFinite) {
  for (const SolverFault fault : {SolverFault::not_finite, SolverFault::other_size}) {
    FaultySolver::fault = fault;
    for (const int good : {0, 1}) {
      FaultySolver::good_solutions = good;
      expect_refused({}, ErrorCode::numerical, "the linear solver's solution is not finite");
    }
    expect_refused(damped_, ErrorCode::numerical, "the linear solver's solution is not finite");
    expect_no_covariances(ErrorCode::numerical, fault == SolverFault::not_finite
                                                    ? "the covariance of pose 4 is not finite"
                                                    : "the covariance of pose 1 is not finite");
  }
}

TEST_F(OwnSolver, IsRefusedWhereItFailsWithoutABlock) {
  for (const SolverFault fault : {SolverFault::no_block, SolverFault::no_such_block}) {
    FaultySolver::fault = fault;
    for (const auto& options : {OptimiseOptions{}, damped_})
      expect_refused(options, ErrorCode::degenerate, "the edges do not determine all variables");
    expect_no_covariances(ErrorCode::degenerate, "the edges do not determine all variables");
  }
}

/// Whatever happened before, the optimum is that of the default solver.
TEST_F(OwnSolver, GoesOnAfterAFailure) {
  FaultySolver::fault = SolverFault::no_such_block;
  EXPECT_FALSE(optimiser_.optimise(graph_));
  FaultySolver::fault = SolverFault::none;
  auto graph = graph_, expected = graph_;
  ASSERT_TRUE(optimiser_.optimise(graph));
  ASSERT_TRUE(optimise(expected));
  for (std::size_t i = 0; i < graph.poses.size(); ++i)
    EXPECT_EQ(graph.poses[i].minus(expected.poses[i]).norm(), 0.0);
}

}  // namespace
}  // namespace wayfare
