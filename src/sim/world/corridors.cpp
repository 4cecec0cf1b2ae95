#include <wayfare/sim/worlds.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <wayfare/core/geodesy.hpp>
#include <wayfare/filter/gauss_markov.hpp>
#include <wayfare/sim/simulate_recording.hpp>

namespace wayfare::sim {
namespace {

constexpr double kDoor_m = 0.9;
constexpr double kPane_m = 1.5;
constexpr double kRoom_m = 3.0;

/// A straight wall in coordinates of its start: metres along it, and into the corridor.
class WallBuilder {
 public:
  WallBuilder(const Eigen::Vector2d& a, const Eigen::Vector2d& b, std::vector<Segment>& walls)
      : a_(a), along_((b - a).normalized()), inward_(-along_.y(), along_.x()), walls_(walls) {}

  [[nodiscard]] Eigen::Vector2d at(double along_m, double inward_m) const {
    return a_ + along_m * along_ + inward_m * inward_;
  }
  /// Points (along, inward), joined by walls.
  void path(const std::vector<std::pair<double, double>>& places) {
    for (std::size_t i = 1; i < places.size(); ++i)
      walls_.push_back(
          {at(places[i - 1].first, places[i - 1].second), at(places[i].first, places[i].second)});
  }
  void person(double along_m, double inward_m) {
    std::vector<std::pair<double, double>> round;
    for (int k = 0; k <= 8; ++k) {
      const double angle = 0.25 * std::numbers::pi * k;
      round.emplace_back(along_m + 0.15 * std::cos(angle), inward_m + 0.15 * std::sin(angle));
    }
    path(round);
  }

 private:
  Eigen::Vector2d a_, along_, inward_;
  std::vector<Segment>& walls_;
};

/// An interruption of a wall, from `begin` over `width`: a recess, or a room.
struct Opening {
  double begin = 0.0, width = 0.0;
  bool room = false, leaf = false;
};

std::vector<Opening> openings(double length, const CorridorFurniture& f, Rng& rng) {
  std::vector<Opening> all;
  if (f.door_spacing_m > 0.0) {
    for (double s = f.door_spacing_m * rng.uniform(0.2, 0.8); s + kDoor_m + 0.1 < length;
         s += f.door_spacing_m) {
      const bool open = rng.uniform() < f.open_share;
      all.push_back({s, kDoor_m, open, open && rng.uniform() < 0.5});
    }
  }
  const auto panes = static_cast<int>(std::lround(f.glass_per_m * length));
  for (int i = 0; i < panes; ++i)
    all.push_back({rng.uniform(0.1, std::max(0.1, length - kPane_m - 0.1)), kPane_m, true, false});
  std::sort(all.begin(), all.end(),
            [](const Opening& a, const Opening& b) { return a.begin < b.begin; });
  return all;
}

void place(WallBuilder& wall, const Opening& o, const CorridorFurniture& f) {
  const double end = o.begin + o.width;
  if (!o.room) {
    wall.path({{o.begin, 0.0}, {o.begin, -f.recess_m}, {end, -f.recess_m}, {end, 0.0}});
    return;
  }
  wall.path({{o.begin, 0.0}, {o.begin, -kRoom_m}, {end, -kRoom_m}, {end, 0.0}});
  // The leaf of an open door, at 60°.
  if (o.leaf) wall.path({{o.begin, 0.0}, {o.begin + 0.45, -0.78}});
}

constexpr double kQuarter = 0.5 * std::numbers::pi;

/// A part of the path: its length and its heading over it.
struct Stretch {
  double length_m = 0.0;
  double heading_rad = 0.0;  ///< at its start
  double turn_rad = 0.0;     ///< over its length
  double weave_rad = 0.0;
  int weaves = 0;

  [[nodiscard]] double heading_at(double s) const {
    const double u = s / length_m;
    double weave = 0.0;
    if (weaves > 0) {
      const double phase = u * weaves;
      const double side = static_cast<int>(phase) % 2 == 0 ? 1.0 : -1.0;
      weave = side * weave_rad * std::sin(2.0 * std::numbers::pi * phase);
    }
    return heading_rad + turn_rad * u + weave;
  }
};

Stretch corridor(double forward_m, double heading_rad, const CorridorDriveParams& p) {
  Stretch s{forward_m, heading_rad, 0.0, 0.0, 0};
  if (p.pattern == MotionPattern::straight) return s;
  s.weave_rad = p.weave_rad;
  s.weaves = std::max(1, static_cast<int>(forward_m / p.weave_length_m));
  double mean_cosine = 0.0;
  constexpr int kParts = 1000;
  for (int i = 0; i < kParts; ++i)
    mean_cosine += std::cos(p.weave_rad * std::sin(2.0 * std::numbers::pi * (i + 0.5) / kParts));
  s.length_m = forward_m * kParts / mean_cosine;
  return s;
}

std::array<Stretch, 5> path_stretches(const CorridorDriveParams& p) {
  const auto& l = p.place.lengths_m;
  const double r = p.corner_radius_m, arc = r * kQuarter;
  return {corridor(l[0] - r, 0.0, p), Stretch{arc, 0.0, kQuarter, 0.0, 0},
          corridor(l[1] - 2.0 * r, kQuarter, p), Stretch{arc, kQuarter, -kQuarter, 0.0, 0},
          corridor(l[2] - r, 0.0, p)};
}

struct Driven {
  Trajectory truth;
  std::array<LogTime, 4> section_ends;
};

/// Path lengths at which the walls of a corridor begin or end beside the vehicle.
std::array<double, 4> section_lengths(const std::array<Stretch, 5>& stretches, double margin) {
  std::array<double, 4> ends{};
  double s = 0.0;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    s += stretches[i].length_m;
    ends[i] = s + (i % 2 == 0 ? -margin : margin);
  }
  return ends;
}

Result<void> check(const CorridorDriveParams& p) {
  constexpr double kLongest_s = 86400.0;
  if (!(p.speed_m_s > 0.0) || !(p.acceleration_m_s2 > 0.0) || !(p.corner_radius_m > 0.0) ||
      !(p.weave_length_m > 0.0) || !std::isfinite(p.weave_rad) ||
      p.motion_period <= Duration::zero() || p.scan_period <= Duration::zero())
    return Error{ErrorCode::invalid,
                 "a drive needs positive speed, acceleration, radius, weave length and periods"};
  const auto& l = p.place.lengths_m;
  if (!(p.corner_radius_m < std::min({l[0], 0.5 * l[1], l[2]})))
    return Error{ErrorCode::invalid, "the corners are wider than a corridor is long"};
  const double length_m = l[0] + l[1] + l[2];
  const double slowest = std::min(p.speed_m_s, std::sqrt(p.acceleration_m_s2));
  if (!(p.rest_s >= 0.0 && p.rest_s + length_m / slowest <= kLongest_s))
    return Error{ErrorCode::invalid, "the drive takes longer than a day"};
  return {};
}

Driven drive(const CorridorDriveParams& p) {
  const auto stretches = path_stretches(p);
  const auto ends = section_lengths(stretches, 0.5 * p.place.width_m);
  const Duration step{10'000'000};
  const double dt = to_seconds(step);
  Driven driven;
  SE2d pose;
  LogTime time;
  const auto rest = static_cast<int>(p.rest_s / dt);
  for (int i = 0; i <= rest; ++i, time += step)
    driven.truth.push_back({time, Transform2<frame::Map, frame::Base>(pose)});
  double length = 0.0, gone = 0.0, speed = 0.0;
  for (const Stretch& s : stretches) length += s.length_m;
  std::size_t at = 0, section = 0;
  double before = 0.0, heading = 0.0;
  while (gone < length - 1e-3) {
    const double braking = std::sqrt(2.0 * p.acceleration_m_s2 * (length - gone));
    speed = std::min({speed + p.acceleration_m_s2 * dt, p.speed_m_s, braking});
    gone += std::min(speed * dt, length - gone);
    while (at + 1 < stretches.size() && gone - before > stretches[at].length_m)
      before += stretches[at++].length_m;
    const double next = stretches[at].heading_at(std::min(gone - before, stretches[at].length_m));
    pose = pose.plus({speed * dt, 0.0, next - heading});
    heading = next;
    driven.truth.push_back({time, Transform2<frame::Map, frame::Base>(pose)});
    for (; section < ends.size() && gone >= ends[section]; ++section)
      driven.section_ends[section] = time;
    time += step;
  }
  return driven;
}

/// Constant, ramp and Gauss-Markov part of the bias over time, and a sample's noise.
class GyroErrors {
 public:
  GyroErrors(const CorridorGyro& g, double dt_s, Rng& rng)
      : rng_(rng), step_(discretise_gauss_markov(g.walk_sigma_rad_s, g.walk_tau_s, dt_s)) {
    constant_ = rng_.uniform(-g.max_bias_rad_s, g.max_bias_rad_s);
    drift_ = rng_.uniform() < 0.5 ? -g.drift_rad_s2 : g.drift_rad_s2;
    walk_ = g.walk_sigma_rad_s * rng_.normal();
    noise_ = g.angle_random_walk_rad_per_sqrt_s / std::sqrt(dt_s);
  }
  double bias(double seconds) {
    walk_ = step_.phi * walk_ + std::sqrt(step_.q) * rng_.normal();
    return constant_ + drift_ * seconds + walk_;
  }
  double noise() { return noise_ * rng_.normal(); }

 private:
  Rng& rng_;
  ProcessStep1<double> step_;
  double constant_ = 0.0, drift_ = 0.0, walk_ = 0.0, noise_ = 0.0;
};

void read_gyro(const CorridorDriveParams& p, Rng rng, CorridorDrive& drive) {
  const Trajectory& truth = drive.recording.truth;
  const double dt = to_seconds(p.motion_period);
  GyroErrors errors(p.gyro, dt, rng);
  // Up is the axis: the Earth rotates in the same sense.
  const double earth = wgs84::kEarthRate_radps * std::sin(p.latitude_rad);
  SE2d before = truth.front().T_map_base.raw();
  for (LogTime t = truth.front().time; t <= truth.back().time; t += p.motion_period) {
    const SE2d pose = true_pose_at(truth, t);
    const double bias = errors.bias(to_seconds(t - truth.front().time));
    const double turn = (before.inverse() * pose).heading().radians();
    const double rate = turn / dt + earth + bias + errors.noise();
    drive.recording.gyro.push_back({t, std::clamp(rate, -p.gyro.range_rad_s, p.gyro.range_rad_s)});
    drive.gyro_bias_rad_s.push_back(bias);
    before = pose;
  }
}

}  // namespace

void append_furnished_wall(const Eigen::Vector2d& a_m, const Eigen::Vector2d& b_m, double depth_m,
                           const CorridorFurniture& f, Rng& rng, std::vector<Segment>& walls) {
  const double length = (b_m - a_m).norm();
  WallBuilder wall(a_m, b_m, walls);
  double from = 0.0;
  for (const Opening& o : openings(length, f, rng)) {
    if (o.begin < from + 0.05 || o.begin + o.width > length - 0.05) continue;
    wall.path({{from, 0.0}, {o.begin, 0.0}});
    place(wall, o, f);
    from = o.begin + o.width;
  }
  wall.path({{from, 0.0}, {length, 0.0}});
  const auto boxes = static_cast<int>(std::lround(f.boxes_per_m * length));
  for (int i = 0; i < boxes; ++i) {
    const double s = rng.uniform(0.0, length - 0.5), width = rng.uniform(0.2, 0.5);
    const double deep = std::min(depth_m, rng.uniform(0.15, 0.45));
    wall.path({{s, 0.01}, {s, deep}, {s + width, deep}, {s + width, 0.01}});
  }
  const auto people = static_cast<int>(std::lround(f.people_per_m * length));
  for (int i = 0; i < people; ++i) {
    const double off = rng.uniform(0.16, std::max(0.16, depth_m - 0.16));
    wall.person(rng.uniform(0.2, length - 0.2), off);
  }
}

Result<FloorPlan> three_corridors(const CorridorsParams& p, const Rng& rng) {
  constexpr double kLongest_m = 1e5;
  const CorridorFurniture& f = p.furniture;
  for (const double length : p.lengths_m)
    if (!(length > 0.0 && length <= kLongest_m) || !(p.width_m > 0.0 && p.width_m <= kLongest_m))
      return Error{ErrorCode::invalid, "a corridor needs a positive length and width up to 100 km"};
  constexpr double kMostPerMetre = 100.0, kNarrowest_m = 0.1;
  if (f.door_spacing_m > 0.0 && f.door_spacing_m < kNarrowest_m)
    return Error{ErrorCode::invalid, "the doors are less than 0.1 m apart"};
  for (const double per_m : {f.boxes_per_m, f.people_per_m, f.glass_per_m})
    if (!(per_m >= 0.0 && per_m <= kMostPerMetre))
      return Error{ErrorCode::invalid, "a corridor has up to 100 objects of a kind per metre"};
  const double h = 0.5 * p.width_m, back = 1.5;
  const double x1 = p.lengths_m[0], y1 = p.lengths_m[1], x2 = x1 + p.lengths_m[2];
  // Once round the inside, with the corridor on the left.
  const std::vector<Eigen::Vector2d> corners = {
      {-back, -h},         {x1 + h, -h},     {x1 + h, y1 - h}, {x2 + back, y1 - h},
      {x2 + back, y1 + h}, {x1 - h, y1 + h}, {x1 - h, h},      {-back, h}};
  std::vector<Segment> walls;
  const double depth = std::max(0.0, h - 0.7);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    Rng own = rng.stream(i);
    // The ends of the building and the walls that face a corridor have no furniture.
    const Eigen::Vector2d &a = corners[i], &b = corners[(i + 1) % corners.size()];
    const CorridorFurniture plain{.door_spacing_m = 0.0};
    const bool is_end = (b - a).norm() < p.width_m + 0.1;
    append_furnished_wall(a, b, depth, is_end ? plain : p.furniture, own, walls);
  }
  return FloorPlan::from_segments(std::move(walls));
}

Lidar2dParams CorridorDriveParams::lms200() {
  Lidar2dParams p;
  p.beams = 361;
  p.bearing_step = Angle::degrees(0.5);
  p.range_noise_m = 0.005;
  p.max_range_m = 80.0;
  return p;
}

std::string_view name_of(CorridorSection section) {
  constexpr std::array<std::string_view, 5> kNames = {"Corridor I", "Outage I", "Corridor II",
                                                      "Outage II", "Corridor III"};
  return kNames[static_cast<std::size_t>(section)];
}

CorridorSection CorridorDrive::section_at(LogTime time) const {
  const auto after = std::upper_bound(section_ends.begin(), section_ends.end(), time);
  return static_cast<CorridorSection>(after - section_ends.begin());
}

Result<CorridorDrive> simulate_corridors(const CorridorDriveParams& p, const Rng& rng) {
  if (auto ok = check(p); !ok) return ok.error();
  auto plan = three_corridors(p.place, rng.stream(0));
  if (!plan) return plan.error();
  Driven driven = drive(p);
  CorridorDrive result{*std::move(plan), {}, {}, 0.0, driven.section_ends};
  Recording& recording = result.recording;
  recording.truth = std::move(driven.truth);
  recording.wheel_base_m = 0.5;
  Rng wheel_rng = rng.stream(1), lidar_rng = rng.stream(2);
  result.speed_scale = p.speed_scale_sigma * wheel_rng.normal();
  WheelParams wheels{.wheel_base_m = recording.wheel_base_m,
                     .left_scale = 1.0 + result.speed_scale,
                     .right_scale = 1.0 + result.speed_scale,
                     // Two wheels with independent errors: the mean has 1/√2 of one wheel's.
                     .slip_m_per_sqrt_m = std::numbers::sqrt2 * p.slip_m_per_sqrt_m};
  recording.wheels = simulate_wheels(recording.truth, p.motion_period, wheels, wheel_rng);
  read_gyro(p, rng.stream(3), result);
  const auto pose_at = [&](LogTime t) { return true_pose_at(recording.truth, t); };
  std::size_t index = 0;
  for (LogTime t = recording.truth.front().time; t <= recording.truth.back().time;
       t += p.scan_period) {
    Rng own = lidar_rng.stream(index++);
    recording.scans.push_back(simulate_scan(result.plan, pose_at, t, p.lidar, own));
  }
  return result;
}

}  // namespace wayfare::sim
