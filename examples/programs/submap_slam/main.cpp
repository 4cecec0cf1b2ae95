// Submap SLAM on a recorded log: local submaps, loop closure by branch and bound, pose-graph
// optimisation.

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/slam/submap_slam.hpp>

#include "support/option_fields.hpp"
#include "support/slam_program.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

Result<LogRun> run(SubmapSlamOptions options, const StateFiles& files, const Recording& recording,
                   const SlamArguments& arguments, const SlamProgress& progress) {
  const auto saved = files.read(arguments.write());
  if (!saved) return saved.error();
  options.threads = arguments.threads;
  auto slam = run_submap_slam(recording, options, progress, *saved);
  if (!slam) return files.named(slam.error());
  if (auto ok = files.write(slam->state, arguments.write()); !ok) return ok.error();
  const SubmapSlamStatistics& s = slam->statistics;
  const double mebibytes = static_cast<double>(slam->memory_bytes) / (1 << 20);
  Facts facts = {
      {"submaps", std::to_string(s.submaps) + " of " + std::to_string(s.nodes) + " scans"},
      {"graph", size_of(slam->graph)},
      {"loop closures", accepted_and_refused(s.loop_closures, s.loops_refused)},
      {"memory", eval::fixed(mebibytes, 1) + " MiB"}};
  return log_run_of_pieces(*slam, std::move(facts));
}

}  // namespace

int main(int argc, char** argv) {
  SubmapSlamOptions options;
  StateFiles files;
  return run_log_program(
      argc, argv,
      {"submap_slam", "submap SLAM",
       "Estimate trajectory and map from a recorded robot log by submap SLAM with loop closure.",
       submap_slam_fields(options), std::bind_front(run, std::cref(options), std::cref(files)),
       [&] { return check_submap_slam(options); },
       [&](CommandLine& app) { files.add_options(app); }});
}
