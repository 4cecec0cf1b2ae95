// Monte-Carlo localisation with likelihoods, maps and models of odometry that the library does not
// know: ranges to beacons in the plane and in space.

#include <wayfare/slam/basic_localiser.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/slam/monte_carlo.hpp>
#include <wayfare/slam/scan_likelihood.hpp>
#include <wayfare/testing/particle_laws.hpp>

namespace wayfare {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Beacons in a hall of 30 m × 20 m × 5 m.
template <class Pose>
struct Hall {
  std::vector<typename Pose::Vector> beacons_m;

  [[nodiscard]] Pose random_pose(Rng& rng) const {
    const Angle heading = Angle::radians(rng.uniform(-3.14159, 3.14159));
    const double x = rng.uniform(0.0, 30.0), y = rng.uniform(0.0, 20.0);
    if constexpr (std::same_as<Pose, SE2d>)
      return {x, y, heading};
    else
      return {{x, y, rng.uniform(0.0, 5.0)},
              SO3d::exp(Eigen::Vector3d(0.0, 0.0, heading.radians()))};
  }
};

struct Ranges {
  std::vector<double> m;
};
/// Another type of scan.
struct Compass {
  Angle heading;
};

template <class P>
struct RangeLikelihood {
  using Pose = P;
  double worst = -kInf;  ///< for poses west of x = 10 m, in place of the likelihood, unless -inf

  [[nodiscard]] double log_likelihood(const P& pose, const Ranges& scan, const Hall<P>& map) const {
    if (worst != -kInf && pose.translation().x() < 10.0) return worst;
    double sum = 0.0;
    for (std::size_t i = 0; i < scan.m.size(); ++i) {
      const double d = (map.beacons_m[i] - pose.translation()).norm() - scan.m[i];
      sum -= std::log1p(d * d / 0.04);
    }
    return sum;
  }
  [[nodiscard]] double log_likelihood(const SE2d& pose, const Compass& scan,
                                      const Hall<SE2d>&) const {
    const double d = (pose.heading() - scan.heading).wrapped().radians() / 0.1;
    return -0.5 * d * d;
  }
  [[nodiscard]] bool enough(const Ranges& scan) const { return scan.m.size() > 2; }
  [[nodiscard]] bool enough(const Compass&) const { return true; }
  static constexpr std::size_t kSensors = 2;
  [[nodiscard]] std::size_t sensor(const Ranges&) const { return 0; }
  [[nodiscard]] std::size_t sensor(const Compass&) const { return 1; }
};
static_assert(ScanLikelihoodModel<RangeLikelihood<SE3d>, Ranges, Hall<SE3d>>);
static_assert(!ScanLikelihoodModel<RangeLikelihood<SE3d>, double, Hall<SE3d>>);

struct Slip {
  [[nodiscard]] Gaussian<SE3d> motion(const SE3d& increment) const {
    return {increment, 4e-4 * SquareOf<SE3d>::Identity()};
  }
};

using InPlane = BasicLocaliser<Hall<SE2d>, RangeLikelihood<SE2d>>;
using InSpace = BasicLocaliser<Hall<SE3d>, RangeLikelihood<SE3d>, Slip>;

std::shared_ptr<const Hall<SE2d>> plane() {
  return std::make_shared<const Hall<SE2d>>(
      Hall<SE2d>{{{0.0, 0.0}, {28.0, 2.0}, {5.0, 19.0}, {30.0, 17.0}, {14.0, 8.0}}});
}

MonteCarloOptions quick(int threads = 1) {
  MonteCarloOptions options;
  options.min_candidates = 20000;
  options.max_particles = 4000;
  options.threads = threads;
  return options;
}

template <class Pose>
Ranges ranges_at(const Pose& truth, const Hall<Pose>& hall, Rng& rng) {
  Ranges scan;
  for (const auto& b : hall.beacons_m)
    scan.m.push_back((b - truth.translation()).norm() + rng.normal(0.0, 0.1));
  return scan;
}

/// A drive in circles, carried away in the middle.
std::vector<MonteCarloOutcome<SE2d>> drive(InPlane& localiser, int steps = 160) {
  const auto hall = plane();
  std::vector<MonteCarloOutcome<SE2d>> outcomes;
  SE2d truth(6.0, 6.0, Angle{}), odometry;
  Rng rng(1);
  for (int k = 0; k < steps; ++k) {
    if (k == 80) truth = SE2d(21.0, 11.0, 2.0_rad);
    const SE2d step(0.2, 0.0, 0.07_rad);
    truth = truth * step;
    odometry = odometry * step;
    const auto at = LogTime::from_seconds(0.2 * k);
    const Transform2<frame::Odom, frame::Base> measured(odometry);
    auto outcome = localiser.add_scan(at, ranges_at(truth, *hall, rng), measured);
    EXPECT_TRUE(outcome) << outcome.error().message;
    if (k % 10 == 5 && outcome)
      outcome = localiser.add_scan(at, Compass{truth.heading()}, measured);
    EXPECT_TRUE(outcome);
    outcomes.push_back(*outcome);
  }
  EXPECT_LT((outcomes.back().T_map_base.mean.translation() - truth.translation()).norm(), 0.2);
  return outcomes;
}

TEST(BasicLocaliser, FindsARobotByAnyLikelihoodAndAgainAfterItWasCarried) {
  InPlane localiser(plane(), {}, {}, quick(), 1);
  const auto outcomes = drive(localiser);
  EXPECT_TRUE(outcomes.front().searched);
  EXPECT_TRUE(outcomes[79].converged);
  EXPECT_TRUE(outcomes.back().converged);
  const auto moved = std::count_if(outcomes.begin() + 80, outcomes.end(),
                                   [](const auto& o) { return o.relocalised; });
  EXPECT_GE(moved, 1);
}

TEST(BasicLocaliser, SameBytesForAnyNumberOfThreads) {
  InPlane one(plane(), {}, {}, quick(1), 3), three(plane(), {}, {}, quick(3), 3);
  const auto a = drive(one, 60), b = drive(three, 60);
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i].T_map_base.mean.translation(), b[i].T_map_base.mean.translation()) << i;
    ASSERT_EQ(a[i].T_map_base.covariance, b[i].T_map_base.covariance) << i;
    ASSERT_EQ(a[i].particles, b[i].particles) << i;
  }
}

// Particles are on both sides of x = 10 m; a likelihood that is not a number takes the western ones
// their weight, one that is nowhere a number changes no weight.
TEST(BasicLocaliser, RefusesLikelihoodsThatAreNotNumbers) {
  Rng rng(1);
  const auto hall = plane();
  const SE2d truth(10.5, 10.0, Angle{});
  for (const double worst : {kNan, kInf}) {
    RangeLikelihood<SE2d> likelihood;
    likelihood.worst = worst;
    InPlane localiser(hall, likelihood, {}, quick(), 1);
    ASSERT_TRUE(localiser.start_at({truth, Eigen::Vector3d(1.0, 1.0, 0.01).asDiagonal()}));
    const auto outcome = localiser.add_scan(LogTime{}, ranges_at(truth, *hall, rng), {});
    ASSERT_TRUE(outcome);
    EXPECT_GT(outcome->refused_likelihoods, 0U);
    EXPECT_LT(outcome->refused_likelihoods, 1000U);
    EXPECT_NEAR(outcome->T_map_base.mean.x(), 10.5, 0.3);
    const auto far = localiser.start_at({SE2d(2.0, 2.0, Angle{}), Eigen::Matrix3d::Zero()});
    ASSERT_TRUE(far);
    const auto nowhere =
        localiser.add_scan(LogTime::from_seconds(2.0), ranges_at(truth, *hall, rng), {});
    ASSERT_TRUE(nowhere);
    EXPECT_EQ(nowhere->refused_likelihoods, nowhere->particles);
    EXPECT_TRUE(has_finite_value(nowhere->T_map_base.mean));
  }
}

TEST(BasicLocaliser, RefusesBadInputAndChangesNothing) {
  InPlane localiser(plane(), {}, {}, quick(), 1);
  EXPECT_FALSE(localiser.start_at({SE2d(kNan, 0.0, Angle{}), Eigen::Matrix3d::Identity()}));
  EXPECT_FALSE(localiser.start_at({SE2d(), -Eigen::Matrix3d::Identity()}));
  EXPECT_TRUE(localiser.particles().empty());
  ASSERT_TRUE(localiser.start_at({SE2d(6.0, 6.0, Angle{}), 0.01 * Eigen::Matrix3d::Identity()}));
  ASSERT_TRUE(localiser.add_scan(LogTime::from_seconds(5.0), Ranges{{1.0}}, {}));  // too few ranges
  const auto states = localiser.particles().states;
  EXPECT_FALSE(localiser.add_scan(LogTime::from_seconds(4.0), Ranges{}, {}));
  EXPECT_FALSE(localiser.add_motion(LogTime::from_seconds(5.0), {}));
  for (std::size_t i = 0; i < states.size(); ++i)
    ASSERT_EQ(localiser.particles().state(i).translation(), states[i].translation());
}

TEST(BasicLocaliser, FindsAPoseInSpace) {
  const auto hall = std::make_shared<const Hall<SE3d>>(Hall<SE3d>{{{0.0, 0.0, 0.0},
                                                                   {28.0, 2.0, 12.0},
                                                                   {5.0, 19.0, 0.5},
                                                                   {30.0, 17.0, 1.0},
                                                                   {14.0, 8.0, 12.0}}});
  MonteCarloOptions options = quick();
  options.min_candidates = 100'000;
  InSpace localiser(hall, {}, {}, options, 1);
  TangentOf<SE3d> twist;
  twist << 0.2, 0.0, 0.005, 0.0, 0.0, 0.07;
  SE3d truth(Eigen::Vector3d(6.0, 6.0, 1.0), SO3d::exp(Eigen::Vector3d(0.0, 0.0, 3.0))), odometry;
  Rng rng(1);
  std::optional<MonteCarloOutcome<SE3d>> last;
  for (int k = 0; k < 60; ++k) {
    truth = truth.plus(twist);
    odometry = odometry.plus(twist);
    const auto outcome =
        localiser.add_scan(LogTime::from_seconds(0.2 * k), ranges_at(truth, *hall, rng),
                           Transform3<frame::Odom, frame::Base>(odometry));
    ASSERT_TRUE(outcome);
    last = *outcome;
  }
  EXPECT_TRUE(last->converged);
  EXPECT_LT((last->T_map_base.mean.translation() - truth.translation()).norm(), 0.3);
  testing::expect_covariance(last->T_map_base.covariance);
}

// The models of this page satisfy the laws, and those of the library.
TEST(ParticleLaws, HoldForLikelihoodsAndOdometry) {
  const auto hall = plane();
  Rng rng(1);
  const SE2d truth(6.0, 6.0, Angle{});
  const Ranges scan = ranges_at(truth, *hall, rng);
  const testing::ParticleLaws<SE2d> laws;
  const RangeLikelihood<SE2d> likelihood;
  laws.check_likelihood([&](const SE2d& x) { return likelihood.log_likelihood(x, scan, *hall); },
                        {truth, 4.0 * Eigen::Matrix3d::Identity()});
  const OdometryNoise noise;
  for (const SE2d& increment : {SE2d(), SE2d(0.3, 0.0, 0.1_rad)}) {
    const Gaussian<SE2d> promised = noise.motion(increment);
    EXPECT_EQ(promised.mean.minus(increment).norm(), 0.0);
    laws.check_sampler(sampler_of_odometry(noise, increment), promised);
    const SE2d start(1.0, 2.0, 3.0_rad);
    laws.check_sampler(sampler_of_odometry(noise, increment),
                       {start * increment, promised.covariance}, start);
  }
  EXPECT_GT(noise.prediction(SE2d()).covariance(0, 0), noise.motion(SE2d()).covariance(0, 0));
}

}  // namespace
}  // namespace wayfare
