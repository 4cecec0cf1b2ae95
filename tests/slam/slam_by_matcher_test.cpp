// Graph, submap and Hector SLAM by a matcher of any type: the laws that all three keep.

#include <atomic>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/match/registration.hpp>
#include <wayfare/motion/motion_noise.hpp>
#include <wayfare/slam/basic_graph_slam.hpp>
#include <wayfare/slam/hector_slam.hpp>
#include <wayfare/slam/submap_slam.hpp>

#include "support.hpp"

namespace wayfare {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;
using Odometry = Transform2<frame::Odom, frame::Base>;

/// What the matcher does at one of its calls.
enum class Fault { none, no_match, error, pose, score, covariance, indefinite, constraint, no_map };
struct Plan {
  Fault fault = Fault::none;
  int at = -1;
  std::atomic<int> calls{0};  // of `match`, or of `make_map` for no_map
};

/// ICP that misbehaves at one of its calls.
class PlannedIcp {
 public:
  using Map = SurfaceMap;

  explicit PlannedIcp(Plan& plan) : plan_(&plan) {}

  Result<SurfaceMap> make_map(std::span<const PlacedPoints> scans) const {
    if (plan_->fault == Fault::no_map && plan_->calls++ == plan_->at)
      return Error{ErrorCode::numerical, "no map today"};
    return icp_.make_map(scans);
  }
  Result<std::optional<MatchResult>> match(const SurfaceMap& map, const PointSet& points,
                                           const SE2d& prior, const SearchWindow& window,
                                           const MatchOptions& options) const {
    auto match = icp_.match(map, points, prior, window, options);
    if (plan_->fault == Fault::no_map || plan_->calls++ != plan_->at) return match;
    if (plan_->fault == Fault::error) return Error{ErrorCode::numerical, "no match today"};
    if (plan_->fault == Fault::no_match) return std::optional<MatchResult>();
    MatchResult bad = match && *match ? **match : MatchResult{.T_map_points = prior};
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    if (plan_->fault == Fault::pose) bad.T_map_points = SE2d(0.0, kNan, Angle());
    if (plan_->fault == Fault::score) bad.score = kNan;
    if (plan_->fault == Fault::covariance) bad.covariance = Eigen::Matrix3d::Constant(kNan);
    if (plan_->fault == Fault::indefinite) bad.covariance = -Eigen::Matrix3d::Identity();
    if (plan_->fault == Fault::constraint) bad.constraint = SceneConstraint{.share = kNan};
    return std::optional(bad);
  }

 private:
  IcpMatcher icp_;
  Plan* plan_;
};

const char* reason_of(Fault fault) {
  switch (fault) {
    case Fault::error:
      return "no match today";
    case Fault::no_map:
      return "no map today";
    case Fault::pose:
      return "not finite: its pose";
    case Fault::score:
      return "not finite: its score";
    case Fault::covariance:
      return "not finite: its covariance";
    case Fault::indefinite:
      return "not positive semi-definite";
    case Fault::constraint:
      return "not finite: its constraint";
    default:
      return "";
  }
}
bool is_invalid_result(Fault fault) {
  return fault != Fault::error && fault != Fault::no_map && fault != Fault::no_match;
}

// The systems, with loops in a single room.

struct Graph {
  using Default = GraphSlam;
  using Options = GraphSlamOptions;
  static constexpr bool kCloses = true;
  template <class M>
  static auto make(const M& matcher, int threads = 1) {
    GraphSlamOptions o;
    o.node_distance_m = 0.1;
    o.nodes_between_loops = 1;
    o.loop_gap_nodes = 4;
    o.loop_gap_travel_m = 0.4;
    o.threads = threads;
    return BasicGraphSlam<M>(matcher, o);
  }
  template <class Slam>
  static auto add(Slam& slam, const LaserScan& scan, const std::optional<Odometry>& odometry) {
    return slam.add_scan(scan, odometry);
  }
  template <class Slam>
  static bool finish(Slam& slam) {
    return slam.finish().has_value();
  }
};

struct Submaps {
  using Default = SubmapSlam;
  using Options = SubmapSlamOptions;
  static constexpr bool kCloses = true;
  template <class M>
  static auto make(const M& matcher, int threads = 1) {
    return BasicSubmapSlam<M>(matcher, options(threads));
  }
  static SubmapSlamOptions options(int threads = 1) {
    SubmapSlamOptions o;
    o.node_distance_m = 0.1;
    o.submap_nodes = 4;
    o.nodes_between_loops = 1;
    o.loop_latency_scans = 2;
    o.loop_gap_travel_m = 0.4;
    o.threads = threads;
    return o;
  }
  template <class Slam>
  static auto add(Slam& slam, const LaserScan& scan, const std::optional<Odometry>& odometry) {
    return slam.add_scan(scan, {odometry, {}});
  }
  template <class Slam>
  static bool finish(Slam& slam) {
    return slam.finish().has_value();
  }
};

struct Hector {
  using Default = HectorSlam;
  using Options = HectorSlamOptions;
  static constexpr bool kCloses = false;
  template <class M>
  static auto make(const M& matcher, int = 1) {
    HectorSlamOptions o;
    o.map_travel_m = 0.1;
    return BasicHectorSlam<M>(matcher, o);
  }
  template <class Slam>
  static auto add(Slam& slam, const LaserScan& scan, const std::optional<Odometry>& odometry) {
    return slam.add_scan(scan, odometry);
  }
  template <class Slam>
  static bool finish(Slam&) {
    return true;
  }
};

constexpr int kScans = 24;

/// To and fro along the room, with a slip of the odometry.
double x_at(int k) { return k < kScans / 2 ? 2.0 + 0.12 * k : 2.0 + 0.12 * (kScans - k); }
LaserScan view_at(int k) { return room_scan(0.2 * k, x_at(k), 1.5); }
Odometry odometry_of(int k) { return Odometry(SE2d(1.02 * x_at(k), 1.5, Angle())); }

struct Outcome {
  std::vector<Eigen::Vector3d> path;
  int refused = 0;
  std::string refusal;
  std::size_t loops = 0, unmatched = 0;
  MatcherErrors errors, of_outcomes;
};

/// A scan that is refused is given once more.
template <class System, class Slam>
Outcome drive(Slam slam) {
  Outcome result;
  for (int k = 0; k < kScans; ++k) {
    auto outcome = System::add(slam, view_at(k), odometry_of(k));
    if (!outcome) {
      ++result.refused;
      result.refusal = outcome.error().message;
      outcome = System::add(slam, view_at(k), odometry_of(k));
    }
    EXPECT_TRUE(outcome);
    if (outcome) result.of_outcomes.add(outcome->matcher_errors);
  }
  EXPECT_TRUE(System::finish(slam));
  for (const StampedPose& p : slam.trajectory()) result.path.push_back(p.T_map_base.raw().log());
  if constexpr (System::kCloses) result.loops = slam.statistics().loop_closures;
  result.unmatched = slam.statistics().unmatched_scans;
  result.errors = slam.statistics().matcher_errors;
  return result;
}

template <class System>
Outcome drive_with(Fault fault, int at, int* calls = nullptr) {
  Plan plan{fault, at};
  Outcome result = drive<System>(System::make(PlannedIcp(plan)));
  if (calls != nullptr) *calls = plan.calls;
  return result;
}

template <class System>
class SlamByAnyMatcher : public ::testing::Test {};
using Systems = ::testing::Types<Graph, Submaps, Hector>;
TYPED_TEST_SUITE(SlamByAnyMatcher, Systems);

TYPED_TEST(SlamByAnyMatcher, AMatcherThatPassesOnChangesNoBit) {
  const Outcome passed = drive_with<TypeParam>(Fault::none, -1);
  const Outcome itself = drive<TypeParam>(TypeParam::make(IcpMatcher()));
  EXPECT_EQ(passed.path, itself.path);
  EXPECT_EQ(passed.loops, itself.loops);
  EXPECT_EQ(itself.unmatched, 0U);
  EXPECT_EQ(itself.errors.count, 0U);
  EXPECT_NEAR(itself.path.back().x() - itself.path.front().x(), 0.12, 0.02);
  if (TypeParam::kCloses) {
    EXPECT_GT(itself.loops, 3U);
  }
}

TYPED_TEST(SlamByAnyMatcher, TheNumberOfThreadsChangesNoBit) {
  const Outcome one = drive<TypeParam>(TypeParam::make(IcpMatcher()));
  const Outcome three = drive<TypeParam>(TypeParam::make(IcpMatcher(), 3));
  EXPECT_EQ(one.path, three.path);
  EXPECT_EQ(one.loops, three.loops);
}

// At every call there is: a result that is not valid is an Error of add_scan, after which the same
// scan goes on as if nothing had been, or it is counted with its reason, as an Error of the matcher
// always is, and the run goes on as after no match.
TYPED_TEST(SlamByAnyMatcher, NoFaultOfTheMatcherPassesUnnoticed) {
  using enum Fault;
  int calls = 0;
  const Outcome clean = drive_with<TypeParam>(none, -1, &calls);
  ASSERT_GT(calls, kScans - 2);
  std::size_t at_scans = 0, at_loops = 0, refused = 0;
  constexpr Fault kFaults[] = {error, pose, score, covariance, indefinite, constraint};
  for (int k = 0; k < calls; ++k)
    for (const Fault fault : {error, kFaults[1 + k % 5]}) {
      SCOPED_TRACE("call " + std::to_string(k) + ": " + reason_of(fault));
      const Outcome run = drive_with<TypeParam>(fault, k);
      if (run.refused > 0) {
        ++refused;
        EXPECT_TRUE(is_invalid_result(fault));
        EXPECT_EQ(run.refused, 1);
        EXPECT_EQ(run.errors.count, 0U);
        EXPECT_THAT(run.refusal, HasSubstr(reason_of(fault)));
        EXPECT_EQ(run.path, clean.path);
        continue;
      }
      ASSERT_EQ(run.errors.count, 1U);
      EXPECT_THAT(run.errors.first, HasSubstr(reason_of(fault)));
      const bool loop = run.errors.first.starts_with("loop: ");
      if (!loop) {
        EXPECT_THAT(run.errors.first, StartsWith("scan: "));
        EXPECT_EQ(fault, error);
        EXPECT_EQ(run.of_outcomes.first, run.errors.first);
      }
      (loop ? at_loops : at_scans) += 1;
      EXPECT_EQ(run.path, drive_with<TypeParam>(no_match, k).path);
    }
  EXPECT_GT(at_scans, 10U);
  EXPECT_GT(refused, 10U);
  if (TypeParam::kCloses) {
    EXPECT_GT(at_loops, 6U);
  }
}

TYPED_TEST(SlamByAnyMatcher, AMapThatCannotBeMadeIsCounted) {
  int calls = 0;
  drive_with<TypeParam>(Fault::no_map, -1, &calls);
  ASSERT_GT(calls, 3);
  for (int k = 0; k < calls; ++k) {
    const Outcome run = drive_with<TypeParam>(Fault::no_map, k);
    EXPECT_GT(run.errors.count, 0U) << "map " << k;
    EXPECT_THAT(run.errors.first, HasSubstr("no map today")) << "map " << k;
  }
}

/// By the default matcher, with odometry at the first scan and, if asked, at the later ones.
template <class System>
std::vector<Eigen::Vector3d> path_by_default(const typename System::Options& options, bool later) {
  typename System::Default slam(options);
  for (int k = 0; k < kScans; ++k)
    EXPECT_TRUE(System::add(slam, view_at(k),
                            k == 0 || later ? std::optional(odometry_of(k)) : std::nullopt));
  std::vector<Eigen::Vector3d> path;
  for (const StampedPose& p : slam.trajectory()) path.push_back(p.T_map_base.raw().log());
  return path;
}

TYPED_TEST(SlamByAnyMatcher, OdometryWhoseNoiseIsNanCountsAsMissing) {
  const auto without = path_by_default<TypeParam>({}, false);
  for (double MotionNoise::*part :
       {&MotionNoise::translation_floor_m, &MotionNoise::heading_per_rad}) {
    typename TypeParam::Options options;
    options.odometry.*part = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(path_by_default<TypeParam>(options, true), without);
  }
  EXPECT_NE(path_by_default<TypeParam>({}, true), without);
}

TEST(MotionModel, IsUncertainByAMetreWhereNoNoiseIsKnown) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  MotionModel model({.translation_floor_m = kNan}, {.heading_floor = Angle::radians(kNan)});
  model.update(LogTime::from_seconds(0), SE2d(), SE2d());
  const Motion motion = model.predict(LogTime::from_seconds(0.1), SE2d(0.2, 0.0, Angle()));
  EXPECT_EQ(motion.sigma, Eigen::Vector3d(1.0, 1.0, 1.0));
  EXPECT_EQ(motion.increment.translation(), Eigen::Vector2d(0.0, 0.0));
}

// The default's maps for the refinement of loops are smoother: without loops.
TEST(SubmapSlamByItsDefaultMatcher, IsTheSameWhenItIsGiven) {
  SubmapSlamOptions options = Submaps::options();
  options.loops_per_search = 0;
  const Outcome given = drive<Submaps>(BasicSubmapSlam(GaussNewtonMatcher(options.match), options));
  EXPECT_EQ(given.path, drive<Submaps>(SubmapSlam(options)).path);
}
TEST(HectorSlamByItsDefaultMatcher, IsTheSameWhenItIsGiven) {
  const HectorSlamOptions options;
  const Outcome given = drive<Hector>(BasicHectorSlam(GaussNewtonMatcher(options.match), options));
  EXPECT_EQ(given.path, drive<Hector>(HectorSlam(options)).path);
}

}  // namespace
}  // namespace wayfare
