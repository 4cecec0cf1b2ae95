// The simulation of Liu et al. (2015, section 6) over many seeds: position errors by section with
// and without walls, gyro bias, consistency, and observability by walls.

#include <cmath>
#include <cstdio>
#include <mutex>
#include <string>
#include <vector>

#include <wayfare/core/parallel.hpp>
#include <wayfare/core/statistics.hpp>
#include <wayfare/eval/consistency.hpp>
#include <wayfare/eval/table.hpp>

#include "corridor_ins/evaluate.hpp"
#include "support/program_files.hpp"
#include "support/progress_line.hpp"
#include "support/slam_program.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Options {
  int pattern = 1, runs = 50, threads = 1;
  std::uint64_t first_seed = 1;
  double rate_hz = 0.0, scan_rate_hz = 5.0;
  double doors = 0.0, open_share = 0.4, boxes = 0.0, people = 0.0;
  bool quiet = false;
};

constexpr std::array kAidings = {Aiding::none, Aiding::scan_to_scan, Aiding::side_walls,
                                 Aiding::end_walls};

struct Runs {
  std::array<std::vector<CorridorErrors>, kAidings.size()> of;
  std::string failure;
};

sim::CorridorDriveParams params_of(const Options& o) {
  sim::CorridorDriveParams p;
  p.pattern = o.pattern == 1 ? sim::MotionPattern::straight : sim::MotionPattern::curved;
  p.scan_period = from_seconds(1.0 / o.scan_rate_hz);
  p.place.furniture.door_spacing_m = o.doors;
  p.place.furniture.open_share = o.open_share;
  p.place.furniture.boxes_per_m = o.boxes;
  p.place.furniture.people_per_m = o.people;
  return p;
}

Runs run_all(const Options& o, const sim::CorridorDriveParams& params) {
  Runs all;
  for (auto& v : all.of) v.resize(static_cast<std::size_t>(o.runs));
  std::mutex mutex;
  ProgressLine progress("drives", o.quiet);
  parallel_for(
      static_cast<std::size_t>(o.runs), o.threads,
      [&](std::size_t i) {
        const auto drive = sim::simulate_corridors(params, Rng(o.first_seed + i));
        for (std::size_t a = 0; drive && a < kAidings.size(); ++a) {
          const auto motion = motion_of(drive->recording);
          auto options = options_for(params, kAidings[a]);
          if (o.rate_hz > 0.0) options.least_scan_interval = from_seconds(1.0 / o.rate_hz);
          const auto run = run_corridor_ins(drive->recording, motion, options,
                                            start_of(options, Rng(o.first_seed + i)));
          if (run) all.of[a][i] = errors_of(*run, *drive, params.rest_s);
        }
        const std::lock_guard lock(mutex);
        if (!drive) all.failure = drive.error().to_string();
      },
      std::ref(progress));
  progress.finish();
  return all;
}

template <class Pick>
std::vector<double> values_of(const std::vector<CorridorErrors>& runs, const Pick& pick) {
  std::vector<double> values;
  for (const CorridorErrors& e : runs) values.push_back(pick(e));
  return values;
}
template <class Pick>
std::string spread(const std::vector<CorridorErrors>& runs, int decimals, const Pick& pick) {
  return eval::mean_std(values_of(runs, pick), decimals);
}
template <class Pick>
double rms(const std::vector<CorridorErrors>& runs, const Pick& pick) {
  return summarise(values_of(runs, pick)).rmse;
}
template <class Test>
std::string share(const std::vector<CorridorErrors>& runs, const Test& test) {
  int n = 0;
  for (const CorridorErrors& e : runs) n += test(e) ? 1 : 0;
  return std::to_string(n) + " of " + std::to_string(runs.size());
}

eval::Table sections(const Runs& all) {
  eval::Table table({{""},
                     {"Corridor I", "m"},
                     {"Outage I", "m"},
                     {"Corridor II", "m"},
                     {"Outage II", "m"},
                     {"Corridor III", "m"},
                     {"Total", "m"},
                     {"worst run", "m"}});
  for (std::size_t a = 0; a < kAidings.size(); ++a) {
    std::vector<std::string> row{name_of(kAidings[a])};
    for (std::size_t s = 0; s < 6; ++s)
      row.push_back(spread(all.of[a], 3, [&](const auto& e) { return e.position_rmse_m[s]; }));
    double worst = 0.0;
    for (const auto& e : all.of[a]) worst = std::max(worst, e.position_rmse_m[5]);
    row.push_back(eval::fixed(worst, 3));
    table.add_row(std::move(row));
  }
  return table;
}

eval::Table sensors(const Runs& all) {
  eval::Table table({{""},
                     {"bias error RMS", "deg/s"},
                     {"sigma", "deg/s"},
                     {"within 3 sigma"},
                     {"within 0.01 deg/s"},
                     {"heading RMSE", "deg"},
                     {"walls used", "%"}});
  for (std::size_t a = 0; a < kAidings.size(); ++a) {
    const auto& runs = all.of[a];
    table.add_row(
        {name_of(kAidings[a]),
         eval::fixed(rms(runs, [](const auto& e) { return e.bias_error_deg_s; }), 4),
         spread(runs, 4, [](const auto& e) { return e.bias_sigma_deg_s; }),
         share(runs,
               [](const auto& e) { return std::abs(e.bias_error_deg_s) < 3 * e.bias_sigma_deg_s; }),
         share(runs, [](const auto& e) { return std::abs(e.bias_error_deg_s) < 0.01; }),
         spread(runs, 3, [](const auto& e) { return e.heading_rmse_deg; }),
         spread(runs, 1, [](const auto& e) { return 100.0 * e.walls_share; })});
  }
  return table;
}

/// Uncertainty that remains with walls: position along and across, and scale of the wheels.
eval::Table observability(const Runs& all, const sim::CorridorDriveParams& params) {
  eval::Table table({{""},
                     {"sigma along at the end", "m"},
                     {"across", "m"},
                     {"scale: final over initial sigma", "%"},
                     {"scale error RMS", "%"}});
  for (std::size_t a = 0; a < kAidings.size(); ++a) {
    const auto& runs = all.of[a];
    table.add_row(
        {name_of(kAidings[a]), spread(runs, 3, [](const auto& e) { return e.along_sigma_m; }),
         spread(runs, 3, [](const auto& e) { return e.across_sigma_m; }),
         spread(runs, 1,
                [&](const auto& e) { return 100.0 * e.scale_sigma / params.speed_scale_sigma; }),
         eval::fixed(100.0 * rms(runs, [](const auto& e) { return e.scale_error; }), 3)});
  }
  return table;
}

/// Mean normalised estimation error squared over all runs, with the bounds of consistent ones.
eval::Table consistency(const Runs& all) {
  eval::Table table(
      {{""}, {"mean NEES of 5"}, {"+- two standard errors"}, {"epochs within 95 % bounds", "%"}});
  for (std::size_t a = 0; a < kAidings.size(); ++a) {
    std::size_t epochs = all.of[a].front().nees.size();
    for (const auto& e : all.of[a]) epochs = std::min(epochs, e.nees.size());
    eval::NeesOverRuns nees(5, epochs);
    eval::IndependentMean mean;
    for (const auto& e : all.of[a]) {
      double sum = 0.0;
      for (std::size_t k = 0; k < epochs; ++k) nees.add(k, e.nees[k]), sum += e.nees[k];
      mean.add(sum / static_cast<double>(epochs));
    }
    table.add_row({name_of(kAidings[a]), eval::fixed(mean.mean(), 2),
                   eval::fixed(2.0 * mean.standard_error(), 2),
                   eval::fixed(100.0 * nees.share_within(), 1)});
  }
  return table;
}

Result<void> run(const Options& o) {
  const auto params = params_of(o);
  const Runs all = run_all(o, params);
  if (!all.failure.empty()) return Error{ErrorCode::invalid, all.failure, {}};
  std::printf("pattern %d, %d drives, mean and standard deviation\n\n", o.pattern, o.runs);
  std::printf("Position RMSE\n%s\nGyro bias at the end\n%s\n", sections(all).to_text().c_str(),
              sensors(all).to_text().c_str());
  std::printf("Observability\n%s\nConsistency\n%s", observability(all, params).to_text().c_str(),
              consistency(all).to_text().c_str());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app("Simulate many drives through three corridors and two corners.");
  Options o;
  app.add_option("--pattern", o.pattern, "1 straight, 2 curved").range(1, 2);
  app.add_option("--runs", o.runs, "drives, one per seed").range(1, 100000);
  app.add_option("--seed", o.first_seed, "of the random numbers, for the first drive");
  add_threads(app, o.threads);
  app.add_number("--scan-rate", o.scan_rate_hz, 0.1, 1000.0, "scans per second");
  app.add_option("--rate", o.rate_hz, "use scans at this rate at most, Hz; default: all")
      .range(0.001, 1e6);
  app.add_option("--doors", o.doors, "distance between doors along each wall, m; 0: none")
      .range(0.0, 1000.0);
  app.add_option("--open", o.open_share, "share of open doors").range(0.0, 1.0);
  app.add_option("--boxes", o.boxes, "boxes per metre of wall").range(0.0, 10.0);
  app.add_option("--people", o.people, "people per metre of wall").range(0.0, 10.0);
  app.add_flag("--quiet", o.quiet, kQuietHelp);
  app.example("--pattern 1 --runs 100", "100 drives with straight motion");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("corridor_study", run(o));
}
