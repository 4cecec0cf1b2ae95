#include <wayfare/io/growing_landmark_graph.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace wayfare::io {
namespace {

using ::testing::HasSubstr;

/// Sixty poses along a circle of 8 m and three trees, all exactly measured; the first sighting of
/// tree 101 is a range and a bearing. Tree 102 is seen by range alone, which determines it from the
/// third sighting on.
GraphFile<SE2d> circle() {
  GraphFile<SE2d> file;
  const SE2d step(1.0, 0.0, Angle::radians(0.125));
  const std::vector<Eigen::Vector2d> trees{{2, 3}, {-4, 1}, {-9, -3}};
  SE2d pose(3.0, -1.0, Angle::radians(2.0));
  for (int i = 0; i < 60; ++i, pose = pose * step) {
    file.vertices.push_back({i, pose});
    if (i > 0) file.edges.push_back({i - 1, i, step, 1e4 * Eigen::Matrix3d::Identity()});
    const auto seen = [&](std::size_t k) -> Eigen::Vector2d { return pose.inverse() * trees[k]; };
    if (i % 3 == 0) file.all<LandmarkPosition<SE2d>>().push_back({{i, 100}, {seen(0)}});
    if (i % 4 == 0) {
      const Angle bearing = Angle::radians(std::atan2(seen(1).y(), seen(1).x()));
      file.all<BearingRange>().push_back({{i, 101}, {bearing, seen(1).norm()}});
    }
    if (i % 5 == 0) file.all<RangeTo<SE2d>>().push_back({{i, 102}, {seen(2).norm()}});
  }
  for (std::size_t k = 0; k < trees.size(); ++k)
    file.landmarks.push_back({100 + static_cast<int>(k), trees[k]});
  return file;
}

/// With other poses than the first and tree 100 of no use, the other trees 0.3 m off.
GraphFile<SE2d> unsolved() {
  GraphFile<SE2d> file = circle();
  for (std::size_t i = 1; i < file.vertices.size(); ++i) file.vertices[i].pose = SE2d();
  for (auto& tree : file.landmarks) tree.position += Eigen::Vector2d(0.3, -0.3);
  file.landmarks[0].position.setZero();
  return file;
}

double distance(const GraphFile<SE2d>& a, const GraphFile<SE2d>& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.vertices.size(); ++i)
    largest = std::max(largest, a.vertices[i].pose.minus(b.vertices[i].pose).norm());
  for (std::size_t i = 0; i < a.landmarks.size(); ++i)
    largest = std::max(largest, (a.landmarks[i].position - b.landmarks[i].position).norm());
  return largest;
}

/// Every step to convergence.
constexpr IncrementalOptions kExact{.relinearise_step = 0.0, .solve_change = 0.0, .max_rounds = 50};

TEST(OptimiseGrowing, FindsExactMeasurements) {
  auto file = unsolved();
  const auto report = optimise_growing(file, {}, false, kExact);
  ASSERT_TRUE(report) << report.error().to_string();
  EXPECT_LT(distance(file, circle()), 1e-6);
  EXPECT_LT(report->cost, 1e-9);
  EXPECT_GE(report->rounds, 50);
}

// A tree is seen 5 m off once. The values are those of the batch optimiser with the same kernel,
// and the cost is less than without one.
TEST(OptimiseGrowing, TakesAKernelOfDoubtfulEdges) {
  auto file = unsolved();
  file.all<LandmarkPosition<SE2d>>()[9].edge.measurement.x() += 5.0;
  auto plain = file;
  const RobustKernel cauchy{RobustKernelKind::cauchy, 1.0};
  const auto without = optimise_growing(plain, {}, false, kExact);
  const auto report = optimise_growing(file, cauchy, false, kExact);
  ASSERT_TRUE(without && report);
  EXPECT_LT(report->cost, 0.5 * without->cost);
  auto graph = to_robust_factor_graph(file, cauchy);
  const auto optimum = optimise(graph, {.min_relative_gain = 1e-12});
  ASSERT_TRUE(optimum);
  EXPECT_NEAR(optimum->final_cost, report->cost, 1e-6 * report->cost);
}

TEST(OptimiseGrowing, LeavesTheFileWhereItCannotGrow) {
  const auto refuse = [](auto change) {
    GraphFile<SE2d> file = unsolved();
    change(file);
    const GraphFile<SE2d> before = file;
    const auto report = optimise_growing(file);
    EXPECT_FALSE(report);
    EXPECT_EQ(distance(file, before), 0.0);
    return report ? std::string() : report.error().message;
  };
  EXPECT_THAT(refuse([](auto& file) { file.fixed = {3}; }), HasSubstr("vertex 3 is fixed"));
  EXPECT_THAT(refuse([](auto& file) {
                file.landmarks.push_back({200, {1.0, 1.0}});
              }),
              HasSubstr("landmark 200 is not measured from any vertex"));
  EXPECT_THAT(refuse([](auto& file) { file.edges[40].information.setZero(); }),
              HasSubstr("zero information"));
  // The last tree by a single range.
  EXPECT_THAT(refuse([](auto& file) { file.template all<RangeTo<SE2d>>().resize(1); }),
              HasSubstr("is not fully determined by the edges"));
}

TEST(PlaceLandmarks, PutsThemWhereTheyAreSeenFirst) {
  GraphFile<SE3d> file;
  const SE3d quarter(Eigen::Vector3d(1, 2, 3), SO3d::exp({0.0, 0.0, 1.5707963267948966}));
  file.vertices = {{0, SE3d()}, {1, quarter}};
  file.landmarks = {{7, {9, 9, 9}}, {8, {9, 9, 9}}, {9, {9, 9, 9}}};
  file.fixed = {9};
  file.sensors.emplace(5, SE3d(Eigen::Vector3d(0.5, 0, 0), SO3d()));
  auto& seen = file.all<LandmarkPosition<SE3d>>();
  seen.push_back({{1, 7}, {Eigen::Vector3d(1, 0, 0)}, 5});  // 1.5 m ahead, along y
  seen.push_back({{0, 7}, {Eigen::Vector3d(4, 4, 4)}});
  seen.push_back({{0, 9}, {Eigen::Vector3d(4, 4, 4)}});
  place_landmarks(file);
  EXPECT_LT((file.landmarks[0].position - Eigen::Vector3d(1, 3.5, 3)).norm(), 1e-12);
  EXPECT_EQ(file.landmarks[1].position, Eigen::Vector3d(9, 9, 9)) << "never seen";
  EXPECT_EQ(file.landmarks[2].position, Eigen::Vector3d(9, 9, 9)) << "fixed";
}

}  // namespace
}  // namespace wayfare::io
