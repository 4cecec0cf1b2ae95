// Attitude estimators with readings and times that no sensor should give.

#include <cmath>
#include <cstdint>
#include <limits>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/inertial/ahrs.hpp>

#include "abuse/abuse.hpp"

namespace wayfare {
namespace {

using namespace tests;

const LogTime kFirst = LogTime() + Duration::min(), kLast = LogTime() + Duration::max();

/// Level, x to the north, in the field of central Europe.
MargSample still(LogTime time) {
  return {time, {0.0, 0.0, 0.0}, {0.0, 0.0, -9.81}, {20.0, 0.0, 43.0}};
}

template <class E>
void feed(E& e, double from_s, double to_s) {
  for (double t = from_s; t < to_s; t += 0.01) e.add(still(LogTime::from_seconds(t)));
}
template <class E>
E started() {
  E e;
  feed(e, 0.0, 3.0);
  return e;
}
template <class E>
auto attitude(const E& e) {
  return e.q_world_body().quaternion().coeffs().template cast<double>().eval();
}
template <class E>
double tilt(const E& e) {
  const auto r = e.q_world_body().matrix();
  return std::acos(std::min(1.0, std::abs(double(r(2, 2)))));
}

template <class E>
class AttitudeAbuse : public ::testing::Test {};
using Estimators = ::testing::Types<Ahrs<frame::Ned>, Ahrs<frame::Enu, float>, MadgwickAhrs<>,
                                    MahonyAhrs<frame::Enu>, MahonyAhrs<frame::Ned, float>>;
TYPED_TEST_SUITE(AttitudeAbuse, Estimators);

TYPED_TEST(AttitudeAbuse, WhatIsNotAMeasurementChangesNothing) {
  TypeParam e = started<TypeParam>();
  ASSERT_TRUE(e.ready());
  const auto before = attitude(e);
  using Vector = typename TypeParam::Vector;
  LogTime time = LogTime::from_seconds(3.0);
  for (const double x : kNotFinite) {
    for (int axis = 0; axis < 3; ++axis) {
      Vector v = Vector::Ones();
      v[axis] = typename TypeParam::Scalar(x);
      time += std::chrono::milliseconds(1);
      EXPECT_EQ(e.add_rate(time, v), UpdateStatus::missing);
      EXPECT_EQ(e.add_force(time, v), UpdateStatus::missing);
      EXPECT_EQ(e.add_field(time, v), UpdateStatus::missing);
    }
  }
  EXPECT_EQ(e.add_field(time, Vector::Zero()), UpdateStatus::missing);
  EXPECT_EQ(e.add_rate(time, Vector::Constant(1e30F)), UpdateStatus::saturated);
  const MargUpdateStatus none = e.add(MargSample{time});
  EXPECT_EQ(none.gyro, UpdateStatus::missing);
  const MargUpdateStatus late = e.add(still(LogTime::from_seconds(2.99)));
  EXPECT_EQ(late.gyro, UpdateStatus::late);
  EXPECT_EQ(attitude(e), before);
}

TYPED_TEST(AttitudeAbuse, RecoversFromAnyNumbersAndTimes) {
  const std::vector<double> numbers = {0.0, kTiny, -kTiny, 1e-30, 1e-7,
                                       1e9, -1e9,  1e30,   kHuge, -kHuge};
  TypeParam e = started<TypeParam>();
  double t = 3.0;
  for (const double x : numbers) {
    for (int sensor = 0; sensor < 3; ++sensor) {
      MargSample s = still(LogTime::from_seconds(t += 0.01));
      (sensor == 0   ? s.angular_rate_radps
       : sensor == 1 ? s.specific_force_mps2
                     : s.magnetic_field_uT)
          .setConstant(x);
      e.add(s);
      ASSERT_TRUE(attitude(e).allFinite()) << x << " sensor " << sensor;
      ASSERT_NEAR(attitude(e).norm(), 1.0, 1e-3) << x;
    }
  }
  for (const LogTime time : {kLast, kFirst, kLast, LogTime(), LogTime::from_seconds(1e9)}) {
    e.add(still(time));
    ASSERT_TRUE(attitude(e).allFinite()) << time.seconds();
  }
  // Times were ahead by centuries: the clock counts as set back after a second.
  feed(e, 10.0, 70.0);
  EXPECT_TRUE(e.ready());
  EXPECT_LT(tilt(e), 0.02);
}

TYPED_TEST(AttitudeAbuse, IsAValue) {
  const TypeParam source = started<TypeParam>();
  expect_value_semantics(source, [](TypeParam& e) {
    feed(e, 3.0, 3.5);
    const auto q = attitude(e);
    return std::vector<double>(q.data(), q.data() + 4);
  });
}

TYPED_TEST(AttitudeAbuse, TwoInstancesInTwoThreads) {
  const auto results = in_two_threads([](int) {
    Rng rng(8);
    TypeParam e = started<TypeParam>();
    for (double t = 3.0; t < 6.0; t += 0.01) {
      MargSample s = still(LogTime::from_seconds(t));
      s.angular_rate_radps += Eigen::Vector3d(rng.normal(), rng.normal(), rng.normal());
      e.add(s);
    }
    const auto q = attitude(e);
    return std::vector<double>(q.data(), q.data() + 4);
  });
  EXPECT_EQ(results[0], results[1]);
}

TEST(AhrsAbuse, ACompassBeforeTheAttitudeIsNotKnowledge) {
  AhrsParameters p;
  p.use_magnetometer = false;
  Ahrs<> e(p);
  EXPECT_EQ(e.set_compass(Angle::degrees(90), Angle::degrees(1)), UpdateStatus::waiting);
  feed(e, 0.0, 1.0);
  ASSERT_TRUE(e.ready());
  EXPECT_FALSE(e.heading_known());
  const auto before = attitude(e);
  for (const double x : kNotFinite) {
    EXPECT_EQ(e.set_compass(Angle::radians(x), Angle::degrees(1)), UpdateStatus::missing);
    EXPECT_EQ(e.set_compass(Angle(), Angle::radians(x)), UpdateStatus::missing);
  }
  EXPECT_EQ(e.set_compass(Angle(), Angle::radians(kHuge)), UpdateStatus::missing);
  EXPECT_EQ(attitude(e), before);
  EXPECT_EQ(e.set_compass(Angle::degrees(90), Angle::degrees(1)), UpdateStatus::used);
  EXPECT_TRUE(e.heading_known());
  EXPECT_NEAR(compass_of_x<frame::Ned>(e.q_world_body()).degrees(), 90.0, 1e-6);
}

TEST(AhrsAbuse, HeadingFixesOfAnyTimeAndValue) {
  AhrsParameters p;
  p.heading_history_s = 1e9;
  p.use_magnetometer = false;
  Ahrs<> e(p);
  feed(e, 0.0, 3.0);
  for (const LogTime time :
       {kFirst, kLast, LogTime::from_seconds(1e9), LogTime::from_seconds(-1e9)})
    EXPECT_NE(e.add_heading({time, Angle(), 0.01}), UpdateStatus::used) << time.seconds();
  const LogTime now = LogTime::from_seconds(2.9);
  for (const double x : {kNan, kInf, -kInf, 0.0, -1.0})
    EXPECT_EQ(e.add_heading({now, Angle(), x}), UpdateStatus::missing) << x;
  EXPECT_EQ(e.add_heading({now, Angle::radians(kInf), 0.01}), UpdateStatus::missing);
  e.add_heading({now, Angle::radians(kHuge), kTiny});
  e.add_heading({LogTime::from_seconds(2.95), Angle::radians(1.0), kHuge});
  feed(e, 3.0, 4.0);
  EXPECT_TRUE(attitude(e).allFinite());
  EXPECT_TRUE(e.world_covariance().allFinite());
  EXPECT_GE(e.world_covariance().diagonal().minCoeff(), 0.0);
  EXPECT_FALSE(HeadingTrack(kHuge).at(kLast));
}

TEST(AhrsAbuse, StandsStillForCenturiesWithoutLosingTheLevel) {
  // 3 s, a gap to the end of time, and 3 s of the past.
  Ahrs<> e = started<Ahrs<>>();
  for (int i = 0; i < 300; ++i) e.add(still(kLast - std::chrono::milliseconds(10 * (300 - i))));
  EXPECT_TRUE(e.ready());
  EXPECT_LT(tilt(e), 0.02);
  EXPECT_EQ(e.report().restarts, 1U);
}

}  // namespace
}  // namespace wayfare
