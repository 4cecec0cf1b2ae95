// Submap and Hector SLAM by matchers of other types.

#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/eval/trajectory_error.hpp>
#include <wayfare/match/registration.hpp>
#include <wayfare/slam/hector_slam.hpp>
#include <wayfare/slam/submap_slam.hpp>
#include <wayfare/sync/odometry_track.hpp>

#include "match/walls.hpp"
#include "support.hpp"

namespace wayfare {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

double error_m(const Trajectory& estimate, const Trajectory& truth) {
  return eval::absolute_error(estimate, truth).translation_m.rmse;
}

SubmapSlamOptions small_submaps(const Recording& recording, int threads = 1) {
  SubmapSlamOptions options;
  options.T_base_laser = recording.T_base_laser;
  options.submap_nodes = 20;
  options.threads = threads;
  return options;
}

void add_scans(SubmapSlamSystem& slam, const Recording& recording, std::size_t from,
               std::size_t to) {
  const OdometryTrack odometry(recording.odometry);
  for (std::size_t i = from; i < to; ++i)
    ASSERT_TRUE(slam.add_scan(recording.scans[i], {odometry.at(recording.scans[i].time), {}}));
}

// As with the library's grids: the lidar's noise is 1-2 cm, a loop that is not closed is off by
// half a metre and more.
TEST(SubmapSlamByOtherMatchers, CloseALoopOfCorridors) {
  const auto run = simulate(kRing, slipping_robot(), 1);
  const auto options = small_submaps(run.recording);
  const auto check = [&](const Result<SubmapSlamRun>& slam) {
    ASSERT_TRUE(slam) << slam.error().to_string();
    EXPECT_GT(slam->statistics.loop_closures, 5U);
    EXPECT_EQ(slam->statistics.unmatched_scans, 0U);
    EXPECT_LT(error_m(slam->trajectory, run.truth), 0.10);
  };
  check(run_submap_slam(run.recording, IcpMatcher(), options));
  check(run_submap_slam(run.recording, NdtMatcher(), options));
}

TEST(SubmapSlamByOtherMatchers, SameBytesForAnyNumberOfThreadsAndAfterARestart) {
  const auto run = simulate(kRing, slipping_robot(), 2);
  const std::size_t n = run.recording.scans.size();
  std::vector<std::uint8_t> whole;
  for (const int threads : {1, 3}) {
    const auto options = small_submaps(run.recording, threads);
    auto slam = std::make_optional<BasicSubmapSlam<IcpMatcher>>(IcpMatcher(), options);
    add_scans(*slam, run.recording, 0, n / 2 + 4);
    const auto saved = slam->save();
    if (threads > 1) {
      auto restored = BasicSubmapSlam<IcpMatcher>::restore(saved, IcpMatcher(), options);
      ASSERT_TRUE(restored) << restored.error().to_string();
      slam.emplace(*std::move(restored));
      EXPECT_EQ(slam->save(), saved);
    }
    add_scans(*slam, run.recording, n / 2 + 4, n);
    ASSERT_TRUE(slam->finish());
    EXPECT_GT(slam->statistics().loop_closures, 0U);
    if (whole.empty()) whole = slam->save();
    EXPECT_EQ(slam->save(), whole) << threads << " threads";
  }
}

enum class Answer { match, bare, nothing, error, elsewhere, nan_pose, nan_score, no_covariance };

/// ICP that answers as it is told.
struct ToldMatcher {
  using Map = SurfaceMap;
  std::shared_ptr<Answer> answer = std::make_shared<Answer>(Answer::match);
  IcpMatcher icp{};

  [[nodiscard]] Result<SurfaceMap> make_map(std::span<const PlacedPoints> scans) const {
    return icp.make_map(scans);
  }
  Result<std::optional<MatchResult>> match(const SurfaceMap& map, const PointSet& points,
                                           const SE2d& prior, const SearchWindow& window,
                                           const MatchOptions& options) {
    if (*answer == Answer::error) return Error{ErrorCode::numerical, "no answer"};
    if (*answer == Answer::nothing) return std::optional<MatchResult>();
    auto found = icp.match(map, points, prior, window, options);
    if (!found || !*found) return found;
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    MatchResult& m = **found;
    if (*answer == Answer::nan_pose) m.T_map_points = SE2d(kNan, 0.0, Angle());
    if (*answer == Answer::elsewhere) m.T_map_points = SE2d(50.0, 0.0, Angle());
    if (*answer == Answer::nan_score) m.score = kNan;
    if (*answer == Answer::no_covariance) m.covariance = -Eigen::Matrix3d::Identity();
    if (*answer != Answer::bare) return found;
    m.covariance.reset();
    m.constraint.reset();
    return found;
  }
};

LaserScan scan_at(int i) { return room_scan(0.1 * i, 3.0 + 0.05 * i, 2.0); }

TEST(SubmapSlamByOtherMatchers, WithoutAMatchThePredictedPoseIsKept) {
  for (const Answer answer : {Answer::nothing, Answer::error, Answer::elsewhere}) {
    const ToldMatcher matcher;
    BasicSubmapSlam slam(matcher);
    for (int i = 0; i < 5; ++i) ASSERT_TRUE(slam.add_scan(scan_at(i)));
    *matcher.answer = answer;
    const auto predicted = slam.add_scan(scan_at(5));
    ASSERT_TRUE(predicted);
    EXPECT_FALSE(predicted->matched);
    EXPECT_NEAR(predicted->T_map_base.raw().x(), 0.25, 0.02);
    EXPECT_EQ(slam.statistics().unmatched_scans, 1U);
    *matcher.answer = Answer::match;
    EXPECT_TRUE(slam.add_scan(scan_at(6))->matched);
  }
}

TEST(SubmapSlamByOtherMatchers, AMatchThatIsNotValidIsReportedAndChangesNothing) {
  for (const Answer answer : {Answer::nan_pose, Answer::nan_score, Answer::no_covariance}) {
    const ToldMatcher matcher;
    BasicSubmapSlam slam(matcher);
    for (int i = 0; i < 5; ++i) ASSERT_TRUE(slam.add_scan(scan_at(i)));
    const auto before = slam.save();
    *matcher.answer = answer;
    const auto outcome = slam.add_scan(scan_at(5));
    ASSERT_FALSE(outcome);
    EXPECT_EQ(outcome.error().code, ErrorCode::numerical);
    EXPECT_EQ(slam.save(), before);
    *matcher.answer = Answer::match;
    EXPECT_TRUE(slam.add_scan(scan_at(5))->matched);
  }
}

TEST(SubmapSlamByOtherMatchers, NeedsNoCovariance) {
  const ToldMatcher matcher;
  *matcher.answer = Answer::bare;
  BasicSubmapSlam slam(matcher);
  for (int i = 0; i < 40; ++i) ASSERT_TRUE(slam.add_scan(scan_at(i)));
  ASSERT_TRUE(slam.finish());
  EXPECT_EQ(slam.statistics().unmatched_scans, 0U);
  EXPECT_GT(slam.statistics().nodes, 4U);
  EXPECT_EQ(slam.local().openness, 0.0);
  EXPECT_NEAR(slam.trajectory().back().T_map_base.raw().x(), 1.95, 0.02);
}

std::vector<std::uint8_t> state_after(SubmapSlamSystem& slam) {
  for (int i = 0; i < 8; ++i) EXPECT_TRUE(slam.add_scan(scan_at(i)));
  return slam.save();
}

TEST(SavedSubmapSlam, IsContinuedByTheMatcherThatSavedItAlone) {
  BasicSubmapSlam by_icp{IcpMatcher()};
  BasicSubmapSlam by_own{ToldMatcher()};
  SubmapSlam by_default;
  const auto icp = state_after(by_icp), own = state_after(by_own),
             library = state_after(by_default);
  EXPECT_TRUE(BasicSubmapSlam<IcpMatcher>::restore(icp, IcpMatcher()));
  EXPECT_TRUE(BasicSubmapSlam<ToldMatcher>::restore(own, ToldMatcher()));
  EXPECT_TRUE(SubmapSlam::restore(library));
  const auto expect_refused = [](const auto& restored, const char* saved, const char* now) {
    ASSERT_FALSE(restored);
    EXPECT_EQ(restored.error().code, ErrorCode::parse);
    EXPECT_THAT(restored.error().message, AllOf(HasSubstr(saved), HasSubstr(now)));
  };
  expect_refused(SubmapSlam::restore(icp), "\"ICP\"", "\"Gauss-Newton\"");
  expect_refused(BasicSubmapSlam<IcpMatcher>::restore(library, IcpMatcher()), "\"Gauss-Newton\"",
                 "\"ICP\"");
  expect_refused(BasicSubmapSlam<NdtMatcher>::restore(icp, NdtMatcher()), "\"ICP\"", "\"NDT\"");
  expect_refused(BasicSubmapSlam<IcpMatcher>::restore(own, IcpMatcher()), "ToldMatcher", "\"ICP\"");
}

/// The same state in the earlier format: without the matcher's name after the first word, and
/// without the counts and texts of two kinds of matcher errors, none here, and the pieces before
/// the digest: the lengths of two empty lists, two times, a count of four bytes, four numbers of
/// the interval and errors of predictions, the usual score, and six counts.
std::vector<std::uint8_t> in_earlier_format(const std::vector<std::uint8_t>& state) {
  constexpr std::size_t kWord = 8;
  const std::size_t name = kWord + state[kWord];
  std::vector<std::uint8_t> earlier{'W', 'S', 'U', 'B', 'M', 'A', 'P', '2'};
  earlier.insert(earlier.end(), state.begin() + static_cast<std::ptrdiff_t>(kWord + name),
                 state.end() - static_cast<std::ptrdiff_t>(5 * kWord + 15 * kWord + 4));
  std::uint64_t digest = 0xcbf29ce484222325;
  for (const std::uint8_t b : earlier) digest = (digest ^ b) * 0x100000001b3;
  for (int i = 0; i < 8; ++i) earlier.push_back(static_cast<std::uint8_t>(digest >> (8 * i)));
  return earlier;
}

TEST(SavedSubmapSlam, OfTheEarlierFormatIsReadByAnyMatcher) {
  SubmapSlam slam;
  const auto saved = state_after(slam), earlier = in_earlier_format(saved);
  const auto restored = SubmapSlam::restore(earlier);
  ASSERT_TRUE(restored) << restored.error().to_string();
  EXPECT_EQ(in_earlier_format(restored->save()), earlier);
  EXPECT_EQ(restored->statistics().pieces, 1U);
  EXPECT_TRUE(BasicSubmapSlam<IcpMatcher>::restore(earlier, IcpMatcher()));
}

/// A circle round the room: a scan every 0.1 s at 0.5 m/s and 20 °/s.
Recording round_the_room(int scans) {
  Rng rng(11);
  Recording recording;
  SE2d pose(-1.0, -1.2, Angle());
  for (int i = 0; i < scans; ++i) {
    recording.scans.push_back(Walls::room().scan(pose, rng));
    recording.scans.back().time = LogTime::from_seconds(0.1 * i);
    recording.truth.push_back(
        {recording.scans.back().time, Transform2<frame::Map, frame::Base>(pose)});
    pose = pose.plus({0.05, 0, Angle::degrees(2).radians()});
  }
  return recording;
}

TEST(HectorSlamByOtherMatchers, TracksWithoutOdometry) {
  const Recording recording = round_the_room(190);
  const auto check = [&](const Result<HectorRun>& slam) {
    ASSERT_TRUE(slam) << slam.error().to_string();
    EXPECT_EQ(slam->statistics.unmatched_scans, 0U);
    EXPECT_TRUE(slam->map.bounds());
    EXPECT_LT(error_m(slam->trajectory, recording.truth), 0.03);
  };
  check(run_hector_slam(recording, {}, IcpMatcher()));
  check(run_hector_slam(recording, {}, NdtMatcher()));
}

// Turned by 35° after every second scan, to and fro: constant velocity is 35° off, to either side.
// Iterative matchers converge from 10° to 20°.
TEST(HectorSlamByOtherMatchers, FollowTurnsFromWhichTheyDoNotConverge) {
  Rng rng(12);
  Recording recording;
  for (int i = 0; i < 40; ++i) {
    const SE2d pose(-1.0 + 0.02 * i, -0.5, Angle::degrees(i % 4 < 2 ? 0.0 : 35.0));
    recording.scans.push_back(Walls::room().scan(pose, rng));
    recording.scans.back().time = LogTime::from_seconds(0.1 * i);
    recording.truth.push_back(
        {recording.scans.back().time, Transform2<frame::Map, frame::Base>(pose)});
  }
  const auto check = [&](const Result<HectorRun>& slam) {
    ASSERT_TRUE(slam) << slam.error().to_string();
    EXPECT_EQ(slam->statistics.unmatched_scans, 0U);
    EXPECT_LT(error_m(slam->trajectory, recording.truth), 0.03);
  };
  check(run_hector_slam(recording, {}, IcpMatcher()));
  check(run_hector_slam(recording, {}, NdtMatcher()));
}

TEST(HectorSlamByOtherMatchers, TheLibrarysOwnMatcherIsOneOfThem) {
  const Recording recording = round_the_room(40);
  const auto one = run_hector_slam(recording);
  const auto other = run_hector_slam(recording, {}, GaussNewtonMatcher(HectorSlamOptions().match));
  ASSERT_TRUE(one && other);
  for (std::size_t i = 0; i < one->trajectory.size(); ++i)
    ASSERT_EQ(one->trajectory[i].T_map_base.raw().translation(),
              other->trajectory[i].T_map_base.raw().translation());
}

TEST(HectorSlamByOtherMatchers, WithoutAMatchThePredictedPoseIsKept) {
  for (const Answer answer : {Answer::nothing, Answer::error, Answer::elsewhere}) {
    const ToldMatcher matcher;
    BasicHectorSlam slam(matcher);
    for (int i = 0; i < 5; ++i) ASSERT_TRUE(slam.add_scan(scan_at(i), {}));
    *matcher.answer = answer;
    const auto predicted = slam.add_scan(scan_at(5), {});
    ASSERT_TRUE(predicted);
    EXPECT_FALSE(predicted->matched);
    EXPECT_NEAR(predicted->T_map_base.raw().x(), 0.25, 0.02);
    EXPECT_EQ(slam.statistics().unmatched_scans, 1U);
  }
}

TEST(HectorSlamByOtherMatchers, AMatchThatIsNotValidIsReportedAndChangesNothing) {
  for (const Answer answer : {Answer::nan_pose, Answer::nan_score, Answer::no_covariance}) {
    const ToldMatcher matcher;
    BasicHectorSlam slam(matcher), untouched{ToldMatcher()};
    for (int i = 0; i < 7; ++i) {
      *matcher.answer = answer;
      if (i > 0) {
        EXPECT_FALSE(slam.add_scan(scan_at(i), {}));
      }
      *matcher.answer = Answer::match;
      const auto after = slam.add_scan(scan_at(i), {}), want = untouched.add_scan(scan_at(i), {});
      ASSERT_TRUE(after && want);
      EXPECT_EQ(after->T_map_base.raw().translation(), want->T_map_base.raw().translation());
    }
    EXPECT_EQ(slam.statistics().scans, 7U);
    EXPECT_EQ(slam.trajectory().size(), 7U);
  }
}

}  // namespace
}  // namespace wayfare
