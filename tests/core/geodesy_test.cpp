#include <wayfare/core/geodesy.hpp>

#include <cmath>

#include <gtest/gtest.h>

namespace wayfare {
namespace {

using Eigen::Vector3d;

// TR8350.2, tables 3.1 and 3.3: semi-minor axis b, e² and the radius of curvature at the pole,
// a²/b. At the equator the meridian's is b²/a; at the pole both are equal.
TEST(Geodesy, TheEllipsoidHasThePublishedSizes) {
  EXPECT_NEAR(wgs84::kSemiMinorAxis_m, 6356752.3142, 1e-4);
  EXPECT_NEAR(wgs84::kEccentricitySquared, 6.69437999014e-3, 1e-14);
  EXPECT_NEAR(meridian_radius_m(0.0), 6335439.3273, 1e-4);
  EXPECT_NEAR(meridian_radius_m(1.0), 6399593.6258, 1e-4);
  EXPECT_NEAR(transverse_radius_m(0.0), 6378137.0, 1e-9);
  EXPECT_NEAR(transverse_radius_m(1.0), 6399593.6258, 1e-4);
}

// On the equator, a quarter turn from it and at the pole the position is on an axis.
TEST(Geodesy, TheAxesAreThoseOfEcef) {
  const auto at = [](double latitude_deg, double longitude_deg, double height_m) {
    return ecef_from_geodetic(
        {Angle::degrees(latitude_deg), Angle::degrees(longitude_deg), height_m});
  };
  EXPECT_LT((at(0, 0, 100) - Vector3d(6378237.0, 0, 0)).norm(), 1e-8);
  EXPECT_LT((at(0, 90, -50) - Vector3d(0, 6378087.0, 0)).norm(), 1e-8);
  EXPECT_LT((at(90, 0, 7) - Vector3d(0, 0, 6356759.3142)).norm(), 1e-4);
}

TEST(Geodesy, HeightIsAlongTheNormalOfTheEllipsoid) {
  constexpr double a = 6378137.0, b = 6356752.314245;
  for (const double latitude_deg : {-71.0, -20.0, 13.0, 48.7}) {
    const Angle latitude = Angle::degrees(latitude_deg), longitude = Angle::degrees(30.0);
    const double phi = latitude.radians(), lambda = longitude.radians();
    const Vector3d x = ecef_from_geodetic({latitude, longitude, 0.0});
    const double p = x.head<2>().norm();
    EXPECT_NEAR(p * p / (a * a) + x.z() * x.z() / (b * b), 1.0, 1e-12);
    // The normal at (p, z) is (p/a², z/b²).
    EXPECT_NEAR(std::atan2(x.z() / (b * b), p / (a * a)), phi, 1e-12);
    EXPECT_NEAR(std::atan2(x.y(), x.x()), lambda, 1e-12);
    const Vector3d normal(std::cos(phi) * std::cos(lambda), std::cos(phi) * std::sin(lambda),
                          std::sin(phi));
    const Vector3d above = ecef_from_geodetic({latitude, longitude, 1000.0});
    EXPECT_LT((above - x - 1000.0 * normal).norm(), 1e-8);
  }
}

TEST(Geodesy, EcefRoundTrip) {
  for (const double latitude_deg : {-90.0, -60.0, -1e-7, 0.0, 22.3, 45.0, 89.99})
    for (const double longitude_deg : {-179.9, -90.0, 0.0, 114.2})
      for (const double height_m : {-10000.0, 0.0, 400.0, 4e5, 2.02e7}) {
        const Geodetic p{Angle::degrees(latitude_deg), Angle::degrees(longitude_deg), height_m};
        const Geodetic back = geodetic_from_ecef(ecef_from_geodetic(p));
        EXPECT_NEAR(back.latitude.degrees(), latitude_deg, 1e-12) << height_m;
        EXPECT_NEAR(back.height_m, height_m, 5e-8) << latitude_deg;
        if (latitude_deg == -90.0) continue;  // a pole has every longitude
        EXPECT_NEAR(back.longitude.degrees(), longitude_deg, 1e-12) << latitude_deg;
      }
}

// TR8350.2, table 3.4, on the ellipsoid. Its change with height follows from Bruns' formula,
// dγ/dh = −γ (1/M + 1/N) − 2 ω², with which (4-3) agrees up to terms of f², 2e-10 s⁻²; the second
// derivative is that of the inverse square, 6 γ/a².
TEST(Geodesy, GravityFollowsBrunsFormula) {
  EXPECT_NEAR(normal_gravity_mps2(0.0, 0.0), 9.7803253359, 1e-10);
  EXPECT_NEAR(normal_gravity_mps2(1.0, 0.0), 9.8321849378, 1e-9);
  EXPECT_NEAR(normal_gravity_mps2(-1.0, 0.0), 9.8321849378, 1e-9);
  constexpr double kEarthRate_radps = 7.292115e-5, kHeight_m = 10000.0;
  for (const double latitude_deg : {-90.0, -45.0, 0.0, 30.0, 60.0}) {
    const double s = std::sin(Angle::degrees(latitude_deg).radians());
    const double gamma = normal_gravity_mps2(s, 0.0);
    const double slope = (normal_gravity_mps2(s, 10.0) - normal_gravity_mps2(s, -10.0)) / 20.0;
    const double bruns = -gamma * (1.0 / meridian_radius_m(s) + 1.0 / transverse_radius_m(s)) -
                         2.0 * kEarthRate_radps * kEarthRate_radps;
    EXPECT_NEAR(slope, bruns, 2e-10) << latitude_deg;
    const double bend =
        normal_gravity_mps2(s, kHeight_m) + normal_gravity_mps2(s, -kHeight_m) - 2.0 * gamma;
    EXPECT_NEAR(bend * std::pow(6378137.0 / kHeight_m, 2) / gamma, 6.0, 1e-5) << latitude_deg;
  }
}

}  // namespace
}  // namespace wayfare
