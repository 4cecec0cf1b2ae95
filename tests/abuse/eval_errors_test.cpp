// Metrics and tables of trajectories that are empty, repeated, reversed or not finite.

#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/eval/consistency.hpp>
#include <wayfare/eval/evaluation.hpp>
#include <wayfare/eval/nav_error.hpp>
#include <wayfare/eval/relations.hpp>
#include <wayfare/eval/table.hpp>
#include <wayfare/eval/trajectory_error.hpp>

#include "abuse/abuse.hpp"

namespace wayfare::eval {
namespace {

using namespace tests;

const LogTime kFirst = LogTime() + Duration::min(), kLast = LogTime() + Duration::max();

StampedPose pose(LogTime time, double x = 0.0) {
  return {time, Transform2<frame::Map, frame::Base>(SE2d(x, 0.0, Angle()))};
}
Trajectory line(int count) {
  Trajectory t;
  for (int i = 0; i < count; ++i) t.push_back(pose(LogTime::from_seconds(i), i));
  return t;
}

TEST(TrajectoryErrorAbuse, NothingHasNoError) {
  const Trajectory none, one = line(1), many = line(10);
  for (const Trajectory& reference : {none, one, many}) {
    const AbsoluteError e = absolute_error({}, reference);
    EXPECT_EQ(e.translation_m.count, 0U);
    EXPECT_TRUE(std::isnan(e.rmse_x_m) && std::isnan(e.percent_of_path));
    EXPECT_TRUE(std::isnan(absolute_error({}, reference, {Alignment::start}).end_m));
    EXPECT_EQ(relative_error({}, Span::seconds(1)).translation_m.count, 0U);
  }
  EXPECT_EQ(absolute_error(many, none).unmatched, 10U);
  EXPECT_TRUE(std::isnan(absolute_error(many, none, {Alignment::start}).rmse_x_m));
  EXPECT_EQ(absolute_error(one, many).translation_m.rmse, 0.0);
  EXPECT_TRUE(std::isnan(absolute_error(one, many).percent_of_path));
  EXPECT_EQ(path_length_m({}), 0.0);
  EXPECT_EQ(rigid_alignment({}, {}).x(), 0.0);
  const std::vector<Eigen::Vector2d> two(2);
  EXPECT_DEATH(static_cast<void>(rigid_alignment(two, {})), "as many points");
}

TEST(TrajectoryErrorAbuse, RepeatedReversedAndExtremeTimes) {
  const Trajectory many = line(10), same(10, pose(LogTime::from_seconds(3), 3.0));
  EXPECT_EQ(absolute_error(same, many).translation_m.rmse, 0.0);
  EXPECT_EQ(absolute_error(same, same).translation_m.rmse, 0.0);
  Trajectory reversed(many.rbegin(), many.rend());
  EXPECT_LE(associate(many, reversed).size(), 10U);
  EXPECT_EQ(associate(reversed, many).size(), 10U);
  const Trajectory ends = {pose(kFirst, 0.0), pose(kLast, 1.0)};
  const auto pairs = associate(many, ends);
  ASSERT_EQ(pairs.size(), 10U);
  for (const PosePair& p : pairs) EXPECT_TRUE(p.reference.x() >= 0.0 && p.reference.x() <= 1.0);
  EXPECT_EQ(absolute_error(ends, ends, {Alignment::start}).end_m, 0.0);
  for (const Trajectory& t : {same, reversed, ends}) {
    EXPECT_EQ(check(Reference{t}).has_value(), t.size() == 2U);
    EXPECT_LE(evaluate(many, {t}).rigid.times.size(), 10U);
    EXPECT_LE(evaluate(t, {many}).rigid.times.size(), 10U);
  }
  for (const double length : {kNan, kInf, -kInf, 0.0, -1.0, kHuge, 1e9})
    for (const Span span : {Span::seconds(length), Span::metres(length)})
      EXPECT_LE(relative_error(associate(many, many), span).translation_m.count, 9U);
  EXPECT_LE(relative_error(associate(ends, ends), Span::seconds(1)).translation_m.count, 1U);
}

TEST(TrajectoryErrorAbuse, ValuesThatAreNotNumbersShowInTheResult) {
  for (const double x : {kNan, kInf, kHuge}) {
    Trajectory estimate = line(10);
    estimate[4] = pose(estimate[4].time, x);
    const AbsoluteError e = absolute_error(estimate, line(10), {.alignment = Alignment::none});
    EXPECT_EQ(e.translation_m.count, 10U);
    EXPECT_FALSE(e.translation_m.rmse < 1e100);
    EXPECT_FALSE(absolute_error(estimate, line(10), {Alignment::start}).rmse_x_m < 1e100);
    EXPECT_FALSE(evaluate(estimate, {line(10)}).start.rmse_x_m < 1e100);
  }
}

TEST(RelationsAbuse, RelationsOutsideReversedAndToThemselves) {
  const Trajectory many = line(10);
  const std::vector<Relation> odd = {
      {kFirst, kLast, {}},
      {LogTime::from_seconds(1e9), LogTime(), {}},
      {LogTime::from_seconds(3), LogTime::from_seconds(3), {}},
      {LogTime::from_seconds(3), LogTime::from_seconds(1), SE2d(-2.0, 0.0, Angle())}};
  for (const bool nearest : {false, true}) {
    const RelationsResult r = relations_error(many, odd, {.nearest_pose = nearest});
    EXPECT_EQ(r.used, 2U);
    EXPECT_EQ(r.outside, 2U);
    EXPECT_NEAR(r.translation_m.max, 0.0, 1e-12);
    EXPECT_EQ(relations_error({}, odd, {.nearest_pose = nearest}).used, 0U);
    EXPECT_EQ(relations_error(many, {}, {.nearest_pose = nearest}).used, 0U);
    const Trajectory ends = {pose(kFirst), pose(kLast)};
    EXPECT_LE(relations_error(ends, odd, {.nearest_pose = nearest}).used, 4U);
  }
  EXPECT_EQ(relations_table("name", {}, {}, {}).rows().size(), 2U);
}

TEST(ConsistencyAbuse, FewerThanTwoValuesHaveNoDeviation) {
  IndependentMean mean;
  EXPECT_TRUE(std::isnan(mean.deviation()) && std::isnan(mean.standard_error()));
  mean.add(3.0);
  EXPECT_EQ(mean.mean(), 3.0);
  EXPECT_TRUE(std::isnan(mean.deviation()) && std::isnan(mean.standard_error()));
  mean.add(3.0);
  EXPECT_EQ(mean.deviation(), 0.0);
  AttitudeRmse rmse;
  EXPECT_TRUE(std::isnan(rmse.value().total.radians()));
  NeesOverRuns runs(3, 2);
  EXPECT_TRUE(std::isnan(runs.mean(0)) && std::isnan(runs.mean_of_all()) &&
              std::isnan(runs.share_within()));
  EXPECT_TRUE(std::isnan(NeesOverRuns(3, 0).mean_of_all()));
  EXPECT_DEATH(runs.add(2, 1.0), "the epoch is out of range");
  EXPECT_TRUE(std::isnan(SigmaCount<3>().share(1)[0]));
}

TEST(ConsistencyAbuse, NotFiniteErrorsAreNeverConsistent) {
  SigmaCount<2> count;
  for (const double x : kNotFinite) count.add(Eigen::Vector2d(x, 0.0), Eigen::Vector2d(1.0, 0.0));
  EXPECT_EQ(count.share(3), Eigen::Vector2d(0.0, 1.0));
  const Eigen::Matrix2d zero = Eigen::Matrix2d::Zero(), one = Eigen::Matrix2d::Identity();
  const Eigen::Vector2d e(1.0, 2.0);
  EXPECT_TRUE(std::isnan(normalised_squared(e, zero)));
  EXPECT_TRUE(std::isnan(normalised_squared(e, -one)));
  EXPECT_TRUE(std::isnan(normalised_squared(e, one * kNan)));
  EXPECT_NEAR(normalised_squared(e, one * kTiny) * kTiny, 5.0, 1e-6);
  EXPECT_TRUE(std::isnan(normalised_squared(e, Eigen::Matrix2d::Ones())));  // singular
  for (const std::size_t samples : {std::size_t{1}, std::size_t{1'000'000'000}}) {
    const Interval bounds = mean_nees_bounds(3, samples);
    EXPECT_TRUE(bounds.contains(samples == 1 ? 2.0 : 3.0));
  }
}

TEST(AttitudeErrorAbuse, HalfTurnsAndNotNumbers) {
  const SO3d half = SO3d::exp({std::numbers::pi, 0.0, 0.0});
  EXPECT_NEAR(attitude_error(half, SO3d()).total.degrees(), 180.0, 1e-6);
  EXPECT_NEAR(attitude_error(half, SO3d()).inclination.degrees(), 180.0, 1e-6);
  AttitudeRmse rmse;
  rmse.add({Angle::radians(kNan), Angle(), Angle()});
  EXPECT_TRUE(std::isnan(rmse.value().total.radians()));
  EXPECT_EQ(rmse.value().heading.radians(), 0.0);
}

TEST(NavErrorAbuse, NothingRepeatedAndExtremeTimes) {
  NavReference reference;
  EXPECT_FALSE(reference_at(reference, LogTime()));
  EXPECT_FALSE(point_at({}, LogTime()));
  EXPECT_TRUE(nav_errors({}, reference, Eigen::Vector3d::Zero(), LogTime()).time_s.empty());
  std::vector<GnssInsPoint> points(3);
  for (GnssInsPoint& p : points) p.sigma.setConstant(1.0F), p.imu_errors.setZero();
  reference.states.resize(3);
  reference.has_velocity = reference.has_attitude = true;
  EXPECT_EQ(nav_errors(points, reference, Eigen::Vector3d::Zero(), LogTime()).time_s.size(), 3U);
  points[0].nav.time = reference.states[0].time = kFirst;
  points[2].nav.time = reference.states[2].time = kLast;
  EXPECT_FALSE(reference_at(reference, LogTime::from_seconds(1e9)));
  const NavErrors e = nav_errors(points, reference, Eigen::Vector3d::Zero(), LogTime());
  EXPECT_EQ(e.time_s.size(), 3U);
  for (const double error : e.error[0]) EXPECT_NEAR(error, 0.0, 1e-6);
  NavState far;
  far.position.height_m = 1e9;
  EXPECT_NEAR(nav_error(NavState{}, far).position_ned_m.z(), -1e9, 1.0);
}

TEST(NavErrorAbuse, PlainGnssNeedsNoInertialReadings) {
  GnssInsRecording r;
  EXPECT_TRUE(plain_gnss(r, {}).time_s.empty());
  r.fixes.resize(2);
  r.fixes[0].time = LogTime::from_seconds(5);
  r.fixes[1].time = LogTime::from_seconds(6);
  const PlainGnss plain = plain_gnss(r, {});
  EXPECT_EQ(plain.time_s, (std::vector<double>{0.0, 1.0}));
  EXPECT_TRUE(std::isnan(plain.error_ned_m[0].x()));
  r.ranges.resize(1);
  EXPECT_TRUE(plain_gnss(r, {}).time_s.empty());  // no position from no satellites
  EXPECT_TRUE(outage_table({}, &OutageError::rmse_m).rows().empty());
}

TEST(TableAbuse, NumbersOfAnySizeAndPrecision) {
  for (const double x : {kHuge, -std::numeric_limits<double>::max(), kTiny, kInf, -kInf, 0.0}) {
    for (const int decimals : {-1, 0, 17, 1000, std::numeric_limits<int>::max() / 2}) {
      EXPECT_FALSE(fixed(x, decimals).empty());
      EXPECT_EQ(std::stod(significant(x, std::max(decimals, 17))), x) << decimals;
    }
  }
  EXPECT_EQ(fixed(kNan, 3), "\u2013");
  EXPECT_EQ(mean_std(std::span<const double>{}, 1), "\u2013 \u00b1 \u2013");
  EXPECT_EQ(significant(1.0 / 3.0, 1000), significant(1.0 / 3.0, 17));
}

TEST(TableAbuse, WithoutColumnsRowsOrText) {
  EXPECT_EQ(Table().to_text(), "\n\n");
  EXPECT_EQ(Table(std::vector<Table::Column>(2)).add_row({"", ""}).to_text(), "\n\n\n");
  Table table({{"\xff\xfe"}, {std::string(1000, 'x'), "\n"}});
  table.add_row({std::string("a\0b", 3), "\u2013"});
  EXPECT_GT(table.to_text().size(), 2000U);
  EXPECT_DEATH(table.add_row({"one"}), "a row has a cell for every column");
  expect_value_semantics(table, [](Table& t) { return t.add_row({"1", "2"}).to_text(); });
}

TEST(EvalAbuse, TwoThreads) {
  const std::vector<Relation> relations = {Relation{LogTime(), LogTime::from_seconds(3), SE2d()}};
  const auto results = in_two_threads([&](int) {
    NeesOverRuns runs(2, 5);
    for (std::size_t i = 0; i < 50; ++i) runs.add(i % 5, double(i % 7));
    return std::tuple(absolute_error(line(50), line(60)).translation_m.rmse, runs.share_within(),
                      relations_table("n", {}, line(9), relations).to_text());
  });
  EXPECT_EQ(results[0], results[1]);
}

}  // namespace
}  // namespace wayfare::eval
