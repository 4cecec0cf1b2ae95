// Processing of the messages received: when a scan can be processed, and the output.

#include <algorithm>
#include <chrono>
#include <utility>

#include <wayfare/io/map_image.hpp>
#include <wayfare/ros/nodes.hpp>
#include <wayfare/sync/odometry_track.hpp>

#include "ros/nodes/laser_slam.hpp"
#include "ros/nodes/samples.hpp"

namespace wayfare::ros {
namespace {

Path path_of(const Trajectory& trajectory, std::string_view frame) {
  Path path;
  if (!trajectory.empty()) path.header = header_of(trajectory.back().time, frame);
  path.poses.reserve(trajectory.size());
  for (const StampedPose& p : trajectory)
    path.poses.push_back({header_of(p.time, frame), pose_of(p.T_map_base.raw())});
  return path;
}

}  // namespace

SlamNodeOutput SlamNode::work(double now_s) {
  SlamNodeOutput out;
  worked_ = false;
  if (options_.sensors != SlamSensors::lidar) {
    process_stream(now_s, out);
  } else if (!lasers_.scans.empty()) {
    process_scan(now_s, out);
  } else if (!lasers_.last_received) {
    wait_for("laser scans", now_s);
  } else if (!settled_ && now_s >= *last_placed_s_ + options_.settle_s) {
    out = finish(now_s);
  }
  const auto notices = notices_.take();
  out.notices.insert(out.notices.end(), notices.begin(), notices.end());
  return out;
}

SlamNodeOutput SlamNode::finish(double now_s) {
  SlamNodeOutput out;
  if (settled_) return out;
  if (stream_) {
    pass_to_stream();
    stream_->finish();
    while (step(now_s, out)) continue;
    stream_->join_pieces();
  } else if (const auto done = slam_->finish(); !done) {
    out.notices.push_back(
        {Severity::error, "the graph could not be optimised: " + done.error().to_string()});
  }
  settled_ = true;
  say_pieces(now_s);
  publish_map(now_s, out);
  return out;
}

bool SlamNode::laser_is_mounted(double now_s) {
  const auto& given = options_.T_base_laser;
  return is_mounted(lasers_, given ? std::optional(given->raw()) : std::nullopt, now_s);
}

bool SlamNode::unit_is_mounted(double now_s) {
  if (!options_.imu || takes_turns() || options_.unit_forward || q_base_unit_) return true;
  if (unit_frame_.empty()) {
    wait_for(unit_heard_.name, now_s);
    return false;
  }
  q_base_unit_ = rotation_of(frames_, options_.base_frame, unit_frame_);
  if (!q_base_unit_)
    wait_for("the transform from '" + options_.base_frame + "' to '" + unit_frame_ +
                 "' (on /tf or /tf_static)",
             now_s);
  return q_base_unit_.has_value();
}

bool SlamNode::has_system(double now_s) {
  if (slam_) return true;
  if (!laser_is_mounted(now_s) || !unit_is_mounted(now_s)) return false;
  slam_ = make_laser_slam(
      options_, Transform2<frame::Base, frame::Laser>(lasers_.mounting->T_base_sensor.raw()),
      q_base_unit_);
  deskewer_.emplace(Transform2<frame::Base, frame::Laser>(lasers_.mounting->T_base_sensor.raw()));
  return true;
}

bool SlamNode::motion_is_known(LogTime time, double now_s) {
  return (!options_.odometry || has_reached(odometry_heard_, time, now_s)) &&
         (!options_.imu || has_reached(unit_heard_, time, now_s)) &&
         (!options_.magnetometer || has_reached(field_heard_, time, now_s));
}

void SlamNode::pass_samples(LogTime until) {
  for (; !unit_.empty() && unit_.front().time <= until; unit_.pop_front())
    if (slam_) slam_->add(unit_.front());
}

MotionHint SlamNode::hint(LogTime time) const {
  if (const auto odometry = odometry_at(time)) return {odometry, {}, leaped(time)};
  if (last_scan_ && !gyro_.empty()) return {{}, GyroTurn(gyro_).between(*last_scan_, time)};
  return {};
}

/// Whether odometry leaped between the last scan and one at this time.
bool SlamNode::leaped(LogTime time) const {
  return last_scan_ && std::ranges::any_of(leaps_, [&](const Leap& leap) {
           return leap.from < time && *last_scan_ < leap.to;
         });
}

Result<ScanOutcome> SlamNode::add_deskewed(const wayfare::LaserScan& scan) {
  // A system that takes the unit's samples undoes a sweep by its own attitudes.
  if (options_.imu && !takes_turns()) return slam_->add_scan(scan, hint(scan.time));
  const auto instant = (*deskewer_)(scan, odometry_, gyro_);
  if (!instant) return instant.error();
  auto outcome = slam_->add_scan(**instant, hint(scan.time));
  if (outcome) deskewer_->placed(scan.time, outcome->T_map_base.raw(), outcome->loop_closures > 0);
  return outcome;
}

void SlamNode::process_scan(double now_s, SlamNodeOutput& out) {
  if (!has_system(now_s) || !motion_is_known(lasers_.scans.front().end_time(), now_s)) return;
  wayfare::LaserScan scan = std::move(lasers_.scans.front());
  lasers_.scans.pop_front();
  stop_waiting();
  worked_ = true;
  const LogTime time = scan.time;
  if (lasers_.mounting->upside_down) scan = turned_over(std::move(scan));
  pass_samples(scan.end_time());
  const auto outcome = add_deskewed(scan);
  if (!outcome)
    return leave_out("scan", "refused", "left out a scan: " + outcome.error().to_string(), now_s);
  if (!outcome->matched)
    notices_.add(Severity::info, "unmatched", "a scan did not match the map: its pose is predicted",
                 now_s);
  placed(time, {outcome->T_map_base.raw(), slam_->covariance()}, now_s, out);
}

void SlamNode::placed(LogTime time, const Gaussian<SE2d>& T_map_base, double now_s,
                      SlamNodeOutput& out) {
  const MotionHint motion = hint(time);
  last_scan_ = time;
  last_placed_s_ = now_s;
  settled_ = false;
  publish_pose(time, T_map_base, motion, out);
  say_pieces(now_s);
  if (now_s >= last_map_s_ + options_.map_period_s) publish_map(now_s, out);
  const LogTime needed = time - from_seconds(1.0);
  forget_before(odometry_, needed);
  forget_before(gyro_, needed);
  std::erase_if(leaps_, [&](const Leap& leap) { return leap.to < needed; });
}

bool SlamNode::has_stream(double now_s) {
  if (stream_) return true;
  const bool lasers = options_.sensors == SlamSensors::both;
  if (lasers && lasers_.frame.empty() && lasers_.scans.empty()) {
    wait_for("laser scans", now_s);
    return false;
  }
  if (radar_.frame.empty() && radar_.scans.empty()) {
    wait_for("radar scans", now_s);
    return false;
  }
  if (lasers && !laser_is_mounted(now_s)) return false;
  const auto& given = options_.T_base_radar;
  if (!is_mounted(radar_, given ? std::optional(given->raw()) : std::nullopt, now_s)) return false;
  RadarSlamStreamOptions o{.slam = options_.filter, .sensors = options_.sensors};
  if (lasers)
    o.slam.T_base_laser =
        Transform2<frame::Base, frame::Laser>(lasers_.mounting->T_base_sensor.raw());
  o.sync.T_base_radar = Transform2<frame::Base, frame::Radar>(radar_.mounting->T_base_sensor.raw());
  // By the caller's clock only.
  o.sync.max_wait = std::chrono::hours(24 * 365);
  stream_.emplace(o);
  return true;
}

void SlamNode::pass_to_stream() {
  for (const OdometrySample& sample : odometry_)
    if (!odometry_passed_ || sample.time > *odometry_passed_) stream_->add(sample);
  if (!odometry_.empty()) odometry_passed_ = odometry_.back().time;
  for (wayfare::LaserScan& scan : lasers_.scans)
    stream_->add(lasers_.mounting->upside_down ? turned_over(std::move(scan)) : std::move(scan));
  for (wayfare::RadarScan& scan : radar_.scans)
    stream_->add(radar_.mounting->upside_down ? turned_over(std::move(scan)) : std::move(scan));
  lasers_.scans.clear();
  radar_.scans.clear();
}

void SlamNode::process_stream(double now_s, SlamNodeOutput& out) {
  if (!has_stream(now_s)) return;
  // Messages stay in the queues, which are bounded, until there is nothing else to do.
  worked_ = step(now_s, out);
  if (worked_) return;
  pass_to_stream();
  worked_ = step(now_s, out);
  if (worked_) return;
  const std::string what(stream_->waits_for());
  if (!what.empty()) {
    wait_for(what + " at the scan's time", now_s);
    if (!waited_in_vain(now_s)) return;
    notices_.add(Severity::warning, "silent",
                 "no " + what + " at the scan's time: continues without until there is", now_s);
    stream_->finish();
    worked_ = step(now_s, out);
  } else if (!settled_ && now_s >= *last_placed_s_ + options_.settle_s) {
    out = finish(now_s);
  }
}

bool SlamNode::step(double now_s, SlamNodeOutput& out) {
  const auto time = stream_->step();
  if (!time) return false;
  stop_waiting();
  const auto pose = stream_->slam().pose();
  if (!pose || pose->time != *time) return true;
  placed(*time, {pose->T_map_base.raw(), stream_->slam().covariance()}, now_s, out);
  publish_particles(*time, out);
  return true;
}

void SlamNode::publish_pose(LogTime time, const Gaussian<SE2d>& T_map_base,
                            const MotionHint& motion, SlamNodeOutput& out) const {
  out.poses.push_back(message_of(T_map_base, time, options_.map_frame));
  const auto give = [&](const SE2d& T_odom_base) {
    out.transforms.push_back(map_to_odom(T_map_base.mean, T_odom_base, time));
  };
  if (options_.odometry && motion.odometry) {
    const SE2d joined = motion.odometry->raw();
    give(T_joined_odom_ ? T_joined_odom_->inverse() * joined : joined);
  } else if (!options_.odometry) {
    const SE2d T_odom_base = slam_->T_odom_base();
    give(T_odom_base);
    out.transforms.push_back(
        transform_of(T_odom_base, time, options_.odom_frame, options_.base_frame));
  }
}

void SlamNode::publish_particles(LogTime time, SlamNodeOutput& out) {
  if (!cloud_is_due(time)) return;
  out.particles.emplace(PoseArray{header_of(time, options_.map_frame)});
  for (const auto& particle : stream_->slam().particles())
    out.particles->poses.push_back(pose_of(particle.pose));
}

void SlamNode::publish_map(double now_s, SlamNodeOutput& out) {
  last_map_s_ = now_s;
  const auto trajectory = stream_ ? stream_->slam().latest_trajectory() : slam_->trajectory();
  out.path = path_of(trajectory, options_.map_frame);
  out.map = message_of(io::grid_image(stream_ ? stream_->map() : slam_->map()), *last_scan_,
                       options_.map_frame);
}

void SlamNode::say_pieces(double now_s) {
  const PieceStatistics now =
      stream_ ? PieceStatistics(stream_->slam().statistics()) : slam_->pieces();
  const std::string piece = "piece " + std::to_string(now.pieces);
  if (now.pieces > std::max<std::size_t>(said_.pieces, 1))
    notices_.add(Severity::warning, piece,
                 "tracking was lost: begins " + piece +
                     " of the trajectory; map and path are of it alone until it is joined",
                 now_s);
  if (now.joins > said_.joins)
    notices_.add(Severity::info, "join " + std::to_string(now.joins),
                 "joined pieces of the trajectory: " + std::to_string(now.joins) + " of " +
                     std::to_string(now.pieces - 1),
                 now_s);
  said_ = now;
}

}  // namespace wayfare::ros
