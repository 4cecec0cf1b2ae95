// Loops of submap SLAM on a log: errors, loops accepted and false ones, time and memory, as one
// line.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <ctime>
#include <string>

#include <wayfare/eval/relations.hpp>
#include <wayfare/eval/trajectory_error.hpp>
#include <wayfare/io/tum.hpp>
#include <wayfare/slam/submap_slam.hpp>

#include "support/option_fields.hpp"
#include "support/process_memory.hpp"
#include "support/slam_program.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

constexpr double kFalse_m = 0.5, kFalseSigmas = 5.0;
constexpr Angle kFalseTurn = Angle::degrees(5.0);

struct Options {
  std::string log, relations, config;
  SubmapSlamOptions slam;
  TruthOptions truth;
  bool header = false, no_odometry = false;
};

/// Loops that contradict the reference by kFalse_m or kFalseTurn, and by kFalseSigmas of their own:
/// along a corridor a loop may be open. Their ends are the scans that are at the nodes' poses.
std::size_t false_loops(const SubmapSlamRun& run, const Trajectory& reference) {
  const auto true_pose = [&](int pose) {
    const Eigen::Vector2d at = run.graph.poses[static_cast<std::size_t>(pose)].translation();
    const auto scan = std::ranges::min_element(run.trajectory, {}, [&](const StampedPose& s) {
      return (s.T_map_base.raw().translation() - at).squaredNorm();
    });
    return pose_at(reference, scan->time);
  };
  std::size_t count = 0;
  for (const PoseEdge<SE2d>& edge : run.graph.edges) {
    if (!edge.robust) continue;
    const auto from = true_pose(edge.from), to = true_pose(edge.to);
    if (!from || !to) continue;
    const SE2d off = edge.measurement.inverse() * (from->inverse() * *to);
    const bool is_far = off.translation().norm() > kFalse_m ||
                        std::abs(off.heading().radians()) > kFalseTurn.radians();
    const Eigen::Vector3d e(off.x(), off.y(), off.heading().radians());
    const double squared_sigmas = e.dot(edge.information * e);
    count += is_far && squared_sigmas > kFalseSigmas * kFalseSigmas ? 1 : 0;
  }
  return count;
}

std::string mean_std(const Summary& s, int digits) { return eval::mean_std(s.mean, s.std, digits); }

Result<void> run(const Options& o) {
  auto recording = read_robot_log(o.log);
  if (!recording) return recording.error();
  if (o.no_odometry) recording->odometry.clear();
  const auto relations = read_relations_or_none(o.relations);
  if (!relations) return relations.error();
  const auto truth = o.truth.read(o.log, recording->truth, times_of(*recording), {});
  if (!truth) return truth.error();
  const double read_mb = resident_memory_mb();
  const std::clock_t begin = std::clock();
  const auto slam = run_submap_slam(*recording, o.slam);
  if (!slam) return slam.error();
  const double cpu_s = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  const auto pairs = eval::relations_error(slam->trajectory, *relations);
  const auto errors = eval::absolute_error(eval::associate(slam->trajectory, truth->poses));
  if (o.header)
    std::printf("relations m; deg; ATE rmse m; deg; loops; false; refused; CPU s; MB over log\n");
  std::printf("%s; %s; %.4f; %.3f; %zu; %zu; %zu; %.2f; %.0f\n",
              mean_std(pairs.translation_m, 4).c_str(), mean_std(pairs.rotation_deg, 3).c_str(),
              errors.translation_m.rmse, errors.rmse_heading_deg, slam->statistics.loop_closures,
              false_loops(*slam, truth->known() ? truth->poses : slam->trajectory),
              slam->statistics.loops_refused, cpu_s, peak_memory_mb() - read_mb);
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app{
      "Run submap SLAM on a log and print, as one line, its errors, the loops accepted, those of "
      "them that contradict the truth (without truth: the path found) by 0.5 m or 5 degrees "
      "and by five of their standard deviations, the loops refused, processor time and memory."};
  Options o;
  const auto fields = submap_slam_fields(o.slam);
  app.add_option("LOG", o.log, "the recorded log").required().existing_file();
  app.add_file("--relations", o.relations, "true relative poses, to compare with");
  o.truth.add_options(app);
  app.add_file("--config", o.config, "JSON file of options, as of submap_slam");
  app.add_flag("--no-odometry", o.no_odometry, "use the scans alone");
  app.add_flag("--header", o.header, "print the columns' names first");
  app.example("robot.log --relations robot.relations", "with the default options");
  if (const auto code = app.parse(argc, argv)) return *code;
  if (!o.config.empty())
    if (auto ok = read_option_fields(o.config, fields); !ok) return exit_code("submap_loops", ok);
  return exit_code("submap_loops", run(o));
}
