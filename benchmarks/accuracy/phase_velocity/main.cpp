// Mean velocity between epochs from carrier phases, beside that from Doppler shifts, on recorded
// and simulated observations with a reference.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include <wayfare/eval/table.hpp>
#include <wayfare/gnss/gps_time.hpp>
#include <wayfare/gnss/phase_displacement.hpp>
#include <wayfare/gnss/single_point.hpp>
#include <wayfare/io/nav_text.hpp>
#include <wayfare/io/observations.hpp>
#include <wayfare/io/rinex.hpp>
#include <wayfare/sim/gnss.hpp>
#include <wayfare/sim/vehicle_trajectory.hpp>

#include "support/program_files.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Options {
  std::string obs, truth, truth_columns;
  std::vector<std::string> nav;
  std::uint64_t seed = 1;
  double cycle_slips_per_hour = 20.0, period_s = 1.0, interval_s = 0.0;
  bool simulated = false;
};

/// Observations with the reference.
struct Observed {
  std::vector<ObservationEpoch> epochs;
  Ephemerides messages;
  std::function<std::optional<Eigen::Vector3d>(LogTime)> antenna_ecef_m;
};

/// By a cubic polynomial through four positions about the time.
std::optional<Eigen::Vector3d> interpolated(const NavTrajectory& all, LogTime time) {
  const auto after = std::upper_bound(all.begin(), all.end(), time,
                                      [](LogTime t, const NavState& s) { return t < s.time; });
  if (after - all.begin() < 2 || all.end() - after < 2) return std::nullopt;
  const auto first = after - 2;
  if (to_seconds((first + 3)->time - first->time) > 3.5) return std::nullopt;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int i = 0; i < 4; ++i) {
    double weight = 1.0;
    for (int k = 0; k < 4; ++k)
      if (k != i)
        weight *= to_seconds(time - (first + k)->time) /
                  to_seconds((first + i)->time - (first + k)->time);
    sum += weight * ecef_from_geodetic((first + i)->position);
  }
  return sum;
}

Result<Observed> recorded(const Options& o) {
  auto obs = io::read_observations(o.obs);
  if (!obs) return obs.error();
  Observed all{std::move(obs->epochs), std::move(obs->ephemerides), {}};
  for (const std::string& path : o.nav) {
    const auto nav = io::read_rinex_navigation(path);
    if (!nav) return nav.error();
    all.messages.add(nav->ephemerides);
  }
  io::ColumnFormat format;
  std::istringstream names(o.truth_columns);
  for (std::string name; std::getline(names, name, ',');) format.columns.push_back(name);
  auto truth = io::read_nav(o.truth, format);
  if (!truth) return truth.error();
  all.antenna_ecef_m = [states = std::move(truth->trajectory)](LogTime t) {
    return interpolated(states, t);
  };
  return all;
}

Observed simulated(const Options& o) {
  const auto start = Time<GpsClock>::from_seconds(1.4e9);
  sim::WalkerParams gps, galileo;
  galileo.system = GnssSystem::galileo, galileo.planes = 3, galileo.radius_m = 29.6e6;
  Observed all;
  all.messages = sim::walker_ephemerides(gps, start);
  all.messages.add(sim::walker_ephemerides(galileo, start));
  const auto drive =
      std::make_shared<const sim::VehicleTrajectory>(sim::demo_drive(log_time(start)));
  sim::ObservationParams params;
  params.period = from_seconds(o.period_s);
  params.phases.emplace().slips_per_satellite_hour = o.cycle_slips_per_hour;
  all.epochs = sim::simulate_observations(*drive, all.messages, params, Rng(o.seed)).epochs;
  all.antenna_ecef_m = [drive](LogTime t) {
    return std::optional(ecef_from_geodetic(drive->state(t).position));
  };
  return all;
}

/// Horizontal and vertical error of a velocity.
struct Errors {
  std::vector<double> horizontal, vertical;

  void add(const Eigen::Vector3d& error_ned_mps) {
    horizontal.push_back(error_ned_mps.head<2>().norm());
    vertical.push_back(std::abs(error_ned_mps.z()));
  }
};

double rms(const std::vector<double>& all) {
  double sum = 0.0;
  for (const double x : all) sum += x * x;
  return std::sqrt(sum / static_cast<double>(all.size()));
}
double quantile(std::vector<double> all, double share) {
  std::sort(all.begin(), all.end());
  return all[std::min(all.size() - 1, static_cast<std::size_t>(share * double(all.size())))];
}

struct Comparison {
  Errors doppler, phases;     ///< of the same intervals
  std::size_t intervals = 0;  ///< with a reference
  std::size_t by_doppler = 0, by_phases = 0, slipped = 0;
};

/// An epoch with its position and velocity.
struct Solved {
  RangeEpoch ranges;
  SinglePoint point;
};

void compare(const Solved& a, const Solved& b, const Observed& all, Comparison& sum) {
  const double dt_s = to_seconds(b.point.instant - a.point.instant);
  if (dt_s <= 0.0 || dt_s > 2.5) return;
  const auto from = all.antenna_ecef_m(a.point.instant), to = all.antenna_ecef_m(b.point.instant);
  if (!from || !to) return;
  ++sum.intervals;
  const Eigen::Matrix3d ned_ecef = rotation_ecef_ned(a.point.position).transpose();
  const Eigen::Vector3d true_mps = ned_ecef * (*to - *from) / dt_s;
  const bool doppler = a.point.velocity_ned_mps && b.point.velocity_ned_mps;
  const auto moved = phase_displacement(a.ranges, b.ranges, a.point.position_ecef_m);
  sum.by_doppler += doppler ? 1 : 0, sum.by_phases += moved ? 1 : 0;
  if (moved) sum.slipped += moved->slipped.size();
  if (!doppler || !moved) return;
  sum.doppler.add(0.5 * (*a.point.velocity_ned_mps + *b.point.velocity_ned_mps) - true_mps);
  sum.phases.add(ned_ecef * moved->displacement_ecef_m / dt_s - true_mps);
}

Result<void> run(const Options& o) {
  if (!o.simulated && (o.obs.empty() || o.truth.empty()))
    return bad_use("recorded observations need --obs and --truth; or --simulated");
  auto all = o.simulated ? Result<Observed>(simulated(o)) : recorded(o);
  if (!all) return all.error();
  Comparison sum;
  std::optional<Solved> before;
  Eigen::Vector3d near = Eigen::Vector3d::Zero();
  for (const ObservationEpoch& epoch : all->epochs) {
    const auto point = single_point(epoch, all->messages, {}, near);
    if (!point) {
      before.reset();
      continue;
    }
    near = point->position_ecef_m;
    Solved now{correct_ranges(epoch, all->messages, near), *point};
    if (before && to_seconds(now.point.time - before->point.time) < o.interval_s - 1e-3) continue;
    if (before) compare(*before, now, *all, sum);
    before = std::move(now);
  }
  if (sum.doppler.horizontal.empty())
    return Error{ErrorCode::not_found, "no interval has both velocities and a reference"};
  eval::Table table({{"velocity from"},
                     {"horizontal RMS [mm/s]"},
                     {"median"},
                     {"95 %"},
                     {"vertical RMS"},
                     {"intervals"}});
  const auto row = [&](const char* name, const Errors& e, std::size_t count) {
    const auto mm = [](double mps) { return eval::fixed(1e3 * mps, 1); };
    table.add_row({name, mm(rms(e.horizontal)), mm(quantile(e.horizontal, 0.5)),
                   mm(quantile(e.horizontal, 0.95)), mm(rms(e.vertical)), std::to_string(count)});
  };
  row("Doppler", sum.doppler, sum.by_doppler);
  row("phases", sum.phases, sum.by_phases);
  std::printf("%zu intervals with a reference, %zu with both; %zu cycle slips excluded\n%s",
              sum.intervals, sum.doppler.horizontal.size(), sum.slipped, table.to_text().c_str());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Mean velocity between epochs from the change of carrier phases, beside the mean of the "
      "velocities from Doppler shifts at both ends.");
  Options o;
  app.add_flag("--simulated", o.simulated, "raw observations of a simulated drive");
  app.add_file("--obs", o.obs, "raw observations, RINEX or UBX");
  app.add_file("--nav", o.nav, "broadcast messages, RINEX; several files allowed").expected(1, 8);
  app.add_file("--truth", o.truth, "positions of the antenna");
  app.add_option("--truth-columns", o.truth_columns, "comma-separated names of its columns, if it has none");
  app.add_option("--seed", o.seed, kSeedHelp).show_default();
  app.add_number("--cycle-slips", o.cycle_slips_per_hour, 0.0, 3600.0,
                 "slips of each satellite's phase an hour, half of them noticed by the receiver");
  app.add_number("--period", o.period_s, 0.05, 10.0, "between simulated epochs, s");
  app.add_number("--interval", o.interval_s, 0.0, 2.5,
                 "least time between epochs that are compared, s");
  app.example("--simulated", "a simulated drive");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("phase_velocity", run(o));
}
