// Clocks, ordering and synchronisation of streams with damaged stamps.

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/sync/augmented_scans.hpp>
#include <wayfare/sync/clock_fit.hpp>
#include <wayfare/sync/in_order.hpp>
#include <wayfare/sync/odometry_track.hpp>

#include "abuse/abuse.hpp"

namespace wayfare::tests {
namespace {

constexpr std::int64_t kFirst = std::numeric_limits<std::int64_t>::min();
constexpr std::int64_t kLast = std::numeric_limits<std::int64_t>::max();

LogTime at(double seconds) { return LogTime::from_seconds(seconds); }
LogTime at_ns(std::int64_t ns) { return LogTime::from_nanoseconds(ns); }
Time<DeviceClock> device_ns(std::int64_t ns) { return Time<DeviceClock>::from_nanoseconds(ns); }

TEST(ClockFitAbuse, StampsAtTheEndsOfTheRange) {
  using Pair = ClockPair<DeviceClock>;
  const std::vector<Pair> ends{{device_ns(kFirst), at_ns(kLast)},
                               {device_ns(kLast), at_ns(kFirst)},
                               {device_ns(0), at_ns(0)}};
  for (const bool late : {false, true})
    for (const double gate : {3.0, 0.0, -1.0, kNan, kInf})
      for (const int rounds : {-1, 0, 1, 8}) {
        const auto fit = fit_clock<DeviceClock>(ends, {late, gate, rounds});
        ASSERT_TRUE(fit);
        EXPECT_TRUE(std::isfinite(fit->rate));
        EXPECT_GE(fit->used, 2U);
        for (const std::int64_t ns : {kFirst, std::int64_t{0}, kLast}) (void)(*fit)(device_ns(ns));
      }
  const std::vector<Pair> same(100, {device_ns(kLast), at_ns(kFirst)});
  EXPECT_FALSE(fit_clock<DeviceClock>(same));
  EXPECT_FALSE(fit_clock<DeviceClock>(std::vector<Pair>{}));
  EXPECT_FALSE(fit_clock<DeviceClock>(std::vector<Pair>{ends[0]}));
}

TEST(ClockEnvelopeAbuse, NeverLaterThanTheArrivalWhateverTheStamps) {
  Rng rng(1);
  for (int run = 0; run < 100; ++run) {
    ClockEnvelope envelope;
    for (int i = 0; i < 100; ++i) {
      const auto stamp = [&] {
        const auto bits = static_cast<std::int64_t>(rng());
        return rng.below(3) == 0 ? bits : bits >> (8 + rng.below(50));
      };
      const LogTime arrived = at_ns(stamp());
      ASSERT_LE(envelope.add(device_ns(stamp()), arrived), arrived);
      ASSERT_TRUE(std::isfinite(envelope.rate()));
      ASSERT_LE(std::abs(envelope.rate() - 1.0), 5e-4 + 1e-12);
    }
  }
  ClockEnvelope used;
  for (int i = 0; i < 500; ++i)
    (void)used.add(device_ns(i * 100'000'000LL), at_ns(i * 100'010'000LL));
  expect_value_semantics(used, [](ClockEnvelope& e) {
    return e.add(device_ns(60'000'000'000), at(60.02)).nanoseconds();
  });
}

TEST(GyroTurnAbuse, TimeReversedAndBrokenSamplesHaveNoTurn) {
  const std::vector<GyroSample> samples{
      {at(0), 1.0}, {at(0.1), 1.0}, {at(0.2), kNan}, {at(0.3), 1.0}};
  const GyroTurn turn(samples);
  EXPECT_FALSE(turn.between(at(0.1), at(0.0)));
  EXPECT_FALSE(turn.between(at(0.0), at(0.25)));
  EXPECT_FALSE(turn.between(at_ns(kFirst), at_ns(kLast)));
  EXPECT_FALSE(turn.between(at(0.3), at(0.4)));
  ASSERT_TRUE(turn.between(at(0.0), at(0.0)));
  EXPECT_EQ(turn.between(at(0.0), at(0.0))->radians(), 0.0);
  EXPECT_FALSE(GyroTurn({}).between(at(0), at(1)));
}

TEST(OdometryTrackAbuse, AnyTimeIsBetweenTheSamples) {
  const auto pose = [](double x) {
    return Transform2<frame::Odom, frame::Base>(SE2d(x, 0.0, Angle{}));
  };
  const std::vector<OdometrySample> ends{{at_ns(kFirst), pose(0)}, {at_ns(kLast), pose(1)}};
  for (const std::int64_t ns : {kFirst, std::int64_t{-1}, kLast}) {
    const double x = OdometryTrack(ends).at(at_ns(ns))->raw().x();
    EXPECT_TRUE(x >= 0.0 && x <= 1.0) << x;
  }
}

WheelSample wheels(double s, double m) { return {at(s), m, m}; }

TEST(SynchroniserAbuse, ADamagedStampIsOneStepAndNotOneForEachPeriodOfTheYears) {
  for (const double far_s : {1e9, 9e9}) {
    Recording recording;
    for (int i = 0; i < 20; ++i) recording.wheels.push_back(wheels(0.05 * i, 0.01));
    recording.wheels.push_back(wheels(far_s, 5.0));
    recording.scans.push_back({at(0.5), {}, {}, 0.0F, 1.0F, {}});
    recording.scans.push_back({at(far_s), {}, {}, 0.0F, 1.0F, {}});
    SyncStatistics statistics;
    const auto steps = synchronise(recording, {}, &statistics);
    ASSERT_LT(steps.size(), 30U);
    double rolled = 0.0;
    std::size_t lasers = 0;
    for (std::size_t i = 0; i < steps.size(); ++i) {
      rolled += steps[i].wheels.left_m;
      lasers += steps[i].laser ? 1 : 0;
      if (i > 0) {
        EXPECT_GT(steps[i].time, steps[i - 1].time);
      }
    }
    EXPECT_NEAR(rolled, 5.0 + 19 * 0.01, 1e-9);
    EXPECT_EQ(lasers, 2U);
    EXPECT_EQ(steps.back().time, at(far_s));
    EXPECT_FALSE(steps.back().wheels_known);
    EXPECT_EQ(statistics.refused_late, 0U);
  }
}

TEST(SynchroniserAbuse, ASilenceOfLessThanAnHourKeepsItsTimeBase) {
  Recording recording;
  recording.wheels = {wheels(0.0, 0.0), wheels(0.05, 0.1), wheels(3000.0, 0.1)};
  EXPECT_EQ(synchronise(recording, {}).size(), 60001U);
}

TEST(SynchroniserAbuse, TheEndsOfTheRangeEnd) {
  for (const std::int64_t from : {kFirst, std::int64_t{0}}) {
    Recording recording;
    recording.wheels = {
        {at_ns(from), 0.1, 0.1}, {at_ns(kLast - 10), 0.1, 0.1}, {at_ns(kLast), 0.1, 0.1}};
    recording.radar = {{at_ns(from), {}}, {at_ns(kLast), {}}};
    SyncStatistics statistics;
    EXPECT_LE(synchronise(recording, {}, &statistics).size(), 3U);
    EXPECT_EQ(statistics.refused_late, 3U);
  }
}

TEST(SynchroniserAbuse, MovesWithItsStreams) {
  const auto make = [] {
    RobotSynchroniser s({});
    for (int i = 0; i < 50; ++i) (void)s.push(wheels(0.05 * i, 0.01));
    return s;
  };
  expect_move_semantics(make, [](RobotSynchroniser& s) {
    s.finish();
    std::vector<double> rolled;
    while (const auto step = s.next()) rolled.push_back(step->wheels.left_m);
    return rolled;
  });
}

TEST(SynchroniserDeathTest, NeedsAPeriodAndScans) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_DEATH(RobotSynchroniser({.period = Duration::zero()}), "period");
  EXPECT_DEATH(RobotSynchroniser({.scans = 0}), "period");
}

TEST(SyncAbuse, TwoThreadsSynchroniseTheSame) {
  const auto both = in_two_threads([](int) {
    Recording recording;
    Rng rng(2);
    for (int i = 0; i < 200; ++i) {
      recording.wheels.push_back(wheels(0.05 * i, rng.normal()));
      recording.gyro.push_back({at(0.04 * i), rng.normal()});
      RadarScan radar{at(0.033 * i), {}};
      for (int k = 0; k < 10; ++k) radar.points.push_back({1.0F, float(rng.normal()), 0, 0, 10});
      recording.radar.push_back(radar);
    }
    std::vector<double> all;
    for (const SyncedStep& step : synchronise(recording, {})) {
      all.push_back(step.wheels.left_m + step.gyro.turn_rate_rad_s);
      if (step.radar) all.push_back(step.radar->points.max_norm_m());
    }
    return all;
  });
  EXPECT_EQ(both[0], both[1]);
}

}  // namespace
}  // namespace wayfare::tests
