// Faulty measurements in one simulated drive: the filter must report them, stay finite, and be
// within a few metres at the end.

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include <wayfare/gnss/correct_ranges.hpp>
#include <wayfare/nav/gnss_ins.hpp>
#include "gnss_ins_support.hpp"

namespace wayfare {
namespace {

constexpr double kLength_s = 120.0;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

struct Recorded {
  tests::Drive drive;
  tests::Simulated truth;
  GnssInsRecording recording;
};

const Recorded& good() {
  static const Recorded made = [] {
    Recorded r;
    r.truth = tests::simulate(r.drive, kLength_s);
    r.recording.imu = r.truth.imu;
    r.recording.ranges = tests::simulate_ranges(r.drive, r.truth, 1.0, {}, 3);
    return r;
  }();
  return made;
}

/// Horizontal error at the last point, m.
double final_error_m(const GnssInsResult& result) {
  const NavState& end = result.points.back().nav;
  const NavTrajectory& truth = good().truth.truth;
  for (auto t = truth.rbegin(); t != truth.rend(); ++t)
    if (t->time <= end.time) return ned_from_geodetic(end.position, t->position).head<2>().norm();
  return kNan;
}

void expect_finite(const GnssInsResult& result) {
  for (const GnssInsPoint& p : result.points) {
    ASSERT_TRUE(p.nav.velocity_ned_mps.allFinite());
    ASSERT_TRUE(std::isfinite(p.nav.position.latitude.radians()));
    ASSERT_TRUE(std::isfinite(p.nav.position.height_m));
    ASSERT_TRUE(p.sigma.allFinite());
    ASSERT_GE(p.sigma.minCoeff(), 0.0F);
  }
}

/// Runs the drive modified by `corrupt`; the filter must finish.
GnssInsResult survives(const std::function<void(GnssInsRecording&)>& corrupt,
                       double within_m = 5.0) {
  GnssInsRecording recording = good().recording;
  corrupt(recording);
  const auto result = run_gnss_ins(recording, {});
  EXPECT_TRUE(result) << result.error().to_string();
  if (!result) return {};
  expect_finite(*result);
  EXPECT_LT(final_error_m(*result), within_m);
  return *result;
}

TEST(GnssInsDamage, WithoutFaults) {
  survives([](GnssInsRecording&) {}, 3.0);
}

TEST(GnssInsDamage, RepeatedAndSwappedEpochs) {
  const GnssInsResult result = survives([](GnssInsRecording& r) {
    for (std::size_t i = 30; i + 1 < r.ranges.size(); i += 10) {
      std::swap(r.ranges[i], r.ranges[i + 1]);
      r.ranges.insert(r.ranges.begin() + static_cast<std::ptrdiff_t>(i) + 3, r.ranges[i + 3]);
    }
  });
  EXPECT_FALSE(result.notices.empty());
}

TEST(GnssInsDamage, ImplausibleRanges) {
  for (const double wrong_m : {60.0, 1e4, -3e7, 1e12, 1e300}) {
    SCOPED_TRACE(wrong_m);
    const GnssInsResult result = survives([&](GnssInsRecording& r) {
      for (std::size_t i = 25; i < r.ranges.size(); ++i)
        r.ranges[i].satellites[2].range_m += wrong_m;
    });
    std::size_t offered = 0, accepted = 0;
    for (const InnovationRecord& i : result.innovations) {
      if (i.kind != InnovationRecord::Kind::range || i.satellite.number != 3) continue;
      if (i.time.seconds() < 26.5) continue;
      ++offered;
      accepted += i.accepted ? 1 : 0;
    }
    EXPECT_LT(accepted, 1 + offered / 20);
  }
}

TEST(GnssInsDamage, HalfTheSatellitesFaultyTemporarily) {
  survives([](GnssInsRecording& r) {
    for (std::size_t i = 50; i < 60; ++i)
      for (std::size_t s = 0; s < 4; ++s)
        r.ranges[i].satellites[s].range_m += 500.0 + 300.0 * double(s);
  });
}

TEST(GnssInsDamage, NonFiniteValues) {
  survives([](GnssInsRecording& r) {
    for (std::size_t i = 100; i < r.imu.size(); i += 501) {
      r.imu[i].angular_rate_radps[i % 3] = kNan;
      r.imu[i + 1].specific_force_mps2[i % 3] = std::numeric_limits<double>::infinity();
    }
    for (std::size_t i = 5; i < r.ranges.size(); i += 3) {
      auto& s = r.ranges[i].satellites;
      s[0].range_m = kNan;
      s[1].range_rate_mps = kNan;
      s[2].position_ecef_m.x() = kNan;
      s[3].velocity_ecef_mps.y() = kNan;
      s[4].range_sigma_m = i % 2 == 0 ? kNan : 0.0;
      s[5].range_rate_sigma_mps = -1.0;
    }
    r.ranges[40].satellites.clear();
    for (CorrectedRange& s : r.ranges[41].satellites) s.range_m = s.range_rate_mps = kNan;
  });
}

TEST(GnssInsDamage, HugeReading) {
  survives([](GnssInsRecording& r) {
    r.imu[6000].specific_force_mps2 = {1e9, -1e9, 1e9};
    r.imu[7000].angular_rate_radps = {1e6, 0.0, 0.0};
  });
}

TEST(GnssInsDamage, EmptyInputIsAnError) {
  const GnssInsRecording& r = good().recording;
  const auto fails = [](const GnssInsRecording& recording) {
    const auto result = run_gnss_ins(recording, {});
    EXPECT_FALSE(result);
    EXPECT_TRUE(result || !result.error().message.empty());
  };
  fails({});
  GnssInsRecording only_imu, only_ranges = r, another_week = r;
  only_imu.imu = r.imu;
  fails(only_imu);
  only_ranges.imu.clear();
  fails(only_ranges);
  for (RangeEpoch& e : another_week.ranges) e.time += std::chrono::hours(24 * 7);
  fails(another_week);
  for (RangeEpoch& e : another_week.ranges) e.time = e.time - std::chrono::hours(24 * 14);
  fails(another_week);
}

TEST(GnssInsDamage, WithoutEphemeridesThereAreNoRanges) {
  ObservationEpoch epoch{Time<GpsClock>::from_seconds(1.4e9), {}};
  for (std::uint8_t n = 1; n <= 8; ++n) {
    SatelliteObservation o;
    o.satellite = {GnssSystem::gps, n};
    o.pseudorange_m = 2.2e7 + 1e5 * n;
    epoch.satellites.push_back(o);
  }
  std::vector<RefusedRange> refused;
  const RangeEpoch ranges =
      correct_ranges(epoch, Ephemerides{}, Eigen::Vector3d(6.4e6, 0.0, 0.0), {}, &refused);
  EXPECT_TRUE(ranges.satellites.empty());
  ASSERT_EQ(refused.size(), 8U);
  for (const RefusedRange& r : refused) EXPECT_EQ(r.why, RangeRefusal::no_ephemeris);
}

}  // namespace
}  // namespace wayfare
