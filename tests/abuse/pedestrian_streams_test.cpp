// Steps, walks and feet with broken streams: readings and stamps that no unit gives.

#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/pedestrian/foot_tracker.hpp>
#include <wayfare/pedestrian/pedestrian.hpp>
#include <wayfare/pedestrian/step_detector.hpp>
#include <wayfare/pedestrian/two_feet.hpp>
#include <wayfare/pedestrian/walk_feedback.hpp>

#include "abuse/abuse.hpp"
#include "pedestrian/foot_walk.hpp"
#include "pedestrian/phone_walk.hpp"

namespace wayfare::tests {
namespace {

constexpr std::int64_t kLast = std::numeric_limits<std::int64_t>::max();
LogTime at(double seconds) { return LogTime::from_seconds(seconds); }

const std::vector<ImuSample>& foot_walk() {
  static const std::vector<ImuSample> samples = [] {
    testing::FootWalkOptions o;
    o.rate_hz = 100.0;
    o.strides = 8;
    return testing::walk_foot(o).samples;
  }();
  return samples;
}
const MargRecording& phone_walk() {
  static const MargRecording samples = [] {
    testing::PhoneWalkOptions o;
    o.steps = 25;
    return testing::walk_phone(o).samples;
  }();
  return samples;
}

std::vector<double> numbers_of(const FootTracker& foot) {
  const FootPose& p = foot.pose();
  return {p.position_m.x(),
          p.position_m.z(),
          p.velocity_mps.y(),
          p.heading.radians(),
          foot.filter().covariance()(3, 3),
          static_cast<double>(foot.report().stances)};
}
std::vector<double> numbers_of(const Pedestrian& walker) {
  const PedestrianPose& p = walker.pose();
  return {p.position_m.x(), p.position_m.y(), p.heading.radians(), p.covariance(2, 2),
          static_cast<double>(walker.report().steps)};
}
bool all_finite(const std::vector<double>& numbers) {
  for (const double x : numbers)
    if (!std::isfinite(x)) return false;
  return true;
}

TEST(FootTrackerAbuse, LivesAsAValueMidStride) {
  FootTracker foot;
  for (std::size_t i = 0; i < 500; ++i) (void)foot.add(foot_walk()[i]);
  expect_value_semantics(foot, [](FootTracker& f) {
    for (std::size_t i = 500; i < 700; ++i) (void)f.add(foot_walk()[i]);
    f.finish([](const FootPose&) {});
    return numbers_of(f);
  });
  expect_value_semantics(FootTracker{}, [](FootTracker& f) {
    f.finish([](const FootPose&) {});
    return f.ready();
  });
}

TEST(FootTrackerAbuse, StampsYearsApartOrAtTheEndOfTheRangeLeaveItFinite) {
  for (const double jump_s : {-9e9, -1e9, -2.0, 1e-9, 1e9, 9e9}) {
    FootTracker foot;
    std::size_t poses = 0;
    LogTime last_pose;
    for (std::size_t i = 0; i < 800; ++i) {
      ImuSample s = foot_walk()[i];
      if (i >= 400) s.time += from_seconds(jump_s);
      (void)foot.add(s, [&](const FootPose& p) {
        ++poses;
        last_pose = p.time;
      });
    }
    foot.finish([&](const FootPose&) { ++poses; });
    EXPECT_TRUE(all_finite(numbers_of(foot))) << jump_s;
    EXPECT_GT(poses, 350U) << jump_s;
    EXPECT_TRUE(foot.filter().covariance().allFinite());
  }
  FootTracker end;
  for (int i = 0; i < 400; ++i) {
    ImuSample s = foot_walk()[0];
    s.time = LogTime::from_nanoseconds(kLast - (400 - i) * 10'000'000LL);
    (void)end.add(s);
  }
  end.finish([](const FootPose&) {});
  EXPECT_TRUE(all_finite(numbers_of(end)));
}

TEST(FootTrackerAbuse, ReadingsThatCannotBeUsedChangeNothing) {
  const auto last_of = [](bool broken) {
    FootTracker foot;
    Rng rng(1);
    for (std::size_t i = 0; i < 600; ++i) {
      const ImuSample good = foot_walk()[i];
      if (broken) {
        ImuSample bad = good;
        bad.time += Duration(rng.below(5'000'000));
        (rng.below(2) == 0 ? bad.angular_rate_radps : bad.specific_force_mps2)[0] =
            std::array{kNan, kInf, -kInf, kHuge, -kHuge, 1e9}[rng.below(6)];
        EXPECT_EQ(foot.add(bad), UpdateStatus::missing);
        ImuSample old = good;
        old.time = foot_walk()[i / 2].time - Duration(1);
        if (i > 0) {
          EXPECT_EQ(foot.add(old), UpdateStatus::late);
        }
      }
      EXPECT_EQ(foot.add(good), UpdateStatus::used);
    }
    return numbers_of(foot);
  };
  EXPECT_EQ(last_of(true), last_of(false));
}

TEST(TwoFeetAbuse, OneFootOrNoneIsNoProjection) {
  TwoFeet feet;
  EXPECT_TRUE(feet.odometry().T_odom_base.raw().translation().allFinite());
  feet.finish([](TwoFeet::Side, const FootPose&) { FAIL(); });
  for (std::size_t i = 0; i < 700; ++i)
    (void)feet.add(TwoFeet::Side::left, foot_walk()[i], [](TwoFeet::Side, const FootPose&) {});
  EXPECT_EQ(feet.projections(), 0U);
  EXPECT_FALSE(feet.tracker(TwoFeet::Side::right).ready());
}

TEST(TwoFeetAbuse, BrokenStreamsOfEitherFootStayFiniteAndMoveAsValues) {
  TwoFeetParameters parameters;
  parameters.farthest_m = 0.05;  // nearer than the feet start
  TwoFeet feet(parameters);
  Rng rng(3);
  const auto none = [](TwoFeet::Side, const FootPose&) {};
  for (std::size_t i = 0; i < 900; ++i)
    for (const auto side : {TwoFeet::Side::left, TwoFeet::Side::right}) {
      ImuSample s = foot_walk()[i];
      if (side == TwoFeet::Side::right && i > 300 && i < 400) continue;
      if (rng.below(20) == 0) s.angular_rate_radps[1] = kNotFinite[rng.below(3)];
      if (rng.below(20) == 0) s.time = s.time - from_seconds(rng.uniform(0.0, 2.0));
      (void)feet.add(side, s, none);
    }
  EXPECT_GT(feet.projections(), 0U);
  EXPECT_TRUE(feet.position(TwoFeet::Side::right).allFinite());
  expect_value_semantics(feet, [&](TwoFeet& f) {
    f.finish(none);
    return std::vector<double>{f.odometry().T_odom_base.raw().x(),
                               static_cast<double>(f.projections())};
  });
}

TEST(StepDetectorAbuse, ForcesThatAreNotNumbersAreMissing) {
  StepDetector clean, dirty;
  for (const MargSample& s : phone_walk()) {
    for (const double odd : kNotFinite)
      EXPECT_EQ(dirty.add(s.time, {0.0, odd, 9.8}, [](const Step&) { FAIL(); }),
                UpdateStatus::missing);
    EXPECT_EQ(clean.add(s.time, s.specific_force_mps2, [](const Step&) {}),
              dirty.add(s.time, s.specific_force_mps2, [](const Step&) {}));
  }
  EXPECT_GT(clean.steps(), 15U);
  EXPECT_EQ(clean.steps(), dirty.steps());
  EXPECT_EQ(clean.band(), dirty.band());
}

TEST(StepDetectorAbuse, AnyForcesAndStampsGiveStepsInOrder) {
  Rng rng(5);
  for (int run = 0; run < 200; ++run) {
    StepDetector detector;
    LogTime now = LogTime::from_nanoseconds(static_cast<std::int64_t>(rng()));
    std::uint64_t steps = 0;
    for (int i = 0; i < 300; ++i) {
      now += from_seconds(rng.below(30) == 0 ? rng.uniform(-1e10, 1e10) : rng.uniform(0.0, 0.1));
      Eigen::Vector3d force(rng.normal(0.0, 5.0), 0.0, 9.8 + 4.0 * std::sin(0.6 * i));
      if (rng.below(20) == 0) force[0] = rng.below(2) == 0 ? kHuge : -kHuge;
      (void)detector.add(now, force, [&](const Step& s) {
        ++steps;
        ASSERT_TRUE(std::isfinite(s.interval_s) && s.interval_s >= 0.0);
        ASSERT_TRUE(std::isfinite(s.crest_mps2) && std::isfinite(s.mean_abs_mps2));
        for (const StepLength& model :
             {StepLength(KimStep{}), StepLength(ConstantStep{}), StepLength(WeinbergStep{}),
              StepLength(HeightFrequencyStep{})})
          ASSERT_TRUE(std::isfinite(length_of(s, model)));
      });
      ASSERT_TRUE(std::isfinite(detector.band()));
    }
    ASSERT_EQ(steps, detector.steps());
  }
}

TEST(StepLengthAbuse, CalibrationByNothingChangesNothing) {
  const Step step{LogTime{}, 0.0, -1.0, 5.0, -3.0};
  for (const StepLength& model :
       {StepLength(KimStep{}), StepLength(WeinbergStep{}), StepLength(HeightFrequencyStep{})}) {
    EXPECT_GE(length_of(step, model), 0.0);
    const double before = length_of(Step{LogTime{}, 0.5, 2.0, -1.0, 1.0}, model);
    for (const double length : {0.0, -1.0, kNan}) {
      const StepLength same = calibrated(model, std::vector<Step>(3, step), length);
      EXPECT_EQ(length_of(Step{LogTime{}, 0.5, 2.0, -1.0, 1.0}, same), before);
    }
    EXPECT_EQ(length_of(Step{LogTime{}, 0.5, 2.0, -1.0, 1.0}, calibrated(model, {}, 10.0)), before);
  }
}

TEST(PedestrianAbuse, MissingReadingsAndLateStampsAreEverydayValues) {
  Pedestrian walker;
  Rng rng(7);
  for (const MargSample& good : phone_walk()) {
    MargSample s = good;
    const auto axis = [&] { return static_cast<int>(rng.below(3)); };
    if (rng.below(8) == 0) s.specific_force_mps2[axis()] = kNotFinite[rng.below(3)];
    if (rng.below(8) == 0) s.angular_rate_radps[axis()] = kNotFinite[rng.below(3)];
    if (rng.below(2) == 0) s.magnetic_field_uT.setConstant(kNan);
    if (rng.below(50) == 0) s.time = s.time - from_seconds(rng.uniform(0.0, 1.0));
    (void)walker.add(s, [](const PedestrianPose& p) {
      ASSERT_TRUE(p.position_m.allFinite() && p.covariance.allFinite());
    });
    (void)walker.add_heading(s.time, Angle::radians(kNotFinite[rng.below(3)]), 0.1);
    (void)walker.add_heading(s.time, Angle::radians(0.1), kNan);
  }
  EXPECT_TRUE(all_finite(numbers_of(walker)));
  EXPECT_GT(walker.report().steps, 5U);
  expect_value_semantics(walker, [](Pedestrian& w) {
    MargSample last = phone_walk().back();
    for (int i = 1; i < 50; ++i) {
      last.time += Duration(10'000'000);
      (void)w.add(last);
    }
    return numbers_of(w);
  });
}

TEST(PedestrianAbuse, YearsBetweenTwoReadingsLeaveItFinite) {
  for (const double jump_s : {-9e9, -1e9, 1e9, 9e9}) {
    Pedestrian walker;
    const std::size_t half = phone_walk().size() / 2;
    for (std::size_t i = 0; i < phone_walk().size(); ++i) {
      MargSample s = phone_walk()[i];
      if (i >= half) s.time += from_seconds(jump_s);
      (void)walker.add(s);
    }
    EXPECT_TRUE(all_finite(numbers_of(walker))) << jump_s;
  }
}

TEST(WalkFeedbackAbuse, PositionsThatAreNotFiniteAreIgnored) {
  WalkFeedback clean, dirty;
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector2d map(0.2 * i, 0.02 * i), steps(0.22 * i, 0.0);
    for (const double odd : {kNan, kInf, kHuge}) {
      dirty.add(at(0.5 * i), {odd, 0.0}, steps, true);
      dirty.add(at(0.5 * i), map, {0.0, odd}, true);
    }
    clean.add(at(0.5 * i), map, steps, true);
    dirty.add(at(0.5 * i), map, steps, true);
  }
  EXPECT_NE(clean.scale(), 1.0);
  EXPECT_EQ(clean.scale(), dirty.scale());
  EXPECT_EQ(clean.direction().radians(), dirty.direction().radians());
  for (int i = 0; i < 2000; ++i) clean.add(at(1e9 - 1e6 * i), {1e9, 1e9 * i}, {1e9 * i, 1.0}, true);
  EXPECT_TRUE(std::isfinite(clean.scale()) && std::isfinite(clean.direction().radians()));
}

TEST(MapHeadingAbuse, VariancesThatAreNoneAreNotUsed) {
  MapHeading heading;
  for (const double odd : {kNan, kInf, -kInf, 0.0, -1.0}) {
    EXPECT_FALSE(heading.independent_variance(at(0), odd, 0.1));
    EXPECT_FALSE(heading.independent_variance(at(0), 0.1, odd));
  }
  ASSERT_TRUE(heading.independent_variance(at(0), 0.1, 0.1));
  EXPECT_FALSE(heading.independent_variance(at(0), 0.1, 0.1));
  for (const double s : {1e9, -1e9, 9e9, -9e9}) {
    const auto variance = heading.independent_variance(at(s), 0.1, 0.1);
    ASSERT_TRUE(variance);
    EXPECT_TRUE(*variance >= 0.1 && std::isfinite(*variance));
  }
}

TEST(PedestrianAbuse, TwoThreadsWalkTheSame) {
  (void)foot_walk();
  (void)phone_walk();
  const auto both = in_two_threads([](int) {
    FootTracker foot;
    for (const ImuSample& s : foot_walk()) (void)foot.add(s);
    Pedestrian walker;
    for (const MargSample& s : phone_walk()) (void)walker.add(s);
    auto all = numbers_of(foot);
    for (const double x : numbers_of(walker)) all.push_back(x);
    return all;
  });
  EXPECT_EQ(both[0], both[1]);
}

}  // namespace
}  // namespace wayfare::tests
