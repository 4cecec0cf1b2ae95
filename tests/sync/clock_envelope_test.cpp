// A device's clock from arrivals with random delays.
#include <wayfare/sync/clock_fit.hpp>

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace wayfare {
namespace {

using DeviceTime = Time<DeviceClock>;

LogTime log_at(double s) {
  return LogTime::from_nanoseconds(1'700'000'000'000'000'000) + from_seconds(s);
}

//! [envelope]
TEST(ClockEnvelope, FindsDriftAndMinimumDelay) {
  std::mt19937 random(1);
  std::exponential_distribution<double> late(1.0 / 0.005);
  ClockEnvelope clock;
  const double drift = 40e-6, least = 0.036;  // the device's clock is fast by 40 ppm
  double worst = 0.0;
  for (int i = 0; i < 3000; ++i) {
    const double t = 0.1 * i;
    const auto device = DeviceTime::from_seconds(7.0 + t * (1.0 + drift));
    const LogTime measured = log_at(t + least);
    const LogTime arrived = measured + from_seconds(late(random));
    const LogTime found = clock.add(device, arrived);
    EXPECT_LE(found, arrived);
    if (i > 600) worst = std::max(worst, std::abs(to_seconds(found - measured)));
  }
  // The minimum delays of 0.25 s buckets within a minute are a few hundredths of a millisecond; the
  // mean delay is 5 ms.
  EXPECT_LT(worst, 0.0005);
  EXPECT_NEAR(clock.rate(), 1.0 / (1.0 + drift), 10e-6);
  EXPECT_EQ(clock.restarts(), 0U);
}
//! [envelope]

TEST(ClockEnvelope, RestartsWithTheDevice) {
  ClockEnvelope clock;
  for (int i = 0; i < 200; ++i)
    clock.add(DeviceTime::from_seconds(100.0 + 0.1 * i), log_at(0.1 * i));
  const LogTime again = clock.add(DeviceTime::from_seconds(0.0), log_at(30.0));
  EXPECT_EQ(again, log_at(30.0));
  EXPECT_EQ(clock.restarts(), 1U);
  EXPECT_EQ(clock.add(DeviceTime::from_seconds(0.1), log_at(30.15)), log_at(30.1));
  // A pause of the link is not a restart.
  EXPECT_EQ(clock.add(DeviceTime::from_seconds(0.2), log_at(31.0)), log_at(30.2));
  EXPECT_EQ(clock.restarts(), 1U);
}

}  // namespace
}  // namespace wayfare
