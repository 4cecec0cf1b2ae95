#include <wayfare/eval/evaluation.hpp>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>

namespace wayfare::eval {
namespace {

using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

StampedPose stamped(double t, const SE2d& pose) {
  return {LogTime::from_seconds(t), Transform2<frame::Map, frame::Base>(pose)};
}

Trajectory moved(const Trajectory& all, const SE2d& T) {
  Trajectory result;
  for (const StampedPose& s : all)
    result.push_back({s.time, Transform2<frame::Map, frame::Base>(T * s.T_map_base.raw())});
  return result;
}

/// A walk with errors that grow, and its truth in another frame.
struct Drifting {
  Trajectory truth, estimate;

  explicit Drifting(int n = 200) {
    Rng rng(7);
    SE2d pose(3, -2, Angle::degrees(40)), drifted;
    for (int i = 0; i < n; ++i) {
      truth.push_back(stamped(0.5 * i, pose));
      estimate.push_back(stamped(0.5 * i, drifted));
      const Eigen::Vector3d step(0.3 + 0.02 * rng.normal(), 0.0, 0.1 * rng.normal());
      pose = pose.plus(step);
      drifted = drifted.plus(step + Eigen::Vector3d(0.003, 0.001, 0.001));
    }
  }
};

void expect_same(const AbsoluteError& a, const AbsoluteError& b) {
  EXPECT_NEAR(a.rmse_x_m, b.rmse_x_m, 1e-9);
  EXPECT_NEAR(a.rmse_y_m, b.rmse_y_m, 1e-9);
  EXPECT_NEAR(a.rmse_heading_deg, b.rmse_heading_deg, 1e-9);
  EXPECT_NEAR(a.translation_m.max, b.translation_m.max, 1e-9);
  EXPECT_NEAR(a.end_m, b.end_m, 1e-9);
}

TEST(Evaluation, ByHand) {
  // The truth drives 4 m along y; the estimate, in its own frame, along x with 1 % more, and turns
  // by 0.1 rad at the end. Started at the same pose, ahead is the truth's y: errors 0, 0.01, … 0.04
  // m.
  Trajectory truth, estimate;
  for (int i = 0; i <= 4; ++i) {
    truth.push_back(stamped(i, SE2d(5, i, Angle::degrees(90))));
    estimate.push_back(stamped(i, SE2d(1.01 * i, 0, Angle::radians(i == 4 ? 0.1 : 0.0))));
  }
  const Evaluation e = evaluate(estimate, {truth});
  const double sum_of_squares = 1e-4 * (1 + 4 + 9 + 16);
  EXPECT_NEAR(e.start.rmse_x_m, 0.0, 1e-12);
  EXPECT_NEAR(e.start.rmse_y_m, std::sqrt(sum_of_squares / 5), 1e-12);
  EXPECT_NEAR(e.start.rmse_heading_deg, 0.1 * 180 / M_PI / std::sqrt(5.0), 1e-9);
  EXPECT_NEAR(e.start.translation_m.max, 0.04, 1e-12);
  EXPECT_NEAR(e.start.end_m, 0.04, 1e-12);
  EXPECT_NEAR(e.start.end_percent, 1.0, 1e-9);
  EXPECT_NEAR(e.start.percent_of_path, 25 * std::sqrt(sum_of_squares / 5), 1e-9);
  // The best fit has the same centre: errors -0.02 … 0.02 m.
  EXPECT_NEAR(e.rigid.rmse_y_m, std::sqrt(1e-4 * 10 / 5), 1e-12);
  EXPECT_NEAR(e.rigid.end_m, 0.02, 1e-12);
  EXPECT_NEAR(e.rigid.alignment.heading().degrees(), 90.0, 1e-9);
  EXPECT_NEAR(e.rigid.alignment.x(), 5.0, 1e-12);
  EXPECT_NEAR(e.rigid.alignment.y(), -0.02, 1e-12);
}

TEST(Evaluation, TheFrameOfTheEstimateMattersOnlyWithoutAlignment) {
  const Drifting run;
  const SE2d T(30, -12, Angle::degrees(200));
  const Evaluation a = evaluate(run.estimate, {run.truth}),
                   b = evaluate(moved(run.estimate, T), {run.truth});
  expect_same(a.start, b.start);
  expect_same(a.rigid, b.rigid);
  EXPECT_GT(std::abs(a.unaligned.translation_m.rmse - b.unaligned.translation_m.rmse), 1.0);
  // The alignment of the one is that of the other after T.
  EXPECT_LT((b.rigid.alignment * T).minus(a.rigid.alignment).norm(), 1e-9);
}

TEST(Evaluation, NoOtherRigidMotionFitsBetter) {
  const Drifting run;
  const Evaluation e = evaluate(run.estimate, {run.truth});
  EXPECT_LE(e.rigid.translation_m.rmse, e.start.translation_m.rmse);
  for (const Eigen::Vector3d& by : {Eigen::Vector3d(0.01, 0, 0), Eigen::Vector3d(0, 0.01, 0),
                                    Eigen::Vector3d(0, 0, 0.001), Eigen::Vector3d(0, 0, -0.001)}) {
    const Trajectory other = moved(run.estimate, e.rigid.alignment.plus(by));
    EXPECT_GT(evaluate(other, {run.truth}).unaligned.translation_m.rmse,
              e.rigid.translation_m.rmse);
  }
}

TEST(Evaluation, TheTruthItselfHasNoErrors) {
  const Drifting run;
  const Evaluation e = evaluate(run.truth, {run.truth});
  for (const AbsoluteError* error : {&e.unaligned, &e.start, &e.rigid}) {
    EXPECT_LT(error->translation_m.max, 1e-9);
    EXPECT_LT(error->rmse_heading_deg, 1e-9);
  }
  EXPECT_NEAR(e.rigid.path_length_m, path_length_m(run.truth), 1e-9);
}

TEST(Evaluation, ASparseTruthIsComparedAtItsOwnTimes) {
  const Drifting run;
  Trajectory surveyed;
  for (std::size_t i = 0; i < run.truth.size(); i += 40) surveyed.push_back(run.truth[i]);
  const Evaluation e = evaluate(run.estimate, {surveyed, false});
  ASSERT_EQ(e.rigid.times.size(), surveyed.size());
  EXPECT_EQ(e.rigid.times[1], surveyed[1].time);
  EXPECT_TRUE(std::isnan(e.rigid.rmse_heading_deg) && std::isnan(e.start.rmse_x_m));
  // The best fit to five of the points.
  EXPECT_LT(e.rigid.translation_m.rmse, 2 * evaluate(run.estimate, {run.truth}).rigid.end_m);
  Trajectory shifted = surveyed;
  for (StampedPose& s : shifted) s.time = s.time + from_seconds(0.25);
  shifted.pop_back();
  EXPECT_EQ(evaluate(run.estimate, {shifted}).rigid.times.size(), shifted.size());
}

TEST(Evaluation, GapsOfTheTruthAreNotBridged) {
  Drifting run;
  Trajectory broken = run.truth;
  broken.erase(broken.begin() + 50, broken.begin() + 60);  // 5.5 s
  Trajectory estimate;  // between the true poses, so that fewer of its poses are common
  for (std::size_t i = 0; i + 1 < run.estimate.size(); i += 2)
    estimate.push_back(
        stamped(0.5 * static_cast<double>(i) + 0.25, run.estimate[i].T_map_base.raw()));
  const Evaluation whole = evaluate(estimate, {run.truth}), e = evaluate(estimate, {broken});
  EXPECT_EQ(whole.rigid.times.size(), estimate.size());
  EXPECT_EQ(e.rigid.times.size(), estimate.size() - 5);
}

TEST(Evaluation, WithoutTwoCommonPosesNothingIsKnown) {
  const Drifting run;
  const Trajectory one = {run.truth[3]}, none;
  for (const Evaluation& e :
       {evaluate(one, {run.truth}), evaluate(none, {run.truth}), evaluate(run.truth, {none})}) {
    EXPECT_TRUE(std::isnan(e.start.rmse_x_m) && std::isnan(e.rigid.end_m));
    EXPECT_TRUE(e.rigid.times.empty());
  }
}

std::string fault_of(const Trajectory& poses) {
  const auto ok = check(Reference{poses});
  return ok ? std::string() : ok.error().to_string();
}

TEST(CheckedReference, NamesWhatIsWrong) {
  const Trajectory good = Drifting(5).truth;
  EXPECT_EQ(fault_of(good), "");
  EXPECT_THAT(fault_of({}), HasSubstr("fewer than two poses"));
  EXPECT_THAT(fault_of({good[0]}), HasSubstr("fewer than two poses"));
  Trajectory bad = good;
  bad[3].time = bad[1].time;
  EXPECT_THAT(fault_of(bad), HasSubstr("pose 4, at 0.500 s, is earlier than the pose before it"));
  bad[3].time = bad[2].time;
  EXPECT_THAT(fault_of(bad), HasSubstr("pose 4, at 1.000 s, has the time of the pose before it"));
  for (const double x : {kNan, std::numeric_limits<double>::infinity()}) {
    bad = good;
    bad[2] = stamped(1.0, SE2d(x, 0, Angle()));
    EXPECT_THAT(fault_of(bad), HasSubstr("pose 3, at 1.000 s, is not finite"));
  }
}

std::string overlap_fault(const Trajectory& truth, double shift_s) {
  std::vector<LogTime> times;
  for (int i = 0; i < 10; ++i) times.push_back(LogTime::from_seconds(i + shift_s));
  const auto ok = check_overlap({truth}, times);
  return ok ? std::string() : ok.error().to_string();
}

TEST(CheckedReference, NamesAnotherTimeBaseAndNoOverlap) {
  const Trajectory truth = Drifting(19).truth;  // 0 to 9 s
  EXPECT_EQ(overlap_fault(truth, 0.0), "");
  EXPECT_EQ(overlap_fault(truth, 7.5), "");
  EXPECT_THAT(overlap_fault(truth, 8.5), HasSubstr("fewer than two poses in common"));
  EXPECT_THAT(overlap_fault(truth, 20.0), HasSubstr("does not overlap with the log"));
  EXPECT_THAT(overlap_fault(truth, -30.0), HasSubstr("does not overlap with the log"));
  EXPECT_THAT(
      overlap_fault(truth, 1.6e9),
      HasSubstr("is on another time base: the true poses are from 0.000 to 9.000 s, the log "
                "from 1600000000.000 to 1600000009.000 s"));
  EXPECT_FALSE(check_overlap({truth}, {}));
  EXPECT_FALSE(check_overlap({}, std::vector{LogTime()}));
}

TEST(ErrorTable, HasARowForEachAlignment) {
  const Drifting run;
  const std::vector<Evaluated> all = {{"one", evaluate(run.estimate, {run.truth})}, {"none", {}}};
  const Table table = error_table(all);
  ASSERT_EQ(table.rows().size(), 4U);
  EXPECT_EQ(table.rows()[0][0], "one, same start");
  EXPECT_EQ(table.rows()[0][4], fixed(all[0].errors.start.translation_m.rmse, 3));
  EXPECT_EQ(table.rows()[1][4], fixed(all[0].errors.rigid.translation_m.rmse, 3));
  EXPECT_EQ(table.rows()[3][1], "\u2013");
  EXPECT_EQ(error_table(all, true).rows().size(), 6U);
  const std::vector<Evaluated> points = {{"one", evaluate(run.estimate, {run.truth, false})}};
  ASSERT_EQ(error_table(points).rows().size(), 1U);
  EXPECT_EQ(error_table(points).rows()[0][0], "one, aligned");
  EXPECT_EQ(error_table(points).rows()[0][3], "\u2013");
  EXPECT_EQ(alignment_table(all).rows()[0][1], "200");
  EXPECT_EQ(alignment_table(all).rows()[1][1], "0");
}

}  // namespace
}  // namespace wayfare::eval
