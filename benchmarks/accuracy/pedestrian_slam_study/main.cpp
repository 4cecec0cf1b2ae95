// A walker with range finder and inertial unit on the head, through simulated buildings: five ways
// to follow the walk beside each other (after Sadruddin 2020, 5.2 and 5.3).

#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include <wayfare/core/statistics.hpp>
#include <wayfare/eval/table.hpp>

#include "heading_walks.hpp"
#include "hector_walks.hpp"
#include "recorded_walk.hpp"
#include "support/command_line.hpp"
#include "support/exit_code.hpp"
#include "support/progress_line.hpp"
#include "walks.hpp"

namespace {

using namespace wayfare;

struct Arguments {
  int seeds = 10;
  std::uint64_t first = 1;
  bool quiet = false, each = false, hector = false, heading = false;
  double gyro_bias_deg = 0.05;
  std::string folder;
};

/// Calls `follow(walk, seed)` for every walk and seed, and `done(walk)` after each walk's last.
template <class Follow, class Done>
void for_each_walk(const Arguments& o, const std::vector<examples::Walk>& walks,
                   const Follow& follow, const Done& done) {
  examples::ProgressLine progress("walks", o.quiet);
  for (std::size_t w = 0; w < walks.size(); ++w) {
    for (int k = 0; k < o.seeds; ++k) {
      follow(walks[w], o.first + static_cast<std::uint64_t>(k));
      progress.update((static_cast<double>(w) + (k + 1.0) / o.seeds) /
                      static_cast<double>(walks.size()));
    }
    done(walks[w]);
  }
  progress.finish();
}

eval::Table five_ways(const Arguments& o, const std::vector<examples::Walk>& walks) {
  eval::Table table(
      {{"walk"}, {"followed by"}, {"mean error", "m"}, {"worst", "m"}, {"of the way", "%"}});
  std::vector<std::vector<double>> errors(examples::methods().size());
  double way_m = 0.0;
  for_each_walk(
      o, walks,
      [&](const examples::Walk& walk, std::uint64_t seed) {
        const examples::WalkErrors e = examples::follow_walk(walk, seed);
        way_m = e.way_m;
        for (std::size_t m = 0; m < errors.size(); ++m) errors[m].push_back(e.rmse_m[m]);
        if (!o.each) return;
        std::printf("%s %d:", walk.name.c_str(), static_cast<int>(seed));
        for (const double r : e.rmse_m) std::printf(" %.3f", r);
        std::printf("  scale %.3f\n", e.scale);
      },
      [&](const examples::Walk& walk) {
        for (std::size_t m = 0; m < errors.size(); ++m) {
          const Summary s = summarise(errors[m]);
          table.add_row({walk.name + ", " + eval::fixed(way_m, 0) + " m", examples::methods()[m],
                         eval::mean_std(s.mean, s.std, 3), eval::fixed(s.max, 3),
                         eval::fixed(100 * s.mean / way_m, 2)});
          errors[m].clear();
        }
      });
  return table;
}

eval::Table hector_with_and_without(const Arguments& o, const std::vector<examples::Walk>& walks) {
  eval::Table table({{"walk"},
                     {"what the unit gives"},
                     {"position", "m"},
                     {"worst", "m"},
                     {"heading", "deg"},
                     {"tilt", "deg"},
                     {"NEES pose"},
                     {"tilt"},
                     {"velocity"}});
  std::vector<std::vector<examples::HectorErrors>> errors(examples::hector_ways().size());
  const auto add_row = [&](const examples::Walk& walk, std::size_t way) {
    const auto of = [&](double examples::HectorErrors::*member) {
      std::vector<double> values;
      for (const examples::HectorErrors& e : errors[way]) values.push_back(e.*member);
      return summarise(values);
    };
    using E = examples::HectorErrors;
    const Summary position = of(&E::position_m);
    const auto mean = [&](double E::*member, int digits) {
      return eval::fixed(of(member).mean, digits);
    };
    table.add_row({walk.name, examples::hector_ways()[way],
                   eval::mean_std(position.mean, position.std, 3), eval::fixed(position.max, 3),
                   mean(&E::heading_deg, 2), mean(&E::tilt_deg, 2), mean(&E::pose_nees, 2),
                   mean(&E::tilt_nees, 2), mean(&E::velocity_nees, 2)});
    errors[way].clear();
  };
  for_each_walk(
      o, walks,
      [&](const examples::Walk& walk, std::uint64_t seed) {
        const auto e = examples::follow_by_hector(walk, seed);
        for (std::size_t way = 0; way < errors.size(); ++way) errors[way].push_back(e[way]);
        if (!o.each) return;
        std::printf("%s %d:", walk.name.c_str(), static_cast<int>(seed));
        for (const examples::HectorErrors& r : e)
          std::printf("  %.3f/%.2f/%.2f", r.position_m, r.tilt_deg, r.pose_nees);
        std::printf("\n");
      },
      [&](const examples::Walk& walk) {
        for (std::size_t way = 0; way < errors.size(); ++way) add_row(walk, way);
      });
  return table;
}

eval::Table headings(const Arguments& o, const std::vector<examples::Walk>& walks) {
  eval::Table table({{"walk"},
                     {"the map's heading corrects"},
                     {"position", "m"},
                     {"worst", "m"},
                     {"filter's heading", "deg"},
                     {"worst", "deg"},
                     {"NEES"}});
  std::vector<std::vector<examples::HeadingErrors>> errors(examples::heading_ways().size());
  for_each_walk(
      o, walks,
      [&](const examples::Walk& walk, std::uint64_t seed) {
        const auto e = examples::follow_headings(walk, seed, Angle::degrees(o.gyro_bias_deg));
        for (std::size_t way = 0; way < errors.size(); ++way) errors[way].push_back(e[way]);
        if (!o.each) return;
        std::printf("%s %d:", walk.name.c_str(), static_cast<int>(seed));
        for (const auto& r : e)
          std::printf("  %.3f/%.2f/%.2f", r.position_m, r.heading_deg, r.nees);
        std::printf("\n");
      },
      [&](const examples::Walk& walk) {
        for (std::size_t way = 0; way < errors.size(); ++way) {
          using E = examples::HeadingErrors;
          const auto of = [&](double E::*member) {
            std::vector<double> values;
            for (const E& e : errors[way]) values.push_back(e.*member);
            return summarise(values);
          };
          const Summary position = of(&E::position_m), heading = of(&E::heading_deg);
          table.add_row({walk.name, examples::heading_ways()[way],
                         eval::mean_std(position.mean, position.std, 3),
                         eval::fixed(position.max, 3), eval::mean_std(heading.mean, heading.std, 2),
                         eval::fixed(heading.max, 2), eval::fixed(of(&E::nees).mean, 2)});
          errors[way].clear();
        }
      });
  return table;
}

}  // namespace

int main(int argc, char** argv) {
  examples::CommandLine app("Errors of five ways to follow a walker through simulated corridors.");
  Arguments o;
  app.add_option("--seeds", o.seeds, "walks a building").positive();
  app.add_option("--seed", o.first, "of the first walk");
  app.add_option("--write", o.folder,
                 "write the first rectangle's scans and readings into this folder, and end");
  app.add_flag("--hector", o.hector, "Hector SLAM alone, with and without its navigation filter");
  app.add_flag("--heading", o.heading,
               "submaps + steps, fed back, alone: the map's heading outside and inside the filter");
  app.add_option("--gyro-bias", o.gyro_bias_deg,
                 "with --heading: of the gyro, standard deviation, deg/s")
      .positive();
  app.add_flag("--each", o.each, "print every walk");
  app.add_flag("--quiet", o.quiet, "no progress");
  if (const auto code = app.parse(argc, argv)) return *code;
  const auto walks = examples::study_walks();
  if (!o.folder.empty())
    return examples::exit_code("pedestrian_slam_study",
                               examples::write_walk(walks.front(), o.first, o.folder));
  const eval::Table table = o.hector    ? hector_with_and_without(o, walks)
                            : o.heading ? headings(o, walks)
                                        : five_ways(o, walks);
  std::fputs(table.to_text().c_str(), stdout);
  return 0;
}
