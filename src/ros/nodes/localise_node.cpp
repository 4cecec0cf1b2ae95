#include <wayfare/ros/localise_node.hpp>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include <Eigen/Core>

#include <wayfare/io/map_image.hpp>
#include <wayfare/slam/detail/recorded_localiser.hpp>
#include <wayfare/sync/odometry_track.hpp>

#include "ros/nodes/samples.hpp"

namespace wayfare::ros {
namespace {

std::string place(const SE2d& pose) {
  return "x " + std::to_string(pose.x()) + " m, y " + std::to_string(pose.y()) + " m, heading " +
         std::to_string(pose.heading().degrees()) + " degrees";
}

bool same(const OccupancyGrid& a, const OccupancyGrid& b) {
  const auto equal = [](const Pose& p, const Pose& q) {
    return p.position.x == q.position.x && p.position.y == q.position.y &&
           p.orientation.x == q.orientation.x && p.orientation.y == q.orientation.y &&
           p.orientation.z == q.orientation.z && p.orientation.w == q.orientation.w;
  };
  return a.info.resolution == b.info.resolution && a.info.width == b.info.width &&
         equal(a.info.origin, b.info.origin) && a.data == b.data;
}

/// Errors: not a unit quaternion, or not finite.
Result<void> check_transform(const TransformParts& t) {
  if (auto turn = yaw_of(t.rotation); !turn) return turn.error();
  if (!Eigen::Vector3d(t.translation.x, t.translation.y, t.translation.z).allFinite())
    return Error{ErrorCode::invalid, "is not finite", "translation"};
  return {};
}

}  // namespace

LocaliseNode::LocaliseNode(LocaliseNodeOptions options)
    : ScanNode(options), options_(std::move(options)) {
  restart();
}

/// As at the beginning: with the pose given by the options, or none.
void LocaliseNode::restart() {
  located_ = false;
  global_ = options_.global;
  given_.reset();
  if (options_.initial) given_ = GivenPose{*options_.initial};
  localiser_.reset();
  deskewer_.reset();
  last_.reset();
  last_cloud_.reset();
  outcome_.reset();
}

void LocaliseNode::restart_at(LogTime at) {
  restart();
  laser_.scans.clear();
  laser_.last_received.reset();
  // Odometry up to the jump back is dropped, too.
  forget_odometry_after(at + from_seconds(options_.jump_back_s));
}

void LocaliseNode::add(const OccupancyGrid& message, double now_s) {
  if (map_message_ && same(*map_message_, message)) return;
  const auto refuse = [&](const Error& error) {
    leave_out("map", "bad map", "left out a map: " + error.to_string(), now_s);
  };
  if (auto ok = check_frame(message.header, options_.map_frame); !ok) return refuse(ok.error());
  const auto image = grid_image_of(message);
  if (!image) return refuse(image.error());
  auto map = LocalisationMap::make(io::occupancy_grid(*image), options_.map);
  if (!map) return refuse(map.error());
  if (map_) {
    notices_.add(Severity::info, "another map", "continues on another map", now_s);
    if (outcome_ && outcome_->converged && !given_)
      given_.emplace(GivenPose{outcome_->T_map_base, outcome_->time});
    auto kept = std::exchange(given_, std::nullopt);
    restart();
    if (kept) given_.swap(kept);
  }
  map_message_ = message;
  map_ = *std::move(map);
  T_map_grid_ = image->origin;
}

void LocaliseNode::add(const LaserScan& message, double now_s) {
  const auto time = time_of(message.header.stamp);
  enqueue(laser_, time ? laser_scan_of(message, *time) : Result<wayfare::LaserScan>(time.error()),
          message.header, now_s, {"starts again", [this](LogTime at) { restart_at(at); }});
}

void LocaliseNode::add(const Odometry& message, double now_s) {
  if (options_.source != OdometrySource::messages) return;
  if (const auto sample = next_odometry(message, now_s)) add_odometry(*sample);
}

void LocaliseNode::add(const TfMessage& message, double now_s) {
  for (const TransformStamped& t : message.transforms) {
    if (auto ok = check_transform(t.transform); !ok) {
      leave_out("transform", "bad transform to " + t.child_frame_id,
                "left out a transform to '" + t.child_frame_id + "': " + ok.error().to_string(),
                now_s);
      continue;
    }
    frames_.add(t);
    if (options_.source != OdometrySource::transforms || frame_of(t.header) != options_.odom_frame)
      continue;
    const auto T_odom_base = frames_.find(options_.odom_frame, options_.base_frame);
    if (!T_odom_base) continue;
    Odometry odometry;
    odometry.header = t.header;
    const Vector3& at = T_odom_base->translation;
    odometry.pose.pose = {{at.x, at.y, at.z}, T_odom_base->rotation};
    if (const auto sample = next_odometry(odometry, now_s)) add_odometry(*sample);
  }
}

void LocaliseNode::add(const PoseWithCovarianceStamped& message, double now_s) {
  auto ok = check_frame(message.header, options_.map_frame);
  const auto pose = ok ? gaussian_of(message.pose) : Result<Gaussian<SE2d>>(ok.error());
  const bool now = message.header.stamp == Stamp{};
  const auto time = now ? LogTime() : time_of(message.header.stamp);
  if (!pose || !time)
    return leave_out(
        "initial pose", "bad pose",
        "left out an initial pose: " + (pose ? time.error() : pose.error()).to_string(), now_s);
  given_ = GivenPose{*pose, now ? laser_.last_received : std::optional(*time)};
}

LocaliseNodeOutput LocaliseNode::work(double now_s) {
  LocaliseNodeOutput out;
  worked_ = false;
  if (!map_) {
    wait_for("a map", now_s);
  } else if (!laser_.scans.empty()) {
    process_scan(now_s, out);
  } else if (!laser_.last_received) {
    wait_for("laser scans", now_s);
  }
  out.notices = notices_.take();
  return out;
}

/// Whether a given pose is to be applied at a scan: its time is reached, or is of another clock.
bool LocaliseNode::applies(const GivenPose& given, LogTime scan) const {
  return !given.at || *given.at <= scan ||
         *given.at > *laser_.last_received + from_seconds(options_.jump_back_s);
}

/// Whether the next scan can be placed. Scans before a pose is given are dropped.
bool LocaliseNode::has_pose(double now_s) {
  constexpr Duration kKept = from_seconds(2.0);
  if (located_ || (global_ && !given_)) return true;
  auto& scans = laser_.scans;
  if (given_) {
    while (!scans.empty() && !applies(*given_, scans.front().time)) scans.pop_front();
    return !scans.empty();
  }
  while (scans.front().time + kKept < scans.back().time) scans.pop_front();
  wait_for("the robot's initial pose", now_s);
  return false;
}

/// The given pose, moved by odometry to where the localiser stands.
Gaussian<SE2d> LocaliseNode::pose_for(const GivenPose& given, LogTime scan, double now_s) {
  if (!given.at || *given.at == scan) return given.T_map_base;
  const auto then = odometry_at(*given.at);
  if (*given.at > scan || !then) {
    notices_.add(
        Severity::warning, "time of pose",
        "the initial pose is stamped " + seconds(std::max(*given.at - scan, scan - *given.at)) +
            (*given.at > scan ? " after" : " before") + " the scan: taken as the pose at the scan",
        now_s);
    return given.T_map_base;
  }
  if (last_ && *given.at <= *last_) {
    const auto last = OdometryTrack(odometry_).at(*last_);
    return compose(given.T_map_base,
                   Gaussian<SE2d>{then->raw().inverse() * last->raw(), Eigen::Matrix3d::Zero()});
  }
  static_cast<void>(localiser_->add_motion(*given.at, then).has_value());
  return given.T_map_base;
}

void LocaliseNode::start_by(LogTime scan, double now_s) {
  if (given_ && applies(*given_, scan)) {
    Gaussian<SE2d> T_map_base = pose_for(*given_, scan, now_s);
    notices_.add(Severity::info, "start", "starts at " + place(T_map_base.mean), now_s);
    T_map_base.mean = T_map_grid_.inverse() * T_map_base.mean;
    if (auto ok = localiser_->start_at(T_map_base); !ok)
      leave_out("initial pose", "bad pose", "left out an initial pose: " + ok.error().to_string(),
                now_s);
    given_.reset();
  } else if (!located_) {
    notices_.add(Severity::info, "start", "searches the whole map", now_s);
    localiser_->start_anywhere();
  }
  located_ = true;
}

Result<LocalisationOutcome> LocaliseNode::add_scan(const wayfare::LaserScan& scan, double now_s) {
  start_by(scan.time, now_s);
  if (last_) detail::add_odometry_of_gap(*localiser_, OdometryTrack(odometry_), *last_, scan.time);
  const auto instant = (*deskewer_)(scan, odometry_);
  if (!instant) return instant.error();
  return localiser_->add_scan(**instant, odometry_at(scan.time));
}

void LocaliseNode::process_scan(double now_s, LocaliseNodeOutput& out) {
  const auto& given = options_.T_base_laser;
  if (!is_mounted(laser_, given ? std::optional(given->raw()) : std::nullopt, now_s) ||
      !has_pose(now_s) || !has_reached(odometry_heard_, laser_.scans.front().end_time(), now_s))
    return;
  if (!localiser_) {
    LocalisationOptions o = options_.localisation;
    o.T_base_laser = Transform2<frame::Base, frame::Laser>(laser_.mounting->T_base_sensor.raw());
    localiser_.emplace(map_, o, options_.seed);
    deskewer_.emplace(o.T_base_laser);
  }
  wayfare::LaserScan scan = std::move(laser_.scans.front());
  laser_.scans.pop_front();
  stop_waiting();
  worked_ = true;
  if (laser_.mounting->upside_down) scan = turned_over(std::move(scan));
  auto outcome = add_scan(scan, now_s);
  if (!outcome)
    return leave_out("scan", "refused", "left out a scan: " + outcome.error().to_string(), now_s);
  last_ = scan.time;
  outcome->T_map_base.mean = T_map_grid_ * outcome->T_map_base.mean;
  report(*outcome, now_s);
  outcome_ = *std::move(outcome);
  publish(now_s, out);
  // Enough for a pose that is given late.
  forget_before(odometry_, scan.time - from_seconds(10.0));
}

void LocaliseNode::publish(double now_s, LocaliseNodeOutput& out) {
  const LogTime time = outcome_->time;
  if (outcome_->particles > 0 && cloud_is_due(time)) {
    std::vector<PoseParticle> particles = localiser_->particles();
    for (PoseParticle& p : particles) p.T_map_base = T_map_grid_ * p.T_map_base;
    out.particles = particle_cloud(particles, time, options_.map_frame);
  }
  if (!outcome_->converged) return;
  out.poses.push_back(message_of(outcome_->T_map_base, time, options_.map_frame));
  if (const auto odometry = odometry_at(time))
    out.transforms.push_back(map_to_odom(outcome_->T_map_base.mean, odometry->raw(), time));
  else
    notices_.add(Severity::warning, "no odometry",
                 "no odometry at a scan: without the transform from map to odometry", now_s);
}

void LocaliseNode::report(const LocalisationOutcome& now, double now_s) {
  const bool before = outcome_ && outcome_->converged;
  if (now.relocalised)
    notices_.add(Severity::warning, "elsewhere",
                 "the robot was carried: found at " + place(now.T_map_base.mean), now_s);
  if (now.converged && !before)
    notices_.add(Severity::info, "localised", "localised at " + place(now.T_map_base.mean), now_s);
  if (before && !now.converged)
    notices_.add(Severity::warning, "lost",
                 now.clusters > 1 ? "not localised any more: " + std::to_string(now.clusters) +
                                        " places are possible"
                                  : "not localised any more: the scans do not fit the map",
                 now_s);
  if (now.odometry_refused && odometry_heard_.last && !odometry_heard_.silent)
    notices_.add(Severity::warning, "implausible",
                 "odometry is missing, or faster than the robot can move: it was set, or the robot "
                 "was carried",
                 now_s);
}

ParticleCloud particle_cloud(std::span<const PoseParticle> particles, LogTime time,
                             std::string_view frame) {
  ParticleCloud cloud{header_of(time, frame)};
  cloud.particles.reserve(particles.size());
  for (const PoseParticle& p : particles) {
    const SE2d& pose = p.T_map_base;
    const double half = 0.5 * pose.heading().radians();
    cloud.particles.push_back(
        {{{pose.x(), pose.y(), 0.0}, {0.0, 0.0, std::sin(half), std::cos(half)}}, p.weight});
  }
  return cloud;
}

}  // namespace wayfare::ros
