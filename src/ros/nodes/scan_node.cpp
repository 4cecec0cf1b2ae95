#include <wayfare/ros/scan_node.hpp>

#include <utility>

#include <wayfare/sync/odometry_track.hpp>

#include "ros/nodes/samples.hpp"

namespace wayfare::ros {
void ScanNode::leave_out(const std::string& kind, const std::string& about, std::string text,
                         double now_s, Severity severity) {
  const std::uint64_t n = ++left_out_[kind];
  if (n > 1) text += " (" + std::to_string(n) + " so far)";
  notices_.add(severity, about, std::move(text), now_s);
}

template <class Scan>
void ScanNode::enqueue(Sensed<Scan>& to, Result<Scan> scan, const Header& header, double now_s,
                       const Restart& restart) {
  if (!scan)
    return leave_out("scan", "bad scan", "left out a scan: " + scan.error().to_string(), now_s);
  const std::string frame(frame_of(header));
  if (to.frame.empty()) to.frame = frame;
  if (frame != to.frame)
    return leave_out(
        "scan", "other than " + to.frame,
        "left out scans in frame '" + frame + "': the map uses those in '" + to.frame + "'", now_s);
  if (to.last_received && scan->time + from_seconds(common_.jump_back_s) < *to.last_received) {
    notices_.add(
        Severity::warning, "back",
        "time went back by " + seconds(*to.last_received - scan->time) + ": " + restart.what,
        now_s);
    restart.done(scan->time);
  } else if (to.last_received && scan->time <= *to.last_received) {
    return leave_out("scan", "late scan",
                     "left out a scan that is " + seconds(*to.last_received - scan->time) +
                         " earlier than the one before it",
                     now_s, Severity::warning);
  }
  to.last_received = scan->time;
  to.scans.push_back(*std::move(scan));
  if (to.scans.size() <= common_.scans_waiting) return;
  to.scans.pop_front();
  leave_out("scan", "too many",
            "scans arrive faster than they are processed, or while it waits: the oldest are left "
            "out",
            now_s, Severity::warning);
}

template <class Scan>
bool ScanNode::is_mounted(Sensed<Scan>& sensed, const std::optional<SE2d>& given, double now_s) {
  if (sensed.mounting) return true;
  if (given) {
    sensed.mounting = LevelMounting{Transform2<frame::Base, Sensor>(*given)};
    return true;
  }
  const std::string from_to = "transform from '" + common_.base_frame + "' to '" + sensed.frame;
  const auto found = frames_.find(common_.base_frame, sensed.frame);
  if (!found) {
    wait_for("the " + from_to + "' (on /tf or /tf_static)", now_s);
    return false;
  }
  const auto level = level_mounting_of(*found);
  if (!level) {
    wait_for("another " + from_to + "': the present one " + level.error().to_string(), now_s);
    return false;
  }
  sensed.mounting = *level;
  return true;
}

template void ScanNode::enqueue(Sensed<wayfare::LaserScan>&, Result<wayfare::LaserScan>,
                                const Header&, double, const Restart&);
template void ScanNode::enqueue(Sensed<wayfare::RadarScan>&, Result<wayfare::RadarScan>,
                                const Header&, double, const Restart&);
template bool ScanNode::is_mounted(Sensed<wayfare::LaserScan>&, const std::optional<SE2d>&, double);
template bool ScanNode::is_mounted(Sensed<wayfare::RadarScan>&, const std::optional<SE2d>&, double);

std::optional<OdometrySample> ScanNode::next_odometry(const Odometry& message, double now_s) {
  const auto time = time_of(message.header.stamp);
  auto ok = check_frame(message.header, common_.odom_frame);
  if (ok && !time) ok = time.error();
  auto sample = ok ? odometry_of(message, *time) : Result<OdometrySample>(ok.error());
  if (!sample) {
    leave_out("odometry", "bad odometry", "left out odometry: " + sample.error().to_string(),
              now_s);
    return std::nullopt;
  }
  if (odometry_.empty()) return *sample;
  if (*time + from_seconds(common_.jump_back_s) < odometry_.back().time) {
    odometry_.clear();
  } else if (*time <= odometry_.back().time) {
    return std::nullopt;
  }
  return *sample;
}

void ScanNode::add_odometry(const OdometrySample& sample) {
  odometry_.push_back(sample);
  odometry_heard_.hear(sample.time);
}

void ScanNode::forget_odometry_after(LogTime time) {
  forget_after(odometry_, time);
  odometry_heard_.last = last_of(odometry_);
}

std::optional<Transform2<frame::Odom, frame::Base>> ScanNode::odometry_at(LogTime time) const {
  const Duration gap = from_seconds(common_.odometry_gap_s);
  if (odometry_.empty() || time <= odometry_.front().time - gap ||
      odometry_.back().time + gap <= time)
    return std::nullopt;
  const OdometrySample& last = odometry_.back();
  // Interpolated to the same bits whether or not the next sample has arrived.
  if (time == last.time)
    return Transform2<frame::Odom, frame::Base>(
        interpolate(last.T_odom_base.raw(), last.T_odom_base.raw(), 0.0));
  return OdometryTrack(odometry_).at(time);
}

TransformStamped ScanNode::map_to_odom(const SE2d& T_map_base, const SE2d& T_odom_base,
                                       LogTime time) const {
  return transform_of(T_map_base * T_odom_base.inverse(), time + from_seconds(common_.post_date_s),
                      common_.map_frame, common_.odom_frame);
}

bool ScanNode::cloud_is_due(LogTime time) {
  if (last_cloud_ && time < *last_cloud_ + from_seconds(common_.particle_period_s)) return false;
  last_cloud_ = time;
  return true;
}

bool ScanNode::has_reached(Awaited& stream, LogTime time, double now_s) {
  if (stream.silent || (stream.last && *stream.last >= time)) return true;
  const std::string what = stream.name;
  wait_for(what + " at the scan's time", now_s);
  if (!waited_in_vain(now_s)) return false;
  stream.silent = true;
  notices_.add(Severity::warning, "silent " + what,
               "no " + what + " at the scan's time: continues with scans alone until there is",
               now_s);
  return true;
}

void ScanNode::wait_for(std::string what, double now_s) {
  if (!blocked_s_ || what != waits_for_) blocked_s_ = now_s;
  waits_for_ = std::move(what);
  if (waited_in_vain(now_s))
    notices_.add(Severity::info, waits_for_, "waits for " + waits_for_, now_s);
}

}  // namespace wayfare::ros
