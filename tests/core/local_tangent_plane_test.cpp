#include <wayfare/core/geodesy.hpp>

#include <gtest/gtest.h>

namespace wayfare {
namespace {

using Eigen::Vector3d;

const Geodetic kAnchors[] = {{Angle::degrees(48.7), Angle::degrees(9.1), 300.0},
                             {Angle::degrees(-33.9), Angle::degrees(179.99), 1600.0},
                             {Angle::degrees(68.0), Angle::degrees(-120.0), -50.0},
                             {Angle::degrees(0.0), Angle::degrees(0.0), 0.0}};
const Vector3d kOffsets[] = {{0, 0, 0}, {3.0, -2.0, 1.0}, {5000, -7000, 120}, {-15000, 9000, -900}};

TEST(LocalTangentPlane, GeodeticRoundTrip) {
  for (const Geodetic& a : kAnchors) {
    const LocalTangentPlane plane(a);
    for (const Vector3d& x : kOffsets) {
      EXPECT_LT((plane.offset(plane.geodetic(x)) - x).norm(), 1e-7);  // radians of 64 bits: 1 nm
    }
  }
}

// Compared with the displacement through ECEF in double precision.
TEST(LocalTangentPlane, DisplacementMatchesTheEllipsoid) {
  for (const Geodetic& a : kAnchors) {
    const LocalTangentPlane plane(a);
    for (const Vector3d& x : kOffsets) {
      const Vector3d expected = ned_from_geodetic(plane.geodetic(x), a);
      EXPECT_LT((plane.displacement(x) - expected).norm(), 2e-8) << x.transpose();
      const Eigen::Vector3f narrow = plane.displacement<float>(x.cast<float>());
      // Single precision resolves 1e-3 m at 15 km.
      EXPECT_LT((narrow.cast<double>() - expected).norm(), 1e-6 * x.norm() + 1e-6);
    }
  }
}

TEST(LocalTangentPlane, RotationMatchesTheEllipsoid) {
  for (const Geodetic& a : kAnchors) {
    const LocalTangentPlane plane(a);
    for (const Vector3d& x : kOffsets) {
      const Eigen::Matrix3d expected =
          rotation_ecef_ned(a).transpose() * rotation_ecef_ned(plane.geodetic(x));
      EXPECT_LT((plane.rotation_anchor_local(x) - expected).norm(), 1e-14);
    }
  }
}

TEST(LocalTangentPlane, EarthMatchesTheEllipsoid) {
  for (const Geodetic& a : kAnchors) {
    const LocalTangentPlane plane(a);
    for (const Vector3d& x : kOffsets) {
      const Geodetic p = plane.geodetic(x);
      const double s = std::sin(p.latitude.radians());
      const EarthAt<double> e = plane.earth(x);
      EXPECT_NEAR(e.sin_latitude, s, 1e-15);
      EXPECT_NEAR(e.cos_latitude, std::cos(p.latitude.radians()), 1e-15);
      EXPECT_NEAR(e.meridian_m, meridian_radius_m(s) + p.height_m, 1e-7);
      EXPECT_NEAR(e.transverse_m, transverse_radius_m(s) + p.height_m, 1e-7);
      EXPECT_NEAR(e.gravity_mps2, normal_gravity_mps2(s, p.height_m), 1e-13);
      // A metre north on the ground is north_scale metres on the chart.
      const double step = 1.0 / e.meridian_m;
      const Geodetic q{p.latitude + Angle::radians(step), p.longitude, p.height_m};
      EXPECT_NEAR(plane.offset(q)[0] - x[0], e.north_scale, 1e-7);
    }
  }
}

// The chart's axes are those of the local level at the anchor: its offsets differ from the
// displacement by terms of second order, |x|²/R with R above 6.3e6 m.
TEST(LocalTangentPlane, OffsetsAreMetresAtTheAnchor) {
  const Vector3d x(3.0, -2.0, 1.0);
  for (const Geodetic& a : kAnchors)
    EXPECT_LT((LocalTangentPlane(a).displacement(x) - x).norm(), x.squaredNorm() / 2e6);
}

// Central differences of the displacement over 100 m of the chart to both sides, whose third-order
// terms are below 3e-10.
TEST(LocalTangentPlane, ScalesAreChartByGround) {
  for (const Geodetic& a : kAnchors) {
    const LocalTangentPlane plane(a);
    for (const Vector3d& x : kOffsets) {
      const auto ground = [&](int axis) {
        const Vector3d step = 100.0 * Vector3d::Unit(axis), there = x + step, here = x - step;
        return (plane.displacement(there) - plane.displacement(here)).norm() / 200.0;
      };
      const EarthAt<double> e = plane.earth(x);
      EXPECT_NEAR(ground(0) * e.north_scale, 1.0, 1e-9) << x.transpose();
      EXPECT_NEAR(ground(1) * e.east_scale, 1.0, 1e-9) << x.transpose();
    }
  }
}

}  // namespace
}  // namespace wayfare
