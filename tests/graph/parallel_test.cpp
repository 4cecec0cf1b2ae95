// How the work is shared out, and results of whole graphs for any number of threads. That of
// solvers is a law of theirs.

#include "graph/cholesky/parallel.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/graph/optimise.hpp>
#include <wayfare/io/g2o.hpp>

#include <wayfare/testing/detail/block_matrices.hpp>
#include "graph/cholesky/symbolic.hpp"
#include "io/support.hpp"

namespace wayfare {
namespace {

using cholesky::share_out;
using cholesky::TaskTree;

bool same_bits(const auto& a, const auto& b) {
  return a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), static_cast<std::size_t>(a.size()) * sizeof(double)) == 0;
}

template <class G>
bool same_pose(const G& a, const G& b) {
  return same_bits(a.translation(), b.translation()) &&
         same_bits(a.rotation().matrix(), b.rotation().matrix());
}

/// The task of each front.
std::vector<int> tasks_of(const TaskTree& tree) {
  std::vector<int> tasks;
  for (int t = 0; t < tree.size(); ++t)
    tasks.resize(static_cast<std::size_t>(tree.begins[static_cast<std::size_t>(t) + 1]), t);
  return tasks;
}

/// Each front's task is that of its parent or below it.
void expect_children_below(const cholesky::FrontPlan& plan, const TaskTree& tree) {
  ASSERT_TRUE(std::is_sorted(tree.begins.begin(), tree.begins.end()));
  const auto task = tasks_of(tree);
  ASSERT_EQ(task.size(), plan.fronts.size());
  for (std::size_t s = 0; s < task.size(); ++s) {
    if (plan.fronts[s].parent < 0) continue;
    const int above = task[static_cast<std::size_t>(plan.fronts[s].parent)];
    int t = task[s];
    while (t >= 0 && t < above) {
      const int parent = tree.parents[static_cast<std::size_t>(t)];
      EXPECT_TRUE(parent < 0 || parent > t);
      t = parent;
    }
    EXPECT_EQ(t, above) << "front " << s;
  }
}

class ShareOut : public ::testing::TestWithParam<int> {};

TEST_P(ShareOut, PutsEveryFrontAboveItsChildren) {
  const int block = GetParam();
  Rng rng(53);
  auto shapes = testing::large_shapes(block, rng);
  shapes.push_back({"one block", 1, {}});
  for (const auto& shape : shapes) {
    SCOPED_TRACE(shape.name);
    const BlockSparse<3> h(shape.columns, shape.pairs);
    const cholesky::UpperPattern pattern{h.starts(), h.rows()};
    const auto plan = cholesky::plan_fronts(pattern, cholesky::minimum_degree(pattern), block);
    EXPECT_EQ(share_out(plan, 1).size(), 1);
    const TaskTree tree = share_out(plan, 2);
    EXPECT_EQ(tree.begins, share_out(plan, 256).begins);
    if (shape.columns >= 36 * 36) {
      EXPECT_GT(tree.size(), 8);
    }
    expect_children_below(plan, tree);
  }
}

INSTANTIATE_TEST_SUITE_P(Blocks, ShareOut, ::testing::Values(2, 3, 6));

// Each task sums its children's results: none may be missing, or still running (which a thread
// sanitizer would detect).
TEST(TaskPool, RunsChildrenBeforeParents) {
  constexpr int kTasks = 200;
  Rng rng(54);
  TaskTree tree;
  std::vector<std::vector<std::size_t>> children(kTasks);
  for (int t = 0; t < kTasks; ++t) {
    tree.begins.push_back(t);
    const auto parent = t + 1 + static_cast<int>(rng.below(7));
    tree.parents.push_back(parent < kTasks ? parent : -1);
    tree.cost_to_root.push_back(rng.uniform(0, 1));  // an arbitrary order
    if (parent < kTasks)
      children[static_cast<std::size_t>(parent)].push_back(static_cast<std::size_t>(t));
  }
  cholesky::TaskPool pool(tree, 8);
  std::vector<int> under(kTasks), want;
  const auto count = [&](int t) {
    int sum = 1;
    for (const std::size_t c : children[static_cast<std::size_t>(t)]) sum += under[c];
    under[static_cast<std::size_t>(t)] = sum;
  };
  for (int t = 0; t < kTasks; ++t) count(t);
  want = under;
  for (int again = 0; again < 50; ++again) {
    std::fill(under.begin(), under.end(), 0);
    pool.run(count);
    ASSERT_EQ(under, want);
  }
}

template <class G>
void expect_same_optimum(const PoseGraph<G>& start) {
  auto want = start;
  const auto one = optimise(want, {.max_iterations = 3});
  ASSERT_TRUE(one) << one.error().to_string();
  for (const int threads : {2, 3, 8}) {
    auto graph = start;
    const auto report = optimise(graph, {.max_iterations = 3, .threads = threads});
    ASSERT_TRUE(report) << report.error().to_string();
    EXPECT_EQ(report->final_cost, one->final_cost);
    int other = 0;
    for (std::size_t i = 0; i < graph.poses.size(); ++i)
      if (!same_pose(graph.poses[i], want.poses[i])) ++other;
    EXPECT_EQ(other, 0) << threads << " threads";
  }
}

class ThreadsOnRealGraphs : public ::testing::TestWithParam<const char*> {};

TEST_P(ThreadsOnRealGraphs, GiveTheSamePoses) {
  WAYFARE_NEEDS_RECORDING(path, std::string("posegraph/") + GetParam() + ".g2o.gz");
  const auto file = io::read_g2o(path);
  ASSERT_TRUE(file) << file.error().to_string();
  std::visit([](const auto& any) { expect_same_optimum(io::to_pose_graph(any)); }, *file);
}

INSTANTIATE_TEST_SUITE_P(Public, ThreadsOnRealGraphs, ::testing::Values("sphere2500", "city10000"));

}  // namespace
}  // namespace wayfare
