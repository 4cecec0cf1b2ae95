#include <wayfare/slam/detail/carrier_filter.hpp>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include <wayfare/filter/covariance_intersection.hpp>
#include <wayfare/filter/process.hpp>

namespace wayfare {
namespace {

using S = CarrierState;
using Row = SparseRow<double, 1>;

constexpr double kConstraintPeriod_s = 0.1;  // interval of the constraints

ScalarMeasurement<double, Row> element(int i, double off, double variance) {
  return {off, Row{{i}, {1.0}}, variance};
}

bool is_finite(const ImuSample& s) {
  return s.angular_rate_radps.allFinite() && s.specific_force_mps2.allFinite();
}

/// Linear interpolation.
ImuSample between(const ImuSample& a, const ImuSample& b, LogTime time) {
  const double u = to_seconds(time - a.time) / to_seconds(b.time - a.time);
  return {time, (1 - u) * a.angular_rate_radps + u * b.angular_rate_radps,
          (1 - u) * a.specific_force_mps2 + u * b.specific_force_mps2};
}

Eigen::Matrix3d about_z(const SO2d& turn) {
  Eigen::Matrix3d r = Eigen::Matrix3d::Identity();
  r.topLeftCorner<2, 2>() = turn.matrix();
  return r;
}

/// Moves position, velocity and attitude over a flat floor.
struct FlatStrapdown {
  using Moves = BlockList<carrier::Position, carrier::Velocity, carrier::Attitude>;
  using By = BlockList<carrier::Position, carrier::Velocity, carrier::Attitude, carrier::GyroBias,
                       carrier::AccelBias>;
  CarrierNoise noise;

  [[nodiscard]] auto step(const Eigen::Vector3d& position_m, const Eigen::Vector3d& velocity_mps,
                          const SO3d& q_map_body, const Eigen::Vector3d& gyro_bias,
                          const Eigen::Vector3d& accel_bias, const ImuInterval& u) const {
    const double dt = u.dt_s;
    const InertialIncrement<double> measured =
        integrate<double>(u.begin_rate_radps - gyro_bias, u.end_rate_radps - gyro_bias,
                          u.begin_force_mps2 - accel_bias, u.end_force_mps2 - accel_bias, dt);
    const Eigen::Matrix3d r = q_map_body.matrix();
    Eigen::Vector3d velocity = velocity_mps, position = position_m;
    velocity +=
        r * measured.velocity_mps - dt * CarrierModel::kGravity_mps2 * Eigen::Vector3d::UnitZ();
    position += 0.5 * dt * (velocity_mps + velocity);
    const double accel = noise.accel_white * noise.accel_white * dt;
    const Eigen::Vector3d one = Eigen::Vector3d::Ones();
    return CoupledStep{
        std::tuple{position, velocity, q_map_body.plus(measured.rotation_rad)},
        jacobian(r, measured, dt),
        std::tuple{Eigen::Vector3d(accel * dt * dt / 4 * one), Eigen::Vector3d(accel * one),
                   Eigen::Vector3d(noise.gyro_white * noise.gyro_white * dt * one)}};
  }

 private:
  static Eigen::Matrix<double, 9, S::kDof> jacobian(const Eigen::Matrix3d& r,
                                                    const InertialIncrement<double>& measured,
                                                    double dt) {
    Eigen::Matrix<double, 9, S::kDof> j = Eigen::Matrix<double, 9, S::kDof>::Identity();
    const Eigen::Matrix3d halfway = r * SO3d::exp(0.5 * measured.rotation_rad).matrix();
    const Eigen::Matrix3d by_attitude = -r * skew(measured.velocity_mps);
    j.block<3, 3>(S::kVelocity, S::kAttitude) = by_attitude;
    j.block<3, 3>(S::kVelocity, S::kGyroBias) = -0.5 * dt * by_attitude;
    j.block<3, 3>(S::kVelocity, S::kAccelBias) = -dt * halfway;
    j.block<3, 3>(S::kPosition, S::kVelocity).diagonal().setConstant(dt);
    j.block<3, 3>(S::kPosition, S::kAttitude) = 0.5 * dt * by_attitude;
    j.block<3, 3>(S::kPosition, S::kAccelBias) = -0.5 * dt * dt * halfway;
    j.block<3, 3>(S::kAttitude, S::kAttitude) = SO3d::exp(-measured.rotation_rad).matrix();
    j.block<3, 3>(S::kAttitude, S::kGyroBias) = -dt * SO3d::right_jacobian(measured.rotation_rad);
    return j;
  }
};

}  // namespace

SE2d CarrierState::planar() const {
  const Eigen::Vector3d x = q_map_body.matrix().col(0);
  return SE2d(position_m.x(), position_m.y(), Angle::radians(std::atan2(x.y(), x.x())));
}

/// The axis a = q e₁ moves by −q [e₁]× δθ, and the heading of a by (a₁ da₂ − a₂ da₁)/(a₁² + a₂²).
Eigen::Matrix<double, 3, S::kDof> CarrierState::planar_jacobian() const {
  constexpr double kUpright = 1e-6;  // no heading when x is vertical
  const Eigen::Matrix3d r = q_map_body.matrix();
  const Eigen::Matrix3d moved = -r * skew(Eigen::Vector3d(Eigen::Vector3d::UnitX()));
  const double level2 = std::max(kUpright, r(0, 0) * r(0, 0) + r(1, 0) * r(1, 0));
  Eigen::Matrix<double, 3, kDof> c = Eigen::Matrix<double, 3, kDof>::Zero();
  c(0, kPosition) = c(1, kPosition + 1) = 1;
  c.block<1, 3>(2, kAttitude) = (r(0, 0) * moved.row(1) - r(1, 0) * moved.row(0)) / level2;
  return c;
}

CarrierModel::Step CarrierModel::operator()(const S& x, const ImuInterval& u) const {
  const Process<carrier::Blocks, FlatStrapdown, carrier::GyroBias, carrier::AccelBias> process{
      {noise_},
      {{noise_.gyro_bias_radps, noise_.gyro_bias_time_s}},
      {{noise_.accel_bias_mps2, noise_.accel_bias_time_s}}};
  const auto step = process(x, u);
  return {{step.state}, step.phi(), step.q()};
}

CarrierFilter::CarrierFilter(const CarrierFilterParameters& parameters)
    : p_(parameters), model_(p_.noise), rest_(p_.rest_rate, p_.rest_force) {}

UpdateStatus CarrierFilter::add(const ImuSample& sample) {
  if (!is_finite(sample)) return UpdateStatus::missing;
  if (clock_.check(sample.time) == SampleClock::Verdict::late) return UpdateStatus::late;
  const bool follows = last_ && sample.time > last_->time &&
                       to_seconds(sample.time - last_->time) <= p_.restart_gap_s;
  if (!follows) {
    start(sample);
    return last_ ? UpdateStatus::used : UpdateStatus::waiting;
  }
  const double dt = to_seconds(sample.time - last_->time);
  if (time_ < sample.time)
    step(time_ > last_->time ? between(*last_, sample, time_) : *last_, sample);
  last_ = sample;
  rest_.add_rate(sample.angular_rate_radps, dt);
  rest_.add_force(sample.specific_force_mps2, dt);
  since_constraint_s_ += dt;
  if (since_constraint_s_ >= kConstraintPeriod_s)
    apply_floor_constraints(std::exchange(since_constraint_s_, 0.0));
  if (level_lost(sample, dt)) start(sample);
  return UpdateStatus::used;
}

/// The vertical from one sample whose specific force could be gravity's: good to 2° at rest. The
/// bias estimates are kept.
void CarrierFilter::start(const ImuSample& sample) {
  const double g = CarrierModel::kGravity_mps2;
  const double off = sample.specific_force_mps2.norm() / g - 1;
  if (!(std::abs(off) < 0.5)) {
    last_.reset();
    return;
  }
  const bool again = starts_ > 0;
  const double turning = sample.angular_rate_radps.norm() > 0.3 ? 0.4 : 0.0;
  const double tilt2 = 0.0012 + 9 * off * off + turning * turning;
  const SO2d heading = planar().rotation();
  S x = state();
  x.q_map_body = SO3d::between(sample.specific_force_mps2, Eigen::Vector3d::UnitZ());
  const SO2d turn = heading * x.planar().rotation().inverse();
  x.q_map_body = SO3d(about_z(turn)) * x.q_map_body;
  x.velocity_mps.setZero();
  x.position_m.z() = 0.0;
  Square p = Square::Zero();
  auto sigma2 = p.diagonal();
  sigma2.segment<3>(S::kPosition).setConstant(p_.height_sigma_m * p_.height_sigma_m);
  sigma2.segment<3>(S::kVelocity).setConstant(p_.speed_sigma_mps * p_.speed_sigma_mps);
  sigma2.segment<3>(S::kAttitude).setConstant(tilt2);
  sigma2.segment<3>(S::kGyroBias).setConstant(std::pow(p_.noise.gyro_bias_radps, 2));
  sigma2.segment<3>(S::kAccelBias).setConstant(std::pow(p_.noise.accel_bias_mps2, 2));
  if (again) p.bottomRightCorner<6, 6>() = covariance().bottomRightCorner<6, 6>();
  ekf_ = Ekf<S>(x, p);
  rest_.reset();
  mean_force_ = g * Eigen::Vector3d::UnitZ();
  lost_s_ = since_constraint_s_ = 0.0;
  last_ = sample;
  time_ = sample.time;
  placed_ = false;
  ++starts_;
}

void CarrierFilter::step(const ImuSample& from, const ImuSample& to) {
  ekf_.predict(model_, wayfare::between(from, to));
  time_ = to.time;
}

bool CarrierFilter::covers(LogTime time) const {
  return last_ && std::abs(to_seconds(time - last_->time)) <= p_.silence_s;
}

void CarrierFilter::advance(LogTime time) {
  if (!last_ || !(time > time_)) return;
  ImuSample now = *last_, then = *last_;
  now.time = time_;
  then.time = time;
  step(now, then);
}

/// Correlated errors as equivalent white noise: a process of variance σ² and correlation time τ,
/// measured every T, has variance 2 σ² τ/T per measurement.
void CarrierFilter::apply_floor_constraints(double elapsed_s) {
  if (at_rest()) {
    apply_zero_velocity(elapsed_s);
    return;
  }
  const double spread = 2 * p_.height_time_s / elapsed_s;
  const auto floor = [&](int i, double value, double sigma) {
    ekf_.update([&](const S&) { return element(i, -value, sigma * sigma * spread); });
  };
  floor(S::kPosition + 2, state().position_m.z(), p_.height_sigma_m);
  floor(S::kVelocity + 2, state().velocity_mps.z(), p_.climb_sigma_mps);
  const double most = p_.speed_sigma_mps * p_.speed_sigma_mps;
  for (int i = 0; i < 2; ++i) {
    // With this noise the variance becomes `most`: the constraint is not counted repeatedly.
    const double v2 = covariance()(S::kVelocity + i, S::kVelocity + i);
    if (v2 > most)
      ekf_.update([&](const S& x) {
        return element(S::kVelocity + i, -x.velocity_mps[i], most * v2 / (v2 - most));
      });
  }
}

/// The gyro reads its bias, the velocity is zero.
void CarrierFilter::apply_zero_velocity(double elapsed_s) {
  const double rate2 = p_.rest_rate_density * p_.rest_rate_density / elapsed_s;
  for (int i = 0; i < 3; ++i) {
    const double v2 = p_.rest_sigma_mps * p_.rest_sigma_mps;
    ekf_.update([&](const S& x) { return element(S::kVelocity + i, -x.velocity_mps[i], v2); });
    const double mean = rest_.mean_rate()[i];
    // A slow steady rotation is not a bias: gate the update.
    ekf_.update(
        [&](const S& x) { return element(S::kGyroBias + i, mean - x.gyro_bias_radps[i], rate2); },
        4.0);
  }
}

bool CarrierFilter::at_rest() const {
  return rest_.still_s() > p_.rest_time_s && rest_.mean_rate().norm() < p_.rest_bias_limit;
}

bool CarrierFilter::level_lost(const ImuSample& sample, double dt_s) {
  const Eigen::Vector3d force = state().q_map_body * sample.specific_force_mps2;
  mean_force_ += (force - mean_force_) * (dt_s / (1 + dt_s));
  const bool tilted =
      mean_force_.head<2>().norm() > p_.lost_level_mps2 || mean_force_.z() < -p_.lost_level_mps2;
  lost_s_ = tilted ? lost_s_ + dt_s : 0.0;
  const double off = sample.specific_force_mps2.norm() / CarrierModel::kGravity_mps2 - 1;
  return lost_s_ >= 0.5 && std::abs(off) < 0.3;
}

void CarrierFilter::place(const SE2d& T_map_base, double sigma_m, Angle sigma) {
  const SO2d turn = T_map_base.rotation() * planar().rotation().inverse();
  const Eigen::Matrix3d r = about_z(turn);
  S x = state();
  x.position_m.head<2>() = T_map_base.translation();
  x.velocity_mps = r * x.velocity_mps;
  x.q_map_body = SO3d(r) * x.q_map_body;
  Square g = Square::Identity();
  g.block<3, 3>(S::kPosition, S::kPosition) = r;
  g.block<3, 3>(S::kVelocity, S::kVelocity) = r;
  Square p = g * covariance() * g.transpose();
  // The attitude error about the vertical is set to `sigma`.
  const Eigen::Vector3d up = x.q_map_body.inverse() * Eigen::Vector3d::UnitZ();
  Square drop = Square::Identity();
  drop.block<3, 3>(S::kAttitude, S::kAttitude) -= up * up.transpose();
  p = (drop * p * drop.transpose()).eval();
  p.block<3, 3>(S::kAttitude, S::kAttitude) += std::pow(sigma.radians(), 2) * up * up.transpose();
  ekf_ = Ekf<S>(x, 0.5 * (p + p.transpose()));
  for (int i = 0; i < 2; ++i) ekf_.reset_variance(S::kPosition + i, sigma_m * sigma_m);
  placed_ = true;
}

Eigen::Matrix3d CarrierFilter::planar_covariance() const {
  const auto c = state().planar_jacobian();
  const Eigen::Matrix3d back = about_z(planar().rotation().inverse());
  const Eigen::Matrix3d p = back * (c * covariance() * c.transpose()) * back.transpose();
  return 0.5 * (p + p.transpose());
}

SO3d CarrierFilter::q_level_body() const {
  return SO3d(about_z(planar().rotation().inverse())) * state().q_map_body;
}

Angle CarrierFilter::level_sigma() const {
  const Eigen::Matrix3d r = state().q_map_body.matrix();
  const Eigen::Matrix3d p =
      r * covariance().block<3, 3>(S::kAttitude, S::kAttitude) * r.transpose();
  const double mean = 0.5 * (p(0, 0) + p(1, 1));
  return Angle::radians(std::sqrt(mean + std::hypot(0.5 * (p(0, 0) - p(1, 1)), p(0, 1))));
}

std::optional<double> CarrierFilter::fuse(const SE2d& T_map_base,
                                          const Eigen::Matrix3d& covariance_in_pose) {
  const SE2d here = planar();
  Eigen::Vector3d innovation;
  innovation << T_map_base.translation() - here.translation(),
      (here.rotation().inverse() * T_map_base.rotation()).angle().radians();
  const Eigen::Matrix3d r = about_z(T_map_base.rotation());
  const Eigen::Matrix3d turned = r * covariance_in_pose * r.transpose();
  const Eigen::Matrix3d noise = 0.5 * (turned + turned.transpose());
  if (p_.independent_matches) {
    if (!ekf_.update_block<3>(innovation, state().planar_jacobian(), noise)) return std::nullopt;
    return 1.0;
  }
  const auto fused = covariance_intersection<S::kDof, 3>(covariance(), state().planar_jacobian(),
                                                         noise, innovation);
  if (!fused) return std::nullopt;
  ekf_ = Ekf<S>(state().plus(fused->correction), fused->covariance);
  // Intersection inflates unobserved states; a bias is never less certain than initially.
  for (int i = S::kGyroBias; i < S::kDof; ++i) {
    const double most = i < S::kAccelBias ? p_.noise.gyro_bias_radps : p_.noise.accel_bias_mps2;
    const double factor = most / std::sqrt(covariance()(i, i));
    if (factor < 1) ekf_.scale_sigma(i, 1, factor);
  }
  return fused->omega;
}

}  // namespace wayfare
