// Random calls of a localiser, against a model of what is accepted and a twin that sees nothing
// else.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>

#include "abuse/slam_localisation_support.hpp"

namespace wayfare::tests {
namespace {

TEST(LocaliserSequence, RefusalsLeaveNoTrace) {
  constexpr int kSchedules = 200, kCalls = 24;
  for (std::uint64_t seed = 0; seed < kSchedules; ++seed) {
    Rng rng(seed);
    std::string calls = "seed " + std::to_string(seed);
    LocalisationOptions options = quick_options();
    if (seed % 4 == 0) options.model = ScanLikelihood::beam;
    if (seed % 5 == 0) options.threads = 2;
    auto localiser = std::make_unique<Localiser>(map_of_room(), options, seed);
    options.threads = 1;
    Localiser twin(map_of_room(), options, seed);
    std::optional<LogTime> last;
    int k = static_cast<int>(rng.below(60));
    for (int i = 0; i < kCalls; ++i) {
      const std::uint64_t what = rng.below(12);
      calls += "; " + std::to_string(what) + "@" + std::to_string(k);
      SCOPED_TRACE(calls);
      std::optional<Odometry> odometry = odometry_of_drive(k);
      const std::uint64_t doubt = rng.below(16);
      if (doubt < 2) odometry.reset();
      if (doubt == 2) odometry = Odometry(SE2d(kNotFinite[rng.below(3)], 0.0, Angle{}));
      if (doubt == 3) odometry = Odometry(SE2d(1e9, -1e9, 1_rad));
      LogTime time = time_of_drive(k);
      if (rng.below(8) == 0)
        time = time - Duration(static_cast<std::int64_t>(rng.below(600'000'000)));
      if (rng.below(16) == 0) time = last.value_or(time) + Duration(1);
      const auto both = [&](bool expected, const auto& call) {
        const auto outcome = call(*localiser);
        ASSERT_EQ(outcome.has_value(), expected);
        if (!expected) return;
        last = time;
        const auto same = call(twin);
        ASSERT_TRUE(same);
        if constexpr (!std::is_same_v<decltype(outcome), const Result<void>>) {
          std::vector<double> a, b;
          append(a, *outcome);
          append(b, *same);
          ASSERT_EQ(a, b);
          ASSERT_TRUE(outcome->mass >= 0.0 && outcome->mass <= 1.0 + 1e-9);
          ASSERT_TRUE(outcome->agreement >= 0.0 && outcome->agreement <= 1.0);
          ASSERT_LE(outcome->particles, 2 * options.max_particles);
        }
      };
      const bool later = !last || time > *last;
      LaserScan scan = scan_of_room(time, pose_of_drive(k));
      PointSet points = points_of_drive(k);
      if (what < 5) {
        if (rng.below(6) == 0) scan.ranges_m.assign(kBeams, NAN);
        if (rng.below(6) == 0) scan.ranges_m.resize(rng.below(20));
        both(later, [&](Localiser& l) { return l.add_scan(scan, odometry); });
        ++k;
      } else if (what < 7) {
        if (rng.below(6) == 0) points = {};
        if (rng.below(6) == 0) points.push_back({1e30F, -1e30F});
        both(!last || time >= *last,
             [&](Localiser& l) { return l.add_radar(time, points, odometry); });
      } else if (what == 7) {
        both(later, [&](Localiser& l) { return l.add_motion(time, odometry); });
      } else if (what == 8) {
        scan.first_bearing = Angle::radians(kNotFinite[rng.below(3)]);
        both(false, [&](Localiser& l) { return l.add_scan(scan, odometry); });
        points.push_back({0.0F, INFINITY});
        both(false, [&](Localiser& l) { return l.add_radar(time, points, odometry); });
      } else if (what == 9) {
        Gaussian<SE2d> start{pose_of_drive(k), 0.01 * Eigen::Matrix3d::Identity()};
        if (rng.below(3) == 0) start.covariance.setZero();
        const bool good = rng.below(3) != 0;
        if (!good) start.covariance(0, 2) = start.covariance(2, 0) = 0.02;
        ASSERT_EQ(localiser->start_at(start).has_value(), good);
        if (good) {
          ASSERT_TRUE(twin.start_at(start));
        }
      } else if (what == 10 && rng.below(3) == 0) {
        localiser->start_anywhere();
        twin.start_anywhere();
        ASSERT_TRUE(localiser->particles().empty());
      } else {
        localiser = std::make_unique<Localiser>(std::move(*localiser));
      }
      if (::testing::Test::HasFatalFailure()) return;
    }
    SCOPED_TRACE(calls);
    const std::vector<double> numbers = numbers_of(*localiser);
    ASSERT_EQ(numbers, numbers_of(twin));
    ASSERT_TRUE(all_finite(numbers));
    double sum = 0.0;
    for (const PoseParticle& p : localiser->particles()) sum += p.weight;
    if (!numbers.empty()) {
      ASSERT_NEAR(sum, 1.0, 1e-9);
    }
  }
}

}  // namespace
}  // namespace wayfare::tests
