// Geodesy against GeographicLib, from the Earth's centre to the satellites.
#include <wayfare/core/geodesy.hpp>

#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <GeographicLib/Geocentric.hpp>
#include <GeographicLib/LocalCartesian.hpp>
#include <GeographicLib/NormalGravity.hpp>

namespace wayfare {
namespace {

using GeographicLib::Geocentric;

Geodetic at(double latitude_deg, double longitude_deg, double height_m) {
  return {Angle::degrees(latitude_deg), Angle::degrees(longitude_deg), height_m};
}

/// Latitudes including poles and equator, heights from the sea floor to the satellites.
const double kLatitudes[] = {-90.0, -89.9999999, -60.0, -1e-7, 0.0, 1e-9, 22.3, 45.0, 89.99, 90.0};
const double kLongitudes[] = {-180.0, -90.0, -0.1, 0.0, 114.2, 179.999999};
const double kHeights[] = {-10000.0, 0.0, 400.0, 1e4, 4e5, 2.02e7, 4.2e7};

TEST(GeodesyOracle, EcefRoundTrip) {
  for (const double latitude : kLatitudes) {
    for (const double longitude : kLongitudes) {
      for (const double height : kHeights) {
        const Geodetic p = at(latitude, longitude, height);
        const Eigen::Vector3d ecef = ecef_from_geodetic(p);
        Eigen::Vector3d theirs;
        Geocentric::WGS84().Forward(latitude, longitude, height, theirs.x(), theirs.y(),
                                    theirs.z());
        EXPECT_LT((ecef - theirs).norm(), 2e-8) << latitude << ' ' << longitude << ' ' << height;
        double lat = 0.0, lon = 0.0, h = 0.0;
        Geocentric::WGS84().Reverse(theirs.x(), theirs.y(), theirs.z(), lat, lon, h);
        const Geodetic back = geodetic_from_ecef(theirs);
        EXPECT_NEAR(back.latitude.degrees(), lat, 1e-12) << height;
        EXPECT_NEAR(back.height_m, h, 5e-8);
        // Within a millimetre of the axis the longitude is arbitrary.
        if (std::abs(latitude) < 89.9999) {
          EXPECT_NEAR(std::remainder(back.longitude.degrees() - lon, 360.0), 0.0, 1e-12);
        }
      }
    }
  }
}

TEST(GeodesyOracle, RandomPointsUpToTheSatellites) {
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> radius(6.347e6, 4.3e7);
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3d ecef =
        radius(random) *
        Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
    double lat = 0.0, lon = 0.0, h = 0.0;
    Geocentric::WGS84().Reverse(ecef.x(), ecef.y(), ecef.z(), lat, lon, h);
    const Geodetic p = geodetic_from_ecef(ecef);
    ASSERT_NEAR(p.latitude.degrees(), lat, 1e-12) << ecef.transpose();
    ASSERT_NEAR(p.longitude.degrees(), lon, 1e-12) << ecef.transpose();
    ASSERT_NEAR(p.height_m, h, 5e-8) << ecef.transpose();
    ASSERT_LT((ecef_from_geodetic(p) - ecef).norm(), 5e-8);
  }
}

TEST(GeodesyOracle, CentreOfTheEarthIsAPole) {
  const Geodetic p = geodetic_from_ecef(Eigen::Vector3d::Zero());
  double lat = 0.0, lon = 0.0, h = 0.0;
  Geocentric::WGS84().Reverse(0.0, 0.0, 0.0, lat, lon, h);
  EXPECT_DOUBLE_EQ(lat, 90.0);
  EXPECT_NEAR(p.latitude.degrees(), lat, 1e-12);
  EXPECT_NEAR(p.height_m, h, 1e-8);
}

TEST(GeodesyOracle, LocalLevel) {
  for (const double latitude : kLatitudes) {
    const Geodetic origin = at(latitude, 114.2, 30.0);
    const GeographicLib::LocalCartesian local(latitude, 114.2, 30.0);
    for (const double away : {1.0, 1e3, 2e7}) {
      const Eigen::Vector3d ned(0.3 * away, -0.8 * away, -0.5 * away);
      const Geodetic p = geodetic_from_ned(ned, origin);
      double east = 0.0, north = 0.0, up = 0.0;
      local.Forward(p.latitude.degrees(), p.longitude.degrees(), p.height_m, east, north, up);
      const double tolerance = 2e-8 + 2e-15 * away;
      EXPECT_NEAR(north, ned.x(), tolerance) << latitude << ' ' << away;
      EXPECT_NEAR(east, ned.y(), tolerance) << latitude << ' ' << away;
      EXPECT_NEAR(-up, ned.z(), tolerance) << latitude << ' ' << away;
      EXPECT_LT((ned_from_geodetic(p, origin) - ned).norm(), tolerance);
    }
  }
}

TEST(GeodesyOracle, NormalGravity) {
  const auto& theirs = GeographicLib::NormalGravity::WGS84();
  for (const double latitude : kLatitudes) {
    const double s = std::sin(Angle::degrees(latitude).radians());
    EXPECT_NEAR(normal_gravity_mps2(s, 0.0), theirs.SurfaceGravity(latitude), 1e-9) << latitude;
    for (const double height : {-1000.0, 500.0, 5000.0, 1e4}) {
      double north = 0.0, down = 0.0;
      theirs.Gravity(latitude, height, north, down);
      // The series neglects 4 g (h/a)³, 1.5e-7 at 10 km, and the squared flattening of its first
      // term, about f² · 2 g h/a = 3.5e-7.
      EXPECT_NEAR(normal_gravity_mps2(s, height), std::hypot(north, down), 1e-6)
          << latitude << ' ' << height;
    }
  }
}

}  // namespace
}  // namespace wayfare
