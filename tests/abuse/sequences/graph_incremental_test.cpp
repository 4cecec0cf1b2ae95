// Random calls of the incremental optimiser, beside a plain graph that the batch optimiser solves.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "abuse/graph_cases.hpp"

namespace wayfare::tests {
namespace {

/// The optimiser, and what it should contain by the documentation.
template <class G>
class Growing {
 public:
  explicit Growing(std::uint64_t seed) : rng_(seed) {
    if (rng_.below(3) == 0) kernel_ = {RobustKernelKind::cauchy, 2.0};
    tested_ = IncrementalOptimiser<G>(kernel_);
  }

  void call() {
    switch (rng_.below(12)) {
      case 0:
      case 1:
      case 2:
        return add_pose();
      case 3:
      case 4:
      case 5:
      case 6:
        return add_edge();
      case 7:
        return append();
      case 8:
        return discard();
      case 9:
        return rng_.below(3) == 0 ? optimise_fully() : copy();
      default:
        return update();
    }
  }

  std::string calls;
  int updates = 0, refusals = 0;

 private:
  void expect_as_modelled() { ASSERT_TRUE(bits_of(tested_.graph()) == bits_of(model_)); }

  void add_pose() {
    const bool bad = rng_.below(8) == 0, held = rng_.below(6) == 0;
    calls += bad ? " bad-pose" : held ? " held-pose" : " pose";
    const G last = model_.poses.empty() ? G() : model_.poses.back();
    const G pose = bad ? moved_to<G>(kNan) : last * G::exp(random_tangent<G>(rng_, 1.0));
    const auto added = tested_.add_pose(pose, held);
    ASSERT_EQ(static_cast<bool>(added), !bad);
    if (!bad) {
      model_.poses.push_back(pose);
      if (held) model_.fixed.push_back(model_.size() - 1);
      ASSERT_EQ(*added, model_.size() - 1);
    }
    expect_as_modelled();
  }

  void add_edge() {
    if (model_.poses.empty()) return;
    auto edge = random_edge(rng_, model_);
    const bool bad = rng_.below(6) == 0 || edge.from == edge.to;
    if (bad) spoil(rng_, edge);
    calls += " edge " + std::to_string(edge.from) + "->" + std::to_string(edge.to);
    ASSERT_EQ(static_cast<bool>(tested_.add_edge(edge)), !bad && edge.from != edge.to);
    if (!bad) model_.edges.push_back(edge);
    expect_as_modelled();
  }

  void append() {
    calls += " append";
    auto more = model_;
    for (std::uint64_t n = rng_.below(4); n > 0 || more.poses.empty(); n -= n > 0 ? 1 : 0) {
      more.add_pose(more.poses.empty() ? G()
                                       : more.poses.back() * G::exp(random_tangent<G>(rng_, 1.0)));
      if (more.size() < 2) continue;
      more.edges.push_back(random_edge(rng_, more));
      if (more.edges.back().from == more.edges.back().to) more.edges.pop_back();
    }
    more.labels.clear();
    for (int i = 0; i < more.size(); ++i) more.labels.push_back("v" + std::to_string(i));
    bool bad = rng_.below(3) == 0;
    if (bad) {
      switch (rng_.below(4)) {
        case 0:
          more.add_pose(moved_to<G>(kInf));
          break;
        case 1:
          more.edges.push_back({0, 0, G()});
          break;
        case 2:
          more.fixed.push_back(more.size());
          break;
        default:
          bad = !model_.poses.empty();
          if (bad) more.poses.resize(model_.poses.size() - 1);
      }
    }
    ASSERT_EQ(static_cast<bool>(tested_.append(more)), !bad);
    if (!bad) model_ = more;
    expect_as_modelled();
  }

  void discard() {
    calls += " discard";
    tested_.discard_pending();
    model_.poses.resize(solved_poses_);
    model_.edges.resize(solved_edges_);
    if (model_.labels.size() > solved_poses_) model_.labels.resize(solved_poses_);
    std::erase_if(model_.fixed,
                  [&](int pose) { return static_cast<std::size_t>(pose) >= solved_poses_; });
    expect_as_modelled();
  }

  void copy() {
    calls += " copy";
    const IncrementalOptimiser<G> other = tested_;
    tested_ = other;
    expect_as_modelled();
  }

  void settle() {
    if (model_.fixed.empty()) model_.fixed.push_back(0);
    solved_poses_ = model_.poses.size();
    solved_edges_ = model_.edges.size();
    model_.poses = tested_.poses();
    expect_as_modelled();
    ASSERT_TRUE(all_finite(model_.poses));
  }

  /// The step of the batch optimiser on the same graph, if it is determined.
  Result<PoseGraph<G>> whole_step() const {
    PoseGraph<G> graph = model_;
    if (auto valid = validate(graph); !valid) return valid.error();
    DampedStep<PoseGraph<G>, DefaultSolver<G::kDof>> step;
    step.prepare(graph);
    step.linearise(graph, kernel_);
    if (step.equations().free().empty()) return graph;
    if (!step.compute(0.0)) return step.undetermined(graph);
    step.apply(graph);
    return graph;
  }

  void update() {
    const bool exact = rng_.below(2) == 0;
    IncrementalOptions options = kExact;
    if (!exact)
      options = {rng_.uniform(0.0, 0.1), rng_.uniform(0.0, 0.01),
                 std::max(0.0, rng_.uniform(-1.0, 1.0)), any_of(rng_, 4), rng_.uniform(0.0, 30.0)};
    calls += exact ? " step" : " update";
    const auto expected = whole_step();
    const double before = robust_cost_of_valid();
    const auto report = tested_.update(options);
    if (!report) {
      ++refusals;
      ASSERT_FALSE(expected) << report.error().message;
      if (exact && tested_.undetermined().variable < 0) {
        ASSERT_EQ(report.error().code, expected.error().code);
      }
      return expect_as_modelled();
    }
    ++updates;
    ASSERT_TRUE(expected) << expected.error().message;
    settle();
    const double after = robust_cost(tested_.graph(), kernel_);
    ASSERT_NEAR(report->cost, after, 1e-9 * (1.0 + after));
    ASSERT_LE(after, 1.01 * before + 1e-6) << "from there on the batch optimiser takes over";
    // An exact step is that of the batch optimiser, however loose the updates before it were.
    if (exact && !report->fell_back) {
      ASSERT_LT(apart(model_.poses, expected->poses), 1e-6);
    }
  }

  void optimise_fully() {
    calls += " fully";
    auto batch = model_;
    const auto expected = optimise(batch, {.kernel = kernel_});
    const auto report = tested_.optimise_fully();
    ASSERT_EQ(static_cast<bool>(report), static_cast<bool>(expected));
    if (!report) {
      ++refusals;
      ASSERT_EQ(report.error().message, expected.error().message);
      return expect_as_modelled();
    }
    ASSERT_EQ(report->final_cost, expected->final_cost);
    ASSERT_EQ(apart(tested_.poses(), batch.poses), 0.0);
    settle();
  }

  [[nodiscard]] double robust_cost_of_valid() const { return robust_cost(model_, kernel_); }

  Rng rng_;
  RobustKernel kernel_;
  IncrementalOptimiser<G> tested_;
  PoseGraph<G> model_;  // with all that is pending
  std::size_t solved_poses_ = 0, solved_edges_ = 0;
};

template <class G>
class GraphCalls : public ::testing::Test {};
using CalledGroups = ::testing::Types<SE2d, SE3d>;
TYPED_TEST_SUITE(GraphCalls, CalledGroups);

TYPED_TEST(GraphCalls, TheIncrementalOptimiserIsAGraphThatTheBatchOptimiserSolves) {
  int updates = 0, refusals = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    Growing<TypeParam> growing(seed);
    for (int k = 0; k < 100; ++k) {
      growing.call();
      ASSERT_FALSE(this->HasFatalFailure()) << "seed " << seed << ':' << growing.calls;
    }
    updates += growing.updates;
    refusals += growing.refusals;
  }
  EXPECT_GT(updates, 1000);
  EXPECT_GT(refusals, 1000);
}

}  // namespace
}  // namespace wayfare::tests
