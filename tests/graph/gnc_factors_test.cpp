// Graduated non-convexity on factor graphs: false bearings and ranges of landmarks.

#include <wayfare/graph/gnc.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <type_traits>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/core/statistics.hpp>
#include <wayfare/graph/edges.hpp>
#include <wayfare/graph/factor_graph.hpp>
#include <wayfare/graph/optimise.hpp>

namespace wayfare {
namespace {

using Point = Eigen::Vector2d;
constexpr RobustKernel kHuber{RobustKernelKind::huber, 1.0};
constexpr double kBearing_rad = 0.01, kRange_m = 0.05;

/// Marked one by one.
struct MarkedSight : BearingRange {
  bool robust = false;
};

/// A robot on two laps of a street round a block, with trees beside it that are seen up to 8 m
/// away. A fraction `share` of the sightings are of nothing: any bearing, any range up to 8 m.
template <class Sight>
struct Street {
  using Graph = FactorGraph<Variables<SE2d, Point>, Edges<Between<SE2d>, Sight>>;
  Graph graph;
  std::vector<VariableId<SE2d>> poses;
  std::vector<SE2d> truth;
  std::vector<int> wrong;  // edges

  /// Without `false_ones`, the same measurements but for the false ones.
  Street(std::uint64_t seed, double share, bool false_ones = true) {
    Rng rng(seed);
    std::vector<Point> trees;
    for (int i = 0; i < 40; ++i) trees.emplace_back(rng.uniform(-6, 26), rng.uniform(-6, 26));
    std::vector<VariableId<Point>> ids(trees.size());
    poses.push_back(graph.add(SE2d()));
    graph.fix(poses[0]);
    truth.push_back(SE2d());
    struct Seen {
      std::size_t pose, tree;
      bool wrong;
      BearingRange edge;
    };
    std::vector<Seen> seen;
    for (int i = 0; i < 160; ++i) {
      if (i > 0) {
        const SE2d motion = i % 20 == 0 ? SE2d(0, 0, Angle::degrees(90)) * SE2d(1, 0, Angle())
                                        : SE2d(1, 0, Angle());
        const SE2d measured = motion * SE2d(0.02 * rng.normal(), 0.02 * rng.normal(),
                                            Angle::radians(0.003 * rng.normal()));
        truth.push_back(truth.back() * motion);
        poses.push_back(graph.add(graph[poses.back()] * measured));
        graph.add(Between<SE2d>{measured, Eigen::Vector3d(2500, 2500, 1.1e5).asDiagonal()},
                  poses[poses.size() - 2], poses.back());
      }
      for (std::size_t t = 0; t < trees.size(); ++t) {
        const Point at = truth.back().inverse() * trees[t];
        if (at.norm() > 8.0 || at.norm() < 0.5) continue;
        const bool false_one = rng.uniform(0, 1) < share;
        double bearing = std::atan2(at.y(), at.x()) + kBearing_rad * rng.normal();
        double range = at.norm() + kRange_m * rng.normal();
        if (false_one) bearing = rng.uniform(-3.1, 3.1), range = rng.uniform(0.5, 8.0);
        seen.push_back({truth.size() - 1,
                        t,
                        false_one,
                        {Angle::radians(bearing), range,
                         Point(1.0 / (kBearing_rad * kBearing_rad), 1.0 / (kRange_m * kRange_m))
                             .asDiagonal()}});
      }
    }
    for (const Seen& s : seen) {
      if (s.wrong && !false_ones) continue;
      const SE2d& from = graph[poses[s.pose]];
      const double a = s.edge.bearing.radians(), r = s.edge.range_m;
      if (ids[s.tree].index < 0)  // where the first sighting places it, true or false
        ids[s.tree] = graph.add(Point(from * Point(r * std::cos(a), r * std::sin(a))));
      if (s.wrong) wrong.push_back(graph.edge_count());
      if constexpr (std::is_same_v<Sight, MarkedSight>)
        graph.add(MarkedSight{s.edge, true}, poses[s.pose], ids[s.tree]);
      else
        graph.add(Sight{s.edge, false_ones ? kHuber : RobustKernel{}}, poses[s.pose], ids[s.tree]);
    }
  }

  /// The largest distance of a pose from where `other` has it.
  [[nodiscard]] double apart_m(const Street& other) const {
    double most = 0.0;
    for (const auto pose : poses)
      most = std::max(most, (graph[pose].translation() - other.graph[pose].translation()).norm());
    return most;
  }
};

struct Score {
  int found = 0, missed = 0, lost = 0;  // false ones rejected, not rejected; true ones rejected
};
Score score(const std::vector<int>& rejected, const std::vector<int>& wrong) {
  Score s;
  for (const int k : wrong)
    std::binary_search(rejected.begin(), rejected.end(), k) ? ++s.found : ++s.missed;
  s.lost = static_cast<int>(rejected.size()) - s.found;
  return s;
}

// A false sighting may agree with the truth by chance: within 4.3 standard deviations of both
// numbers lie 8.6·0.01/6.2 · 8.6·0.05/7.5 < 0.1 % of them.
TEST(GncFactors, FindsFalseSightingsAmongTrueOnes) {
  int wrong = 0, right = 0, missed = 0, lost = 0;
  for (const std::uint64_t seed : {11U, 12U, 13U, 14U})
    for (const double share : {0.1, 0.2, 0.3, 0.4}) {
      SCOPED_TRACE(std::to_string(seed) + ", " + std::to_string(share));
      Street<Robust<BearingRange>> street(seed, share), clean(seed, share, false);
      ASSERT_TRUE(optimise(clean.graph));
      const auto report = optimise_gnc(street.graph);
      ASSERT_TRUE(report) << report.error().to_string();
      const Score s = score(report->rejected, street.wrong);
      ASSERT_GT(s.found, 50);
      if (s.missed == 0 && s.lost == 0) {
        EXPECT_LT(street.apart_m(clean), 1e-3);
      }
      EXPECT_LT(street.apart_m(clean), 0.1);
      wrong += static_cast<int>(street.wrong.size());
      right += clean.graph.edge_count() - static_cast<int>(clean.poses.size()) + 1;
      missed += s.missed;
      lost += s.lost;
    }
  EXPECT_LT(missed, 0.01 * wrong) << wrong;
  EXPECT_LT(lost, 0.01 * right) << right;
}

// The same edges marked one by one give the same result, and unmarked ones are trusted.
TEST(GncFactors, EdgesAreMarkedByTypeOrOneByOne) {
  Street<Robust<BearingRange>> typed(11, 0.1);
  Street<MarkedSight> marked(11, 0.1);
  const auto by_type = optimise_gnc(typed.graph), one_by_one = optimise_gnc(marked.graph);
  ASSERT_TRUE(by_type && one_by_one);
  EXPECT_EQ(by_type->rejected, one_by_one->rejected);
  FactorGraph<Variables<SE2d, Point>, Edges<MarkedSight>> few;
  const auto pose = few.add(SE2d());
  const auto tree = few.add(Point(3.0, 0.1));
  few.fix(pose);
  for (const double range : {3.0, 3.01, 2.99, 5.0})
    few.add(MarkedSight{{Angle(), range, Point(1e4, 1e4).asDiagonal()}, range == 5.0}, pose, tree);
  const auto report = optimise_gnc(few);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->rejected, std::vector<int>{3});
  EXPECT_LT((few[tree] - Point(3.0, 0.0)).norm(), 1e-4) << "the mean of the first three";
  FactorGraph<Variables<SE2d, Point>, Edges<MarkedSight>> trusted;
  const auto p = trusted.add(SE2d());
  const auto t = trusted.add(Point(3.0, 0.1));
  trusted.fix(p);
  for (const double range : {3.0, 5.0})
    trusted.add(MarkedSight{{Angle(), range, Point(1e4, 1e4).asDiagonal()}, false}, p, t);
  const auto all = optimise_gnc(trusted);
  ASSERT_TRUE(all);
  EXPECT_TRUE(all->rejected.empty());
  EXPECT_LT((trusted[t] - Point(4.0, 0.0)).norm(), 1e-4) << "the mean of both";
}

/// Place of a tree, without an information matrix: in standard deviations of 1 cm.
struct MarkedPlace {
  using Variables = EdgeVariables<SE2d, Point>;
  static constexpr int kDim = 2;
  Point seen;
  bool robust = false;
  [[nodiscard]] Point error(const SE2d& pose, const Point& tree) const {
    return (pose.inverse() * tree - seen) / 0.01;
  }
};

// Beside an edge that determines the tree, which is trusted as a type without marks, an edge of
// σ = 1 cm is an outlier where its error exceeds the square root of the quantile of χ² of as many
// degrees of freedom as its information has; without one, as its error has.
TEST(GncFactors, TheGateIsTheQuantileOfTheEdgesDegreesOfFreedom) {
  FactorGraph<Variables<SE2d, Point>, Edges<LandmarkPosition<SE2d>, MarkedSight, MarkedPlace>>
      graph;
  const auto pose = graph.add(SE2d());
  const auto tree = graph.add(Point(3.0, 0.0));
  graph.fix(pose);
  graph.add(LandmarkPosition<SE2d>{Point(3.0, 0.0), 1e10 * Eigen::Matrix2d::Identity()}, pose,
            tree);
  for (const int freedom : {1, 2}) {
    const double limit_m = 0.01 * std::sqrt(chi_square_quantile(0.9999, freedom));
    for (const double part : {0.99, 1.01}) {
      const double seen_m = 3.0 + part * limit_m;
      graph.add(
          MarkedSight{{Angle(), seen_m, Point(freedom == 2 ? 1e4 : 0.0, 1e4).asDiagonal()}, true},
          pose, tree);
      if (freedom == 2) graph.add(MarkedPlace{Point(seen_m, 0.0), true}, pose, tree);
    }
  }
  const auto report = optimise_gnc(graph);
  ASSERT_TRUE(report) << report.error().to_string();
  EXPECT_EQ(report->rejected, (std::vector<int>{2, 4, 6}));
}

// Two sightings contradict each other and nothing supports either: named, and nothing has moved.
TEST(GncFactors, NamesAVariableWithRejectedEdgesOnly) {
  FactorGraph<Variables<SE2d, Point>, Edges<Robust<BearingRange>>> graph;
  const auto pose = graph.add(SE2d());
  const auto tree = graph.add(Point(3.0, 0.1));
  graph.fix(pose);
  for (const double range : {2.0, 6.0})
    graph.add(Robust{BearingRange{Angle(), range, Point(1e4, 1e4).asDiagonal()}, RobustKernel{}},
              pose, tree);
  const auto report = optimise_gnc(graph);
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().code, ErrorCode::degenerate);
  EXPECT_NE(report.error().message.find("variable 1 is not fully determined"), std::string::npos)
      << report.error().message;
  EXPECT_EQ(graph[tree], Point(3.0, 0.1));
}

}  // namespace
}  // namespace wayfare
