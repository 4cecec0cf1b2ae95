#include "hector_walks.hpp"

#include <cmath>
#include <numbers>
#include <optional>

#include <Eigen/Cholesky>

#include <wayfare/inertial/ahrs.hpp>
#include <wayfare/slam/hector_slam.hpp>

#include "recorded_walk.hpp"

namespace wayfare::examples {
namespace {

constexpr double kToDegrees = 180 / std::numbers::pi;
constexpr double kAccelBias_mps2 = 0.03;  // standard deviation, some time after calibration

struct Mean {
  double sum = 0.0;
  int count = 0;
  void add(double value) {
    sum += value;
    ++count;
  }
  [[nodiscard]] double get() const { return sum / count; }  // NaN without values
};

template <class Vector, class Matrix>
double nees(const Vector& error, const Matrix& covariance) {
  return error.dot(covariance.llt().solve(error)) / static_cast<double>(error.size());
}

/// Estimate of a method at a scan.
struct Estimate {
  SO3d q_level_head;  // with any heading
  std::optional<CarrierState> state{};
  CarrierFilter::Square covariance{};
};

class Comparison {
 public:
  explicit Comparison(const SimulatedWalk& walk) : walk_(walk) {}

  /// `at_end`: of the pose at the end of a sweep.
  void add(std::size_t scan, const SE2d& pose, const Estimate& estimate, bool at_end = false) {
    const LaserScan& measured = walk_.recorded.scans[scan];
    const StampedPose truth = at_end && measured.is_sweep() ? walk_.truth_at(measured.end_time())
                                                            : walk_.recorded.truth[scan];
    truth_.push_back(truth);
    if (!start_) start_ = truth.T_map_base.raw() * pose.inverse();
    trajectory_.push_back({truth.time, Transform2<frame::Map, frame::Base>(pose)});
    const SE2d expected = start_->inverse() * truth.T_map_base.raw();
    const double rotation = (pose.rotation().inverse() * expected.rotation()).angle().radians();
    heading2_.add(rotation * rotation);
    const double t = truth.time.seconds();
    const SO3d head = walk_.head.at(t).q_world_head;
    const Eigen::Vector3d up = head.inverse() * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d up_estimate = estimate.q_level_head.inverse() * Eigen::Vector3d::UnitZ();
    const double tilt = std::atan2(up.cross(up_estimate).norm(), up.dot(up_estimate));
    tilt2_.add(tilt * tilt);
    if (estimate.state) check(estimate, expected, up, t);
  }

  [[nodiscard]] HectorErrors errors() const {
    return {rmse_m(trajectory_, truth_),
            kToDegrees * std::sqrt(heading2_.get()),
            kToDegrees * std::sqrt(tilt2_.get()),
            pose_.get(),
            tilt_.get(),
            velocity_.get()};
  }

 private:
  void check(const Estimate& estimate, const SE2d& expected, const Eigen::Vector3d& up, double t) {
    const CarrierState& x = *estimate.state;
    const SE2d here = x.planar();
    Eigen::Vector3d off;
    off << expected.translation() - here.translation(),
        (here.rotation().inverse() * expected.rotation()).angle().radians();
    const auto c = x.planar_jacobian();
    pose_.add(nees(off, Eigen::Matrix3d(c * estimate.covariance * c.transpose())));

    // A rotation by τ changes the vertical u of the state to u + [u]× τ.
    const Eigen::Vector3d u = x.q_map_body.inverse() * Eigen::Vector3d::UnitZ();
    Eigen::Matrix<double, 2, 3> across;
    across.row(0) = u.unitOrthogonal();
    across.row(1) = u.cross(across.row(0).transpose());
    const Eigen::Matrix<double, 2, 3> moves = across * skew(u);
    tilt_.add(nees(Eigen::Vector2d(across * (up - u)),
                   Eigen::Matrix2d(moves *
                                   estimate.covariance.block<3, 3>(CarrierState::kAttitude,
                                                                   CarrierState::kAttitude) *
                                   moves.transpose())));

    constexpr double kStep_s = 0.004;
    Eigen::Vector3d v =
        (walk_.head.at(t + kStep_s).position_m - walk_.head.at(t - kStep_s).position_m) /
        (2 * kStep_s);
    v.head<2>() = start_->rotation().inverse() * Eigen::Vector2d(v.head<2>());
    velocity_.add(nees(Eigen::Vector3d(v - x.velocity_mps),
                       Eigen::Matrix3d(estimate.covariance.block<3, 3>(CarrierState::kVelocity,
                                                                       CarrierState::kVelocity))));
  }

  const SimulatedWalk& walk_;
  std::optional<SE2d> start_;
  Trajectory trajectory_, truth_;
  Mean heading2_, tilt2_, pose_, tilt_, velocity_;
};

HectorErrors scans_alone(const SimulatedWalk& walk) {
  HectorSlam slam;
  Comparison comparison(walk);
  for (std::size_t i = 0; i < walk.recorded.scans.size(); ++i)
    if (const auto outcome = slam.add_scan(walk.recorded.scans[i], std::nullopt))
      comparison.add(i, outcome->T_map_base.raw(), {});
  return comparison.errors();
}

/// Scans levelled by the attitude filter alone.
HectorErrors levelled(const SimulatedWalk& walk) {
  HectorSlam slam;
  Comparison comparison(walk);
  Ahrs<frame::Enu> ahrs(head_pedestrian(1.0).ahrs);
  auto reading = walk.recorded.unit.begin();
  for (std::size_t i = 0; i < walk.recorded.scans.size(); ++i) {
    const LaserScan& scan = walk.recorded.scans[i];
    for (; reading != walk.recorded.unit.end() && reading->time <= scan.end_time(); ++reading)
      ahrs.add(*reading);
    const SO3d q = ahrs.q_world_body();
    const Eigen::Vector3d x = q.matrix().col(0);
    const SO3d level = SO3d::exp(Eigen::Vector3d(0, 0, -std::atan2(x.y(), x.x()))) * q;
    if (const auto outcome = slam.add_scan(level_scan(scan, level), std::nullopt))
      comparison.add(i, outcome->T_map_base.raw(), {level});
  }
  return comparison.errors();
}

HectorErrors filtered(const SimulatedWalk& walk, const HectorSlamOptions& options) {
  HectorSlam slam(options);
  Comparison comparison(walk);
  auto reading = walk.recorded.unit.begin();
  for (std::size_t i = 0; i < walk.recorded.scans.size(); ++i) {
    const LaserScan& scan = walk.recorded.scans[i];
    for (; reading != walk.recorded.unit.end() && reading->time <= scan.end_time(); ++reading)
      slam.add(ImuSample{reading->time, reading->angular_rate_radps, reading->specific_force_mps2});
    const auto outcome = slam.add_scan(scan, std::nullopt);
    if (!outcome) continue;
    const CarrierFilter& c = slam.carrier();
    comparison.add(i, outcome->T_map_base.raw(), {c.q_level_body(), c.state(), c.covariance()},
                   true);
  }
  return comparison.errors();
}

}  // namespace

const std::vector<std::string>& hector_methods() {
  static const std::vector<std::string> names = {
      "none: tilted scans", "levelled by the attitude filter", "six degrees, intersected",
      "six degrees, as if independent"};
  return names;
}

std::vector<HectorErrors> follow_by_hector(const Walk& walk, std::uint64_t seed) {
  sim::HeadWalk::UnitNoise noise;
  noise.accel_bias_mps2 = kAccelBias_mps2;
  const SimulatedWalk simulated = simulate_walk(walk, seed, noise);
  HectorSlamOptions independent;
  independent.carrier.independent_matches = true;
  return {scans_alone(simulated), levelled(simulated), filtered(simulated, {}),
          filtered(simulated, independent)};
}

}  // namespace wayfare::examples
