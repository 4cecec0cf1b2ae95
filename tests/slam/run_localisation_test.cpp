// Whole recordings localised by localisers that the library does not know.

#include <wayfare/slam/run_localisation.hpp>

#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/slam/basic_localiser.hpp>

#include "localisation_support.hpp"
#include "slam/localisation/scan_weigher.hpp"

namespace wayfare {
namespace {

using ::testing::HasSubstr;

constexpr float kNoNumber = std::numeric_limits<float>::quiet_NaN();

const Place& room() {
  static const Place place = make_place(kSymmetric, 1);
  return place;
}

BasicLocaliser<LocalisationMap, ScanModels> library_as_a_stranger(LocalisationOptions options,
                                                                  const Recording& recording) {
  options.T_base_laser = recording.T_base_laser;
  return {room().map, ScanModels(std::make_shared<const LocalisationOptions>(options)), options,
          options, 7};
}

// The library's own localiser, given as somebody else's.
TEST(RunLocalisationByAnyLocaliser, IsTheLibrarysRunToTheLastBit) {
  Recording recording = room().recording;
  recording.scans.resize(60);
  recording.scans[20].time = recording.scans[19].time;  // refused
  recording.scans[40].bearing_step = Angle::radians(static_cast<double>(kNoNumber));
  recording.scans.erase(recording.scans.begin() + 25, recording.scans.begin() + 31);  // a gap
  for (const bool known : {true, false}) {
    const auto start = known ? std::optional(known_start(recording)) : std::nullopt;
    const auto want =
        run_localisation(recording, room().map, quick(), 7, start, {.snapshots_at = {0.5}});
    auto localiser = library_as_a_stranger(quick(), recording);
    if (start) {
      ASSERT_TRUE(localiser.start_at(*start));
    }
    const auto have = run_localisation(recording, localiser, {.snapshots_at = {0.5}});
    ASSERT_TRUE(want && have);
    expect_same(*have, *want);
    EXPECT_EQ(have->refused_scans, 2U);
    EXPECT_EQ(have->refused_scans, want->refused_scans);
    EXPECT_EQ(have->first_refusal, want->first_refusal);
    ASSERT_EQ(have->snapshots.size(), 1U);
    ASSERT_EQ(have->snapshots[0].particles.size(), want->snapshots[0].particles.size());
    for (std::size_t i = 0; i < have->snapshots[0].particles.size(); ++i)
      ASSERT_EQ(have->snapshots[0].particles[i].weight, want->snapshots[0].particles[i].weight);
  }
}

/// Both sensors tell how far along the room they are, to the decimetre.
struct AlongTheRoom {
  [[nodiscard]] SE2d random_pose(Rng& rng) const { return {rng.uniform(0.5, 11.5), 1.25, Angle()}; }
};
struct Lengthwise {
  static constexpr std::size_t kSensors = 2;
  [[nodiscard]] double log_likelihood(const SE2d& pose, const LaserScan& scan,
                                      const AlongTheRoom&) const {
    const double seen = static_cast<double>(scan.ranges_m.front());
    return -0.5 * std::pow((pose.x() - seen) / 0.1, 2);
  }
  [[nodiscard]] double log_likelihood(const SE2d& pose, const PointSet& points,
                                      const AlongTheRoom&) const {
    const auto seen = static_cast<double>(points[points.size() - 1].x());
    return -0.5 * std::pow((pose.x() - seen) / 0.1, 2);
  }
  [[nodiscard]] std::size_t sensor(const LaserScan&) const { return 0; }
  [[nodiscard]] std::size_t sensor(const PointSet&) const { return 1; }
};

/// A drive of 0.4 m/s along the room from x = 2 m on: radar frames every half second, a laser scan
/// 0.2 s after each.
Recording told_drive() {
  Recording recording;
  for (int k = 0; k <= 20; ++k) {
    const LogTime time = LogTime::from_seconds(0.5 * k);
    recording.odometry.push_back(
        {time, Transform2<frame::Odom, frame::Base>(SE2d(0.2 * k, 0.0, Angle()))});
    if (k == 20) break;
    const auto x = static_cast<float>(2.0 + 0.2 * k);
    recording.radar.push_back({time, {{.x_m = x, .y_m = 0.0F}}});
    recording.scans.push_back({time + from_seconds(0.2),
                               Angle(),
                               Angle::degrees(1),
                               0.05F,
                               30.0F,
                               {x + 0.08F, x + 0.08F}});
  }
  return recording;
}

MonteCarloOptions few_candidates() {
  MonteCarloOptions options;
  options.min_candidates = 5000;
  return options;
}

// Radar frames of 1.5 s make one scan, at the time of the last: four of these.
TEST(RunLocalisationByAnyLocaliser, UsesTheSensorsThatTheLikelihoodIsFor) {
  const Recording recording = told_drive();
  BasicLocaliser localiser(std::make_shared<const AlongTheRoom>(), Lengthwise{}, OdometryNoise{},
                           few_candidates(), 1);
  std::size_t before = 0;
  const auto run = run_localisation(
      recording, localiser, {.before_scan = [&](std::size_t scan, auto&) { before = scan + 1; }});
  ASSERT_TRUE(run) << run.error().to_string();
  EXPECT_EQ(run->refused_scans, 0U);
  EXPECT_EQ(before, run->outcomes.size());
  std::size_t radar = 0;
  for (const LocalisationOutcome& o : run->outcomes) radar += o.sensor == RangeSensor::radar;
  EXPECT_EQ(run->outcomes.size() - radar, recording.scans.size());
  EXPECT_EQ(radar, recording.radar.size() / 4);
  EXPECT_NEAR(run->outcomes.back().T_map_base.mean.x(), 5.88, 0.1);
  EXPECT_EQ(run->trajectory().size(), run->outcomes.size());
}

TEST(RunLocalisationByAnyLocaliser, RefusesBadScansAndARunWithoutAny) {
  Recording recording = told_drive();
  recording.radar.clear();
  recording.scans[3].first_bearing = Angle::radians(static_cast<double>(kNoNumber));
  recording.scans[9].time = recording.scans[8].time;
  BasicLocaliser localiser(std::make_shared<const AlongTheRoom>(), Lengthwise{}, OdometryNoise{},
                           few_candidates(), 1);
  const auto run = run_localisation(recording, localiser);
  ASSERT_TRUE(run);
  EXPECT_EQ(run->refused_scans, 2U);
  EXPECT_THAT(run->first_refusal, HasSubstr("scan 3: "));
  EXPECT_EQ(run->outcomes.size(), 18U);
  EXPECT_FALSE(run_localisation(Recording{}, localiser));
}

/// A localiser that is not the library's at all: it goes where odometry says.
struct DeadReckoning {
  using Odometry = std::optional<Transform2<frame::Odom, frame::Base>>;
  int motions = 0;
  Result<void> add_motion(LogTime, const Odometry&) {
    ++motions;
    return {};
  }
  Result<MonteCarloOutcome<SE2d>> add_scan(LogTime time, const LaserScan&,
                                           const Odometry& odometry) {
    if (!odometry) return Error{ErrorCode::not_found, "no odometry"};
    return MonteCarloOutcome<SE2d>{.time = time,
                                   .T_map_base = {odometry->raw(), Eigen::Matrix3d::Zero()},
                                   .converged = true,
                                   .particles = 1};
  }
};

TEST(RunLocalisationByAnyLocaliser, NeedsTwoMembersOnly) {
  Recording recording = told_drive();
  recording.scans.erase(recording.scans.begin() + 5, recording.scans.begin() + 15);
  DeadReckoning localiser;
  const auto run = run_localisation(recording, localiser, {.snapshots_at = {1.0}});
  ASSERT_TRUE(run);
  EXPECT_EQ(run->outcomes.size(), 10U);
  EXPECT_NEAR(run->trajectory(true).back().T_map_base.raw().x(), 3.88, 1e-12);
  EXPECT_TRUE(run->snapshots.back().particles.empty());
  EXPECT_EQ(localiser.motions, 10);  // of the gap of 5.5 s, every half second
}

}  // namespace
}  // namespace wayfare
