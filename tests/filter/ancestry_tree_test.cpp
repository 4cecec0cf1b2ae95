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

std::vector<std::int64_t> numbers(const Trajectory& way) {
  std::vector<std::int64_t> result;
  for (const StampedPose& p : way) result.push_back(p.time.nanoseconds());
  return result;
}

/// Beside it, every way with a copy of all its poses.
TEST(AncestryTree, KeepsTheWaysThatAreHeldAndNothingElse) {
  using Way = std::vector<std::int64_t>;
  Rng rng(1);
  AncestryTree tree;
  std::vector<std::pair<AncestryTree::Node, Way>> ways;
  for (std::int64_t n = 0; n < 4000; ++n) {
    const double what = rng.uniform();
    if (ways.empty() || what < 0.05) {
      ways.emplace_back(tree.plant(pose_number(n)), Way{n});
    } else if (what < 0.7) {
      auto& [end, way] = ways[rng.below(ways.size())];
      end = tree.grow(end, pose_number(n));
      way.push_back(n);
    } else if (what < 0.85) {
      ways.push_back(ways[rng.below(ways.size())]);
      tree.hold(ways.back().first);
    } else {
      std::swap(ways[rng.below(ways.size())], ways.back());
      tree.release(ways.back().first);
      ways.pop_back();
    }
    std::set<std::int64_t> kept;
    for (const auto& [end, way] : ways) kept.insert(way.begin(), way.end());
    ASSERT_EQ(tree.size(), kept.size()) << "after " << n;
  }
  ASSERT_GT(ways.size(), 10U);
  for (const auto& [end, way] : ways) EXPECT_EQ(numbers(tree.way(end)), way);
}

}  // namespace
}  // namespace wayfare
