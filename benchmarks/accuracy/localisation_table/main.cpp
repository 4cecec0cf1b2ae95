// Monte-Carlo localisation in simulated places, over seeds: found from nowhere, after being carried
// away, and tracked.

#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include <wayfare/core/statistics.hpp>
#include <wayfare/eval/table.hpp>

#include "localise/trials.hpp"
#include "support/command_line.hpp"
#include "support/exit_code.hpp"
#include "support/progress_line.hpp"

namespace {

using namespace wayfare;

struct Options {
  std::vector<std::string> worlds{"building", "corridor_loop", "room", "cluttered_room"};
  int seeds = 10;
  double way_m = examples::kWay_m;
  std::uint64_t first_seed = 1;
  std::string sensors = "lidar";
  bool beam = false, verbose = false, quiet = false;
  LocalisationOptions localisation;
};

struct Searches {
  int tried = 0, found = 0, wrong = 0, mirrored = 0, narrowed = 0;
  std::vector<double> ways_m, shares_wrong;

  void add(const examples::Search& s) {
    ++tried;
    found += s.found ? 1 : 0;
    wrong += s.wrongly_believed ? 1 : 0;
    narrowed += s.narrowed ? 1 : 0;
    mirrored += s.mirrored ? 1 : 0;
    shares_wrong.push_back(s.share_wrong);
    if (s.found) ways_m.push_back(s.way_m);
  }
  [[nodiscard]] std::string count() const {
    return std::to_string(found) + (narrowed > found ? " (" + std::to_string(narrowed) + ")" : "") +
           " of " + std::to_string(tried);
  }
  [[nodiscard]] std::string wrong_count() const {
    return std::to_string(wrong) + (mirrored > 0 ? " (" + std::to_string(mirrored) + ")" : "") +
           ", " + eval::fixed(100.0 * summarise(shares_wrong).mean, 1) + " %";
  }
  [[nodiscard]] std::string way() const {
    const Summary s = summarise(ways_m);
    return eval::fixed(s.median, 1) + " / " + eval::fixed(s.max, 1);
  }
};

struct Row {
  Searches global, kidnapped;
  std::vector<double> rmse_m, rmse_deg, worst_m, ns, particles;
};

void print(const std::string& world, std::uint64_t seed, const char* what,
           const examples::Search& s) {
  std::printf("%s seed %d %s: %s after %.1f m%s, %zu places, %.1f %% of the scans wrong\n",
              world.c_str(), static_cast<int>(seed), what, s.found ? "found" : "not found", s.way_m,
              s.wrongly_believed ? ", wrongly believed" : "", s.clusters, 100.0 * s.share_wrong);
}

Result<void> run_seed(const Options& o, const std::string& world, std::uint64_t seed, Row& row) {
  const auto course =
      examples::make_course({.world = world, .seed = seed, .radar = o.sensors != "lidar"});
  if (!course) return course.error();
  const auto global = examples::try_global(*course, o.localisation, seed, o.way_m);
  if (!global) return global.error();
  const auto kidnapped = examples::try_kidnapped(*course, o.localisation, seed, o.way_m);
  if (!kidnapped) return kidnapped.error();
  const auto tracking = examples::try_tracking(*course, o.localisation, seed);
  if (!tracking) return tracking.error();
  row.global.add(*global);
  row.kidnapped.add(*kidnapped);
  row.rmse_m.push_back(tracking->rmse_m);
  row.rmse_deg.push_back(tracking->rmse_deg);
  row.worst_m.push_back(tracking->worst_m);
  row.ns.push_back(tracking->ns_per_beam);
  row.particles.push_back(tracking->particles);
  if (!o.verbose) return {};
  print(world, seed, "from nowhere", *global);
  print(world, seed, "carried away", *kidnapped);
  std::printf("%s seed %d tracked: %.3f m, %.2f deg, worst %.2f m, believed %.3f\n", world.c_str(),
              static_cast<int>(seed), tracking->rmse_m, tracking->rmse_deg, tracking->worst_m,
              tracking->believed);
  return {};
}

std::string spread(const std::vector<double>& values, double scale, int decimals) {
  const Summary s = summarise(values);
  return eval::mean_std(scale * s.mean, scale * s.std, decimals);
}

Result<void> run(const Options& o) {
  eval::Table table({{"world"},
                     {"from nowhere"},
                     {"way, median / worst", "m"},
                     {"wrongly believed"},
                     {"carried away"},
                     {"way, median / worst", "m"},
                     {"wrongly believed"},
                     {"tracked RMSE", "cm"},
                     {"heading RMSE", "deg"},
                     {"worst", "cm"},
                     {"particles"},
                     {"a particle's beam", "ns"}});
  examples::ProgressLine progress("localising", o.quiet);
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
    table.add_row({name, row.global.count(), row.global.way(), row.global.wrong_count(),
                   row.kidnapped.count(), row.kidnapped.way(), row.kidnapped.wrong_count(),
                   spread(row.rmse_m, 100.0, 2), spread(row.rmse_deg, 1.0, 2),
                   spread(row.worst_m, 100.0, 1), eval::fixed(summarise(row.particles).mean, 0),
                   spread(row.ns, 1.0, 2)});
  }
  progress.finish();
  std::fputs(table.to_text().c_str(), stdout);
  std::puts(
      "found (with those whose heaviest place is right, or right but for the symmetry of the "
      "world, "
      "and not believed)\nwrongly believed at the end (of these: right but for the symmetry), and "
      "of all scans on the way");
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  examples::CommandLine app(
      "Localise simulated robots on known maps, over seeds, and print how it went.");
  Options o;
  app.add_option("--world", o.worlds,
                 "building, corridor_loop, room, cluttered_room, or VOXELS,WAY: files of a "
                 "real building's map and of a way through it")
      .show_default();
  app.add_option("--seeds", o.seeds, "runs of each").range(1, 1000);
  app.add_option("--first-seed", o.first_seed, "the first of them");
  app.add_option("--way", o.way_m, "metres within which the robot is to be found")
      .positive()
      .show_default();
  app.add_option("--sensors", o.sensors, "lidar, radar or both")
      .one_of({"lidar", "radar", "both"})
      .show_default();
  app.add_flag("--beam", o.beam, "beam model instead of the likelihood field");
  app.add_option("--threads", o.localisation.threads, "the results do not depend on them");
  app.add_option("--beams", o.localisation.beams, "beams of a scan looked at");
  app.add_flag("--verbose", o.verbose, "every trial");
  app.add_flag("--quiet", o.quiet, "no progress");
  if (const auto code = app.parse(argc, argv)) return *code;
  o.localisation.use_lidar = o.sensors != "radar";
  o.localisation.use_radar = o.sensors != "lidar";
  if (o.beam) o.localisation.model = ScanLikelihood::beam;
  return examples::exit_code("localisation_table", run(o));
}
