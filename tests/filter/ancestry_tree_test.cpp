#include <wayfare/filter/detail/ancestry_tree.hpp>

#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>

namespace wayfare {
namespace {

StampedPose pose_number(std::int64_t n) {
  return {LogTime::from_nanoseconds(n),
          Transform2<frame::Map, frame::Base>(SE2d(static_cast<double>(n), 0.0, Angle()))};
}

std::vector<std::int64_t> numbers(const Trajectory& trajectory) {
  std::vector<std::int64_t> result;
  for (const StampedPose& p : trajectory) result.push_back(p.time.nanoseconds());
  return result;
}

/// Compared with a separate copy of every trajectory.
TEST(AncestryTree, KeepsTheReferencedTrajectoriesOnly) {
  using Numbers = std::vector<std::int64_t>;
  Rng rng(1);
  AncestryTree tree;
  std::vector<std::pair<AncestryTree::Node, Numbers>> trajectories;
  for (std::int64_t n = 0; n < 4000; ++n) {
    const double what = rng.uniform();
    if (trajectories.empty() || what < 0.05) {
      trajectories.emplace_back(tree.add_root(pose_number(n)), Numbers{n});
    } else if (what < 0.7) {
      auto& [end, trajectory] = trajectories[rng.below(trajectories.size())];
      end = tree.append(end, pose_number(n));
      trajectory.push_back(n);
    } else if (what < 0.85) {
      trajectories.push_back(trajectories[rng.below(trajectories.size())]);
      tree.retain(trajectories.back().first);
    } else {
      std::swap(trajectories[rng.below(trajectories.size())], trajectories.back());
      tree.release(trajectories.back().first);
      trajectories.pop_back();
    }
    std::set<std::int64_t> kept;
    for (const auto& [end, trajectory] : trajectories)
      kept.insert(trajectory.begin(), trajectory.end());
    ASSERT_EQ(tree.size(), kept.size()) << "after " << n;
  }
  ASSERT_GT(trajectories.size(), 10U);
  for (const auto& [end, trajectory] : trajectories)
    EXPECT_EQ(numbers(tree.trajectory(end)), trajectory);
}

}  // namespace
}  // namespace wayfare
