#include <wayfare/ros/slam_node.hpp>

#include <algorithm>
#include <utility>

#include <wayfare/io/grid_image.hpp>
#include <wayfare/sync/gyro_turn.hpp>
#include <wayfare/sync/odometry_track.hpp>

namespace wayfare::ros {
namespace {

std::string seconds(Duration d) { return std::to_string(to_seconds(d)) + " s"; }

/// Samples no scan to come can need.
template <class Sample>
void forget_before(std::vector<Sample>& samples, LogTime time) {
  constexpr std::ptrdiff_t kWorthIt = 1000;
  const auto first =
      std::find_if(samples.begin(), samples.end(), [&](const Sample& s) { return s.time >= time; });
  if (first - samples.begin() > kWorthIt) samples.erase(samples.begin(), first - 1);
}

template <class Sample>
void forget_after(std::vector<Sample>& samples, LogTime time) {
  std::erase_if(samples, [&](const Sample& s) { return s.time > time; });
}

Path path_of(const Trajectory& trajectory, std::string_view frame) {
  Path path;
  if (!trajectory.empty()) path.header = header_of(trajectory.back().time, frame);
  path.poses.reserve(trajectory.size());
  for (const StampedPose& p : trajectory)
    path.poses.push_back({header_of(p.time, frame), pose_of(p.T_map_base.raw())});
  return path;
}

}  // namespace

SlamNode::SlamNode(SlamNodeOptions options)
    : options_(std::move(options)), slam_(std::make_unique<SubmapSlam>(options_.slam)) {}

void SlamNode::add(const LaserScan& message, double now_s) {
  const auto time = time_of(message.header.stamp);
  auto scan = time ? laser_scan_of(message, *time) : Result<wayfare::LaserScan>(time.error());
  if (!scan)
    return notices_.tell(Severity::error, "bad scan",
                         "left out a scan: " + scan.error().to_string(), now_s);
  if (last_heard_ && scan->time + from_seconds(options_.jump_back_s) < *last_heard_) {
    notices_.tell(Severity::warning, "back",
                  "time went back by " + seconds(*last_heard_ - scan->time) + ": begins a new map",
                  now_s);
    begin_anew(scan->time);
  } else if (last_heard_ && scan->time <= *last_heard_) {
    return notices_.tell(Severity::warning, "late scan",
                         "left out a scan that is " + seconds(*last_heard_ - scan->time) +
                             " earlier than the one before it",
                         now_s);
  }
  last_heard_ = scan->time;
  scans_.push_back({*std::move(scan), std::string(frame_of(message.header))});
  if (scans_.size() <= options_.scans_waiting) return;
  scans_.pop_front();
  notices_.tell(Severity::warning, "too many",
                "scans come faster than they are worked on, or while it waits: the oldest are "
                "left out",
                now_s);
}

void SlamNode::add(const Odometry& message, double now_s) {
  if (!options_.odometry) return;
  const auto time = time_of(message.header.stamp);
  auto ok = check_frame(message.header, options_.odom_frame);
  if (ok && !time) ok = time.error();
  auto sample = ok ? odometry_of(message, *time) : Result<OdometrySample>(ok.error());
  if (!sample)
    return notices_.tell(Severity::error, "bad odometry",
                         "left out odometry: " + sample.error().to_string(), now_s);
  const SE2d told = sample->T_odom_base.raw();
  if (!odometry_.empty()) {
    const OdometrySample& last = odometry_.back();
    if (*time + from_seconds(options_.jump_back_s) < last.time) {
      odometry_.clear();
      T_joined_odom_.reset();
    } else if (*time <= last.time) {
      return;
    } else {
      constexpr double kSlack_m = 0.5;
      const SE2d before = last.T_odom_base.raw();
      const SE2d joined = T_joined_odom_ ? *T_joined_odom_ * told : told;
      const double moved_m = (before.inverse() * joined).translation().norm();
      if (moved_m > kSlack_m + options_.max_speed_mps * to_seconds(*time - last.time)) {
        notices_.tell(Severity::warning, "leap",
                      "odometry leapt by " + std::to_string(moved_m) +
                          " m: it is taken to have been set anew, the robot to have stood",
                      now_s);
        T_joined_odom_ = before * told.inverse();
      }
    }
  }
  if (T_joined_odom_)
    sample->T_odom_base = Transform2<frame::Odom, frame::Base>(*T_joined_odom_ * told);
  odometry_.push_back(*sample);
  motion_silent_ = false;
}

void SlamNode::add(const Imu& message, double now_s) {
  if (options_.odometry || !options_.imu) return;
  const auto time = time_of(message.header.stamp);
  const auto sample = time ? imu_of(message, *time) : Result<ImuSample>(time.error());
  if (!sample)
    return notices_.tell(Severity::error, "bad reading",
                         "left out an inertial reading: " + sample.error().to_string(), now_s);
  if (!gyro_.empty() && *time + from_seconds(options_.jump_back_s) < gyro_.back().time)
    gyro_.clear();
  if (!gyro_.empty() && *time <= gyro_.back().time) return;
  gyro_.push_back({*time, sample->angular_rate_radps.z()});
  motion_silent_ = false;
}

void SlamNode::add(const TfMessage& message) {
  for (const TransformStamped& t : message.transforms) frames_.add(t);
}

SlamNodeOutput SlamNode::work(double now_s) {
  SlamNodeOutput out;
  worked_ = false;
  if (scans_.empty()) {
    if (!last_heard_) {
      wait_for("laser scans", now_s);
    } else if (!settled_ && now_s >= *last_placed_s_ + options_.settle_s) {
      out = settle(now_s);
    }
  } else if (laser_is_known(scans_.front().frame, now_s) &&
             motion_is_known(scans_.front().scan.time, now_s)) {
    Waiting next = std::move(scans_.front());
    scans_.pop_front();
    blocked_s_.reset();
    waits_for_.clear();
    worked_ = true;
    place(std::move(next), now_s, out);
  }
  const auto notices = notices_.take();
  out.notices.insert(out.notices.end(), notices.begin(), notices.end());
  return out;
}

SlamNodeOutput SlamNode::settle(double now_s) {
  SlamNodeOutput out;
  if (settled_) return out;
  settled_ = true;
  if (const auto done = slam_->finish(); !done)
    out.notices.push_back(
        {Severity::error, "the graph could not be optimised: " + done.error().to_string()});
  give_map(now_s, out);
  return out;
}

void SlamNode::begin_anew(LogTime at) {
  slam_ = std::make_unique<SubmapSlam>(options_.slam);
  scans_.clear();
  last_scan_.reset();
  settled_ = true;
  // What the other topics said before they went back as well.
  const LogTime until = at + from_seconds(options_.jump_back_s);
  forget_after(odometry_, until);
  forget_after(gyro_, until);
  if (odometry_.empty()) T_joined_odom_.reset();
}

bool SlamNode::laser_is_known(const std::string& frame, double now_s) {
  if (laser_ && frame == laser_frame_) return true;
  if (laser_) {
    notices_.tell(Severity::error, "other laser",
                  "left out scans in frame '" + frame + "': the map is made of those in '" +
                      laser_frame_ + "'",
                  now_s);
    scans_.pop_front();
    return false;
  }
  LevelMounting mounting;
  if (options_.T_base_laser) {
    mounting.T_base_sensor = Transform2<frame::Base, Sensor>(options_.T_base_laser->raw());
  } else {
    const auto found = frames_.find(options_.base_frame, frame);
    if (!found) {
      wait_for("the transform from '" + options_.base_frame + "' to '" + frame +
                   "' (on /tf or /tf_static)",
               now_s);
      return false;
    }
    const auto level = level_mounting_of(*found);
    if (!level) {
      wait_for("another transform from '" + options_.base_frame + "' to '" + frame +
                   "': the one there is " + level.error().to_string(),
               now_s);
      return false;
    }
    mounting = *level;
  }
  laser_ = mounting;
  laser_frame_ = frame;
  options_.slam.T_base_laser = Transform2<frame::Base, frame::Laser>(mounting.T_base_sensor.raw());
  slam_ = std::make_unique<SubmapSlam>(options_.slam);
  return true;
}

bool SlamNode::motion_is_known(LogTime time, double now_s) {
  if ((!options_.odometry && !options_.imu) || motion_silent_) return true;
  const bool there = options_.odometry ? !odometry_.empty() && odometry_.back().time >= time
                                       : !gyro_.empty() && gyro_.back().time >= time;
  if (there) return true;
  const std::string what = options_.odometry ? "odometry" : "inertial readings";
  wait_for(what + " of the scan's time", now_s);
  if (now_s < *blocked_s_ + options_.patience_s) return false;
  motion_silent_ = true;
  notices_.tell(Severity::warning, "silent",
                "no " + what + " of the scan's time: goes on by scans alone until there is", now_s);
  return true;
}

MotionHint SlamNode::hint(LogTime time) const {
  const Duration gap = from_seconds(options_.odometry_gap_s);
  if (!odometry_.empty() && odometry_.front().time - gap < time &&
      time < odometry_.back().time + gap)
    return {OdometryTrack(odometry_).at(time), {}};
  if (last_scan_ && !gyro_.empty()) return {{}, GyroTurn(gyro_).between(*last_scan_, time)};
  return {};
}

void SlamNode::place(Waiting next, double now_s, SlamNodeOutput& out) {
  const LogTime time = next.scan.time;
  if (laser_->upside_down) next.scan = turned_over(std::move(next.scan));
  const MotionHint motion = hint(time);
  const auto outcome = slam_->add_scan(next.scan, motion);
  if (!outcome)
    return notices_.tell(Severity::error, "refused",
                         "left out a scan: " + outcome.error().to_string(), now_s);
  if (!outcome->matched)
    notices_.tell(Severity::info, "unmatched",
                  "a scan did not fit the map: the robot is placed by motion alone", now_s);
  last_scan_ = time;
  last_placed_s_ = now_s;
  settled_ = false;
  give_pose(time, outcome->T_map_base.raw(), motion, out);
  if (now_s >= last_map_s_ + options_.map_period_s) give_map(now_s, out);
  const LogTime needed = time - from_seconds(1.0);
  forget_before(odometry_, needed);
  forget_before(gyro_, needed);
}

void SlamNode::give_pose(LogTime time, const SE2d& T_map_base, const MotionHint& motion,
                         SlamNodeOutput& out) const {
  out.poses.push_back({header_of(time, options_.map_frame), pose_of(T_map_base)});
  const LogTime dated = time + from_seconds(options_.post_date_s);
  const auto give = [&](const SE2d& T_odom_base) {
    out.transforms.push_back(transform_of(T_map_base * T_odom_base.inverse(), dated,
                                          options_.map_frame, options_.odom_frame));
  };
  if (options_.odometry && motion.odometry) {
    const SE2d joined = motion.odometry->raw();
    give(T_joined_odom_ ? T_joined_odom_->inverse() * joined : joined);
  } else if (!options_.odometry) {
    const SE2d T_odom_base = slam_->local().T_local_base.raw();
    give(T_odom_base);
    out.transforms.push_back(
        transform_of(T_odom_base, time, options_.odom_frame, options_.base_frame));
  }
}

void SlamNode::give_map(double now_s, SlamNodeOutput& out) {
  last_map_s_ = now_s;
  out.path = path_of(slam_->trajectory(), options_.map_frame);
  out.map = message_of(io::grid_image(slam_->map(options_.map)), *last_scan_, options_.map_frame);
}

void SlamNode::wait_for(std::string what, double now_s) {
  if (!blocked_s_ || what != waits_for_) blocked_s_ = now_s;
  waits_for_ = std::move(what);
  if (now_s >= *blocked_s_ + options_.patience_s)
    notices_.tell(Severity::info, waits_for_, "waits for " + waits_for_, now_s);
}

}  // namespace wayfare::ros
