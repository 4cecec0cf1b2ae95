#pragma once

// Recordings of walks with a phone (Microsoft's indoor location data, 2020) and with a head-mounted
// unit (Rocip), if available.

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <wayfare/io/text_file.hpp>
#include <wayfare/pedestrian/pedestrian.hpp>

namespace wayfare::testing {

struct TimedPoint {
  double t_s = 0.0;
  Eigen::Vector2d p = Eigen::Vector2d::Zero();
};

struct WalkRecording {
  MargRecording samples;
  std::vector<TimedPoint> truth;
  double length_m = 0.0;
};

inline void measure_length(WalkRecording& walk, std::size_t stride) {
  for (std::size_t i = stride; i < walk.truth.size(); i += stride)
    walk.length_m += (walk.truth[i].p - walk.truth[i - stride].p).norm();
}

/// Recordings begin at zero, the samples a thousand seconds later, since waypoints may be earlier.
inline LogTime recording_time(double t_s) {
  return LogTime::from_nanoseconds(std::llround((t_s + 1000.0) * 1e9));
}

inline Result<WalkRecording> read_phone_walk(const std::string& path) {
  const auto table = io::read_float_table(path);
  if (!table) return table.error();
  if (table->columns < 10) return Error{ErrorCode::invalid, "has too few columns", path};
  WalkRecording walk;
  for (std::size_t i = 0; i < table->rows(); ++i) {
    const auto r = table->row(i);
    const auto v = [&](std::size_t c) { return Eigen::Vector3d(r[c], r[c + 1], r[c + 2]); };
    walk.samples.push_back({recording_time(double(r[0])), v(4), v(1), v(7)});
  }
  std::ifstream points(path.substr(0, path.find(".f32")) + ".waypoints.csv");
  for (std::string line; std::getline(points, line);) {
    TimedPoint p;
    if (std::sscanf(line.c_str(), "%lf,%lf,%lf", &p.t_s, &p.p.x(), &p.p.y()) == 3)
      walk.truth.push_back(p);
  }
  if (walk.truth.size() < 2) return Error{ErrorCode::not_found, "has no waypoints", path};
  measure_length(walk, 1);
  return walk;
}

inline Result<WalkRecording> read_head_walk(const std::string& path) {
  const auto table = io::read_float_table(path);
  if (!table) return table.error();
  if (table->columns < 16) return Error{ErrorCode::invalid, "has too few columns", path};
  WalkRecording walk;
  for (std::size_t i = 0; i < table->rows(); ++i) {
    const auto r = table->row(i);
    const auto v = [&](std::size_t c) { return Eigen::Vector3d(r[c], r[c + 1], r[c + 2]); };
    // Uncalibrated, roughly in units of the Earth's field.
    const Eigen::Vector3d field = 45.0 * v(7);
    walk.samples.push_back(
        {recording_time(double(r[0])), v(1), v(4),
         field.isZero() ? Eigen::Vector3d::Constant(MargSample::kNone).eval() : field});
    walk.truth.push_back({double(r[0]), {r[10], r[12]}});
  }
  measure_length(walk, 30);
  return walk;
}

struct WalkedStep {
  double t_s, heading_rad, length_m;
  Step step;
};

inline std::vector<WalkedStep> steps_along(const WalkRecording& walk,
                                           const PedestrianParameters& parameters) {
  Pedestrian pedestrian(parameters);
  std::vector<WalkedStep> steps;
  std::vector<double> north;
  for (const MargSample& s : walk.samples)
    pedestrian.add(s, [&](const PedestrianPose& p) {
      steps.push_back(
          {to_seconds(p.time - recording_time(0.0)), p.heading.radians(), p.length_m, p.step});
      north.push_back(pedestrian.mean_field().correction());
    });
  // The path turns about its start with every step.
  for (std::size_t i = 0; i < steps.size(); ++i) steps[i].heading_rad += north.back() - north[i];
  return steps;
}

/// The dead-reckoned path at the times of the truth, interpolated between steps.
inline std::vector<Eigen::Vector2d> path_of(const std::vector<WalkedStep>& steps,
                                            const WalkRecording& walk) {
  std::vector<TimedPoint> track;
  Eigen::Vector2d p = Eigen::Vector2d::Zero();
  for (const WalkedStep& s : steps) {
    if (track.empty() || s.t_s - track.back().t_s > 1.5 * s.step.interval_s)
      track.push_back({s.t_s - s.step.interval_s, p});
    p += s.length_m * Eigen::Vector2d(std::cos(s.heading_rad), std::sin(s.heading_rad));
    track.push_back({s.t_s, p});
  }
  std::vector<Eigen::Vector2d> points;
  std::size_t i = 0;
  for (const TimedPoint& q : walk.truth) {
    while (i + 1 < track.size() && track[i + 1].t_s <= q.t_s) ++i;
    if (track.empty()) {
      points.emplace_back(0.0, 0.0);
    } else if (i + 1 == track.size() || q.t_s <= track[i].t_s) {
      points.push_back(track[i].p);
    } else {
      const double u = (q.t_s - track[i].t_s) / (track[i + 1].t_s - track[i].t_s);
      points.push_back((1.0 - u) * track[i].p + u * track[i + 1].p);
    }
  }
  return points;
}

/// The direction of the true path between the points `reach_s` before and after a time or, with
/// zero, between the two around it.
inline double true_direction(const WalkRecording& walk, double t_s, double reach_s) {
  const auto after = [&](double t) {
    std::size_t i = 1;
    while (i + 1 < walk.truth.size() && walk.truth[i].t_s < t) ++i;
    return i;
  };
  const Eigen::Vector2d d =
      reach_s > 0.0 ? walk.truth[after(t_s + reach_s)].p - walk.truth[after(t_s - reach_s)].p
                    : walk.truth[after(t_s)].p - walk.truth[after(t_s) - 1].p;
  return std::atan2(d.y(), d.x());
}

/// With the true direction of every step.
inline std::vector<WalkedStep> with_true_directions(std::vector<WalkedStep> steps,
                                                    const WalkRecording& walk, double reach_s) {
  for (WalkedStep& s : steps) s.heading_rad = true_direction(walk, s.t_s, reach_s);
  return steps;
}
/// With the true length of the walk.
inline std::vector<WalkedStep> with_true_length(std::vector<WalkedStep> steps,
                                                const WalkRecording& walk) {
  double sum = 0.0;
  for (const WalkedStep& s : steps) sum += s.length_m;
  for (WalkedStep& s : steps) s.length_m *= sum > 0.0 ? walk.length_m / sum : 1.0;
  return steps;
}
/// With the gyro's mean bias known: without the linear part of the heading drift.
inline std::vector<WalkedStep> without_drift(std::vector<WalkedStep> steps,
                                             const WalkRecording& walk, double reach_s) {
  double unwrapped = 0.0, t = 0.0, h = 0.0, tt = 0.0, th = 0.0;
  for (const WalkedStep& s : steps) {
    unwrapped += wrap_to_pi(s.heading_rad - true_direction(walk, s.t_s, reach_s) - unwrapped);
    t += s.t_s;
    h += unwrapped;
    tt += s.t_s * s.t_s;
    th += s.t_s * unwrapped;
  }
  const double n = double(steps.size());
  for (WalkedStep& s : steps) s.heading_rad -= (n * th - t * h) / (n * tt - t * t) * s.t_s;
  return steps;
}

inline PedestrianParameters head_parameters() {
  PedestrianParameters p;
  p.forward = Eigen::Vector3d::UnitZ();
  p.length = KimStep{0.65};
  // An uncalibrated magnetometer needs the gates.
  const AhrsParameters usual;
  p.ahrs.field_norm_gate = usual.field_norm_gate;
  p.ahrs.field_dip_gate = usual.field_dip_gate;
  p.ahrs.heading_density = usual.heading_density;
  return p;
}

struct WalkErrors {
  double absolute = 0.0;  ///< at the end, relative to the distance, without alignment
  double turned = 0.0;    ///< the same after the best rotation about the start
  double turn_rad = 0.0;  ///< that rotation, counter-clockwise
  double ate_m = 0.0;     ///< root mean square after rigid alignment
};

inline WalkErrors walk_errors(const std::vector<WalkedStep>& steps, const WalkRecording& walk) {
  const std::vector<Eigen::Vector2d> path = path_of(steps, walk);
  const auto best_rotation = [&](const Eigen::Vector2d& a0, const Eigen::Vector2d& b0) {
    double dot = 0.0, cross = 0.0;
    for (std::size_t i = 0; i < path.size(); ++i) {
      const Eigen::Vector2d a = path[i] - a0, b = walk.truth[i].p - b0;
      dot += a.dot(b);
      cross += a.x() * b.y() - a.y() * b.x();
    }
    return Eigen::Rotation2Dd(std::atan2(cross, dot));
  };
  const Eigen::Vector2d a0 = path.front(), b0 = walk.truth.front().p;
  const Eigen::Vector2d a = path.back() - a0, b = walk.truth.back().p - b0;
  WalkErrors e;
  e.absolute = (a - b).norm() / walk.length_m;
  const Eigen::Rotation2Dd turn = best_rotation(a0, b0);
  e.turn_rad = turn.angle();
  e.turned = (turn * a - b).norm() / walk.length_m;
  Eigen::Vector2d am = Eigen::Vector2d::Zero(), bm = am;
  const double n = double(path.size());
  for (std::size_t i = 0; i < path.size(); ++i) {
    am += path[i] / n;
    bm += walk.truth[i].p / n;
  }
  const auto rotation = best_rotation(am, bm);
  double squares = 0.0;
  for (std::size_t i = 0; i < path.size(); ++i)
    squares += (rotation * (path[i] - am) - (walk.truth[i].p - bm)).squaredNorm();
  e.ate_m = std::sqrt(squares / n);
  return e;
}

}  // namespace wayfare::testing
