// Radar against LiDAR in long corridors: the same scan-to-map matching once with each, wheel
// odometry only as the start of each search.

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include <wayfare/eval/statistics.hpp>
#include <wayfare/eval/table.hpp>
#include <wayfare/eval/trajectory_error.hpp>
#include <wayfare/io/report.hpp>
#include <wayfare/sim/worlds.hpp>

#include "exit_code.hpp"
#include "localise_by_matching.hpp"
#include "program_files.hpp"
#include "progress_line.hpp"
#include "surface_picture.hpp"

namespace {

using namespace wayfare;
using examples::MatchingRun;
using examples::Sensor;

struct Options {
  std::string out;
  std::uint64_t first_seed = 1;
  std::size_t seeds = 10;
  std::size_t frames = 20;
  double window_m = 0.3;
  bool force = false;
  bool quiet = false;
};

constexpr std::array<Sensor, 3> kSensors{Sensor::odometry, Sensor::lidar, Sensor::radar};
constexpr std::array<const char*, 3> kNames{"wheel odometry", "LiDAR", "radar"};

// A run's errors: in the map's axes as the published table has them, and over straight stretches
// of the way in the robot's own.
struct Errors {
  double x_m = 0.0, y_m = 0.0, heading_deg = 0.0;
  double along_m = 0.0, across_m = 0.0, turn_deg = 0.0;
};

// Of the motion over every stretch of `length_m` that is straight.
void add_stretches(const std::vector<eval::PosePair>& pairs, double length_m, Errors& errors) {
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (std::size_t i = 0, k = 0; i < pairs.size(); i += 10) {
    const auto& from = pairs[i].reference;
    const auto far = [&](std::size_t j) {
      return (pairs[j].reference.translation() - from.translation()).norm() >= length_m;
    };
    while (k < pairs.size() && !far(k)) ++k;
    if (k == pairs.size()) break;
    const SE2d truly = from.inverse() * pairs[k].reference;
    // Straight: no corner in between, where along and across would change places.
    if (std::abs(truly.y()) > 0.1 || std::abs(truly.heading().radians()) > 0.1) continue;
    const SE2d estimated = pairs[i].estimate.inverse() * pairs[k].estimate;
    const SE2d error = truly.inverse() * estimated;
    squares += Eigen::Vector3d(error.x(), error.y(), error.heading().degrees()).cwiseAbs2();
    count += 1.0;
  }
  const Eigen::Vector3d rms = (squares / std::max(count, 1.0)).cwiseSqrt();
  errors.along_m = rms.x();
  errors.across_m = rms.y();
  errors.turn_deg = rms.z();
}

Errors errors_of(const Trajectory& estimate, const Trajectory& truth) {
  constexpr double kStretch_m = 5.0;
  const auto pairs = eval::associate(estimate, truth);
  Errors errors;
  for (const eval::PosePair& pair : pairs) {
    const Eigen::Vector2d d = pair.estimate.translation() - pair.reference.translation();
    const double turn = (pair.reference.heading() - pair.estimate.heading()).wrapped().degrees();
    errors.x_m += d.x() * d.x();
    errors.y_m += d.y() * d.y();
    errors.heading_deg += turn * turn;
  }
  const auto n = static_cast<double>(pairs.size());
  for (double* e : {&errors.x_m, &errors.y_m, &errors.heading_deg}) *e = std::sqrt(*e / n);
  add_stretches(pairs, kStretch_m, errors);
  return errors;
}

struct SeedRuns {
  Trajectory truth;
  std::array<MatchingRun, 3> runs = {};
  std::array<Errors, 3> errors;
};

Result<SeedRuns> run_seed(std::uint64_t seed, const Options& o) {
  const Rng rng(seed);
  const auto world = sim::make_world("corridor_loop", rng);
  if (!world) return world.error();
  const auto recording = sim::simulate_world(*world, sim::turtlebot(rng), rng);
  if (!recording) return recording.error();
  SyncParams sync = sync_params(*recording);
  sync.scans = o.frames;
  const auto steps = synchronise(*recording, sync);
  examples::MatchingOptions options;
  options.window.half_x_m = options.window.half_y_m = o.window_m;
  // Half way along the first corridor, where LiDAR sees two walls and nothing else.
  options.surface_at = LogTime::from_seconds(60.0);
  SeedRuns result;
  result.truth = recording->truth;
  for (std::size_t s = 0; s < kSensors.size(); ++s) {
    auto run = examples::localise_by_matching(steps, *recording, kSensors[s],
                                              recording->truth.front().T_map_base.raw(), options);
    if (!run) return run.error();
    result.runs[s] = std::move(run).value();
    result.errors[s] = errors_of(result.runs[s].trajectory, result.truth);
  }
  return result;
}

eval::Table error_table(const std::vector<SeedRuns>& all) {
  eval::Table table({{"RMSE, mean \u00b1 spread over seeds"},
                     {"x", "m"},
                     {"y", "m"},
                     {"heading", "deg"},
                     {"along 5 m", "m"},
                     {"across 5 m", "m"},
                     {"turn in 5 m", "deg"}});
  for (std::size_t s = 0; s < kSensors.size(); ++s) {
    const auto cell = [&](double Errors::*field, int decimals) {
      std::vector<double> values;
      for (const SeedRuns& runs : all) values.push_back(runs.errors[s].*field);
      const eval::Summary summary = eval::summarise(values);
      return eval::mean_std(summary.mean, summary.std, decimals);
    };
    table.add_row({kNames[s], cell(&Errors::x_m, 2), cell(&Errors::y_m, 2),
                   cell(&Errors::heading_deg, 2), cell(&Errors::along_m, 3),
                   cell(&Errors::across_m, 3), cell(&Errors::turn_deg, 2)});
  }
  return table;
}

eval::Table seed_table(const std::vector<SeedRuns>& all, std::uint64_t first) {
  eval::Table table({{"seed"},
                     {"LiDAR x", "m"},
                     {"y", "m"},
                     {"heading", "deg"},
                     {"along", "m"},
                     {"refused"},
                     {"radar x", "m"},
                     {"y", "m"},
                     {"heading", "deg"},
                     {"along", "m"},
                     {"refused"}});
  for (std::size_t i = 0; i < all.size(); ++i) {
    std::vector<std::string> row = {std::to_string(first + i)};
    for (const std::size_t s : {std::size_t{1}, std::size_t{2}}) {
      const Errors& e = all[i].errors[s];
      for (const double v : {e.x_m, e.y_m, e.heading_deg}) row.push_back(eval::fixed(v, 2));
      row.push_back(eval::fixed(e.along_m, 3));
      row.push_back(std::to_string(all[i].runs[s].refused) + " of " +
                    std::to_string(all[i].runs[s].refused + all[i].runs[s].matched));
    }
    table.add_row(std::move(row));
  }
  return table;
}

io::Series series(std::string name, const Trajectory& trajectory) {
  io::Series result{std::move(name), {}, {}, io::Mark::line};
  for (const StampedPose& pose : trajectory) {
    result.x.push_back(pose.T_map_base.raw().x());
    result.y.push_back(pose.T_map_base.raw().y());
  }
  return result;
}

io::Plot paths(const SeedRuns& runs) {
  io::Plot plot;
  plot.title = "The first seed's ways";
  plot.x_label = "x [m]";
  plot.y_label = "y [m]";
  plot.equal_aspect = true;
  plot.series.push_back(series("truth", runs.truth));
  for (std::size_t s = 0; s < kSensors.size(); ++s)
    plot.series.push_back(series(kNames[s], runs.runs[s].trajectory));
  return plot;
}

std::string width_text(const ScoreSurface& surface) {
  const examples::RidgeWidth width = examples::ridge_width(surface);
  return "The places within a tenth of the best score spread " + eval::fixed(width.along_m, 3) +
         " m along the corridor and " + eval::fixed(width.across_m, 3) + " m across it.";
}

Result<void> add_surfaces(const SeedRuns& runs, const Options& o, io::Report& report) {
  const io::WriteOptions write{o.force ? io::Existing::replace : io::Existing::refuse};
  for (const std::size_t s : {std::size_t{1}, std::size_t{2}}) {
    if (!runs.runs[s].surface) continue;
    const io::Image image = examples::surface_picture(*runs.runs[s].surface);
    const std::string file = s == 1 ? "score_lidar.png" : "score_radar.png";
    const std::string path = (std::filesystem::path(o.out) / file).string();
    if (auto done = io::write_png(path, image, write); !done) return done;
    report.image(image, std::string(kNames[s]) +
                            ": score of a scan in the map, over 0.6 m ahead (up), behind and to "
                            "both sides. " +
                            width_text(*runs.runs[s].surface));
    if (!o.quiet) std::printf("%s: %s\n", kNames[s], width_text(*runs.runs[s].surface).c_str());
  }
  return {};
}

Result<void> write_report(const std::vector<SeedRuns>& all, const Options& o) {
  io::Report report("Radar against LiDAR in long corridors",
                    "Scan-to-map matching alone; wheel odometry says where each search begins");
  report.table(error_table(all),
               "Root mean square errors: of the pose in the map's axes, and of the motion over "
               "straight stretches of 5 m in the robot's own");
  report.paragraph(
      "Zhang 2020, table 7, on a real corridor: odometry 4.75 m, 2.91 m, 28.8 deg; LiDAR 2.84 m, "
      "8.34 m, 6.69 deg; radar 0.46 m, 1.48 m, 6.51 deg.");
  report.plot(paths(all.front()));
  report.heading("Scores around one match");
  if (auto done = add_surfaces(all.front(), o, report); !done) return done;
  report.heading("Seed by seed");
  report.table(seed_table(all, o.first_seed));
  const io::WriteOptions write{o.force ? io::Existing::replace : io::Existing::refuse};
  return report.write((std::filesystem::path(o.out) / "report.html").string(), write);
}

Result<void> run(const Options& o) {
  const io::WriteOptions write{o.force ? io::Existing::replace : io::Existing::refuse};
  if (auto ready = examples::prepare_files(
          o.out, {"report.html", "score_lidar.png", "score_radar.png"}, write);
      !ready)
    return ready;
  examples::ProgressLine progress("driving and matching", o.quiet);
  std::vector<SeedRuns> all;
  for (std::size_t i = 0; i < o.seeds; ++i) {
    auto runs = run_seed(o.first_seed + i, o);
    if (!runs) return runs.error();
    all.push_back(std::move(runs).value());
    progress.update(static_cast<double>(i + 1) / static_cast<double>(o.seeds));
  }
  progress.finish();
  if (auto done = write_report(all, o); !done) return done;
  if (!o.quiet)
    std::printf("%s\n%s", error_table(all).to_text().c_str(),
                seed_table(all, o.first_seed).to_text().c_str());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Drive a Turtlebot round a loop of simulated corridors and localise it by scan matching, "
      "once "
      "with its LiDAR and once with its radar; odometry only starts each search.");
  Options o;
  app.add_option("--out", o.out, "folder for report.html and the score pictures")->required();
  app.add_option("--seeds", o.seeds, "drives, each in a building of its own")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--first-seed", o.first_seed)->capture_default_str();
  app.add_option("--frames", o.frames, "radar frames gathered into one scan")
      ->check(CLI::Range(3, 100))
      ->capture_default_str();
  app.add_option("--window", o.window_m, "half the search's width, m")
      ->check(CLI::Range(0.05, 2.0))
      ->capture_default_str();
  app.add_flag("--force", o.force, "replace files that are there already");
  app.add_flag("--quiet", o.quiet, "no progress, no tables");
  CLI11_PARSE(app, argc, argv);
  return examples::exit_code("hallway_comparison", run(o));
}
