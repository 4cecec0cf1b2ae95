// The matchers' optimum on scans of real logs equals that of an exhaustive search by definition.

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/io/carmen.hpp>
#include <wayfare/match/correlative.hpp>

#include "io/support.hpp"
#include "reference.hpp"

namespace wayfare {
namespace {

/// A scan of a log, the field of the ten before it, and a prior.
struct Problem {
  LikelihoodField field;
  PointSet seen;
  SE2d prior;
};

std::vector<Problem> problems_of(const io::CarmenLog& log, std::size_t count, Rng& rng) {
  std::vector<Problem> problems;
  const auto& scans = log.recording.scans;
  const auto pose = [&](std::size_t i) { return log.reported_poses[i].T_map_base.raw(); };
  for (std::size_t p = 0; p < count; ++p) {
    const std::size_t i = 10 + p * (scans.size() - 11) / count;
    std::vector<PointSet> points;
    std::vector<PlacedPoints> placed;
    for (std::size_t j = i - 10; j <= i; ++j) points.push_back(end_points(scans[j]));
    for (std::size_t j = 0; j < 10; ++j) placed.push_back({&points[j], pose(i - 10 + j)});
    const SE2d off(rng.uniform(-0.2, 0.2), rng.uniform(-0.2, 0.2),
                   Angle::degrees(rng.uniform(-12, 12)));
    const auto field = likelihood_field(placed);
    if (field && !points.back().empty()) problems.push_back({*field, points.back(), pose(i) * off});
  }
  return problems;
}

/// Plain, with a Gaussian prior, and with a score that few or no candidates reach.
std::vector<MatchOptions> ways_to_ask() {
  std::vector<MatchOptions> ways(4);
  ways[1].prior_information = Eigen::Vector3d(25, 100, 400).asDiagonal();
  ways[1].independent_points = 8;
  ways[2].min_score = 0.9;
  ways[3].min_score = 0.99;
  return ways;
}

void expect_the_optimum(const Problem& problem, const SearchWindow& window) {
  CorrelativeMatcher correlative;
  BranchAndBoundMatcher bounded;
  const PrecomputationGrids grids(problem.field);
  for (const MatchOptions& options : ways_to_ask()) {
    const auto shape =
        correlative.surface(problem.field, problem.seen, problem.prior, window, options);
    ASSERT_TRUE(shape) << shape.error().to_string();
    const Reference want = brute_force(problem.field, problem.seen, problem.prior, *shape, options);
    for (const auto& got :
         {correlative.match(problem.field, problem.seen, problem.prior, window, options),
          bounded.match(grids, problem.seen, problem.prior, window, options)}) {
      ASSERT_TRUE(got) << got.error().to_string();
      ASSERT_EQ(got->has_value(), want.found);
      if (!want.found) continue;
      EXPECT_EQ((*got)->candidate, want.candidate);
      EXPECT_DOUBLE_EQ((*got)->score, static_cast<double>(want.sum) /
                                          static_cast<double>(problem.seen.size()) / 4080);
    }
  }
}

void expect_the_optima(const std::string& path) {
  const auto log = io::read_carmen(path);
  ASSERT_TRUE(log);
  ASSERT_EQ(log->reported_poses.size(), log->recording.scans.size());
  Rng rng(31);
  const auto problems = problems_of(*log, 10, rng);
  ASSERT_GE(problems.size(), 8U);
  for (std::size_t i = 0; i < problems.size(); ++i) {
    SCOPED_TRACE(i);
    expect_the_optimum(problems[i], {0.3, 0.3, Angle::degrees(i % 2 == 0 ? 20 : 6)});
    // Too wide for SmallSearch.
    if (i % 3 == 0) expect_the_optimum(problems[i], {1.2, 0.9, Angle::degrees(1)});
  }
}

TEST(MatchersOnRealLogs, FindTheOptimumOnFreiburg079) {
  WAYFARE_NEEDS_RECORDING(log, "slam2d/fr079.clf.gz");
  expect_the_optima(log);
}

TEST(MatchersOnRealLogs, FindTheOptimumOnIntel) {
  WAYFARE_NEEDS_RECORDING(log, "slam2d/intel.clf.gz");
  expect_the_optima(log);
}

}  // namespace
}  // namespace wayfare
