#include <wayfare/slam/basic_graph_slam.hpp>

#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <span>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/eval/trajectory_error.hpp>
#include <wayfare/match/registration.hpp>

#include "support.hpp"

namespace wayfare {
namespace {

using ::testing::HasSubstr;

/// ICP that fails as asked.
class Faulty {
 public:
  using Map = SurfaceMap;
  enum class Fault { none, error, no_match, no_map, pose, score, covariance, constraint, far };

  /// At every match from now on.
  void set(Fault fault) { *fault_ = fault; }

  [[nodiscard]] Result<SurfaceMap> make_map(std::span<const PlacedPoints> scans) const {
    if (*fault_ == Fault::no_map) return Error{ErrorCode::invalid, "no map"};
    return icp_.make_map(scans);
  }

  [[nodiscard]] Result<std::optional<MatchResult>> match(const SurfaceMap& map,
                                                         const PointSet& points, const SE2d& prior,
                                                         const SearchWindow& window,
                                                         const MatchOptions& options) const {
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    auto match = icp_.match(map, points, prior, window, options);
    if (*fault_ == Fault::none) return match;
    if (*fault_ == Fault::error) return Error{ErrorCode::numerical, "the matcher is in error"};
    if (*fault_ == Fault::no_match || !match || !*match) return std::optional<MatchResult>();
    MatchResult& result = **match;
    if (*fault_ == Fault::pose) result.T_map_points = SE2d(kNan, 0, Angle());
    if (*fault_ == Fault::score) result.score = kNan;
    if (*fault_ == Fault::covariance) result.covariance = Eigen::Matrix3d::Constant(kNan);
    if (*fault_ == Fault::constraint) result.constraint->share = kNan;
    if (*fault_ == Fault::far) result.T_map_points = SE2d(1e300, 0, Angle());
    return match;
  }

 private:
  IcpMatcher icp_;
  std::shared_ptr<Fault> fault_ = std::make_shared<Fault>(Fault::none);  // shared by the copies
};

using FaultySlam = BasicGraphSlam<Faulty>;
using Fault = Faulty::Fault;

/// Odometry of the room's scans.
std::optional<Transform2<frame::Odom, frame::Base>> odometry_at(double x) {
  return Transform2<frame::Odom, frame::Base>(SE2d(x, 1.5, Angle{}));
}

/// Five scans 10 cm apart.
FaultySlam five_scans(const Faulty& matcher) {
  FaultySlam slam(matcher);
  for (int k = 0; k < 5; ++k)
    EXPECT_TRUE(slam.add_scan(room_scan(0.2 * k, 2.0 + 0.1 * k, 1.5), odometry_at(2.0 + 0.1 * k)));
  EXPECT_EQ(slam.statistics().unmatched_scans, 0U);
  return slam;
}

TEST(BasicGraphSlam, KeepsThePredictedPoseWhereTheMatcherFails) {
  for (const Fault fault : {Fault::error, Fault::no_match, Fault::far}) {
    Faulty matcher;
    FaultySlam slam = five_scans(matcher);
    const SE2d before = slam.trajectory().back().T_map_base.raw();
    matcher.set(fault);
    const auto outcome = slam.add_scan(room_scan(1.0, 2.5, 1.5), odometry_at(2.5));
    ASSERT_TRUE(outcome) << outcome.error().to_string();
    EXPECT_FALSE(outcome->matched);
    EXPECT_EQ(slam.statistics().unmatched_scans, 1U);
    const SE2d step = before.inverse() * outcome->T_map_base.raw();
    EXPECT_LT(step.minus(SE2d(0.1, 0.0, Angle())).norm(), 1e-12);
    matcher.set(Fault::none);
    EXPECT_TRUE(slam.add_scan(room_scan(1.2, 2.6, 1.5), odometry_at(2.6))->matched);
  }
}

TEST(BasicGraphSlam, KeepsThePredictedPoseWithoutAMap) {
  Faulty matcher;
  matcher.set(Fault::no_map);
  FaultySlam slam(matcher);
  for (int k = 0; k < 5; ++k) {
    const double x = 2.0 + 0.1 * k;
    const auto outcome = slam.add_scan(room_scan(0.2 * k, x, 1.5), odometry_at(x));
    ASSERT_TRUE(outcome) << outcome.error().to_string();
    EXPECT_NEAR(outcome->T_map_base.raw().x(), x, 1e-12);
  }
  EXPECT_EQ(slam.statistics().unmatched_scans, 4U);
}

// The scan after the refused one is placed as if that had not been there, to the last bit.
TEST(BasicGraphSlam, ReportsAResultThatIsNotFiniteAndChangesNothing) {
  for (const Fault fault : {Fault::pose, Fault::score, Fault::covariance, Fault::constraint}) {
    Faulty good, bad;
    FaultySlam expected = five_scans(good), slam = five_scans(bad);
    bad.set(fault);
    const auto refused = slam.add_scan(room_scan(1.0, 2.5, 1.5), odometry_at(2.5));
    ASSERT_FALSE(refused);
    EXPECT_THAT(refused.error().message, HasSubstr("matcher's result is not finite"));
    bad.set(Fault::none);
    EXPECT_EQ(slam.statistics().scans, 5U);
    EXPECT_EQ(slam.graph().size(), expected.graph().size());
    const auto next = slam.add_scan(room_scan(1.2, 2.6, 1.5), odometry_at(2.6));
    const auto same = expected.add_scan(room_scan(1.2, 2.6, 1.5), odometry_at(2.6));
    ASSERT_TRUE(next && same);
    EXPECT_EQ(next->T_map_base.raw().translation(), same->T_map_base.raw().translation());
    EXPECT_EQ(next->T_map_base.raw().rotation().cos(), same->T_map_base.raw().rotation().cos());
  }
}

GraphSlamOptions for_icp(int threads = 1) {
  GraphSlamOptions options;
  options.threads = threads;
  return options;
}

// A correctly closed loop is accurate to a few centimetres, as with the library's matcher; the
// number of threads, which match loops, changes no bit.
TEST(BasicGraphSlam, ClosesALoopOfCorridorsByIcp) {
  const auto run = simulate(kRing, slipping_robot(), 1);
  const auto slam = run_graph_slam(run.recording, IcpMatcher{}, for_icp());
  ASSERT_TRUE(slam) << slam.error().to_string();
  EXPECT_EQ(slam->trajectory.size(), run.recording.scans.size());
  EXPECT_GT(slam->statistics.loop_closures, 5U);
  EXPECT_LT(rmse_m(slam->trajectory, run.truth), 0.10);
  const auto threads = run_graph_slam(run.recording, IcpMatcher{}, for_icp(2));
  ASSERT_TRUE(threads);
  ASSERT_EQ(threads->trajectory.size(), slam->trajectory.size());
  for (std::size_t i = 0; i < slam->trajectory.size(); ++i)
    ASSERT_EQ(threads->trajectory[i].T_map_base.raw().translation(),
              slam->trajectory[i].T_map_base.raw().translation())
        << "scan " << i;
}

}  // namespace
}  // namespace wayfare
