// A walker with range finder and inertial unit on the head in simulated buildings: five methods of
// localisation (after Sadruddin 2020, 5.2 and 5.3).

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include <wayfare/core/statistics.hpp>

#include "heading_walks.hpp"
#include "hector_walks.hpp"
#include "recorded_walk.hpp"
#include "support/program_files.hpp"
#include "support/progress_line.hpp"
#include "walks.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Arguments {
  int seeds = 10;
  std::uint64_t first = 1;
  bool quiet = false, each = false, hector = false, heading = false;
  double gyro_bias_deg = 0.05, sweep_ms = 0.0;
  bool no_deskew = false;
  std::string folder, plan, walk = "rectangle";
};

/// Calls `follow(walk, seed)` for every walk and seed, and `done(walk)` after each walk's last.
template <class Follow, class Done>
void for_each_walk(const Arguments& o, const std::vector<Walk>& walks, const Follow& follow,
                   const Done& done) {
  ProgressLine progress("walks", o.quiet);
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

template <class Errors>
Summary summary_of(const std::vector<Errors>& errors, double Errors::*member) {
  std::vector<double> values;
  for (const Errors& e : errors) values.push_back(e.*member);
  return summarise(values);
}

eval::Table method_table(const Arguments& o, const std::vector<Walk>& walks) {
  eval::Table table({{"walk"},
                     {"method"},
                     {"mean error", "m"},
                     {"worst", "m"},
                     {"of the path", "%"},
                     {"better than submaps", "%"}});
  const auto submaps = static_cast<std::size_t>(
      std::find(methods().begin(), methods().end(), "submaps") - methods().begin());
  std::vector<std::vector<double>> errors(methods().size());
  double length_m = 0.0;
  for_each_walk(
      o, walks,
      [&](const Walk& walk, std::uint64_t seed) {
        const WalkErrors e = follow_walk(walk, seed);
        length_m = e.length_m;
        for (std::size_t m = 0; m < errors.size(); ++m) errors[m].push_back(e.rmse_m[m]);
        if (!o.each) return;
        std::printf("%s %d:", walk.name.c_str(), static_cast<int>(seed));
        for (const double r : e.rmse_m) std::printf(" %.3f", r);
        std::printf("  scale %.3f\n", e.scale);
      },
      [&](const Walk& walk) {
        const double of_submaps_m = summarise(errors.at(submaps)).mean;
        for (std::size_t m = 0; m < errors.size(); ++m) {
          const Summary s = summarise(errors[m]);
          table.add_row({walk.name + ", " + eval::fixed(length_m, 0) + " m", methods()[m],
                         eval::mean_std(s.mean, s.std, 3), eval::fixed(s.max, 3),
                         eval::fixed(100 * s.mean / length_m, 2),
                         eval::fixed(100 * (1.0 - s.mean / of_submaps_m), 1)});
        }
        for (std::vector<double>& of_method : errors) of_method.clear();
      });
  return table;
}

eval::Table hector_table(const Arguments& o, const std::vector<Walk>& walks) {
  eval::Table table({{"walk"},
                     {"use of the unit"},
                     {"position", "m"},
                     {"worst", "m"},
                     {"heading", "deg"},
                     {"tilt", "deg"},
                     {"NEES pose"},
                     {"tilt"},
                     {"velocity"}});
  std::vector<std::vector<HectorErrors>> errors(hector_methods().size());
  const auto add_row = [&](const Walk& walk, std::size_t method) {
    using E = HectorErrors;
    const auto of = [&](double E::*member) { return summary_of(errors[method], member); };
    const Summary position = of(&E::position_m);
    const auto mean = [&](double E::*member, int digits) {
      return eval::fixed(of(member).mean, digits);
    };
    table.add_row({walk.name, hector_methods()[method],
                   eval::mean_std(position.mean, position.std, 3), eval::fixed(position.max, 3),
                   mean(&E::heading_deg, 2), mean(&E::tilt_deg, 2), mean(&E::pose_nees, 2),
                   mean(&E::tilt_nees, 2), mean(&E::velocity_nees, 2)});
    errors[method].clear();
  };
  for_each_walk(
      o, walks,
      [&](const Walk& walk, std::uint64_t seed) {
        const auto e = follow_by_hector(walk, seed);
        for (std::size_t method = 0; method < errors.size(); ++method)
          errors[method].push_back(e[method]);
        if (!o.each) return;
        std::printf("%s %d:", walk.name.c_str(), static_cast<int>(seed));
        for (const HectorErrors& r : e)
          std::printf("  %.3f/%.2f/%.2f", r.position_m, r.tilt_deg, r.pose_nees);
        std::printf("\n");
      },
      [&](const Walk& walk) {
        for (std::size_t method = 0; method < errors.size(); ++method) add_row(walk, method);
      });
  return table;
}

eval::Table heading_table(const Arguments& o, const std::vector<Walk>& walks) {
  eval::Table table({{"walk"},
                     {"the map's heading corrects"},
                     {"position", "m"},
                     {"worst", "m"},
                     {"filter's heading", "deg"},
                     {"worst", "deg"},
                     {"NEES"}});
  std::vector<std::vector<HeadingErrors>> errors(heading_methods().size());
  for_each_walk(
      o, walks,
      [&](const Walk& walk, std::uint64_t seed) {
        const auto e = follow_headings(walk, seed, Angle::degrees(o.gyro_bias_deg));
        for (std::size_t method = 0; method < errors.size(); ++method)
          errors[method].push_back(e[method]);
        if (!o.each) return;
        std::printf("%s %d:", walk.name.c_str(), static_cast<int>(seed));
        for (const auto& r : e)
          std::printf("  %.3f/%.2f/%.2f", r.position_m, r.heading_deg, r.nees);
        std::printf("\n");
      },
      [&](const Walk& walk) {
        for (std::size_t method = 0; method < errors.size(); ++method) {
          using E = HeadingErrors;
          const auto of = [&](double E::*member) { return summary_of(errors[method], member); };
          const Summary position = of(&E::position_m), heading = of(&E::heading_deg);
          table.add_row({walk.name, heading_methods()[method],
                         eval::mean_std(position.mean, position.std, 3),
                         eval::fixed(position.max, 3), eval::mean_std(heading.mean, heading.std, 2),
                         eval::fixed(heading.max, 2), eval::fixed(of(&E::nees).mean, 2)});
          errors[method].clear();
        }
      });
  return table;
}

/// The walk of --walk, and its plan if that is wanted.
Result<void> write_chosen(const Arguments& o, const std::vector<Walk>& walks) {
  const auto walk =
      std::find_if(walks.begin(), walks.end(), [&](const Walk& w) { return w.name == o.walk; });
  if (auto ok = write_walk(*walk, o.first, o.folder); !ok || o.plan.empty()) return ok;
  return write_plan(walk->plan, o.plan);
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app("Errors of five methods to localise a walker in simulated corridors.");
  Arguments o;
  app.add_option("--seeds", o.seeds, "walks per building").positive();
  app.add_option("--seed", o.first, "of the random numbers, for the first walk");
  const Option write =
      app.add_option("--write", o.folder,
                     "write scans and readings of the first walk to this folder, and exit")
          .shown_as("DIR");
  app.add_option("--walk", o.walk, "of --write: its building")
      .one_of({"rectangle", "eight", "corridors"})
      .needs(write.name())
      .show_default();
  app.add_option("--write-plan", o.plan, "of --write: also the building's floor plan, to this file")
      .needs(write.name());
  app.add_flag("--hector", o.hector, "only Hector SLAM, with and without its navigation filter");
  app.add_flag(
      "--heading", o.heading,
      "only submaps + steps with feedback: the map's heading outside and inside the filter");
  app.add_option("--gyro-bias", o.gyro_bias_deg,
                 "with --heading: standard deviation of the gyro bias, deg/s")
      .positive();
  app.add_number("--sweep", o.sweep_ms, 0.0, 1000.0,
                 "time from a scan's first beam to its last, ms: 181.3 in a revolution at 5.5 Hz; "
                 "0: all beams at one instant");
  app.add_flag("--no-deskew", o.no_deskew,
               "with --sweep: take the beams of a scan as of one instant");
  app.add_flag("--each", o.each, "print every walk");
  app.add_flag("--quiet", o.quiet, kQuietHelp);
  app.example("--seeds 5", "five walks in each building");
  if (const auto code = app.parse(argc, argv)) return *code;
  auto walks = study_walks();
  for (Walk& walk : walks) {
    walk.sweep = from_seconds(1e-3 * o.sweep_ms);
    walk.beams_have_times = !o.no_deskew;
  }
  if (!o.folder.empty()) return exit_code("pedestrian_slam_study", write_chosen(o, walks));
  const eval::Table table = o.hector    ? hector_table(o, walks)
                            : o.heading ? heading_table(o, walks)
                                        : method_table(o, walks);
  std::fputs(table.to_text().c_str(), stdout);
  return 0;
}
