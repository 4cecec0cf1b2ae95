// Simulated walks with a unit on each foot: horizontal errors of one foot, of both and with the
// bound on their distance; on stairs, heights by the foot, by air pressure and by both.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include <wayfare/core/statistics.hpp>
#include <wayfare/eval/table.hpp>
#include <wayfare/io/tum.hpp>
#include <wayfare/pedestrian/two_feet.hpp>
#include <wayfare/sim/walks.hpp>

#include "pedestrian/walk.hpp"
#include "support/progress_line.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Arguments : OutputArguments {
  int seeds = 20, strides = 150;
  std::uint64_t first = 1;
  double bound_m = 0.85, turn_deg = 0.0;
  bool stairs = false;
  sim::BarometerNoise barometer;
};

sim::FeetPlan plan_of(const Arguments& a) {
  sim::FeetPlan plan;
  plan.strides = a.strides;
  plan.turn_rad = Angle::degrees(a.turn_deg).radians();
  // Two storeys of 3.4 m up and one down, with corridors between.
  const auto at = [&](double part) { return static_cast<int>(part * a.strides); };
  if (a.stairs) plan.stairs = {{at(0.2), 10}, {at(0.4), 10}, {at(0.7), 10, -0.34}};
  return plan;
}

/// Readings of a foot with air pressure.
struct FootFile {
  io::MargFile file;
  std::vector<Eigen::Vector3d> truth;
};

FootFile foot_file(const sim::FootTruth& foot, const Arguments& a, double dt_s, Rng rng) {
  FootFile result{{}, foot.position};
  std::vector<double> heights;
  for (std::size_t i = 0; i < foot.samples.size(); ++i) {
    const ImuSample& s = foot.samples[i];
    result.file.samples.push_back({s.time, s.angular_rate_radps, s.specific_force_mps2});
    heights.push_back(foot.position[i].z());
  }
  // A barometer gives ten readings a second.
  constexpr double kPeriod_s = 0.1;
  const auto every = static_cast<std::size_t>(std::max(1.0, std::round(kPeriod_s / dt_s)));
  std::vector<double> sampled;
  for (std::size_t i = 0; i < heights.size(); i += every) sampled.push_back(heights[i]);
  const auto pressures =
      sim::simulate_pressure(sampled, dt_s * static_cast<double>(every), a.barometer, rng);
  for (std::size_t i = 0; i < heights.size(); ++i)
    result.file.pressure_Pa.push_back(i % every == 0 ? pressures[i / every] : MargSample::kNone);
  return result;
}

struct Feet {
  sim::FeetTruth truth;
  FootFile left, right;
};

Feet feet_of(const Arguments& a, std::uint64_t seed) {
  const sim::FeetPlan plan = plan_of(a);
  Feet feet{sim::simulate_feet(plan, {}, Rng(seed)), {}, {}};
  const Rng rng(seed);
  feet.left = foot_file(feet.truth.left, a, 1.0 / plan.rate_hz, rng.stream(2));
  feet.right = foot_file(feet.truth.right, a, 1.0 / plan.rate_hz, rng.stream(3));
  return feet;
}

/// Horizontal errors at the end.
struct Ends {
  double left_m = 0.0, right_m = 0.0, middle_m = 0.0;
  [[nodiscard]] double worse_m() const { return std::max(left_m, right_m); }
};

Ends ends(const sim::FeetTruth& truth, double bound_m) {
  using Side = TwoFeet::Side;
  TwoFeetParameters p;
  p.farthest_m = bound_m;
  TwoFeet feet(p);
  const auto none = [](Side, const FootPose&) {};
  for (std::size_t i = 0; i < truth.left.samples.size(); ++i) {
    feet.add(Side::left, truth.left.samples[i], none);
    feet.add(Side::right, truth.right.samples[i], none);
  }
  feet.finish(none);
  const Eigen::Vector3d l = feet.position(Side::left) - truth.left.position.back();
  const Eigen::Vector3d r =
      feet.position(Side::right) - truth.right_from_left - truth.right.position.back();
  const auto level = [](const Eigen::Vector3d& v) { return v.head<2>().norm(); };
  return {level(l), level(r), level(0.5 * (l + r))};
}

using Errors = std::vector<double>;
std::string rms(const Errors& errors, int digits = 2) {
  return eval::fixed(summarise(errors).rmse, digits);
}

eval::Table horizontal_table(const Arguments& a, const std::vector<Feet>& walks) {
  Errors one, middle, bound, worse, worse_bound;
  for (const Feet& feet : walks) {
    const Ends alone = ends(feet.truth, 0.0), together = ends(feet.truth, a.bound_m);
    one.push_back(alone.left_m);
    middle.push_back(alone.middle_m);
    bound.push_back(together.middle_m);
    worse.push_back(alone.worse_m());
    worse_bound.push_back(together.worse_m());
  }
  eval::Table table({{"horizontal error at the end, root mean square"}, {"m"}});
  table.add_row({"one foot", rms(one)});
  table.add_row({"midpoint, each foot alone", rms(middle)});
  table.add_row({"midpoint, bound on their distance", rms(bound)});
  table.add_row({"the worse foot, each alone", rms(worse)});
  table.add_row({"the worse foot, bound", rms(worse_bound)});
  return table;
}

/// Height errors of one walk, and those of the filter over their standard deviations, squared.
struct HeightErrors {
  Errors foot, pressure, both, normalised;
  double foot_end_m = 0.0, pressure_end_m = 0.0, both_end_m = 0.0;
};

HeightErrors height_errors(const Arguments& a, const FootFile& foot) {
  WalkRun run = run_foot(foot.file.samples, {}, [](double) {});
  add_heights(run, foot.file, {a.barometer.white_Pa, a.barometer.drift_Pa});
  HeightErrors e;
  std::size_t i = 0;
  for (const WalkRow& row : run.rows) {
    while (foot.file.samples[i].time < row.time) ++i;
    const double truth = foot.truth[i].z();
    e.foot.push_back(row.position_m.z() - truth);
    e.pressure.push_back(row.pressure_height_m - truth);
    e.both.push_back(row.height_m - truth);
    if (row.height_sigma_m > 0.0)
      e.normalised.push_back(std::pow((row.height_m - truth) / row.height_sigma_m, 2));
  }
  e.foot_end_m = e.foot.back();
  e.pressure_end_m = e.pressure.back();
  e.both_end_m = e.both.back();
  return e;
}

eval::Table height_table(const Arguments& a, const std::vector<Feet>& walks) {
  HeightErrors all;
  Errors foot_end, pressure_end, both_end;
  const auto append = [](Errors& to, const Errors& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  for (const Feet& feet : walks) {
    const HeightErrors e = height_errors(a, feet.left);
    append(all.foot, e.foot);
    append(all.pressure, e.pressure);
    append(all.both, e.both);
    append(all.normalised, e.normalised);
    foot_end.push_back(e.foot_end_m);
    pressure_end.push_back(e.pressure_end_m);
    both_end.push_back(e.both_end_m);
  }
  eval::Table table({{"height error of the left foot, root mean square"},
                     {"whole walk", "m"},
                     {"at the end", "m"},
                     {"NEES"}});
  table.add_row({"foot", rms(all.foot, 3), rms(foot_end, 3), "-"});
  table.add_row({"pressure", rms(all.pressure, 3), rms(pressure_end, 3), "-"});
  table.add_row(
      {"both", rms(all.both, 3), rms(both_end, 3), eval::fixed(summarise(all.normalised).mean, 2)});
  return table;
}

std::string columns_text(const io::MargFile& file) {
  std::string text = "t_s,gx_radps,gy_radps,gz_radps,ax_mps2,ay_mps2,az_mps2,p_Pa\n";
  for (std::size_t i = 0; i < file.samples.size(); ++i) {
    const MargSample& s = file.samples[i];
    text += io::format_nanoseconds(s.time.nanoseconds());
    for (const Eigen::Vector3d& v : {s.angular_rate_radps, s.specific_force_mps2})
      for (const double x : v) text += ',' + eval::fixed(x, 6);
    const double p = file.pressure_Pa[i];
    text += std::isfinite(p) ? ',' + eval::fixed(p, 2) + '\n' : ",nan\n";
  }
  return text;
}

io::Trajectory3 trajectory(const FootFile& foot, const std::vector<Eigen::Vector3d>& positions) {
  io::Trajectory3 poses;
  for (std::size_t i = 0; i < positions.size(); ++i)
    poses.push_back({foot.file.samples[i].time,
                     Transform3<frame::Map, frame::Base>(SE3d(positions[i], SO3d()))});
  return poses;
}

Result<void> write(const Arguments& a) {
  const std::vector<std::string> names = {"left.csv", "right.csv", "left_truth.tum", "truth.tum"};
  if (auto ready = a.prepare(names); !ready) return ready;
  const Feet feet = feet_of(a, a.first);
  std::vector<Eigen::Vector3d> middle;
  for (std::size_t i = 0; i < feet.left.truth.size(); ++i)
    middle.push_back(0.5 * (feet.left.truth[i] + feet.truth.right_from_left + feet.right.truth[i]));
  return first_error(
      {io::write_file(a.path("left.csv"), columns_text(feet.left.file), a.write()),
       io::write_file(a.path("right.csv"), columns_text(feet.right.file), a.write()),
       io::write_tum(a.path("left_truth.tum"), trajectory(feet.left, feet.left.truth), a.write()),
       io::write_tum(a.path("truth.tum"), trajectory(feet.left, middle), a.write())});
}

Result<void> run(const Arguments& a) {
  if (!a.out.empty()) return write(a);
  ProgressLine progress("walks", a.quiet);
  std::vector<Feet> walks;
  for (int i = 0; i < a.seeds; ++i) {
    walks.push_back(feet_of(a, a.first + static_cast<std::uint64_t>(i)));
    progress.update(static_cast<double>(i) / a.seeds);
  }
  progress.finish();
  std::printf("%d walks of %.0f m, bound %.2f m\n%s\n", a.seeds, walks.front().truth.length_m,
              a.bound_m, horizontal_table(a, walks).to_text().c_str());
  if (a.stairs) std::printf("%s\n", height_table(a, walks).to_text().c_str());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Simulated walks with an inertial unit and a barometer on each foot: errors of one foot, of "
      "both with and without a bound on their distance, and of heights on stairs.");
  Arguments a;
  app.add_number("--seeds", a.seeds, 1, 1000, "walks");
  app.add_option("--first", a.first, "the first seed").show_default();
  app.add_number("--strides", a.strides, 10, 100000, "of each walk");
  app.add_number("--turn", a.turn_deg, -45.0, 45.0, "of the path per stride, degrees");
  app.add_positive("--farthest", a.bound_m, "bound on the distance of the feet, m");
  app.add_flag("--stairs", a.stairs, "two storeys up and one down");
  app.add_positive("--pressure-noise", a.barometer.white_Pa, "white noise of a reading, Pa");
  app.add_positive("--pressure-drift", a.barometer.drift_Pa, "random walk, Pa/sqrt(s)");
  app.add_option("--write", a.out,
                 "writes the first walk to this folder instead: left.csv, right.csv, "
                 "left_truth.tum, truth.tum (the midpoint)")
      .shown_as("DIR");
  app.add_flag("--force", a.force, "replace existing files");
  app.add_flag("--quiet", a.quiet, kQuietHelp);
  app.example("--seeds 20 --stairs", "20 walks with stairs");
  app.example("--write feet --strides 60", "the readings of one walk, for pedestrian");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("feet_study", run(a));
}
