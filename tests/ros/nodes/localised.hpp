#pragma once

// A node that localises a robot in a simulated office, with all its output.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/io/map_image.hpp>
#include <wayfare/ros/localise_node.hpp>
#include <wayfare/sim/floor_plan.hpp>
#include <wayfare/slam/localisation.hpp>
#include "room_drive.hpp"
#include "sim/support.hpp"

namespace wayfare::testing {

inline const ros::OccupancyGrid& office_map() {
  static const ros::OccupancyGrid map = [] {
    const sim::PlannedRoute office = planned(office_plan("a b c b a d a b"));
    const auto grid = sim::map_of_plan(office.plan, office.route_m.front());
    return ros::message_of(io::grid_image(*grid), room_drive().scans.front().time, "map");
  }();
  return map;
}

/// The start of the drive, as a user gives it.
inline Gaussian<SE2d> begin_of(const Recording& r) {
  Gaussian<SE2d> start{r.truth.front().T_map_base.raw()};
  start.covariance = Eigen::Vector3d(0.25, 0.25, 0.07).asDiagonal();
  return start;
}

inline ros::PoseWithCovarianceStamped initial_pose(const Gaussian<SE2d>& pose, LogTime time) {
  return ros::message_of(pose, time, "map");
}

inline ros::FrameTree frames_of(const Recording& r) {
  ros::FrameTree frames;
  for (const ros::TransformStamped& t : mounting(r).transforms) frames.add(t);
  return frames;
}

/// The recording of the messages, as by the program on logs: an angle loses the last bit in them.
inline LocalisationRun offline(Recording r, const std::optional<Gaussian<SE2d>>& start,
                               const ros::OccupancyGrid& map = office_map()) {
  for (OdometrySample& o : r.odometry)
    o = *ros::odometry_of(ros::message_of(o, "odom", "base_link"), o.time);
  for (LaserScan& s : r.scans) s = *ros::laser_scan_of(ros::message_of(s, "laser"), s.time);
  r.T_base_laser = Transform2<frame::Base, frame::Laser>(
      ros::level_mounting_of(*frames_of(r).find("base_link", "laser"))->T_base_sensor.raw());
  const io::GridImage image = *ros::grid_image_of(map);
  std::optional<Gaussian<SE2d>> in_grid = start;
  if (in_grid) in_grid->mean = image.origin.inverse() * in_grid->mean;
  auto run =
      *run_localisation(r, *LocalisationMap::make(io::occupancy_grid(image)), {}, 1, in_grid);
  for (LocalisationOutcome& o : run.outcomes) o.T_map_base.mean = image.origin * o.T_map_base.mean;
  return run;
}

/// A node with all its output, and its own clock.
class Localised {
 public:
  explicit Localised(ros::LocaliseNodeOptions options = {}) : node(std::move(options)) {}

  template <class Message>
  void add(const Message& message) {
    node.add(message, now_s);
    work();
  }
  void wait(double seconds) {
    for (double waited = 0.0; waited < seconds; waited += 0.05) work();
  }
  void work() {
    now_s += 0.05;
    do {
      const ros::LocaliseNodeOutput out = node.work(now_s);
      poses.insert(poses.end(), out.poses.begin(), out.poses.end());
      transforms.insert(transforms.end(), out.transforms.begin(), out.transforms.end());
      if (out.particles) clouds.push_back(*out.particles);
      for (const ros::Notice& n : out.notices) said += n.text + "\n";
      const auto& outcome = node.outcome();
      if (outcome && outcome->time != seen_) {
        outcomes.push_back(*outcome);
        seen_ = outcome->time;
      }
    } while (node.busy());
  }
  /// Odometry before the scans of its time, as messages or as transforms.
  void drive(const Recording& r, bool by_transforms = false) {
    std::size_t next = 0;
    const auto odometry_until = [&](LogTime time) {
      for (; next < r.odometry.size() && r.odometry[next].time <= time; ++next) {
        const OdometrySample& o = r.odometry[next];
        if (by_transforms)
          add(ros::TfMessage{
              {ros::transform_of(o.T_odom_base.raw(), o.time, "odom", "base_footprint")}});
        else
          add(ros::message_of(o, "odom", "base_link"));
      }
    };
    for (const LaserScan& scan : r.scans) {
      odometry_until(scan.time);
      add(ros::message_of(scan, "laser"));
    }
    odometry_until(r.odometry.back().time);
    wait(3.0);
  }
  [[nodiscard]] std::uint64_t left_out(const std::string& kind) const {
    const auto found = node.left_out().find(kind);
    return found == node.left_out().end() ? 0 : found->second;
  }

  ros::LocaliseNode node;
  double now_s = 100.0;
  std::vector<ros::PoseWithCovarianceStamped> poses;
  std::vector<ros::TransformStamped> transforms;
  std::vector<ros::ParticleCloud> clouds;
  std::vector<LocalisationOutcome> outcomes;
  std::string said;

 private:
  std::optional<LogTime> seen_;
};

inline ros::LocaliseNodeOptions with_initial() {
  ros::LocaliseNodeOptions options;
  options.initial = begin_of(room_drive());
  return options;
}

inline bool same_bits(const SE2d& a, const SE2d& b) {
  return a.x() == b.x() && a.y() == b.y() && a.rotation().cos() == b.rotation().cos() &&
         a.rotation().sin() == b.rotation().sin();
}

inline void expect_same(const std::vector<LocalisationOutcome>& got,
                        const std::vector<LocalisationOutcome>& wanted) {
  ASSERT_EQ(got.size(), wanted.size());
  for (std::size_t i = 0; i < got.size(); ++i) {
    ASSERT_EQ(got[i].time, wanted[i].time) << i;
    ASSERT_TRUE(same_bits(got[i].T_map_base.mean, wanted[i].T_map_base.mean)) << i;
    ASSERT_EQ(got[i].T_map_base.covariance, wanted[i].T_map_base.covariance) << i;
    ASSERT_EQ(got[i].converged, wanted[i].converged) << i;
  }
}

inline double error_m(const LocalisationOutcome& outcome, const Recording& r) {
  const auto truth = pose_at(r.truth, outcome.time);
  return (outcome.T_map_base.mean.translation() - truth->translation()).norm();
}

}  // namespace wayfare::testing
