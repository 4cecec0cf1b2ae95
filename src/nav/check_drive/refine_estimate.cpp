// Mounting, time offset and lever arm by runs of the filter.

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <vector>

#include <Eigen/Cholesky>

#include <wayfare/nav/check_drive.hpp>

namespace wayfare {
namespace {

using Eigen::Vector3d;
using Kind = InnovationRecord::Kind;

/// The direction of travel and the vertical in the unit's axes, averaged over the run.
class Directions {
 public:
  void add(const GnssInsPoint& p, const SO3d& q_body_imu) {
    const SO3d unit_nav = (p.nav.q_nb * q_body_imu).inverse();
    travel_ += unit_nav * p.nav.velocity_ned_mps;
    down_ += p.nav.velocity_ned_mps.norm() * (unit_nav * Vector3d::UnitZ());
    distance_ += p.nav.velocity_ned_mps.norm();
  }
  /// One if it always travels in the same direction of the unit.
  [[nodiscard]] double steadiness() const {
    return distance_ > 0.0 ? travel_.norm() / distance_ : 0.0;
  }
  [[nodiscard]] SO3d mounting() const {
    const Vector3d x = travel_.normalized();
    const Vector3d z = (down_ - down_.dot(x) * x).normalized();
    Eigen::Matrix3d body;
    body << x.transpose(), z.cross(x).transpose(), z.transpose();
    return SO3d(body);
  }

 private:
  Vector3d travel_ = Vector3d::Zero(), down_ = Vector3d::Zero();
  double distance_ = 0.0;
};

void refine_mounting(const GnssInsResult& run, const SO3d& q_body_imu, DriveEstimate& estimate) {
  constexpr double kFast_mps = 5.0, kSteady = 0.97;
  constexpr std::size_t kParts = 8, kEvery = 10;
  Directions all;
  std::vector<Directions> parts(kParts);
  std::vector<const GnssInsPoint*> fast;
  for (std::size_t i = 0; i < run.points.size(); i += kEvery)
    if (run.points[i].nav.velocity_ned_mps.norm() > kFast_mps) fast.push_back(&run.points[i]);
  if (fast.size() < 10 * kParts) return;
  for (std::size_t i = 0; i < fast.size(); ++i) {
    all.add(*fast[i], q_body_imu);
    parts[i * kParts / fast.size()].add(*fast[i], q_body_imu);
  }
  if (all.steadiness() < kSteady) return;
  double squares = 0.0;
  for (const Directions& part : parts)
    squares += (part.mounting() * all.mounting().inverse()).log().squaredNorm();
  estimate.q_body_imu = all.mounting();
  estimate.mounting_sigma_rad = std::sqrt(squares) / kParts + 0.002;
}

/// Innovations of the receiver's measurements, found again in another run.
using Key = std::tuple<LogTime, Kind, SatelliteId, int>;
std::map<Key, InnovationRecord> receiver_innovations(const GnssInsResult& run) {
  constexpr double kTransient_s = 10.0;
  std::map<Key, InnovationRecord> result;
  int axis = 0;
  LogTime last = run.points.front().nav.time;
  const LogTime from = last + from_seconds(kTransient_s);
  Kind kind = Kind::range;
  for (const InnovationRecord& r : run.innovations) {
    if (r.kind == Kind::constraint || r.kind == Kind::standstill) continue;
    axis = r.time == last && r.kind == kind && r.satellite.number == 0 ? axis + 1 : 0;
    last = r.time, kind = r.kind;
    if (r.time > from) result.emplace(Key{r.time, r.kind, r.satellite, axis}, r);
  }
  return result;
}

struct Step {
  Eigen::Vector4d change = Eigen::Vector4d::Zero();  ///< lever arm, m, and time offset, s
  Eigen::Vector4d sigma = Eigen::Vector4d::Constant(1e9);
};

constexpr double kLeverStep_m = 0.3, kTimeStep_s = 0.02;

GnssInsOptions moved(GnssInsOptions options, int parameter, double change) {
  if (parameter < 3) options.antenna_lever_arm_m[parameter] += change;
  if (parameter == 3) options.imu_time_offset_s += change;
  return options;
}

/// Least squares of innovations that are linear in the parameters; their derivatives are the
/// differences between runs.
std::optional<Step> fit_innovations(const GnssInsRecording& recording,
                                    const GnssInsOptions& options, const GnssInsResult& run) {
  constexpr double kOutlier = 2.5;
  const auto base = receiver_innovations(run);
  std::vector<std::map<Key, InnovationRecord>> other;
  const Eigen::Vector4d width(kLeverStep_m, kLeverStep_m, kLeverStep_m, kTimeStep_s);
  for (int i = 0; i < 4; ++i) {
    const auto changed = run_gnss_ins(recording, moved(options, i, width[i]));
    if (!changed) return std::nullopt;
    other.push_back(receiver_innovations(*changed));
  }
  Eigen::Matrix4d a = Eigen::Matrix4d::Zero();
  Eigen::Vector4d b = Eigen::Vector4d::Zero();
  double squares = 0.0, weights = 0.0;
  for (const auto& [key, r] : base) {
    Eigen::Vector4d row;
    bool found = r.accepted;
    for (std::size_t i = 0; found && i < 4; ++i) {
      const auto at = other[i].find(key);
      found = at != other[i].end() && at->second.accepted;
      const auto k = static_cast<Eigen::Index>(i);
      if (found) row[k] = (at->second.innovation - r.innovation) / (width[k] * r.sigma);
    }
    if (!found) continue;
    const double y = r.innovation / r.sigma;
    const double weight = std::min(1.0, kOutlier / std::max(std::abs(y), 1e-9));
    a += weight * row * row.transpose(), b -= weight * y * row;
    squares += weight * y * y, weights += weight;
  }
  if (weights < 100.0) return std::nullopt;
  // What is not observable stays: a priori 1 m, 1 s.
  const double scale = std::max(squares / weights, 1.0);
  a /= scale, b /= scale;
  a += Eigen::Matrix4d::Identity();
  const Eigen::LDLT<Eigen::Matrix4d> solver(a);
  Step step{solver.solve(b), solver.solve(Eigen::Matrix4d::Identity()).diagonal().cwiseSqrt()};
  return step.change.allFinite() && step.sigma.allFinite() ? std::optional(step) : std::nullopt;
}

}  // namespace

void refine_estimate(const GnssInsRecording& recording, const GnssInsOptions& options,
                     DriveEstimate& estimate) {
  constexpr double kObservable_m = 0.1;
  if (!estimate.q_body_imu || !estimate.imu_time_offset_s) return;
  const GnssInsRecording readings = corrected(recording, estimate);
  GnssInsOptions now = corrected(options, estimate);
  for (int round = 0; round < 2; ++round) {
    const auto run = run_gnss_ins(readings, now);
    if (!run) return;
    refine_mounting(*run, now.q_body_imu, estimate);
    // The lever arm is in body axes: it turns with them.
    now.q_body_imu = *estimate.q_body_imu;
    const auto step = fit_innovations(readings, now, *run);
    if (!step) return;
    const Eigen::Vector4d most(1.0, 1.0, 1.0, 0.2);
    const Eigen::Vector4d change = step->change.cwiseMax(-most).cwiseMin(most);
    for (int i = 0; i < 3; ++i)
      if (step->sigma[i] < kObservable_m) now.antenna_lever_arm_m[i] += change[i];
    now.imu_time_offset_s += change[3];
    estimate.imu_time_offset_s = now.imu_time_offset_s;
    estimate.time_offset_sigma_s = step->sigma[3];
    estimate.antenna_lever_arm_m = now.antenna_lever_arm_m;
    estimate.lever_arm_sigma_m = step->sigma.head<3>();
  }
}

GnssInsRecording corrected(GnssInsRecording recording, const DriveEstimate& estimate) {
  for (ImuSample& s : recording.imu) {
    s.angular_rate_radps = s.angular_rate_radps.cwiseProduct(estimate.gyro_factor);
    s.specific_force_mps2 = s.specific_force_mps2.cwiseProduct(estimate.accel_factor);
  }
  return recording;
}

GnssInsOptions corrected(GnssInsOptions options, const DriveEstimate& estimate) {
  if (estimate.q_body_imu) options.q_body_imu = *estimate.q_body_imu;
  if (estimate.imu_time_offset_s) options.imu_time_offset_s = *estimate.imu_time_offset_s;
  if (estimate.antenna_lever_arm_m) options.antenna_lever_arm_m = *estimate.antenna_lever_arm_m;
  return options;
}

}  // namespace wayfare
