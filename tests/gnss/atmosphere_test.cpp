// Values computed by hand from the published formulas; rtklib_test.cpp compares with RTKLIB.

#include <wayfare/gnss/range_model.hpp>

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include <wayfare/gnss/ephemerides.hpp>
#include <wayfare/gnss/gps_time.hpp>

namespace wayfare {
namespace {

constexpr double kPi = std::numbers::pi;

Geodetic place(double latitude_deg, double longitude_deg, double height_m = 0.0) {
  return {Angle::degrees(latitude_deg), Angle::degrees(longitude_deg), height_m};
}
LineOfSight zenith() { return {0.0, 0.5 * kPi}; }
Time<GpsClock> of_week(double s) { return gps_time(2200, from_seconds(s)); }

// At the zenith E = ½ semicircle: ψ = 0.0137/0.61 − 0.022 = 0.000459 semicircles, the slant factor
// 1 + 16·0.03³ = 1.000432.
constexpr double kSlantAtZenith = 1.000432;

TEST(Ionosphere, AtNightIsFiveNanoseconds) {
  KlobucharModel model;
  model.alpha[0] = 2e-8;
  const double delay =
      ionosphere_delay_m(model, of_week(2 * 3600), place(10, 0), zenith(), carrier::kL1);
  EXPECT_NEAR(delay, 5e-9 * kSlantAtZenith * kSpeedOfLight_mps, 1e-12);
  EXPECT_NEAR(delay, 1.49961, 1e-5);
}

// At Greenwich towards the zenith local time is the time of day; the delay peaks at 14 h with the
// amplitude α₀ and falls as 1 − x²/2 + x⁴/24, with x = 1 at 72000 s/2π later, for the minimum
// period.
TEST(Ionosphere, PeaksAtTwoInTheAfternoon) {
  KlobucharModel model;
  model.alpha[0] = 2e-8;
  const double day_s = 3 * 86400.0;
  const auto at = [&](double s) {
    return ionosphere_delay_m(model, of_week(day_s + s), place(10, 0), zenith(), carrier::kL1) /
           (kSlantAtZenith * kSpeedOfLight_mps);
  };
  EXPECT_NEAR(at(50400.0), 25e-9, 1e-20);
  const double quarter_s = 72000.0 / (2.0 * kPi);
  EXPECT_NEAR(at(50400.0 + quarter_s), 5e-9 + 2e-8 * (1.0 - 0.5 + 1.0 / 24.0), 1e-16);
  EXPECT_NEAR(at(50400.0 - quarter_s), at(50400.0 + quarter_s), 1e-16);
  EXPECT_NEAR(at(50400.0 + 1.58 * quarter_s), 5e-9, 1e-20);
  model.beta[0] = 144000.0;  // doubled: at the same time x = ½
  EXPECT_NEAR(at(50400.0 + quarter_s), 5e-9 + 2e-8 * (1.0 - 0.125 + 1.0 / 384.0), 1e-16);
}

// Local time is 4 minutes per degree of longitude: 90° east peaks at 8 h, 90° west at 20 h.
TEST(Ionosphere, LocalTimeDependsOnLongitude) {
  KlobucharModel model;
  model.alpha[0] = 2e-8;
  for (const double longitude : {-90.0, 0.0, 90.0, 179.0}) {
    const double peak_s = 50400.0 - longitude * 240.0;
    EXPECT_NEAR(ionosphere_delay_m(model, of_week(peak_s + 86400.0), place(0, longitude), zenith(),
                                   carrier::kL1),
                25e-9 * kSlantAtZenith * kSpeedOfLight_mps, 1e-9);
  }
}

// φ_m = φ_i + 0.064 cos((λ_i − 1.617)π): at λ = 1.617 semicircles (−68.94°) and φ = 36°, so that
// φ_i = 0.2 + 0.000459, φ_m = 0.264459; each α is the coefficient of its power.
TEST(Ionosphere, AmplitudeIsACubicOfTheMagneticLatitude) {
  const double longitude = (1.617 - 2.0) * 180.0, magnetic = 0.2 + 0.0137 / 0.61 - 0.022 + 0.064;
  const double peak_s = 50400.0 - longitude * 240.0;
  for (std::size_t power = 0; power < 4; ++power) {
    KlobucharModel model;
    model.alpha[power] = 1e-7;
    const double want = 5e-9 + 1e-7 * std::pow(magnetic, static_cast<double>(power));
    EXPECT_NEAR(
        ionosphere_delay_m(model, of_week(peak_s), place(36, longitude), zenith(), carrier::kL1) /
            (kSlantAtZenith * kSpeedOfLight_mps),
        want, 1e-14);
    model.alpha[power] = -1e-7;  // no amplitude below zero
    EXPECT_NEAR(
        ionosphere_delay_m(model, of_week(peak_s), place(36, longitude), zenith(), carrier::kL1) /
            (kSlantAtZenith * kSpeedOfLight_mps),
        5e-9, 1e-20);
  }
}

TEST(Ionosphere, ScalesWithTheSquaredWavelengthAndTheSlant) {
  KlobucharModel model;
  const auto at = [&](double elevation_deg, double carrier_hz, double height_m = 0.0) {
    return ionosphere_delay_m(model, of_week(0), place(45, 7, height_m),
                              {1.0, elevation_deg * kPi / 180.0}, carrier_hz);
  };
  const double l1 = at(40, carrier::kL1), ratio = carrier::kL1 / carrier::kL2;
  EXPECT_NEAR(at(40, carrier::kL2), ratio * ratio * l1, 1e-12);
  // 18° is 0.1 semicircle: 1 + 16·0.43³ = 2.272112.
  EXPECT_NEAR(at(18, carrier::kL1), 5e-9 * 2.272112 * kSpeedOfLight_mps, 1e-9);
  EXPECT_EQ(at(0, carrier::kL1), 0.0);
  EXPECT_EQ(at(-5, carrier::kL1), 0.0);
  EXPECT_EQ(at(40, carrier::kL1, 500e3), 0.0);
  EXPECT_EQ(at(std::nan(""), carrier::kL1), 0.0);
}

// Dry air at sea level: 0.0022768·1013.25/(1 − 0.00266 cos 2φ) = 2.306968 m at 45°.
// Vapour at 288.16 K: 6.108·0.7·exp((17.15·288.16 − 4684)/249.71) = 12.0119 hPa, which gives
// 0.002277·(1255/288.16 + 0.05)·12.0119 = 0.120488 m.
TEST(Troposphere, AtTheZenithOfSeaLevel) {
  const double dry = 0.0022768 * 1013.25;
  EXPECT_NEAR(zenith_troposphere_delay_m(place(45, 0), 0.0), 2.306968, 1e-6);
  EXPECT_NEAR(zenith_troposphere_delay_m(place(0, 0), 0.0), dry / (1.0 - 0.00266), 1e-12);
  EXPECT_NEAR(zenith_troposphere_delay_m(place(-90, 0), 0.0), dry / (1.0 + 0.00266), 1e-12);
  EXPECT_NEAR(zenith_troposphere_delay_m(place(45, 0), 0.7) - 2.306968, 0.120488, 2e-6);
}

// At 2000 m the standard atmosphere has 794.9 hPa (ISO 2533: 795.0) and the wet part about a third.
TEST(Troposphere, ThinsWithHeight) {
  const auto at = [](double height_m, double humidity) {
    return zenith_troposphere_delay_m(place(45, 0, height_m), humidity);
  };
  EXPECT_NEAR(at(2000, 0.0) * (1.0 - 0.00028 * 2.0) / 0.0022768, 795.0, 0.3);
  EXPECT_LT(at(2000, 0.7) - at(2000, 0.0), 0.5 * (at(0, 0.7) - at(0, 0.0)));
  for (double h = 0; h < 9900; h += 100) EXPECT_GT(at(h, 0.7), at(h + 100, 0.7));
  EXPECT_EQ(at(-50, 0.7), at(0, 0.7));
  EXPECT_EQ(at(-101, 0.7), 0.0);
  EXPECT_EQ(at(10'001, 0.7), 0.0);
}

TEST(Troposphere, MappingIsTheCosecantExceptNearTheHorizon) {
  EXPECT_NEAR(troposphere_mapping(0.5 * kPi), 1.0, 1e-15);
  const auto against_cosecant = [](double degrees) {
    const double e = degrees * kPi / 180.0;
    return troposphere_mapping(e) * std::sin(e);
  };
  for (const double e : {20.0, 30.0, 60.0, 89.0}) EXPECT_NEAR(against_cosecant(e), 1.0, 0.01);
  EXPECT_NEAR(against_cosecant(10.0), 0.97, 0.005);
  EXPECT_NEAR(against_cosecant(5.0), 0.89, 0.005);
  EXPECT_EQ(troposphere_delay_m(place(45, 0), {0.0, -0.01}), 0.0);
  EXPECT_NEAR(troposphere_delay_m(place(45, 0), {0.0, kPi / 6.0}, 0.0),
              2.306968 * 1.001 / std::sqrt(0.252001), 1e-5);
}

TEST(LineOfSight, IsAzimuthAndElevationOfTheLocalLevel) {
  const Geodetic here = place(48, 9, 300);
  const auto seen = [&](double north, double east, double down) {
    return line_of_sight(here, ecef_from_geodetic(here) +
                                   rotation_ecef_ned(here) * Eigen::Vector3d(north, east, down));
  };
  EXPECT_NEAR(seen(0, 0, -2e7).elevation_rad, 0.5 * kPi, 1e-9);
  EXPECT_NEAR(seen(0, 1e7, -1e7).azimuth_rad, 0.5 * kPi, 1e-9);
  EXPECT_NEAR(seen(0, 1e7, -1e7).elevation_rad, 0.25 * kPi, 1e-9);
  EXPECT_NEAR(seen(-1e7, -1e7, 0).azimuth_rad, 1.25 * kPi, 1e-9);
  EXPECT_NEAR(seen(3e6, 0, 4e6).elevation_rad, -std::atan2(4.0, 3.0), 1e-9);
}

}  // namespace
}  // namespace wayfare
