// LiDAR graph SLAM of two rooms in two of its three tiers: one call for a recording, and scan by
// scan as a robot would. The third is types of one's own: 23_own_matcher.cpp.
#include <cstdio>

#include <wayfare/eval/trajectory_error.hpp>
#include <wayfare/sim/simulate_recording.hpp>
#include <wayfare/slam/graph_slam.hpp>

using namespace wayfare;

int main() {
  const char* drawing =
      "metres_per_character 0.5\nroute a b c b a\npicture\n##############\n#     #      #\n"
      "# a          #\n#         b  #\n#     #      #\n#     #   c  #\n##############\n";
  const auto rooms = sim::read_plan(drawing);
  if (!rooms) return std::puts(rooms.error().message.c_str()), 1;
  sim::RobotParams robot;
  robot.wheels.right_scale = 1.03;  // a wheel larger than assumed: the odometry turns
  const auto drive = sim::simulate_recording(rooms->plan, rooms->route_m, robot, Rng(1));
  if (!drive) return std::puts(drive.error().message.c_str()), 1;
  const Recording& recording = drive->recording;
  const auto error_m = [&](const Trajectory& trajectory) {
    return eval::absolute_error(trajectory, drive->truth).translation_m.rmse;
  };
  std::printf("odometry: %.2f m rms\n", error_m(as_trajectory(recording.odometry)));

  // One call.
  const auto run = run_graph_slam(recording);
  if (!run) return std::puts(run.error().message.c_str()), 1;
  std::printf("recording: %.3f m rms, %d loop closures\n", error_m(run->trajectory),
              static_cast<int>(run->statistics.loop_closures));

  // Scan by scan, with the odometry at the time of the scan.
  GraphSlam slam({.T_base_laser = recording.T_base_laser});
  std::size_t at = 0;
  for (const LaserScan& scan : recording.scans) {
    while (recording.odometry[at].time < scan.time) ++at;
    const auto outcome = slam.add_scan(scan, recording.odometry[at].T_odom_base);
    if (!outcome) return std::puts(outcome.error().message.c_str()), 1;
    if (outcome->loop_closures > 0)  // the poses so far have changed
      std::printf("%5.1f s: loop closed\n", scan.time.seconds());
  }
  if (!slam.finish()) return 1;
  std::printf("scan by scan: %.3f m rms\n", error_m(slam.trajectory()));
}
