#include <wayfare/gnss/single_point.hpp>

#include <cmath>
#include <limits>
#include <random>

#include <gmock/gmock.h>

#include "sky.hpp"

#include <wayfare/sensors/measurements.hpp>

namespace wayfare {
namespace {

using ::testing::HasSubstr;
using testing::SkyReceiver;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

SinglePointOptions without_air() {
  SinglePointOptions options;
  options.corrections.ionosphere = false;
  options.corrections.troposphere = false;
  return options;
}

double distance_m(const SinglePoint& p, const SkyReceiver& receiver) {
  return (p.position_ecef_m - ecef_from_geodetic(receiver.position)).norm();
}

bool is_used(const SinglePoint& p, SatelliteId satellite) {
  for (const SatelliteResidual& r : p.residuals)
    if (r.satellite == satellite) return r.range_used;
  return false;
}

RangeRefusal refusal_of(const SinglePoint& p, SatelliteId satellite) {
  for (const RefusedRange& r : p.refused)
    if (r.satellite == satellite) return r.why;
  ADD_FAILURE() << to_string(satellite) << " was not rejected";
  return {};
}

class SinglePointTest : public ::testing::Test {
 protected:
  Ephemerides messages_ = testing::sky_messages();
  SkyReceiver receiver_;
  ObservationEpoch epoch() const { return testing::sky_epoch(messages_, receiver_); }
  /// The satellites of one system alone, at most `count`.
  ObservationEpoch only(GnssSystem system, std::size_t count = 99) const {
    ObservationEpoch e = epoch();
    std::erase_if(e.satellites, [&](const auto& o) { return o.satellite.system != system; });
    if (e.satellites.size() > count) e.satellites.resize(count);
    return e;
  }
};

//! [single point]
TEST_F(SinglePointTest, PositionVelocityAndClocks) {
  receiver_.velocity_ned_mps = {12.0, -7.0, 0.5};
  const ObservationEpoch e = epoch();
  ASSERT_GE(e.satellites.size(), 20U);
  const Result<SinglePoint> p = single_point(e, messages_, without_air());
  ASSERT_TRUE(p) << p.error().to_string();
  EXPECT_LT(distance_m(*p, receiver_), 2e-4);
  ASSERT_TRUE(p->velocity_ned_mps);
  // The rate of the travel time neglects the receiver's motion: 14 m/s · 4 km/s / c.
  EXPECT_LT((*p->velocity_ned_mps - receiver_.velocity_ned_mps).norm(), 1e-3);
  for (std::size_t s = 0; s < 4; ++s)
    EXPECT_NEAR(p->clock_bias_m[s], receiver_.clock_m[s], 2e-3) << s;
  EXPECT_NEAR(p->clock_drift_mps, receiver_.drift_mps, 1e-3);
  EXPECT_TRUE(p->consistent);
  EXPECT_EQ(p->used, static_cast<int>(e.satellites.size()));
  EXPECT_EQ(p->degrees_of_freedom, p->used - 7);
  EXPECT_NEAR(to_seconds(p->instant - log_time(testing::sky_time())), 0.0, 2e-9);
  for (const SatelliteResidual& r : p->residuals) EXPECT_LT(std::abs(r.range_m), 1e-3);
}
//! [single point]

TEST_F(SinglePointTest, IsIndependentOfTheInitialPosition) {
  const Eigen::Vector3d there = ecef_from_geodetic(receiver_.position);
  for (const Eigen::Vector3d& near :
       {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(-there), Eigen::Vector3d(kNan, 0, 0),
        Eigen::Vector3d(there + Eigen::Vector3d(3e5, 1e5, 0)), there}) {
    const Result<SinglePoint> p = single_point(epoch(), messages_, without_air(), near);
    ASSERT_TRUE(p) << near.transpose() << ": " << p.error().to_string();
    EXPECT_LT(distance_m(*p, receiver_), 2e-4) << near.transpose();
  }
}

TEST_F(SinglePointTest, FaultsAreExcluded) {
  for (const double fault : {60.0, -200.0, 5000.0, 1e6}) {
    for (std::size_t faults = 1; faults <= 3; ++faults) {
      ObservationEpoch e = epoch();
      for (std::size_t i = 0; i < faults; ++i)
        e.satellites[5 * i + 1].pseudorange_m += fault * (1.0 + 0.3 * static_cast<double>(i));
      const Result<SinglePoint> p = single_point(e, messages_, without_air());
      ASSERT_TRUE(p) << fault << ' ' << p.error().to_string();
      EXPECT_LT(distance_m(*p, receiver_), 0.05) << fault << " on " << faults;
      EXPECT_TRUE(p->consistent);
      EXPECT_EQ(p->used, static_cast<int>(e.satellites.size() - faults));
      for (std::size_t i = 0; i < faults; ++i)
        EXPECT_FALSE(is_used(*p, e.satellites[5 * i + 1].satellite));
    }
  }
}

TEST_F(SinglePointTest, AFaultyDopplerIsExcluded) {
  ObservationEpoch e = epoch();
  e.satellites[2].doppler_hz += 200.0;
  e.satellites[3].doppler_hz = kNan;
  const Result<SinglePoint> p = single_point(e, messages_, without_air());
  ASSERT_TRUE(p && p->velocity_ned_mps);
  EXPECT_LT(p->velocity_ned_mps->norm(), 2e-3);
  EXPECT_FALSE(p->residuals[2].rate_used);
  EXPECT_TRUE(p->residuals[2].range_used);
  EXPECT_TRUE(p->residuals[3].range_used);
}

TEST_F(SinglePointTest, RejectionsHaveTheirReasons) {
  ObservationEpoch e = epoch();
  auto& s = e.satellites;
  s[0].pseudorange_m = 1e9;
  s[1].pseudorange_m = -1e8;
  s[2].pseudorange_m = s[2].doppler_hz = kNan;
  s[3].pseudorange_m = std::numeric_limits<double>::infinity();
  s[3].doppler_hz = kNan;
  const SatelliteObservation twice = s[4];
  s.push_back(twice);
  s.back().pseudorange_m += 300.0;
  s.push_back({{GnssSystem::gps, 32}, 2.2e7, 0.0, kNan, 45.0, carrier::kL1});
  s[6].cn0_dbhz = 12.0;
  SinglePointOptions options = without_air();
  options.corrections.min_cn0_dbhz = 20.0;
  options.corrections.excluded = {s[7].satellite};
  const Result<SinglePoint> p = single_point(e, messages_, options);
  ASSERT_TRUE(p) << p.error().to_string();
  EXPECT_LT(distance_m(*p, receiver_), 2e-4);
  EXPECT_EQ(refusal_of(*p, s[0].satellite), RangeRefusal::implausible);
  EXPECT_EQ(refusal_of(*p, s[1].satellite), RangeRefusal::implausible);
  EXPECT_EQ(refusal_of(*p, s[2].satellite), RangeRefusal::not_measured);
  EXPECT_EQ(refusal_of(*p, s[3].satellite), RangeRefusal::not_measured);
  EXPECT_EQ(refusal_of(*p, twice.satellite), RangeRefusal::duplicate);
  EXPECT_EQ(refusal_of(*p, {GnssSystem::gps, 32}), RangeRefusal::no_ephemeris);
  EXPECT_EQ(refusal_of(*p, s[6].satellite), RangeRefusal::weak);
  EXPECT_EQ(refusal_of(*p, s[7].satellite), RangeRefusal::not_wanted);
  // With another elevation mask.
  options.corrections.elevation_mask = Angle::degrees(89.0);
  EXPECT_FALSE(single_point(e, messages_, options));
}

TEST_F(SinglePointTest, UnhealthyAndOldMessages) {
  ObservationEpoch e = epoch();
  const SatelliteId sick = e.satellites[0].satellite;
  KeplerianEphemeris k = testing::sky_message(sick.system, sick.number);
  k.health = 63;
  ASSERT_TRUE(messages_.add(k));
  const Result<SinglePoint> p = single_point(e, messages_, without_air());
  ASSERT_TRUE(p);
  EXPECT_EQ(refusal_of(*p, sick), RangeRefusal::unhealthy);
  // An epoch off by a week roll-over finds no message, and reports that.
  e.time += 1024 * kGpsWeek;
  const Result<SinglePoint> late = single_point(e, messages_, without_air());
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().code, ErrorCode::degenerate);
  std::vector<RefusedRange> refused;
  EXPECT_TRUE(correct_ranges(e, messages_, {}, {}, &refused).satellites.empty());
  EXPECT_EQ(refused.front().why, RangeRefusal::ephemeris_too_far);
  EXPECT_EQ(refused.size(), e.satellites.size());
}

TEST_F(SinglePointTest, FewSatellites) {
  const auto answer = [&](std::size_t count) {
    SinglePointOptions options = without_air();
    options.max_pdop = 1e6;
    return single_point(only(GnssSystem::gps, count), messages_, options);
  };
  const Result<SinglePoint> four = answer(4);
  ASSERT_TRUE(four) << four.error().to_string();
  EXPECT_LT(distance_m(*four, receiver_), 1e-3);
  EXPECT_EQ(four->degrees_of_freedom, 0);
  const Result<SinglePoint> three = answer(3);
  ASSERT_FALSE(three);
  EXPECT_EQ(three.error().code, ErrorCode::degenerate);
  EXPECT_THAT(three.error().message, HasSubstr("needs 4 satellites, there are 3 (3 of GPS)"));
  EXPECT_FALSE(answer(0));
  EXPECT_FALSE(single_point(ObservationEpoch{}, messages_));
  EXPECT_FALSE(single_point(RangeEpoch{}));
  // Two of each of two systems: five unknowns.
  ObservationEpoch mixed = only(GnssSystem::gps, 2);
  for (const auto& o : only(GnssSystem::galileo, 2).satellites) mixed.satellites.push_back(o);
  const Result<SinglePoint> two = single_point(mixed, messages_, without_air());
  ASSERT_FALSE(two);
  EXPECT_THAT(two.error().message, HasSubstr("2 of GPS, 2 of Galileo"));
  // A known clock offset is the fifth equation.
  SinglePointOptions options = without_air();
  options.offsets[2] = ClockOffset{receiver_.clock_m[2] - receiver_.clock_m[0], 0.1};
  options.max_pdop = 1e3;
  const Result<SinglePoint> known = single_point(mixed, messages_, options);
  ASSERT_TRUE(known) << known.error().to_string();
  EXPECT_LT(distance_m(*known, receiver_), 0.01);
}

TEST_F(SinglePointTest, PoorGeometryIsAnError) {
  // All in nearly one direction.
  RangeEpoch ranges;
  const Eigen::Vector3d here = ecef_from_geodetic(receiver_.position);
  for (int i = 0; i < 6; ++i) {
    CorrectedRange r;
    r.satellite = {GnssSystem::gps, static_cast<std::uint8_t>(i + 1)};
    r.position_ecef_m = here + 2.2e7 * (here.normalized() +
                                        1e-3 * Eigen::Vector3d(std::sin(i), std::cos(i), 0.1 * i))
                                           .normalized();
    r.range_m = (r.position_ecef_m - here).norm();
    ranges.satellites.push_back(r);
  }
  const Result<SinglePoint> p = single_point(ranges, {}, here);
  ASSERT_FALSE(p);
  EXPECT_EQ(p.error().code, ErrorCode::degenerate);
  // Six times the same direction.
  for (CorrectedRange& r : ranges.satellites) r.position_ecef_m = here + 2.2e7 * here.normalized();
  EXPECT_FALSE(single_point(ranges, {}, here));
}

TEST_F(SinglePointTest, InconsistencyIsReportedOrAnError) {
  ObservationEpoch e = only(GnssSystem::gps, 6);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> far(-800.0, 800.0);
  for (auto& o : e.satellites) o.pseudorange_m += far(random);
  SinglePointOptions options = without_air();
  options.exclude_faults = false;
  const Result<SinglePoint> p = single_point(e, messages_, options);
  ASSERT_TRUE(p) << p.error().to_string();
  EXPECT_FALSE(p->consistent);
  EXPECT_GT(std::sqrt(p->position_covariance_ned_m2.trace()), 100.0);  // covers the error
  options.answer_inconsistent = false;
  const Result<SinglePoint> none = single_point(e, messages_, options);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::invalid);
}

TEST_F(SinglePointTest, InconsistenciesOfAnySizeGiveASolutionOrAnError) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> exponent(0.0, 7.0), sign(-1.0, 1.0);
  for (int i = 0; i < 100; ++i) {
    ObservationEpoch e =
        i % 2 == 0 ? epoch() : only(GnssSystem::gps, 4 + static_cast<std::size_t>(i % 5));
    for (auto& o : e.satellites) {
      o.pseudorange_m += sign(random) * std::pow(10.0, exponent(random));
      o.doppler_hz += sign(random) * std::pow(10.0, exponent(random));
    }
    const Result<SinglePoint> p = single_point(e, messages_, without_air());
    if (!p) continue;
    EXPECT_GE(p->used, 4) << i;
    EXPECT_TRUE(p->position_ecef_m.allFinite() && p->position_covariance_ned_m2.allFinite()) << i;
    EXPECT_GT(p->position_covariance_ned_m2.diagonal().minCoeff(), 0.0) << i;
  }
}

TEST_F(SinglePointTest, ErrorsMatchTheCovariance) {
  // 400 epochs with the modelled noise: the normalised squared error has the mean of χ² with 3
  // degrees of freedom, 3 ± 4 · √(6 / 400) = 0.49, the sum of squares that of its own degrees of
  // freedom, and about one in a thousand is a false alarm.
  std::mt19937 random(9);
  std::normal_distribution<double> noise;
  const SinglePointOptions options = without_air();
  const ObservationEpoch exact = epoch();
  double nees = 0.0, velocity_nees = 0.0, squares = 0.0;
  int faulty = 0;
  constexpr int kRuns = 400;
  for (int i = 0; i < kRuns; ++i) {
    ObservationEpoch e = exact;
    for (auto& o : e.satellites) {
      const Ephemeris& message = messages_.of(o.satellite).front();
      const LineOfSight sight = line_of_sight(
          receiver_.position, satellite_state(message, testing::sky_time()).position_ecef_m);
      const RangeSigmaModel& sigma = options.corrections.sigma;
      o.pseudorange_m += noise(random) * sigma.range_m(sight.elevation_rad, o.cn0_dbhz);
      o.doppler_hz += noise(random) * sigma.rate_mps(sight.elevation_rad, o.cn0_dbhz) *
                      o.carrier_hz / kSpeedOfLight_mps;
    }
    const Result<SinglePoint> p = single_point(e, messages_, options);
    ASSERT_TRUE(p);
    const Eigen::Vector3d error = ned_from_geodetic(p->position, receiver_.position);
    nees += error.dot(p->position_covariance_ned_m2.inverse() * error) / kRuns;
    velocity_nees +=
        p->velocity_ned_mps->dot(p->velocity_covariance_ned.inverse() * *p->velocity_ned_mps) /
        kRuns;
    squares += p->chi_square / p->degrees_of_freedom / kRuns;
    faulty += p->used < static_cast<int>(e.satellites.size()) ? 1 : 0;
  }
  EXPECT_NEAR(nees, 3.0, 0.5);
  EXPECT_NEAR(velocity_nees, 3.0, 0.5);
  EXPECT_NEAR(squares, 1.0, 0.06);
  EXPECT_LE(faulty, 4);
}

TEST_F(SinglePointTest, EstimatesSystemOffsets) {
  SystemOffsets offsets;
  EXPECT_FALSE(offsets.of(GnssSystem::galileo));
  Result<SinglePoint> p = single_point(epoch(), messages_, without_air());
  ASSERT_TRUE(p);
  for (int i = 0; i < 30; ++i) {
    if (i == 20) p->clock_bias_m[2] += 1000.0;  // an outlier has no effect
    offsets.learn(*p);
    if (i == 20) p->clock_bias_m[2] -= 1000.0;
  }
  for (const GnssSystem system : kAllGnssSystems) ASSERT_TRUE(offsets.of(system));
  EXPECT_NEAR(offsets.of(GnssSystem::galileo)->offset_m, 12.0, 0.1);
  EXPECT_NEAR(offsets.of(GnssSystem::glonass)->offset_m, 60.0, 0.1);
  EXPECT_NEAR(offsets.of(GnssSystem::beidou)->offset_m, -15.0, 0.1);
  // All ranges on one clock are consistent for a filter with a single clock.
  const Eigen::Vector3d here = ecef_from_geodetic(receiver_.position);
  RangeCorrectionOptions no_air = without_air().corrections;
  const RangeEpoch ranges = correct_ranges(epoch(), messages_, here, no_air);
  for (const CorrectedRange& r : on_one_clock(ranges, offsets).satellites) {
    EXPECT_NEAR(r.range_m - (r.position_ecef_m - here).norm(), 250.0, 0.2);
    EXPECT_GE(r.range_sigma_m, 0.5);
  }
  for (const CorrectedRange& r : on_one_clock(ranges, SystemOffsets()).satellites)
    EXPECT_EQ(std::isfinite(r.range_m), r.satellite.system == GnssSystem::gps);
}

TEST_F(SinglePointTest, AtmosphereIsRemovedByTheSimulatedModel) {
  messages_.gps_ionosphere = nominal_ionosphere();
  ObservationEpoch e = epoch();
  for (auto& o : e.satellites) {
    const SatelliteState s =
        satellite_state(messages_.of(o.satellite).front(), testing::sky_time());
    const LineOfSight sight = line_of_sight(receiver_.position, s.position_ecef_m);
    o.pseudorange_m += troposphere_delay_m(receiver_.position, sight) +
                       ionosphere_delay_m(*messages_.gps_ionosphere, e.time, receiver_.position,
                                          sight, o.carrier_hz);
  }
  const Result<SinglePoint> p = single_point(e, messages_);
  ASSERT_TRUE(p);
  // Satellites move by 300 m in 80 ms, 1e-5 rad as seen from the ground: 1e-3 m of delay.
  EXPECT_LT(distance_m(*p, receiver_), 5e-3);
}

TEST(ChiSquare, Thresholds) {
  // Tabulated upper quantiles of χ²; the approximation is good to 3 %.
  EXPECT_NEAR(chi_square_threshold(1, 0.05), 3.841, 0.115);
  EXPECT_NEAR(chi_square_threshold(5, 0.001), 20.515, 0.4);
  EXPECT_NEAR(chi_square_threshold(10, 0.001), 29.588, 0.6);
  EXPECT_NEAR(chi_square_threshold(30, 0.5), 29.336, 0.05);
}

}  // namespace
}  // namespace wayfare
