// The library at work on simulated robots, with the errors against the truth.

#include <string>

#include "demos.hpp"
#include "support/command_line.hpp"
#include "support/exit_code.hpp"

int main(int argc, char** argv) {
  using namespace wayfare;
  examples::CommandLine app(
      "Simulate a robot with radar and LiDAR in a loop of corridors, run graph SLAM and particle "
      "filters on its log and report how far each is from the truth; or a robot with LiDAR in an "
      "office floor, and graph SLAM.");
  examples::SlamArguments arguments;
  std::string world = "corridor_loop";
  examples::add_out(app, arguments, "folder for log, trajectories, maps and report");
  app.add_option("--world", world, "corridor_loop or office")
      .one_of({"corridor_loop", "office"})
      .show_default();
  examples::add_seed(app, arguments, "the same seed gives the same results");
  examples::add_threads(app, arguments);
  examples::add_manners(app, arguments);
  if (const auto code = app.parse(argc, argv)) return *code;
  return examples::exit_code("demo", world == "office" ? examples::run_office(arguments)
                                                       : examples::run_corridors(arguments));
}
