// Monte-Carlo localisation in simulated worlds, over seeds: global localisation, after kidnapping,
// and tracking.

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include <wayfare/core/statistics.hpp>
#include <wayfare/eval/table.hpp>

#include "localise/trials.hpp"
#include "support/plans.hpp"
#include "support/program_files.hpp"
#include "support/progress_line.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Options {
  std::vector<std::string> worlds{"building", "corridor_loop", "room", "cluttered_room"};
  int seeds = 10;
  double distance_m = kDistance_m;
  std::uint64_t first_seed = 1;
  std::string sensors = "lidar";
  bool beam = false, verbose = false, quiet = false;
  LocalisationOptions localisation;
};

struct Searches {
  int tried = 0, found = 0, wrong = 0, mirrored = 0, best_is_correct = 0;
  std::vector<double> distances_m, shares_wrong;

  void add(const Search& s) {
    ++tried;
    found += s.found ? 1 : 0;
    wrong += s.wrong ? 1 : 0;
    best_is_correct += s.best_is_correct ? 1 : 0;
    mirrored += s.mirrored ? 1 : 0;
    shares_wrong.push_back(s.share_wrong);
    if (s.found) distances_m.push_back(s.distance_m);
  }
  [[nodiscard]] std::string count() const {
    return std::to_string(found) +
           (best_is_correct > found ? " (" + std::to_string(best_is_correct) + ")" : "") + " of " +
           std::to_string(tried);
  }
  [[nodiscard]] std::string wrong_count() const {
    return std::to_string(wrong) + (mirrored > 0 ? " (" + std::to_string(mirrored) + ")" : "") +
           ", " + eval::fixed(100.0 * summarise(shares_wrong).mean, 1) + " %";
  }
  [[nodiscard]] std::string distance() const {
    const Summary s = summarise(distances_m);
    return eval::fixed(s.median, 1) + " / " + eval::fixed(s.max, 1);
  }
};

struct Row {
  Searches global, kidnapped;
  std::vector<double> rmse_m, rmse_deg, worst_m, ns, particles;
};

void print(const std::string& world, std::uint64_t seed, const char* what, const Search& s) {
  std::printf("%s seed %d %s: %s after %.1f m%s, %zu clusters, %.1f %% of the scans wrong\n",
              world.c_str(), static_cast<int>(seed), what, s.found ? "found" : "not found",
              s.distance_m, s.wrong ? ", wrongly converged" : "", s.clusters,
              100.0 * s.share_wrong);
}

Result<void> run_seed(const Options& o, const std::string& world, std::uint64_t seed, Row& row) {
  const auto course = make_course({.world = world, .seed = seed, .radar = o.sensors != "lidar"});
  if (!course) return course.error();
  const auto global = try_global(*course, o.localisation, seed, o.distance_m);
  if (!global) return global.error();
  const auto kidnapped = try_kidnapped(*course, o.localisation, seed, o.distance_m);
  if (!kidnapped) return kidnapped.error();
  const auto tracking = try_tracking(*course, o.localisation, seed);
  if (!tracking) return tracking.error();
  row.global.add(*global);
  row.kidnapped.add(*kidnapped);
  row.rmse_m.push_back(tracking->rmse_m);
  row.rmse_deg.push_back(tracking->rmse_deg);
  row.worst_m.push_back(tracking->worst_m);
  row.ns.push_back(tracking->ns_per_beam);
  row.particles.push_back(tracking->particles);
  if (!o.verbose) return {};
  print(world, seed, "global", *global);
  print(world, seed, "kidnapped", *kidnapped);
  std::printf("%s seed %d tracked: %.3f m, %.2f deg, worst %.2f m, converged %.3f\n", world.c_str(),
              static_cast<int>(seed), tracking->rmse_m, tracking->rmse_deg, tracking->worst_m,
              tracking->converged);
  return {};
}

std::string spread(const std::vector<double>& values, double scale, int decimals) {
  const Summary s = summarise(values);
  return eval::mean_std(scale * s.mean, scale * s.std, decimals);
}

/// Names, or files VOXELS,PATH.
Result<void> check_worlds(const std::vector<std::string>& worlds) {
  std::vector<std::string> names = world_names();
  names.insert(names.begin(), "building");
  for (const std::string& world : worlds)
    if (world.find(',') == world.npos && std::ranges::find(names, world) == names.end())
      return no_such_world(world, names);
  return {};
}

Result<void> run(const Options& o) {
  if (auto ok = check_worlds(o.worlds); !ok) return ok;
  eval::Table table({{"world"},
                     {"global"},
                     {"distance, median / worst", "m"},
                     {"wrongly converged"},
                     {"kidnapped"},
                     {"distance, median / worst", "m"},
                     {"wrongly converged"},
                     {"tracked RMSE", "cm"},
                     {"heading RMSE", "deg"},
                     {"worst", "cm"},
                     {"particles"},
                     {"per particle and beam", "ns"}});
  ProgressLine progress("localising", o.quiet);
  const double total = static_cast<double>(o.worlds.size()) * o.seeds;
  double done = 0.0;
  for (const std::string& world : o.worlds) {
    Row row;
    const std::string name = std::filesystem::path(world.substr(0, world.find(','))).filename();
    for (int k = 0; k < o.seeds; ++k) {
      if (auto ok = run_seed(o, world, o.first_seed + static_cast<std::uint64_t>(k), row); !ok)
        return ok;
      progress.update(++done / total);
    }
    table.add_row({name, row.global.count(), row.global.distance(), row.global.wrong_count(),
                   row.kidnapped.count(), row.kidnapped.distance(), row.kidnapped.wrong_count(),
                   spread(row.rmse_m, 100.0, 2), spread(row.rmse_deg, 1.0, 2),
                   spread(row.worst_m, 100.0, 1), eval::fixed(summarise(row.particles).mean, 0),
                   spread(row.ns, 1.0, 2)});
  }
  progress.finish();
  std::fputs(table.to_text().c_str(), stdout);
  std::puts(
      "found (including those not converged whose best cluster is correct up to the symmetry of "
      "the world)\nwrongly converged at the end (of these: correct up to the symmetry), and share "
      "of all scans");
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Localise simulated robots on known maps, over seeds, and print a table of the results.");
  Options o;
  app.add_option("--world", o.worlds,
                 "building, corridor_loop, room, cluttered_room, or VOXELS,PATH: files of a real "
                 "building's map and of a path through it")
      .show_default();
  app.add_option("--seeds", o.seeds, "runs in each world").range(1, 1000);
  app.add_option("--first-seed", o.first_seed, "the first of them");
  app.add_option("--way", o.distance_m, "distance within which the robot is to be localised, m")
      .positive()
      .show_default();
  app.add_option("--sensors", o.sensors, "lidar, radar or both")
      .one_of({"lidar", "radar", "both"})
      .show_default();
  app.add_flag("--beam", o.beam, "the beam model instead of the likelihood field");
  app.add_option("--threads", o.localisation.threads, kThreadsHelp);
  app.add_option("--beams", o.localisation.beams, "beams used per scan");
  app.add_flag("--verbose", o.verbose, "print every trial");
  app.add_flag("--quiet", o.quiet, kQuietHelp);
  app.example("--world room --seeds 20", "20 runs in one world");
  if (const auto code = app.parse(argc, argv)) return *code;
  o.localisation.use_lidar = o.sensors != "radar";
  o.localisation.use_radar = o.sensors != "lidar";
  if (o.beam) o.localisation.model = ScanLikelihood::beam;
  return exit_code("localisation_table", run(o));
}
