// Step length models and stance statistics: the library's and others, by their laws.
#include <wayfare/pedestrian/foot_tracker.hpp>
#include <wayfare/pedestrian/pedestrian.hpp>
#include <wayfare/pedestrian/stance.hpp>
#include <wayfare/pedestrian/two_feet.hpp>

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/testing/pedestrian_laws.hpp>
#include "core/faults_of.hpp"
#include "foot_walk.hpp"
#include "phone_walk.hpp"

namespace wayfare {
namespace {

using testing::faults_of;
using ::testing::HasSubstr;
using testing::StanceLaws;
using testing::StepLengthLaws;
using testing::walk_foot;
using testing::walk_phone;

/// Affine in the step frequency, without a factor.
struct FrequencyStep {
  double offset_m = 0.3, per_hz_m = 0.2;
  double operator()(const Step& s) const {
    return offset_m + per_hz_m / std::max(s.interval_s, 0.2);
  }
};

/// MAG of Skog et al. 2010.
struct Magnitude {
  double gravity_mps2 = 9.80665, sigma_mps2 = 0.2;
  double operator()(const StanceWindow& window) const {
    double sum = 0.0;
    for (const ImuSample& s : window) {
      const double off = (s.specific_force_mps2.norm() - gravity_mps2) / sigma_mps2;
      sum += off * off;
    }
    return sum / static_cast<double>(window.size());
  }
};

static_assert(!ScaledStepLength<FrequencyStep> && ScaledStepLength<KimStep>);

TEST(StepLengthModels, SatisfyTheirLaws) {
  StepLengthLaws<ConstantStep>{}.check();
  StepLengthLaws<WeinbergStep>{}.check();
  StepLengthLaws<KimStep>{}.check();
  StepLengthLaws<HeightFrequencyStep>{}.check();
  StepLengthLaws<StepLength>{WeinbergStep{}}.check();
  StepLengthLaws<FrequencyStep>{}.check();
}

TEST(StepLengthModels, LawsNameWhatIsWrong) {
  struct Unscaled {
    double factor = 0.5;
    double operator()(const Step& s) const { return factor + 0.1 * s.interval_s; }
  };
  EXPECT_THAT(faults_of([] { StepLengthLaws<ConstantStep>{{-0.5}}.check(); }),
              HasSubstr("length -0.5 m"));
  EXPECT_THAT(faults_of([] { StepLengthLaws<Unscaled>{}.check(); }), HasSubstr("factor"));
}

// The lengths are those of the model, and the rest of the walk is the same.
TEST(StepLengthModels, AreUsedByDeadReckoning) {
  BasicPedestrianParameters<FrequencyStep> parameters;
  parameters.length.offset_m = 0.4;
  BasicPedestrian own(parameters);
  Pedestrian usual;
  double sum = 0.0;
  for (const auto& s : walk_phone({}).samples) {
    usual.add(s);
    own.add(s, [&](const PedestrianPose& pose) {
      EXPECT_EQ(pose.length_m, 0.4 + 0.2 / pose.step.interval_s);
      sum += pose.length_m;
    });
  }
  EXPECT_NEAR(own.report().distance_m, sum, 1e-9);
  EXPECT_GT(own.report().steps, 70U);
  EXPECT_EQ(own.report().steps, usual.report().steps);
  EXPECT_EQ(own.pose().heading.radians(), usual.pose().heading.radians());
}

// Every second length is NaN: those steps are dropped and counted, and the position stays finite.
TEST(StepLengthModels, StepsWithoutAFiniteLengthAreDropped) {
  struct Faulty {
    double operator()(const Step& s) const {
      return s.time.nanoseconds() / 100'000'000 % 2 == 0 ? std::numeric_limits<double>::quiet_NaN()
                                                         : 0.7;
    }
  };
  BasicPedestrian walker{BasicPedestrianParameters<Faulty>{}};
  std::uint64_t poses = 0;
  for (const auto& s : walk_phone({}).samples)
    walker.add(s, [&](const PedestrianPose& pose) {
      ++poses;
      EXPECT_TRUE(pose.position_m.allFinite() && pose.covariance.allFinite());
    });
  EXPECT_GT(walker.report().without_length, 10U);
  EXPECT_EQ(poses + walker.report().without_length, walker.report().steps);
  EXPECT_NEAR(walker.report().distance_m, 0.7 * double(poses), 1e-9);
}

TEST(StanceStatistics, SatisfyTheirLaws) {
  FootParameters ared;
  ared.statistic = StanceStatistic::ared;
  StanceLaws<ShoeOrAred>{ShoeOrAred{}}.check();
  StanceLaws<ShoeOrAred>{ShoeOrAred{ared}}.check();
  StanceLaws<Magnitude>{}.check();
}

TEST(StanceStatistics, LawsNameWhatIsWrong) {
  const auto faults = [](auto statistic) {
    return faults_of([&] { StanceLaws<decltype(statistic)>{statistic}.check(); });
  };
  const auto x = [](const StanceWindow& w) {
    return std::abs((*w.begin()).specific_force_mps2.x() / 0.1);
  };
  EXPECT_THAT(faults(x), HasSubstr("in another mounting"));
  EXPECT_THAT(faults(Magnitude{9.0}), HasSubstr("at rest"));
  EXPECT_THAT(faults([](const StanceWindow&) { return 0.5; }), HasSubstr("in a swing 0.5"));
}

// Half of a percent of 52 m, as SHOE needs 0.3 %: MAG sees no rotation.
TEST(StanceStatistics, AreUsedByTheFootTracker) {
  const auto walk = walk_foot({});
  BasicFootTracker tracker(FootParameters{}, Magnitude{});
  double last = -1.0;
  const auto keep = [&](const FootPose& pose) { last = pose.statistic; };
  for (const ImuSample& s : walk.samples) tracker.add(s, keep);
  tracker.finish(keep);
  EXPECT_GE(last, 0.0);
  EXPECT_LT((tracker.pose().position_m - walk.position.back()).norm(), 0.005 * walk.length_m);
}

// The default statistic, given as one's own, gives the same numbers.
TEST(StanceStatistics, TheDefaultIsOneOfThem) {
  const auto walk = walk_foot({});
  FootTracker usual;
  BasicFootTracker given(FootParameters{}, [](const StanceWindow& w) { return ShoeOrAred{}(w); });
  BasicTwoFeet feet(TwoFeetParameters{}, Magnitude{});
  for (const ImuSample& s : walk.samples) {
    usual.add(s);
    given.add(s);
    feet.add({}, s, [](auto, const FootPose&) {});
  }
  EXPECT_EQ(usual.pose().position_m, given.pose().position_m);
  EXPECT_EQ(usual.report().stances, given.report().stances);
  EXPECT_GT(feet.tracker({}).report().stances, 30U);
}

// A statistic that is negative or NaN detects no stance, and the filter is not harmed.
TEST(StanceStatistics, NumbersThatAreNoneCountAsMotion) {
  for (const double value : {-2.0, std::numeric_limits<double>::quiet_NaN()}) {
    BasicFootTracker tracker(FootParameters{}, [value](const StanceWindow&) { return value; });
    for (const ImuSample& s : walk_foot({}).samples) tracker.add(s);
    EXPECT_EQ(tracker.report().stances, 0U);
    EXPECT_TRUE(tracker.pose().position_covariance_m2.allFinite());
  }
}

}  // namespace
}  // namespace wayfare
