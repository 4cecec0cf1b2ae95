// Consistency of the navigation filter over many simulated drives.

#include <algorithm>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include <wayfare/eval/consistency.hpp>
#include <wayfare/sim/ins_monte_carlo.hpp>

#include "support/program_files.hpp"
#include "support/progress_line.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Options : OutputArguments {
  std::size_t runs = 100, satellites = 8;
  std::uint64_t seed = 1;
  double imu_rate_hz = 100.0, correlated_share = 0.0, correlated_tau_s = 100.0;
  int threads = 1, rounds = 0;
  bool constraints = false, smooth = false, as_white = false, wheels = false, phases = false;
};

void add_options(CommandLine& app, Options& o) {
  app.add_option("--runs", o.runs, "drives").range(1, 100000).show_default();
  app.add_option("--seed", o.seed, kSeedHelp).show_default();
  app.add_option("--satellites", o.satellites, "largest number of satellites").show_default();
  app.add_option("--rounds", o.rounds,
                 "instead of the drive of 310 s, rounds of five minutes (280 are a day; use "
                 "--imu-rate 10 for them)")
      .range(1, 3000);
  app.add_option("--imu-rate", o.imu_rate_hz, "samples per second of the unit")
      .range(10.0, 2000.0)
      .show_default();
  app.add_number("--correlated", o.correlated_share, 0.0, 1.0,
                 "share of the ranges' variance that is correlated, in simulation and filter");
  app.add_number("--correlation-time", o.correlated_tau_s, 1e-3, 1e9, "of that, s");
  app.add_flag("--as-white", o.as_white, "the filter takes them for white noise");
  app.add_option("--threads", o.threads, kThreadsHelp).range(1, 1024).show_default();
  app.add_flag("--constraints", o.constraints,
               "with zero-velocity and non-holonomic constraints, the filter's default");
  app.add_flag("--smooth", o.smooth, "estimate each instant by all measurements");
  app.add_flag("--wheels", o.wheels, "with the speeds of wheels: 1 % scale error, noise 0.1 m/s");
  app.add_flag("--phases", o.phases, "with carrier phases: noise 3 mm, 10 cycle slips an hour");
  app.add_option("--out", o.out, "folder for report.html").shown_as("DIR");
  add_force_and_quiet(app, o);
  add_json(app, o);
}

constexpr const char* kNames[] = {"north [m]",
                                  "east [m]",
                                  "down [m]",
                                  "velocity north [m/s]",
                                  "velocity east",
                                  "velocity down",
                                  "attitude x [deg]",
                                  "attitude y",
                                  "attitude z",
                                  "gyro bias x [deg/s]",
                                  "gyro bias y",
                                  "gyro bias z",
                                  "accel bias x [m/s2]",
                                  "accel bias y",
                                  "accel bias z",
                                  "gyro scale x [%]",
                                  "gyro scale y",
                                  "gyro scale z",
                                  "accel scale x [%]",
                                  "accel scale y",
                                  "accel scale z",
                                  "clock bias [m]",
                                  "clock drift [m/s]"};

double display_factor(int state) {
  if (state >= ins_state::kAttitude && state < ins_state::kAccelBias)
    return 180.0 / std::numbers::pi;
  return state >= ins_state::kGyroScale && state < ins_state::kClock ? 100.0 : 1.0;
}

using Kind = InnovationRecord::Kind;

struct Figures {
  explicit Figures(std::size_t epochs)
      : all(ins_state::kSize, epochs), navigation(9, epochs), ranges(1, epochs), rates(1, epochs) {}

  void add(std::size_t epoch, const sim::InsErrorAt& at) {
    const auto nis = [&at](Kind kind) { return at.nis[static_cast<std::size_t>(kind)]; };
    all.add(epoch, at.nees);
    navigation.add(epoch, at.navigation_nees);
    ranges.add(epoch, nis(Kind::range).sum, nis(Kind::range).count);
    rates.add(epoch, nis(Kind::range_rate).sum, nis(Kind::range_rate).count);
    within.add(at.error, at.sigma);
    squares += at.error.cwiseAbs2();
  }

  eval::NeesOverRuns all, navigation, ranges, rates;
  eval::IndependentMean all_of_runs, navigation_of_runs;
  eval::SigmaCount<ins_state::kSize> within;
  sim::InsErrorAt::Vector squares = sim::InsErrorAt::Vector::Zero();
};

Figures figures_of(const std::vector<sim::InsErrorSeries>& courses) {
  Figures f(courses[0].size());
  for (const sim::InsErrorSeries& course : courses) {
    double all = 0.0, navigation = 0.0;
    for (std::size_t k = 0; k < std::min(course.size(), f.all.epochs()); ++k) {
      f.add(k, course[k]);
      all += course[k].nees, navigation += course[k].navigation_nees;
    }
    f.all_of_runs.add(all / static_cast<double>(course.size()));
    f.navigation_of_runs.add(navigation / static_cast<double>(course.size()));
  }
  return f;
}

eval::Table error_table(const Figures& f) {
  eval::Table table({{"state"}, {"RMSE"}, {"within 1 sigma"}, {"2 sigma"}, {"3 sigma"}});
  for (int i = 0; i < ins_state::kSize; ++i) {
    const double rmse = std::sqrt(f.squares[i] / static_cast<double>(f.within.count()));
    std::vector<std::string> row = {kNames[i], eval::fixed(display_factor(i) * rmse, 4)};
    for (int k = 1; k <= 3; ++k) row.push_back(eval::fixed(f.within.share(k)[i], 4));
    table.add_row(row);
  }
  return table;
}

eval::Table nees_table(const Figures& f) {
  eval::Table table(
      {{"NEES"}, {"expected"}, {"mean"}, {"standard error"}, {"epochs within 95 % bounds"}});
  const auto row = [&table](const char* name, const char* expected, const eval::NeesOverRuns& nees,
                            const eval::IndependentMean& of_runs) {
    table.add_row({name, expected, eval::fixed(nees.mean_of_all(), 2),
                   eval::fixed(of_runs.standard_error(), 2), eval::fixed(nees.share_within(), 3)});
  };
  row("23 states", "23", f.all, f.all_of_runs);
  row("position, velocity, attitude", "9", f.navigation, f.navigation_of_runs);
  return table;
}

eval::Table nis_table(const Figures& f) {
  eval::Table table({{"NIS"}, {"mean"}, {"95 % bounds"}, {"epochs within 95 % bounds"}});
  const auto row = [&table](const char* name, const eval::NeesOverRuns& nis) {
    const eval::Interval bounds = eval::mean_nees_bounds(1, nis.count());
    table.add_row({name, eval::fixed(nis.mean_of_all(), 4),
                   eval::fixed(bounds.low, 4) + " to " + eval::fixed(bounds.high, 4),
                   eval::fixed(nis.share_within(), 3)});
  };
  row("ranges", f.ranges);
  row("range rates", f.rates);
  return table;
}

Result<void> write_report(const Options& o, const Figures& f) {
  io::Plot plot{"NEES of 23 states, mean of " + std::to_string(o.runs) + " runs",
                "epoch [s]",
                "NEES",
                {{"mean", {}, {}},
                 {"95 % bounds", {}, {}, io::Mark::dashed},
                 {"", {}, {}, io::Mark::dashed}}};
  const eval::Interval bounds = eval::mean_nees_bounds(ins_state::kSize, o.runs);
  for (std::size_t k = 0; k < f.all.epochs(); ++k) {
    const double values[] = {f.all.mean(k), bounds.low, bounds.high};
    for (std::size_t i = 0; i < 3; ++i) plot.series[i].add(static_cast<double>(k + 1), values[i]);
  }
  io::Report report("Consistency of the navigation filter",
                    o.rounds > 0 ? "Simulated rounds of a block with different noise"
                                 : "Simulated drives of 310 s and 4.5 km with different noise");
  report.table(nees_table(f)).plot(plot);
  if (!o.smooth) report.table(nis_table(f));
  report.table(error_table(f), "Errors and their bounds");
  return o.write_report(report);
}

Result<void> run(const Options& o) {
  if (auto ready = o.prepare({"report.html"}); !ready) return ready;
  sim::InsMonteCarloOptions options;
  options.imu.period = from_seconds(1.0 / o.imu_rate_hz);
  options.ranges.max_satellites = o.satellites;
  options.filter.zero_velocity_updates = o.constraints;
  options.filter.non_holonomic_in_outage = o.constraints;
  options.ranges.correlated_share = o.correlated_share;
  options.ranges.correlated_tau_s = o.correlated_tau_s;
  if (!o.as_white) options.filter.correlated = {o.correlated_share, o.correlated_tau_s, 1e9};
  options.smooth = o.smooth;
  if (o.wheels) {
    options.filter.odometer.emplace();
    options.wheels.sigma_mps = options.filter.odometer->speed_sigma_mps;
    options.wheels.resolution_mps = 0.0;
  }
  if (o.phases) {
    options.filter.carrier_phase.emplace();
    options.ranges.phases.emplace().slips_per_satellite_hour = 10.0;
  }
  options.threads = o.threads;
  ProgressLine progress("driving", o.quiet);
  const auto courses = sim::ins_monte_carlo(
      o.rounds > 0 ? sim::round_drive(o.rounds) : sim::demo_drive(), sim::gps_and_galileo(), o.runs,
      options, Rng(o.seed), std::ref(progress));
  progress.finish();
  if (courses[0].empty()) return Error{ErrorCode::degenerate, "the filter gives no solution"};
  const Figures figures = figures_of(courses);
  if (o.json != "-")
    std::printf("%s\n%s\n%s", nees_table(figures).to_text().c_str(),
                o.smooth ? "" : nis_table(figures).to_text().c_str(),
                error_table(figures).to_text().c_str());
  return o.wants_report() ? write_report(o, figures) : Result<void>{};
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Run the navigation filter on many simulated drives and check the consistency of its "
      "errors.");
  Options options;
  add_options(app, options);
  app.example("--runs 50", "50 drives");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("ins_consistency", run(options));
}
