// A walker with range finder and inertial unit on the head, through simulated buildings: five ways
// to follow the walk beside each other (after Sadruddin 2020, 5.2 and 5.3).

#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include <wayfare/eval/statistics.hpp>
#include <wayfare/eval/table.hpp>

#include "command_line.hpp"
#include "exit_code.hpp"
#include "progress_line.hpp"
#include "walks.hpp"

int main(int argc, char** argv) {
  using namespace wayfare;
  examples::CommandLine app("Errors of five ways to follow a walker through simulated corridors.");
  int seeds = 10;
  std::uint64_t first = 1;
  bool quiet = false, each = false;
  app.add_option("--seeds", seeds, "walks a building").positive();
  app.add_option("--seed", first, "of the first walk");
  std::string folder;
  app.add_option("--write", folder,
                 "write the first rectangle's scans and readings into this folder, and end");
  app.add_flag("--each", each, "print every walk");
  app.add_flag("--quiet", quiet, "no progress");
  if (const auto code = app.parse(argc, argv)) return *code;
  const auto walks = examples::study_walks();
  if (!folder.empty())
    return examples::exit_code("pedestrian_slam_study",
                               examples::write_walk(walks.front(), first, folder));
  examples::ProgressLine progress("walks", quiet);
  eval::Table table(
      {{"walk"}, {"followed by"}, {"mean error", "m"}, {"worst", "m"}, {"of the way", "%"}});
  for (std::size_t w = 0; w < walks.size(); ++w) {
    std::vector<std::vector<double>> errors(examples::methods().size());
    double way_m = 0.0;
    for (int k = 0; k < seeds; ++k) {
      const auto seed = first + static_cast<std::uint64_t>(k);
      const examples::WalkErrors e = examples::follow_walk(walks[w], seed);
      way_m = e.way_m;
      for (std::size_t m = 0; m < errors.size(); ++m) errors[m].push_back(e.rmse_m[m]);
      if (each) {
        std::printf("%s %d:", walks[w].name.c_str(), static_cast<int>(seed));
        for (const double r : e.rmse_m) std::printf(" %.3f", r);
        std::printf("  scale %.3f\n", e.scale);
      }
      progress.update((static_cast<double>(w) + (k + 1.0) / seeds) /
                      static_cast<double>(walks.size()));
    }
    for (std::size_t m = 0; m < errors.size(); ++m) {
      const eval::Summary s = eval::summarise(errors[m]);
      table.add_row({walks[w].name + ", " + eval::fixed(way_m, 0) + " m", examples::methods()[m],
                     eval::mean_std(s.mean, s.std, 3), eval::fixed(s.max, 3),
                     eval::fixed(100 * s.mean / way_m, 2)});
    }
  }
  progress.finish();
  std::fputs(table.to_text().c_str(), stdout);
  return 0;
}
