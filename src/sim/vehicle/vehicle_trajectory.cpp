#include <wayfare/sim/vehicle_trajectory.hpp>

#include <algorithm>
#include <cmath>

#include <wayfare/core/se3.hpp>

namespace wayfare::sim {
namespace {

// Earth rate in local level.
Eigen::Vector3d earth_rate_ned(double latitude) {
  return {wgs84::kEarthRate_radps * std::cos(latitude), 0.0,
          -wgs84::kEarthRate_radps * std::sin(latitude)};
}

// Transport rate: rotation of local level due to motion over the Earth (Groves 2013, (5.44)).
Eigen::Vector3d transport_rate_ned(const Geodetic& p, const Eigen::Vector3d& v) {
  const double s = std::sin(p.latitude.radians()), t = std::tan(p.latitude.radians());
  const double rn = transverse_radius_m(s) + p.height_m, rm = meridian_radius_m(s) + p.height_m;
  return {v.y() / rn, -v.x() / rm, -v.y() * t / rn};
}

// Rate of the body relative to local level, in body axes, from roll, pitch, yaw and their rates.
Eigen::Vector3d body_rate(const Eigen::Vector3d& rpy, const Eigen::Vector3d& rate) {
  const double sr = std::sin(rpy[0]), cr = std::cos(rpy[0]);
  const double sp = std::sin(rpy[1]), cp = std::cos(rpy[1]);
  return {rate[0] - rate[2] * sp, rate[1] * cr + rate[2] * sr * cp,
          -rate[1] * sr + rate[2] * cr * cp};
}

Eigen::Vector3d white(Rng& rng) {
  Eigen::Vector3d w;
  for (double& x : w) x = rng.normal();
  return w;
}

void step_process(Eigen::Vector3d& n, const GaussMarkov3& process, double seconds, Rng& rng) {
  for (int i = 0; i < 3; ++i) {
    const double phi = std::exp(-seconds / process.tau_s[i]);
    const double q = -std::expm1(-2.0 * seconds / process.tau_s[i]);
    n[i] = phi * n[i] + process.sigma[i] * std::sqrt(q) * rng.normal();
  }
}

ImuSample reading_at(const VehicleTrajectory& trajectory, LogTime time) {
  const VehicleMotion m = trajectory.motion(time);
  return {time, m.angular_rate_radps, m.specific_force_mps2};
}

// Two-point Gauss-Legendre: exact to the third order within a spline's segment.
ImuSample mean_reading(const VehicleTrajectory& trajectory, LogTime from, Duration period) {
  const double half = 0.5 * to_seconds(period), offset = half / std::sqrt(3.0);
  const ImuSample a = reading_at(trajectory, from + from_seconds(half - offset));
  const ImuSample b = reading_at(trajectory, from + from_seconds(half + offset));
  return {from + period, 0.5 * (a.angular_rate_radps + b.angular_rate_radps),
          0.5 * (a.specific_force_mps2 + b.specific_force_mps2)};
}

using Samples = std::vector<CurveSample>;

// The representative of `angle` nearest to `reference`.
double unwrapped(double angle, double reference) {
  return reference + wrap_to_pi(angle - reference);
}

// Heading and grade, without roll, while the vehicle is fast enough to determine them.
Samples course_samples(const SmoothCurve& position, const TrackFit& fit) {
  Samples moving;
  for (double t = position.begin_s(); t <= position.end_s(); t += fit.knot_spacing_s) {
    const Eigen::Vector3d v = position.at(t).first;
    const double speed = v.head<2>().norm();
    if (speed < fit.min_course_speed_mps) continue;
    double yaw = std::atan2(v.y(), v.x());
    if (!moving.empty()) yaw = unwrapped(yaw, moving.back().value[2]);
    const double sigma = 0.3 * fit.velocity_sigma_mps / speed;
    moving.push_back({t, {0.0, std::atan2(-v.z(), speed), yaw}, sigma});
  }
  return moving;
}

// At rest between two drives, the heading difference is spread over the time between.
Samples fill_standstills(const Samples& moving, const SmoothCurve& position, const TrackFit& fit) {
  CurveSample level{position.begin_s(), Eigen::Vector3d::Zero(), 0.05};
  if (moving.empty()) {
    Samples still(3, level);
    still[1].time_s = 0.5 * (position.begin_s() + position.end_s());
    still[2].time_s = position.end_s();
    return still;
  }
  Samples all;
  CurveSample before = moving.front();
  before.time_s = position.begin_s();
  const auto bridge = [&](const CurveSample& after) {
    const double gap = after.time_s - before.time_s;
    for (double t = fit.knot_spacing_s; t < gap - 0.5 * fit.knot_spacing_s; t += fit.knot_spacing_s)
      all.push_back(
          {before.time_s + t, before.value + t / gap * (after.value - before.value), 0.02});
  };
  for (const CurveSample& sample : moving) {
    bridge(sample);
    all.push_back(sample);
    before = sample;
  }
  CurveSample last = before;
  last.time_s = position.end_s();
  bridge(last);
  return all;
}

Samples recorded_attitudes(std::span<const NavState> solution) {
  Samples all;
  for (const NavState& s : solution) {
    Eigen::Vector3d rpy = roll_pitch_yaw_rad(s.q_nb);
    if (!all.empty())
      for (int i : {0, 2}) rpy[i] = unwrapped(rpy[i], all.back().value[i]);
    all.push_back({to_seconds(s.time - solution.front().time), rpy, 1e-3});
  }
  return all;
}

}  // namespace

VehicleMotion VehicleTrajectory::motion(LogTime time) const {
  const double t = to_seconds(time - start_);
  const SmoothCurve::Point p = position_.at(t), a = attitude_.at(t);
  VehicleMotion m;
  m.nav.time = time;
  m.nav.position = geodetic_from_ned(p.value, origin_);
  const Eigen::Matrix3d ned_origin =
      rotation_ecef_ned(m.nav.position).transpose() * rotation_ecef_ned(origin_);
  const Eigen::Vector3d v = ned_origin * p.first;
  m.nav.velocity_ned_mps = v;
  m.nav.q_nb = rotation_from_roll_pitch_yaw(a.value);

  // The curve's second derivative is the acceleration in Earth-fixed axes, so only Coriolis is
  // missing; the centrifugal part is in gravity.
  const double latitude = m.nav.position.latitude.radians();
  const Eigen::Vector3d w_ie = earth_rate_ned(latitude);
  const Eigen::Vector3d gravity(0.0, 0.0,
                                normal_gravity_mps2(std::sin(latitude), m.nav.position.height_m));
  const SO3d q_bn = m.nav.q_nb.inverse();
  m.specific_force_mps2 = q_bn * (ned_origin * p.second + 2.0 * w_ie.cross(v) - gravity).eval();
  m.angular_rate_radps =
      body_rate(a.value, a.first) + q_bn * (w_ie + transport_rate_ned(m.nav.position, v)).eval();
  return m;
}

EcefMotion ecef_motion(const VehicleMotion& m, const Eigen::Vector3d& lever_arm_body_m) {
  const Eigen::Matrix3d ecef_ned = rotation_ecef_ned(m.nav.position);
  const Eigen::Vector3d w_ie(0.0, 0.0, wgs84::kEarthRate_radps);
  const Eigen::Matrix3d ecef_body = ecef_ned * m.nav.q_nb.matrix();
  const Eigen::Vector3d arm = ecef_body * lever_arm_body_m;
  const Eigen::Vector3d w_eb = ecef_body * m.angular_rate_radps - w_ie;
  return {ecef_from_geodetic(m.nav.position) + arm,
          ecef_ned * m.nav.velocity_ned_mps + w_eb.cross(arm)};
}

ImuErrorProcess::ImuErrorProcess(const ImuNoise& noise, Rng& rng) : noise_(noise) {
  errors_.gyro_bias_radps = noise.gyro_bias_radps.sigma.cwiseProduct(white(rng));
  errors_.accel_bias_mps2 = noise.accel_bias_mps2.sigma.cwiseProduct(white(rng));
  errors_.gyro_scale = noise.gyro_scale.sigma.cwiseProduct(white(rng));
  errors_.accel_scale = noise.accel_scale.sigma.cwiseProduct(white(rng));
}

void ImuErrorProcess::step(double seconds, Rng& rng) {
  step_process(errors_.gyro_bias_radps, noise_.gyro_bias_radps, seconds, rng);
  step_process(errors_.accel_bias_mps2, noise_.accel_bias_mps2, seconds, rng);
  step_process(errors_.gyro_scale, noise_.gyro_scale, seconds, rng);
  step_process(errors_.accel_scale, noise_.accel_scale, seconds, rng);
}

ImuSample ImuErrorProcess::measure(const ImuSample& truth, double seconds, Rng& rng) const {
  const auto measured = [&](const Eigen::Vector3d& own, const Eigen::Vector3d& scale,
                            const Eigen::Vector3d& bias, const Eigen::Vector3d& density) {
    return Eigen::Vector3d(own + own.cwiseProduct(scale) + bias +
                           density.cwiseProduct(white(rng)) / std::sqrt(seconds));
  };
  ImuSample sample{truth.time};
  sample.angular_rate_radps = measured(truth.angular_rate_radps, errors_.gyro_scale,
                                       errors_.gyro_bias_radps, noise_.gyro_white_rad_per_sqrt_s);
  sample.specific_force_mps2 = measured(truth.specific_force_mps2, errors_.accel_scale,
                                        errors_.accel_bias_mps2, noise_.accel_white_mps_per_sqrt_s);
  return sample;
}

SimulatedUnit::SimulatedUnit(const VehicleTrajectory& trajectory, const ImuParams& params,
                             const Rng& rng)
    : trajectory_(trajectory),
      params_(params),
      rng_(rng),
      process_(params.noise, rng_),
      next_(trajectory.begin()) {
  WAYFARE_EXPECTS(params.period > Duration::zero(), "a sensor needs a positive period");
}

bool SimulatedUnit::read(ImuSample& sample) {
  if (next_ > trajectory_.end()) return false;
  const double dt = to_seconds(params_.period);
  ImuSample truth = params_.mean_of_period
                        ? mean_reading(trajectory_, next_ - params_.period, params_.period)
                        : reading_at(trajectory_, next_);
  if (next_ > trajectory_.begin()) process_.step(dt, rng_);
  const SO3d q_imu_body = params_.q_body_imu.inverse();
  truth.angular_rate_radps = q_imu_body * truth.angular_rate_radps;
  truth.specific_force_mps2 = q_imu_body * truth.specific_force_mps2;
  sample = process_.measure(truth, dt, rng_);
  next_ += params_.period;
  return true;
}

SimulatedImu simulate_imu(const VehicleTrajectory& trajectory, const ImuParams& params,
                          const Rng& rng) {
  SimulatedUnit unit(trajectory, params, rng);
  SimulatedImu imu;
  for (ImuSample sample; unit.read(sample);) {
    imu.samples.push_back(sample);
    imu.errors.push_back(unit.errors());
  }
  return imu;
}

ImuNoise perfect_imu() {
  const GaussMarkov3 none{Eigen::Vector3d::Zero(), Eigen::Vector3d::Ones()};
  return {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), none, none, none, none};
}

VehicleTrajectory demo_drive(LogTime start) {
  constexpr Waypoint kRoute[] = {{0, 0, 0, 8},     {550, 0, 3, 0},     {550, 550, 8, 4},
                                 {1100, 550, 12},  {1100, 1100, 2, 0}, {650, 1400, 5, 0},
                                 {50, 1150, 9, 4}, {50, 450, 4, 0},    {-100, 36, -3, 4.6}};
  VehicleLimits limits;
  limits.speed_mps = 23.0;
  const Geodetic origin{Angle::degrees(51.0797), Angle::degrees(-114.1314), 1100.0};
  return drive_waypoints(origin, kRoute, limits, start).value();
}

VehicleTrajectory round_drive(int rounds, LogTime start) {
  WAYFARE_EXPECTS(rounds > 0, "a drive needs a round");
  VehicleLimits gentle;
  gentle.acceleration_mps2 = gentle.braking_mps2 = gentle.lateral_acceleration_mps2 = 0.8;
  gentle.turn_radius_m = 80.0, gentle.build_up_s = 4.0;
  std::vector<Waypoint> route;
  for (int i = 0; i < rounds; ++i) {
    route.push_back({0, 0, 0, 0});
    route.push_back({900, 0, 10, i % 7 == 0 ? 60.0 : 0.0});
    route.push_back({900, 800, 0, 0});
    route.push_back({0, 800, 5, i % 3 == 0 ? 20.0 : 0.0});
  }
  const Geodetic origin{Angle::degrees(51.0), Angle::degrees(-114.0), 1100.0};
  return drive_waypoints(origin, route, gentle, start).value();
}

Result<VehicleTrajectory> follow_solution(std::span<const NavState> solution, const TrackFit& fit) {
  if (solution.size() < 4)
    return Error{ErrorCode::invalid, "a track needs four states or more to be followed"};
  const NavState& first = solution.front();
  Samples samples;
  double end_s = 0.0;
  for (const NavState& s : solution) {
    const double t = to_seconds(s.time - first.time);
    if (t < end_s)
      return Error{ErrorCode::invalid, "the states of a track are not in order of time"};
    end_s = t;
    const Eigen::Matrix3d origin_ned =
        rotation_ecef_ned(first.position).transpose() * rotation_ecef_ned(s.position);
    samples.push_back({t, ned_from_geodetic(s.position, first.position), fit.position_sigma_m});
    const double held_s = t - fit.velocity_late_s;
    if (held_s >= 0.0)
      samples.push_back({held_s, origin_ned * s.velocity_ned_mps, fit.velocity_sigma_mps,
                         CurveSample::Of::derivative});
  }
  auto position = SmoothCurve::fit(samples, 0.0, end_s, {fit.knot_spacing_s, fit.jerk_sigma_mps3});
  if (!position) return position.error();
  const Samples turned = fit.attitude_from_course
                             ? fill_standstills(course_samples(*position, fit), *position, fit)
                             : recorded_attitudes(solution);
  auto attitude = SmoothCurve::fit(turned, 0.0, end_s, {fit.knot_spacing_s, 1.0});
  if (!attitude) return attitude.error();
  return VehicleTrajectory(first.position, first.time, std::move(position).value(),
                           std::move(attitude).value());
}

}  // namespace wayfare::sim
