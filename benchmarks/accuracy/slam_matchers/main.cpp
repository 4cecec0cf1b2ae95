// The SLAM systems with different scan matchers on a recorded log: error of the relations, time.

#include <cstdio>
#include <ctime>
#include <optional>
#include <string>
#include <vector>

#include <wayfare/eval/relations.hpp>
#include <wayfare/eval/table.hpp>

#include "support/progress_line.hpp"
#include "support/slam_program.hpp"
#include "systems.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Options {
  std::string log, relations, only;
  bool quiet = false;
  Scores scores;
};

Result<void> add_row(eval::Table& table, const System& system, const Recording& recording,
                     const std::vector<eval::Relation>& relations, bool quiet) {
  const std::clock_t begin = std::clock();
  const auto timed = run_timed(system.name + ", " + system.matcher, quiet, [&](ProgressLine& line) {
    return system.run(recording, std::ref(line));
  });
  if (!timed) return timed.error();
  const double cpu_s = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  const SystemRun& run = timed->slam;
  const auto e = eval::relations_error(run.trajectory, relations);
  table.add_row({system.name, system.matcher,
                 eval::mean_std(e.translation_m.mean, e.translation_m.std, 4),
                 eval::mean_std(e.rotation_deg.mean, e.rotation_deg.std, 3),
                 eval::fixed(1e3 * cpu_s / static_cast<double>(run.scans), 2),
                 std::to_string(run.unmatched_scans), std::to_string(run.loop_closures)});
  if (run.matcher_errors.count > 0)
    std::fprintf(stderr, "%s, %s: %zu errors of the matcher, the first at a %s\n",
                 system.name.c_str(), system.matcher.c_str(), run.matcher_errors.count,
                 run.matcher_errors.first.c_str());
  return {};
}

Result<void> run(const Options& o) {
  const auto recording = read_robot_log(o.log);
  if (!recording) return recording.error();
  const auto relations = read_relations_or_none(o.relations);
  if (!relations) return relations.error();
  eval::Table table({{"system"},
                     {"matcher"},
                     {"translation", "m"},
                     {"rotation", "deg"},
                     {"CPU time per scan", "ms"},
                     {"unmatched scans"},
                     {"loop closures"}});
  std::vector<System> systems = graph_slam_systems(o.scores);
  for (const auto& more : {submap_slam_systems(o.scores), hector_slam_systems(o.scores)})
    systems.insert(systems.end(), more.begin(), more.end());
  for (const System& system : systems) {
    if (!o.only.empty() && (system.name + " " + system.matcher).find(o.only) == std::string::npos)
      continue;
    if (auto ok = add_row(table, system, *recording, *relations, o.quiet); !ok) return ok;
  }
  std::printf("%s", table.to_text().c_str());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app{
      "Compare SLAM systems with different scan matchers on a recorded log: mean error "
      "of its relations and CPU time per scan."};
  Options o;
  app.add_option("LOG", o.log, "the recorded log").required().existing_file();
  app.add_option("RELATIONS", o.relations, "true relative poses").required().existing_file();
  app.add_option("--only", o.only, "the rows with this in \"system matcher\"");
  app.add_option("--tracked-score", o.scores.tracked,
                 "score below which ICP and NDT search more widely; 0: as chosen")
      .range(0.0, 1.0);
  app.add_option("--lost-score", o.scores.lost,
                 "score below which their matches are not used; 0: as chosen")
      .range(0.0, 1.0);
  app.add_flag("--quiet", o.quiet, kQuietHelp);
  app.example("robot.log robot.relations", "all systems and matchers");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("slam_matchers", run(o));
}
