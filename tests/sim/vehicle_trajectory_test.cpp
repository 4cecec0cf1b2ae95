#include <wayfare/sim/vehicle_trajectory.hpp>

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/sensors/trajectory.hpp>

namespace wayfare::sim {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
const Geodetic kOrigin{Angle::degrees(47.0), Angle::degrees(8.5), 450.0};

// A strapdown mechanisation independent of the library, in Earth-fixed axes (Groves 2013,
// (5.29)-(5.37)), where the trajectory uses local level: v̇ = C f + g − 2 ω × v, with its own
// gravity formula.
struct EcefState {
  Eigen::Vector3d p, v;
  Eigen::Quaterniond q;  // body to ECEF
};

Eigen::Vector3d gravity_ecef(const Eigen::Vector3d& p) {
  const Geodetic g = geodetic_from_ecef(p);
  return rotation_ecef_ned(g).col(2) *
         normal_gravity_mps2(std::sin(g.latitude.radians()), g.height_m);
}

struct EcefRate {
  Eigen::Vector3d p, v;
  Eigen::Vector4d q;
};

EcefRate derivative(const EcefState& s, const VehicleMotion& m) {
  const Eigen::Vector3d w_ie(0, 0, wgs84::kEarthRate_radps);
  const Eigen::Vector3d w = m.angular_rate_radps - s.q.conjugate() * w_ie;
  const Eigen::Quaterniond dq = s.q * Eigen::Quaterniond(0, 0.5 * w.x(), 0.5 * w.y(), 0.5 * w.z());
  return {s.v, s.q * m.specific_force_mps2 + gravity_ecef(s.p) - 2.0 * w_ie.cross(s.v),
          dq.coeffs()};
}

EcefState moved(EcefState s, const EcefRate& r, double dt) {
  s.p += dt * r.p;
  s.v += dt * r.v;
  s.q.coeffs() += dt * r.q;
  s.q.normalize();
  return s;
}

// Fourth-order Runge-Kutta on a perfect unit's measurements; returns the largest errors of
// position, velocity and attitude.
Eigen::Vector3d integrate(const VehicleTrajectory& trajectory, Duration step) {
  VehicleMotion a = trajectory.motion(trajectory.begin());
  const EcefMotion start = ecef_motion(a, Eigen::Vector3d::Zero());
  EcefState s{start.position_m, start.velocity_mps,
              SO3d(rotation_ecef_ned(a.nav.position)).quaternion() * a.nav.q_nb.quaternion()};
  Eigen::Vector3d worst = Eigen::Vector3d::Zero();
  const double dt = to_seconds(step);
  for (LogTime t = trajectory.begin(); t + step <= trajectory.end(); t += step) {
    const VehicleMotion b = trajectory.motion(t + step / 2), c = trajectory.motion(t + step);
    const EcefRate k1 = derivative(s, a), k2 = derivative(moved(s, k1, dt / 2), b);
    const EcefRate k3 = derivative(moved(s, k2, dt / 2), b), k4 = derivative(moved(s, k3, dt), c);
    s = moved(s,
              {(k1.p + 2 * k2.p + 2 * k3.p + k4.p) / 6, (k1.v + 2 * k2.v + 2 * k3.v + k4.v) / 6,
               (k1.q + 2 * k2.q + 2 * k3.q + k4.q) / 6},
              dt);
    a = c;
    const EcefMotion truth = ecef_motion(c, Eigen::Vector3d::Zero());
    const SO3d q_eb = SO3d(rotation_ecef_ned(c.nav.position)) * c.nav.q_nb;
    worst = worst.cwiseMax(Eigen::Vector3d((s.p - truth.position_m).norm(),
                                           (s.v - truth.velocity_mps).norm(),
                                           SO3d(s.q).minus(q_eb).norm()));
  }
  return worst;
}

double length_m(const VehicleTrajectory& trajectory) {
  double length = 0.0;
  for (LogTime t = trajectory.begin(); t < trajectory.end(); t += from_seconds(0.1))
    length += 0.1 * trajectory.state(t).velocity_ned_mps.norm();
  return length;
}

TEST(VehicleTrajectory, APerfectStrapdownReproducesTheDrive) {
  // Third derivatives jump at the knots, so the step divides their spacing; then the fourth-order
  // error of 5 ms steps over 310 s is far below a millimetre.
  const Eigen::Vector3d worst = integrate(demo_drive(), std::chrono::milliseconds(5));
  EXPECT_LT(worst[0], 1e-4);
  EXPECT_LT(worst[1], 1e-6);
  EXPECT_LT(worst[2], 1e-8);
}

TEST(VehicleTrajectory, APerfectStrapdownReproducesAFastDriveNearThePole) {
  // Coriolis and transport rate are largest here: 80° north, 100 m/s.
  VehicleLimits fast;
  fast.speed_mps = 100.0, fast.acceleration_mps2 = 10.0, fast.lateral_acceleration_mps2 = 20.0;
  fast.turn_radius_m = 500.0;
  const std::vector<Waypoint> route = {{0, 0}, {4000, 0, 200}, {4000, 5000, 50}, {0, 8000}};
  const Geodetic origin{Angle::degrees(80.0), Angle::degrees(-170.0), 3000.0};
  const auto drive = drive_waypoints(origin, route, fast);
  ASSERT_TRUE(drive);
  const Eigen::Vector3d worst = integrate(*drive, std::chrono::milliseconds(5));
  EXPECT_LT(worst[0], 1e-4);
  EXPECT_LT(worst[1], 1e-6);
  EXPECT_LT(worst[2], 1e-8);
}

TEST(VehicleTrajectory, TheBuiltInDriveIs310SecondsAnd4500Metres) {
  const VehicleTrajectory drive = demo_drive(LogTime::from_seconds(1000));
  EXPECT_EQ(drive.begin(), LogTime::from_seconds(1000));
  EXPECT_NEAR(to_seconds(drive.end() - drive.begin()), 310.0, 1.0);
  EXPECT_NEAR(length_m(drive), 4500.0, 20.0);
}

TEST(VehicleTrajectory, RespectsItsLimitsAndStops) {
  VehicleLimits limits;
  limits.speed_mps = 23.0;
  const VehicleTrajectory drive = demo_drive();
  double standing_s = 0.0;
  for (LogTime t = drive.begin(); t <= drive.end(); t += from_seconds(0.05)) {
    const VehicleMotion m = drive.motion(t);
    const double speed = m.nav.velocity_ned_mps.norm();
    // A margin of a few per cent for the smoothing by splines.
    EXPECT_LT(speed, 1.01 * limits.speed_mps);
    EXPECT_LT(std::abs(m.angular_rate_radps.z()), 1.03 * limits.turn_rate_radps);
    const Eigen::Vector3d level = m.nav.q_nb * m.specific_force_mps2;
    EXPECT_LT(level.head<2>().norm(),
              1.05 * std::hypot(limits.braking_mps2, limits.lateral_acceleration_mps2));
    if (speed < 0.01) standing_s += 0.05;
  }
  // 8 + 4 + 4 + 4 s, less the rise time of the acceleration at each.
  EXPECT_NEAR(standing_s, 20.0, 3.0);
}

TEST(VehicleTrajectory, NeverSlipsSidewaysOrLeavesTheGround) {
  const VehicleTrajectory drive = demo_drive();
  for (LogTime t = drive.begin(); t <= drive.end(); t += from_seconds(0.05)) {
    const NavState s = drive.state(t);
    const Eigen::Vector3d body = s.q_nb.inverse() * s.velocity_ned_mps;
    EXPECT_LT(std::abs(body.y()), 0.01) << to_seconds(t - drive.begin());
    EXPECT_LT(std::abs(body.z()), 0.02) << to_seconds(t - drive.begin());
    EXPECT_GT(body.x(), -0.01);
  }
}

TEST(VehicleTrajectory, AccelerationAndTurnRateAreContinuous) {
  const VehicleTrajectory drive = demo_drive();
  const Duration step = from_seconds(0.001);
  VehicleMotion before = drive.motion(drive.begin());
  for (LogTime t = drive.begin() + step; t <= drive.end(); t += step) {
    const VehicleMotion m = drive.motion(t);
    // A discontinuity would be as large as the acceleration itself; the jerk is below 15 m/s³.
    EXPECT_LT((m.specific_force_mps2 - before.specific_force_mps2).norm(), 0.015);
    EXPECT_LT((m.angular_rate_radps - before.angular_rate_radps).norm(), 0.003);
    before = m;
  }
}

TEST(VehicleTrajectory, PassesCollinearWaypointsAtTheirHeight) {
  const std::vector<Waypoint> straight = {{0, 0, 0}, {200, 0, 5, 4.0}, {500, 0, 2}};
  const auto drive = drive_waypoints(kOrigin, straight);
  ASSERT_TRUE(drive);
  double standing_north = NAN, height = NAN;
  for (LogTime t = drive->begin() + from_seconds(5); t < drive->end(); t += from_seconds(0.1)) {
    const NavState s = drive->state(t);
    if (s.velocity_ned_mps.norm() > 1e-3) continue;
    standing_north = ned_from_geodetic(s.position, kOrigin).x();
    height = s.position.height_m;
    break;
  }
  EXPECT_NEAR(standing_north, 200.0, 0.2);
  EXPECT_NEAR(height, kOrigin.height_m + 5.0, 1e-3);
}

TEST(VehicleTrajectory, RefusesInvalidWaypoints) {
  const auto message = [](std::vector<Waypoint> route) {
    const auto drive = drive_waypoints(kOrigin, route);
    return drive ? std::string("driven") : drive.error().message;
  };
  using testing::HasSubstr;
  EXPECT_THAT(message({}), HasSubstr("two waypoints"));
  EXPECT_THAT(message({{0, 0}}), HasSubstr("two waypoints"));
  EXPECT_THAT(message({{0, 0}, {0, 0}}), HasSubstr("waypoint 1"));
  EXPECT_THAT(message({{0, 0}, {NAN, 0}}), HasSubstr("waypoint 1"));
  EXPECT_THAT(message({{0, 0}, {100, 0}, {0, 0}}), HasSubstr("reverses at waypoint 1"));
}

// Samples of a drive as from a receiver with fixed ambiguities, 4 Hz.
std::vector<NavState> solution_of(const VehicleTrajectory& drive, double noise_m,
                                  double noise_mps) {
  std::vector<NavState> solution;
  Rng rng(5);
  for (LogTime t = drive.begin(); t <= drive.end(); t += from_seconds(0.25)) {
    NavState s = drive.state(t);
    const auto noise = [&](double sigma) {
      const double x = rng.normal(), y = rng.normal();
      return Eigen::Vector3d(sigma * x, sigma * y, sigma * rng.normal());
    };
    s.position = geodetic_from_ned(noise(noise_m), s.position);
    s.velocity_ned_mps += noise(noise_mps);
    s.q_nb = SO3d();
    solution.push_back(s);
  }
  return solution;
}

TEST(FollowSolution, ReproducesPositionsToMillimetresAndAttitudesFromTheCourse) {
  const VehicleTrajectory drive = demo_drive();
  const auto solution = solution_of(drive, 0.005, 0.03);
  const auto followed = follow_solution(solution);
  ASSERT_TRUE(followed) << followed.error().to_string();
  double squares = 0.0, worst_yaw = 0.0;
  for (const NavState& s : solution) {
    const NavState f = followed->state(s.time), truth = drive.state(s.time);
    squares += ned_from_geodetic(f.position, s.position).squaredNorm() / 3.0;
    EXPECT_LT(ned_from_geodetic(f.position, truth.position).norm(), 0.03);
    EXPECT_LT((f.velocity_ned_mps - truth.velocity_ned_mps).norm(), 0.2);
    if (truth.velocity_ned_mps.norm() > 3.0)
      worst_yaw = std::max(worst_yaw, f.q_nb.minus(truth.q_nb).norm());
  }
  EXPECT_LT(std::sqrt(squares / static_cast<double>(solution.size())), 0.006);
  EXPECT_LT(worst_yaw, 2.0 * kDegree);
  const Eigen::Vector3d worst = integrate(*followed, std::chrono::milliseconds(5));
  EXPECT_LT(worst[0], 1e-3);
  EXPECT_LT(worst[2], 1e-7);
}

TEST(FollowSolution, HandlesStopsAndRefusesInvalidInput) {
  const NavState still{LogTime{}, kOrigin, Eigen::Vector3d::Zero(), {}};
  std::vector<NavState> standing(20, still);
  for (std::size_t i = 0; i < standing.size(); ++i)
    standing[i].time += from_seconds(0.25 * static_cast<double>(i));
  const auto followed = follow_solution(standing);
  ASSERT_TRUE(followed);
  EXPECT_LT(followed->state(LogTime::from_seconds(2.3)).velocity_ned_mps.norm(), 1e-9);
  EXPECT_FALSE(follow_solution(std::span(standing).first(3)));
  std::swap(standing[3], standing[9]);
  EXPECT_FALSE(follow_solution(standing));
  std::swap(standing[3], standing[9]);
  standing[7].velocity_ned_mps.x() = NAN;
  EXPECT_FALSE(follow_solution(standing));
}

TEST(EcefMotion, VelocityIsTheDifferenceQuotientOfPosition) {
  const VehicleTrajectory drive = demo_drive();
  const Eigen::Vector3d arm(1.2, -0.4, -1.5);
  for (double s : {30.0, 33.0, 60.0, 100.0, 200.0}) {
    const LogTime t = drive.begin() + from_seconds(s);
    const auto at = [&](double ds) { return ecef_motion(drive.motion(t + from_seconds(ds)), arm); };
    const Eigen::Vector3d slope = (at(1e-3).position_m - at(-1e-3).position_m) / 2e-3;
    // The quotient's own error is h²/6 times the third derivative.
    EXPECT_LT((slope - at(0).velocity_mps).norm(), 1e-4);
  }
}

}  // namespace
}  // namespace wayfare::sim
