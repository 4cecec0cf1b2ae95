// Positions from epochs that are empty, repeated, contradictory or not finite.

#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/gnss/single_point.hpp>

#include "abuse/abuse.hpp"
#include "gnss/sky.hpp"

namespace wayfare {
namespace {

using namespace tests;

RangeCorrectionOptions vacuum() {
  RangeCorrectionOptions o;
  o.ionosphere = o.troposphere = false;
  return o;
}

struct Epoch {
  Ephemerides messages = testing::sky_messages();
  testing::SkyReceiver receiver;
  ObservationEpoch observations = testing::sky_epoch(messages, receiver);
  Eigen::Vector3d here = ecef_from_geodetic(receiver.position);
  RangeEpoch ranges = correct_ranges(observations, messages, here, vacuum());
};

void expect_here(const Epoch& e, const Result<SinglePoint>& point, double within_m = 1.0) {
  ASSERT_TRUE(point) << point.error().to_string();
  EXPECT_LT((point->position_ecef_m - e.here).norm(), within_m);
  EXPECT_TRUE(point->position_covariance_ned_m2.allFinite());
}

TEST(SinglePointAbuse, NothingIsAnErrorAndNotANumberIsNoMeasurement) {
  const Epoch e;
  EXPECT_FALSE(single_point(RangeEpoch{}));
  EXPECT_FALSE(single_point(ObservationEpoch{}, e.messages));
  EXPECT_FALSE(single_point(e.observations, Ephemerides{}));
  for (const double x : {kNan, kInf, -kInf}) {
    for (double CorrectedRange::*value :
         {&CorrectedRange::range_m, &CorrectedRange::range_sigma_m}) {
      RangeEpoch some = e.ranges, all = e.ranges;
      some.satellites[2].*value = x;
      for (CorrectedRange& r : all.satellites) r.*value = x;
      expect_here(e, single_point(some));
      EXPECT_EQ(single_point(all).error().code, ErrorCode::degenerate);
    }
    RangeEpoch rates = e.ranges;
    for (CorrectedRange& r : rates.satellites) r.range_rate_mps = x;
    const auto point = single_point(rates);
    expect_here(e, point);
    EXPECT_FALSE(point->velocity_ned_mps);
  }
}

TEST(SinglePointAbuse, ExtremeValuesAreExcludedOrAnError) {
  const Epoch e;
  for (const double x : {kHuge, -kHuge, 1e30, 1e9, -1e9}) {
    RangeEpoch one = e.ranges;
    one.satellites[1].range_m = x;
    const auto point = single_point(one);
    expect_here(e, point);
    RangeEpoch all = e.ranges;
    for (CorrectedRange& r : all.satellites) r.range_m = r.range_rate_mps = x;
    const auto none = single_point(all);
    EXPECT_FALSE(none);
    RangeEpoch far = e.ranges;
    far.satellites[1].position_ecef_m.setConstant(x);
    const auto odd = single_point(far);
    expect_here(e, odd);
  }
  for (const double sigma : {kTiny, 1e-160, kHuge, 0.0, -1.0}) {
    RangeEpoch all = e.ranges;
    for (CorrectedRange& r : all.satellites) r.range_sigma_m = r.range_rate_sigma_mps = sigma;
    const auto point = single_point(all);
    EXPECT_TRUE(!point || (point->position_ecef_m.allFinite() && !std::isnan(point->chi_square)));
  }
}

TEST(SinglePointAbuse, AnyFirstPositionLeadsToTheSameOrToAnError) {
  const Epoch e;
  for (const double x : {kNan, kInf, kHuge, 1e12, -1e9, 3e6, 1.0, kTiny}) {
    const Eigen::Vector3d near = Eigen::Vector3d::Constant(x);
    SCOPED_TRACE(x);
    expect_here(e, single_point(e.ranges, {}, near));
    SinglePointOptions options;
    options.corrections = vacuum();
    expect_here(e, single_point(e.observations, e.messages, options, near));
  }
  // On a satellite the direction to it is not defined.
  const auto on = single_point(e.ranges, {}, e.ranges.satellites[0].position_ecef_m);
  EXPECT_TRUE(!on || on->position_ecef_m.allFinite());
}

TEST(SinglePointAbuse, ARepeatedSatelliteCountsOnce) {
  const Epoch e;
  const auto once = single_point(e.ranges);
  RangeEpoch many = e.ranges;
  for (int i = 0; i < 20'000; ++i) {
    many.satellites.push_back(e.ranges.satellites[0]);
    many.satellites.back().range_m += 1e4;
    many.satellites.back().range_rate_mps += 1e3;
  }
  const auto point = single_point(many);
  ASSERT_TRUE(once && point);
  EXPECT_EQ(point->position_ecef_m, once->position_ecef_m);
  EXPECT_EQ(point->used, once->used);
  EXPECT_EQ(point->position_covariance_ned_m2, once->position_covariance_ned_m2);
  EXPECT_EQ(*point->velocity_ned_mps, *once->velocity_ned_mps);
  // Four copies of one satellite are one.
  RangeEpoch same{many.time, std::vector<CorrectedRange>(4, e.ranges.satellites[0])};
  EXPECT_EQ(single_point(same).error().code, ErrorCode::degenerate);
}

TEST(SinglePointAbuse, ManyContradictingSatellitesTakeNoTime) {
  const Epoch e;
  RangeEpoch many{e.ranges.time, {}};
  Rng rng(2);
  for (int i = 0; i < 600; ++i) {
    CorrectedRange r =
        e.ranges.satellites[static_cast<std::size_t>(i) % e.ranges.satellites.size()];
    r.satellite = {GnssSystem(i % 4), static_cast<std::uint8_t>(i / 4)};
    r.range_m += rng.normal(0.0, 1e5);
    many.satellites.push_back(r);
  }
  const auto point = single_point(many);
  EXPECT_TRUE(!point || point->position_ecef_m.allFinite());
}

TEST(SystemOffsetsAbuse, LearnNothingFromNothing) {
  SystemOffsets offsets;
  for (const double x : {kNan, kInf, -kInf, kHuge}) {
    for (int i = 0; i < 20; ++i) {
      SinglePoint point;
      point.degrees_of_freedom = 5;
      point.clock_bias_m = {x, 1.0, x, 2.0};
      offsets.learn(point);
      point.clock_bias_m = {1.0, x, x, x};
      if (!std::isfinite(x)) offsets.learn(point);
    }
  }
  EXPECT_FALSE(SystemOffsets().of(GnssSystem::galileo));
  const RangeEpoch none = on_one_clock({}, offsets);
  EXPECT_TRUE(none.satellites.empty());
  const GnssFix fix = to_fix(SinglePoint{});
  EXPECT_FALSE(fix.velocity_ned_mps);
}

TEST(ChiSquareAbuse, OfNoDegreeOfFreedomIsZero) {
  for (const int dof : {std::numeric_limits<int>::min(), -1, 0})
    EXPECT_EQ(chi_square_threshold(dof, 1e-3), 0.0);
  for (const double p : {0.0, 1.0, kNan, kInf, -1.0})
    for (const int dof : {1, 1'000'000'000})
      EXPECT_TRUE(std::isfinite(chi_square_threshold(dof, p))) << p;
}

TEST(GnssAbuse, TwoThreadsSolveTheSame) {
  const auto results = in_two_threads([](int) {
    const Epoch e;
    SystemOffsets offsets;
    double sum = 0.0;
    for (int i = 0; i < 20; ++i) {
      const auto point = single_point(e.ranges);
      offsets.learn(*point);
      sum += single_point(e.observations, e.messages)->position_ecef_m.sum();
      sum += point->position_ecef_m.sum() + point->chi_square;
    }
    return std::tuple(sum, offsets.of(GnssSystem::galileo)->offset_m,
                      single_point(on_one_clock(e.ranges, offsets))->used);
  });
  EXPECT_EQ(results[0], results[1]);
}

}  // namespace
}  // namespace wayfare
