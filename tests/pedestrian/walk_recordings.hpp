#pragma once

// Recordings of walks with a phone (Microsoft's indoor location data, 2020) and with a unit on the
// head (Rocip), where they are.

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <wayfare/estimate/pedestrian.hpp>
#include <wayfare/io/float_table.hpp>

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

/// Recordings begin at zero; their samples a thousand seconds later, for waypoints may come before.
inline LogTime recording_time(double t_s) {
  return LogTime::from_nanoseconds(std::llround((t_s + 1000.0) * 1e9));
}

inline Result<WalkRecording> read_phone_walk(const std::string& path) {
  const auto table = io::read_float_table(path);
  if (!table) return table.error();
  if (table->columns < 10) return Error{ErrorCode::invalid, "has other columns", path};
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
  if (table->columns < 16) return Error{ErrorCode::invalid, "has other columns", path};
  WalkRecording walk;
  for (std::size_t i = 0; i < table->rows(); ++i) {
    const auto r = table->row(i);
    const auto v = [&](std::size_t c) { return Eigen::Vector3d(r[c], r[c + 1], r[c + 2]); };
    // Not calibrated: in units of the Earth's field, about.
    const Eigen::Vector3d field = 45.0 * v(7);
    walk.samples.push_back(
        {recording_time(double(r[0])), v(1), v(4),
         field.isZero() ? Eigen::Vector3d::Constant(MargSample::kNone).eval() : field});
    walk.truth.push_back({double(r[0]), {r[10], r[12]}});
  }
  measure_length(walk, 30);
  return walk;
}

/// The walked way at the times of the truth, interpolated between steps.
struct WalkedWay {
  std::vector<Eigen::Vector2d> points;
  std::vector<Step> steps;
};

inline WalkedWay walk_along(const WalkRecording& walk, const PedestrianParameters& parameters) {
  Pedestrian pedestrian(parameters);
  WalkedWay way;
  std::vector<TimedPoint> track;
  for (const MargSample& s : walk.samples)
    pedestrian.add(s, [&](const PedestrianPose& p) {
      const double t = to_seconds(p.time - recording_time(0.0));
      if (track.empty() || t - track.back().t_s > 1.5 * p.step.interval_s)
        track.push_back({t - p.step.interval_s,
                         track.empty() ? Eigen::Vector2d::Zero().eval() : track.back().p});
      track.push_back({t, p.position_m});
      way.steps.push_back(p.step);
    });
  std::size_t i = 0;
  for (const TimedPoint& q : walk.truth) {
    while (i + 1 < track.size() && track[i + 1].t_s <= q.t_s) ++i;
    if (track.empty()) {
      way.points.emplace_back(0.0, 0.0);
    } else if (i + 1 == track.size() || q.t_s <= track[i].t_s) {
      way.points.push_back(track[i].p);
    } else {
      const double u = (q.t_s - track[i].t_s) / (track[i + 1].t_s - track[i].t_s);
      way.points.push_back((1.0 - u) * track[i].p + u * track[i + 1].p);
    }
  }
  return way;
}

inline PedestrianParameters head_parameters() {
  PedestrianParameters p;
  p.forward = Eigen::Vector3d::UnitZ();
  p.length = KimStep{0.65};
  // A magnetometer that was never calibrated must be refused where it does not fit.
  const AhrsParameters usual;
  p.ahrs.field_norm_gate = usual.field_norm_gate;
  p.ahrs.field_dip_gate = usual.field_dip_gate;
  p.ahrs.heading_density = usual.heading_density;
  return p;
}

struct WalkErrors {
  double absolute = 0.0;  ///< at the end, as part of the distance, heading as it is
  double turned = 0.0;    ///< the same, turned about the start to fit the truth best
  double ate_m = 0.0;     ///< root mean square after the best rigid fit
};

inline WalkErrors walk_errors(const WalkedWay& way, const WalkRecording& walk) {
  const auto best_turn = [&](const Eigen::Vector2d& a0, const Eigen::Vector2d& b0) {
    double dot = 0.0, cross = 0.0;
    for (std::size_t i = 0; i < way.points.size(); ++i) {
      const Eigen::Vector2d a = way.points[i] - a0, b = walk.truth[i].p - b0;
      dot += a.dot(b);
      cross += a.x() * b.y() - a.y() * b.x();
    }
    return Eigen::Rotation2Dd(std::atan2(cross, dot));
  };
  const Eigen::Vector2d a0 = way.points.front(), b0 = walk.truth.front().p;
  const Eigen::Vector2d a = way.points.back() - a0, b = walk.truth.back().p - b0;
  WalkErrors e;
  e.absolute = (a - b).norm() / walk.length_m;
  e.turned = (best_turn(a0, b0) * a - b).norm() / walk.length_m;
  Eigen::Vector2d am = Eigen::Vector2d::Zero(), bm = am;
  const double n = double(way.points.size());
  for (std::size_t i = 0; i < way.points.size(); ++i) {
    am += way.points[i] / n;
    bm += walk.truth[i].p / n;
  }
  const auto turn = best_turn(am, bm);
  double squares = 0.0;
  for (std::size_t i = 0; i < way.points.size(); ++i)
    squares += (turn * (way.points[i] - am) - (walk.truth[i].p - bm)).squaredNorm();
  e.ate_m = std::sqrt(squares / n);
  return e;
}

}  // namespace wayfare::testing
