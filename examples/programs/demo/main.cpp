// SLAM of simulated robots, with errors against the truth.

#include <string>

#include "demos.hpp"

int main(int argc, char** argv) {
  using namespace wayfare;
  using namespace wayfare::examples;
  CommandLine app(
      "Simulate a robot with radar and LiDAR in a loop of corridors, run graph SLAM and particle "
      "filters on its log and report their errors; or a robot with LiDAR in an office floor, and "
      "graph SLAM.");
  SlamArguments arguments;
  std::string world = "corridor_loop";
  add_out(app, arguments, "folder for log, trajectories, maps and report");
  app.add_option("--world", world, "corridor_loop or office")
      .one_of({"corridor_loop", "office"})
      .show_default();
  add_seed(app, arguments, "the same seed gives the same results");
  add_threads(app, arguments.threads);
  add_force_and_quiet(app, arguments);
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("demo", world == "office" ? run_office(arguments) : run_corridors(arguments));
}
