// Names, ephemerides, atmosphere and range corrections with values that no satellite sends.

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/gnss/correct_ranges.hpp>
#include <wayfare/gnss/ephemerides.hpp>

#include "abuse/abuse.hpp"
#include "gnss/sky.hpp"

namespace wayfare {
namespace {

using namespace tests;
using testing::sky_glonass;
using testing::sky_message;
using testing::sky_time;

const Time<GpsClock> kFirst = Time<GpsClock>() + Duration::min();
const Time<GpsClock> kLast = Time<GpsClock>() + Duration::max();

TEST(GnssNamesAbuse, NoOtherTextIsASatellite) {
  for (const char* text : {"", " ", "G", "G0", "G00", "G1 ", "J01", "g01", "G-1", "G+1", "GG1",
                           "G001", "\xff\xff\xff", "  0", "0x1"})
    EXPECT_FALSE(parse_satellite(text)) << text;
  EXPECT_FALSE(parse_satellite(std::string_view("G\0001", 3)));
  EXPECT_FALSE(parse_satellite(std::string(1'000'000, 'G')));
  EXPECT_EQ(to_string({GnssSystem::beidou, 255}), "C255");
  for (int band = -128; band < 128; ++band)
    for (const GnssSystem system : kAllGnssSystems) {
      const auto hz = carrier_hz(system, static_cast<char>(band), std::numeric_limits<int>::max());
      EXPECT_TRUE(!hz || std::isfinite(*hz));
    }
}

std::vector<double KeplerianEphemeris::*> kepler_values() {
  using K = KeplerianEphemeris;
  return {&K::sqrt_semi_major_axis,
          &K::eccentricity,
          &K::mean_anomaly_rad,
          &K::mean_motion_difference_radps,
          &K::inclination_rad,
          &K::inclination_rate_radps,
          &K::ascending_node_rad,
          &K::ascending_node_rate_radps,
          &K::argument_of_perigee_rad,
          &K::cuc_rad,
          &K::cus_rad,
          &K::crc_m,
          &K::crs_m,
          &K::cic_rad,
          &K::cis_rad,
          &K::clock_bias_s,
          &K::clock_drift,
          &K::clock_drift_rate_per_s};
}

TEST(EphemeridesAbuse, NoValueOfAMessageMayBeNotFiniteOrHuge) {
  Ephemerides all;
  const auto refused = [&](const Ephemeris& e) {
    const auto added = all.add(e);
    return !added && added.error().code == ErrorCode::invalid && all.empty();
  };
  std::vector<double> bad(kNotFinite.begin(), kNotFinite.end());
  bad.insert(bad.end(), {kHuge, -kHuge, 1e9});
  for (const auto value : kepler_values()) {
    for (const double x : bad) {
      KeplerianEphemeris k = sky_message(GnssSystem::gps, 5);
      k.*value = x;
      EXPECT_TRUE(refused(k)) << x;
    }
  }
  for (const double x : bad) {
    for (const int i : {0, 1}) {
      KeplerianEphemeris k = sky_message(GnssSystem::galileo, 5);
      k.group_delay_s[i] = x;
      EXPECT_TRUE(refused(k)) << x;
      GlonassEphemeris g = sky_glonass(3);
      (i == 0 ? g.position_m : g.velocity_mps)[1] = x;
      EXPECT_TRUE(refused(g)) << x;
      g = sky_glonass(3);
      (i == 0 ? g.clock_bias_s : g.clock_drift) = x;
      EXPECT_TRUE(refused(g)) << x;
    }
  }
  EXPECT_TRUE(refused(KeplerianEphemeris{}));
  EXPECT_TRUE(refused(GlonassEphemeris{}));
  EXPECT_TRUE(refused(sky_message(GnssSystem::glonass, 5)));
}

TEST(EphemeridesAbuse, MessagesOfAnyTimeAreFoundAtAnyTime) {
  Ephemerides all;
  for (const Time<GpsClock> toe : {kFirst, kLast, sky_time()}) {
    KeplerianEphemeris k = sky_message(GnssSystem::gps, 5);
    k.toe = k.toc = toe;
    GlonassEphemeris g = sky_glonass(3);
    g.toe = toe;
    ASSERT_TRUE(all.add(k) && all.add(g));
  }
  for (const Time<GpsClock> time : {kFirst, kLast, sky_time(), Time<GpsClock>()}) {
    for (const SatelliteId id : all.satellites()) {
      const Ephemeris* nearest = all.nearest(id, time);
      ASSERT_NE(nearest, nullptr);
      if (time != Time<GpsClock>()) {
        EXPECT_EQ(reference_time(*nearest), time);
      }
      for (const Ephemeris& e : all.of(id)) {
        const SatelliteState s = satellite_state(e, time);
        EXPECT_TRUE(time != reference_time(e) || s.position_ecef_m.norm() > 2e7);
        EXPECT_TRUE(std::isfinite(s.clock_s));
      }
    }
  }
  EXPECT_EQ(all.nearest({GnssSystem::gps, 6}, sky_time()), nullptr);
  EXPECT_EQ(Ephemerides().nearest({GnssSystem::gps, 6}, kLast), nullptr);
}

TEST(EphemeridesAbuse, AnOrbitOfYearsAgoIsNotANumber) {
  const GlonassEphemeris g = sky_glonass(3);
  const auto after = [&](double s, double step_s = 60.0) {
    return satellite_state(g, g.toe + from_seconds(s), step_s).position_ecef_m;
  };
  EXPECT_TRUE(after(86400.0).allFinite());
  EXPECT_TRUE(after(-86400.0).allFinite());
  EXPECT_TRUE(after(10.0, kHuge).allFinite());
  EXPECT_FALSE(after(1e9).allFinite());
  EXPECT_FALSE(after(10.0, 1e-9).allFinite());
  EXPECT_FALSE(after(10.0, kTiny).allFinite());
  EXPECT_DEATH(static_cast<void>(after(10.0, 0.0)), "the step is positive");
}

TEST(EphemeridesAbuse, AddsItselfAndItsOwnMessages) {
  Ephemerides all = testing::sky_messages();
  const std::size_t size = all.size();
  all.add(all);
  EXPECT_EQ(all.size(), size);
  for (const SatelliteId id : all.satellites()) EXPECT_TRUE(all.add(all.of(id).front()));
  EXPECT_EQ(all.size(), size);
  expect_value_semantics(all, [](Ephemerides& e) {
    KeplerianEphemeris k = sky_message(GnssSystem::gps, 31);
    EXPECT_TRUE(e.add(k));
    const Ephemeris* nearest = e.nearest({GnssSystem::gps, 7}, sky_time());
    return std::tuple(e.size(), satellite_state(*nearest, sky_time()).position_ecef_m.norm());
  });
}

TEST(AtmosphereAbuse, ExtremePlacesTimesAndDirectionsGiveNoDelayOrAFiniteOne) {
  for (const double latitude : {-90.0, -89.999, 0.0, 90.0}) {
    for (const double height : {-1e9, -100.0, 0.0, 1e4, 4e5, 1e9, kHuge}) {
      const Geodetic at{Angle::degrees(latitude), Angle::degrees(-180.0), height};
      for (const double elevation : {-1.5, 0.0, kTiny, 1e-6, 1.5}) {
        for (const Time<GpsClock> time : {kFirst, kLast, sky_time()}) {
          const LineOfSight sight{6.0, elevation};
          const double delay =
              ionosphere_delay_m(nominal_ionosphere(), time, at, sight, carrier::kL1) +
              troposphere_delay_m(at, sight);
          EXPECT_TRUE(delay >= 0.0 && delay < 200.0) << latitude << ' ' << height << ' ' << delay;
        }
      }
    }
  }
  KlobucharModel strange = nominal_ionosphere();
  strange.alpha.fill(-kHuge), strange.beta.fill(-kHuge);
  EXPECT_LT(ionosphere_delay_m(strange, sky_time(), {}, {1.0, 1.0}, carrier::kL1), 10.0);
}

TEST(RangeCorrectionAbuse, BadObservationsAreRefusedWithTheirReason) {
  const Ephemerides messages = testing::sky_messages();
  const ObservationEpoch good = testing::sky_epoch(messages, {});
  const Eigen::Vector3d here = ecef_from_geodetic(testing::SkyReceiver{}.position);
  const std::size_t all = correct_ranges(good, messages, here).satellites.size();
  ASSERT_GT(all, 8U);
  const auto count = [&](const std::function<void(SatelliteObservation&)>& spoil,
                         RangeRefusal expected) {
    ObservationEpoch epoch = good;
    spoil(epoch.satellites[1]);
    std::vector<RefusedRange> refused;
    const RangeEpoch ranges = correct_ranges(epoch, messages, here, {}, &refused);
    EXPECT_TRUE(std::any_of(refused.begin(), refused.end(),
                            [&](const RefusedRange& r) { return r.why == expected; }));
    EXPECT_EQ(ranges.satellites.size(), all - 1);
  };
  for (const double x : kNotFinite)
    count([&](auto& o) { o.pseudorange_m = o.doppler_hz = x; }, RangeRefusal::not_measured);
  for (const double x : {kHuge, -kHuge, 1e9, -1e9})
    count([&](auto& o) { o.pseudorange_m = x; }, RangeRefusal::implausible);
  count([&](auto& o) { o.satellite = good.satellites[0].satellite; }, RangeRefusal::duplicate);
  count([&](auto& o) { o.satellite.number = 255; }, RangeRefusal::no_ephemeris);
}

TEST(RangeCorrectionAbuse, StrangeReceiversAndTimesDoNoHarm) {
  const Ephemerides messages = testing::sky_messages();
  ObservationEpoch epoch = testing::sky_epoch(messages, {});
  const std::size_t unknown =
      correct_ranges(epoch, messages, Eigen::Vector3d::Zero()).satellites.size();
  for (const double x : {kNan, kInf, kHuge, 1e9, 1e-300, 0.0}) {
    const RangeEpoch ranges = correct_ranges(epoch, messages, Eigen::Vector3d::Constant(x));
    EXPECT_EQ(ranges.satellites.size(), unknown) << x;
    for (const CorrectedRange& r : ranges.satellites) EXPECT_TRUE(std::isfinite(r.range_m));
  }
  for (const Time<GpsClock> time : {kFirst, kLast, Time<GpsClock>()}) {
    epoch.time = time;
    std::vector<RefusedRange> refused;
    EXPECT_TRUE(
        correct_ranges(epoch, messages, Eigen::Vector3d::Zero(), {}, &refused).satellites.empty());
    for (const RefusedRange& r : refused) EXPECT_EQ(r.why, RangeRefusal::ephemeris_too_far);
  }
  EXPECT_TRUE(correct_ranges({}, messages, Eigen::Vector3d::Zero()).satellites.empty());
  EXPECT_TRUE(correct_ranges(epoch, {}, Eigen::Vector3d::Zero()).satellites.empty());
  const RangeSigmaModel sigma;
  for (const double x : {kNan, kInf, -kInf, kHuge, -kHuge})
    EXPECT_TRUE(std::isfinite(sigma.range_m(0.5, x)) && std::isfinite(sigma.rate_mps(0.5, x)));
}

}  // namespace
}  // namespace wayfare
