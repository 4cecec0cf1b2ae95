#include "two_feet.hpp"

#include <cmath>

namespace wayfare::examples {
namespace {

using Side = TwoFeet::Side;

io::StampedPose3 pose_of(LogTime time, const Eigen::Vector3d& position, Angle heading) {
  return {time, Transform3<frame::Map, frame::Base>(
                    SE3d(position, SO3d::exp({0.0, 0.0, heading.radians()})))};
}

FeetTracks track(const MargRecording& left, const MargRecording& right,
                 const TwoFeetParameters& parameters) {
  TwoFeet feet(parameters);
  FeetTracks tracks;
  const auto keep = [&](Side side, const FootPose& pose) {
    auto& poses = side == Side::left ? tracks.left : tracks.right;
    poses.push_back(pose_of(pose.time, feet.position(side), pose.heading));
    const bool both = feet.tracker(Side::left).ready() && feet.tracker(Side::right).ready();
    if (side != Side::left || !both) return;
    const OdometrySample middle = feet.odometry();
    tracks.middle.push_back(
        {pose.time, Transform2<frame::Map, frame::Base>(middle.T_odom_base.raw())});
  };
  const auto add = [&](Side side, const MargSample& s) {
    feet.add(side, {s.time, s.angular_rate_radps, s.specific_force_mps2}, keep);
  };
  auto r = right.begin();
  for (const MargSample& l : left) {
    for (; r != right.end() && r->time <= l.time; ++r) add(Side::right, *r);
    add(Side::left, l);
  }
  for (; r != right.end(); ++r) add(Side::right, *r);
  feet.finish(keep);
  tracks.left_stances = feet.tracker(Side::left).report().stances;
  tracks.right_stances = feet.tracker(Side::right).report().stances;
  tracks.projections = feet.projections();
  return tracks;
}

std::vector<Eigen::Vector2d> points(const io::Trajectory3& track) {
  std::vector<Eigen::Vector2d> result;
  for (const auto& p : track) result.emplace_back(p.T_map_base.raw().translation().head<2>());
  return result;
}

}  // namespace

void RightFoot::add_options(CommandLine& app) {
  app.add_file("--right", file,
               "the unit on the right foot, on the clock of FILE, which is then on the left one")
      .excludes("--known-length");
  app.add_option("--right-columns", columns, "its --columns, if they differ").delimiter(',');
  app.add_positive("--farthest", farthest_m, "bound on the distance of the feet, m (with --right)");
  app.add_positive("--feet-apart", width_m, "distance of the feet at the start, m (with --right)");
  app.add_option("--right-heading", heading_deg,
                 "heading of the right unit's axes from the left one's at the start, degrees "
                 "counter-clockwise; by default from the first metres of both tracks");
}

Result<io::MargFile> RightFoot::read(const RecordingOptions& left) const {
  RecordingOptions options = left;
  if (!columns.empty()) options.columns = columns;
  return options.read(file);
}

Result<TwoFeetRun> run_two_feet(const MargRecording& left, const MargRecording& right,
                                const FootParameters& foot, const RightFoot& options) {
  TwoFeetRun run;
  run.parameters.foot = foot;
  run.parameters.farthest_m = 0.0;
  run.parameters.right_from_left_m.setZero();
  run.heading_known = options.heading_deg.has_value();
  // Each in its own axes, for the relative heading of the units.
  const FeetTracks own = track(left, right, run.parameters);
  if (own.left.empty() || own.right.empty())
    return Error{ErrorCode::degenerate,
                 "one of the feet gives no attitude: no reading of gyro and accelerometer near "
                 "gravity"};
  if (own.left.back().time < own.right.front().time ||
      own.right.back().time < own.left.front().time)
    return Error{ErrorCode::invalid, "has no time in common with the other foot's recording"};
  const auto mounting = feet_mounting(points(own.left), points(own.right), options.width_m);
  if (!mounting) return mounting.error();
  run.parameters.right_from_left_m = mounting->right_from_left_m;
  run.parameters.right_from_left =
      options.heading_deg ? Angle::degrees(*options.heading_deg) : mounting->right_from_left;
  run.alone = track(left, right, run.parameters);
  run.parameters.farthest_m = options.farthest_m;
  run.bound = track(left, right, run.parameters);
  return run;
}

}  // namespace wayfare::examples
