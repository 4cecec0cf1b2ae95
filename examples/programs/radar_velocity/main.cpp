// Velocity of a radar from the radial speeds of each frame.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/io/report.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/motion/radar_velocity.hpp>

#include "inertial.hpp"
#include "support/chirp_config.hpp"
#include "support/slam_program.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Options : SlamArguments {
  RadarVelocityOptions velocity;
  std::string chirps;
  InertialOptions inertial;
};

struct Velocities {
  std::vector<RadarVelocity> found;
  std::size_t frames = 0, points = 0;
  std::string first_refusal;
};

Velocities estimate(const std::vector<RadarScan>& scans, const Options& o) {
  Velocities f;
  const Rng rng(o.seed);
  for (const RadarScan& scan : scans) {
    auto velocity = radar_velocity(scan, rng.stream(f.frames++), o.velocity);
    f.points += scan.points.size();
    if (velocity) {
      f.found.push_back(*std::move(velocity));
    } else if (f.first_refusal.empty()) {
      f.first_refusal = velocity.error().to_string();
    }
  }
  return f;
}

std::string csv(const Velocities& f) {
  std::string text =
      "t_s,vx_mps,vy_mps,vz_mps,sigma_x_mps,sigma_y_mps,sigma_z_mps,points,inliers,residual_mps\n";
  for (const RadarVelocity& v : f.found) {
    char line[256];
    std::snprintf(line, sizeof line, ",%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%zu,%zu,%.6f\n",
                  v.velocity_m_s.x(), v.velocity_m_s.y(), v.velocity_m_s.z(),
                  std::sqrt(v.covariance(0, 0)), std::sqrt(v.covariance(1, 1)),
                  std::sqrt(v.covariance(2, 2)), v.points, v.inliers, v.residual_m_s);
    text += io::format_nanoseconds(v.time.nanoseconds());
    text += line;
  }
  return text;
}

double share(const RadarVelocity& v) {
  return static_cast<double>(v.inliers) / static_cast<double>(v.points);
}

/// Of `value` over all frames.
template <class Value>
std::string quantile_text(const Velocities& f, double part, int decimals, Value value) {
  std::vector<double> all;
  for (const RadarVelocity& v : f.found) all.push_back(value(v));
  return eval::fixed(quantile(std::move(all), part), decimals);
}

/// The frames in which the radar moves.
Velocities moving(const Velocities& all) {
  constexpr double kMoves_m_s = 0.2;
  Velocities some;
  for (const RadarVelocity& v : all.found)
    if (v.velocity_m_s.norm() > kMoves_m_s) some.found.push_back(v);
  return some;
}

Facts facts_of(const Velocities& f) {
  const auto speed = [](const RadarVelocity& v) { return v.velocity_m_s.norm(); };
  const auto residual = [](const RadarVelocity& v) { return v.residual_m_s; };
  const auto sigma = [](const RadarVelocity& v) { return std::sqrt(v.covariance.trace()); };
  const Velocities m = moving(f);
  std::size_t used = 0, inliers = 0;
  for (const RadarVelocity& v : f.found) used += v.points, inliers += v.inliers;
  return {{"frames", std::to_string(f.frames) + ", " + std::to_string(f.points) + " points"},
          {"velocity found", std::to_string(f.found.size()) + " frames"},
          {"inliers", std::to_string(inliers) + " of " + std::to_string(used) + " points, " +
                          eval::fixed(100.0 * static_cast<double>(inliers) /
                                          static_cast<double>(std::max<std::size_t>(used, 1)),
                                      1) +
                          " %"},
          {"share of inliers", "median " + quantile_text(f, 0.5, 3, share) +
                                   ", in the worst tenth " + quantile_text(f, 0.1, 3, share)},
          {"residual", "median " + quantile_text(f, 0.5, 3, residual) + " m/s"},
          {"sigma", "median " + quantile_text(f, 0.5, 3, sigma) + " m/s"},
          {"speed", "median " + quantile_text(f, 0.5, 3, speed) + ", largest " +
                        quantile_text(f, 1.0, 3, speed) + " m/s"},
          {"above 0.2 m/s", std::to_string(m.found.size()) + " frames: share of inliers " +
                                quantile_text(m, 0.5, 3, share) + ", residual " +
                                quantile_text(m, 0.5, 3, residual) + ", sigma " +
                                quantile_text(m, 0.5, 3, sigma) + " m/s"}};
}

Result<void> write_report(const Options& o, const Velocities& f, const Facts& facts,
                          const std::optional<InertialResult>& inertial) {
  io::Plot velocity = io::time_plot("Velocity of the radar in its axes", "velocity [m/s]");
  io::Plot inliers = io::time_plot("Inliers", "share of inliers");
  velocity.series = {{"forward", {}, {}}, {"left", {}, {}}, {"up", {}, {}}};
  inliers.series = {{"inliers", {}, {}, io::Mark::points}};
  for (const RadarVelocity& v : f.found) {
    const double t = to_seconds(v.time - f.found.front().time);
    for (std::size_t k = 0; k < 3; ++k)
      velocity.series[k].add(t, v.velocity_m_s[static_cast<long>(k)]);
    inliers.series[0].add(t, share(v));
  }
  io::Report report("Velocity of a radar from Doppler measurements", o.log);
  report.facts(facts).plot(velocity).plot(inliers);
  if (inertial) add_plots(*inertial, report);
  return o.write_report(report);
}

Result<void> run(Options o) {
  Facts radar;
  if (!o.chirps.empty()) {
    const auto chirps = read_chirps(o.chirps);
    if (!chirps) return chirps.error();
    apply(*chirps, o.velocity);
    for (const auto& [name, text] : facts_of(*chirps)) radar.emplace_back("radar " + name, text);
  }
  if (auto ready = o.prepare({"velocity.csv", "path.tum", "report.html"}); !ready) return ready;
  const auto recording = read_robot_log(o.log, o.topics, false);
  if (!recording) return recording.error();
  if (recording->radar.empty())
    return Error{ErrorCode::not_found, "contains no radar points", o.log};
  const Velocities f = estimate(recording->radar, o);
  if (f.found.empty()) return Error{ErrorCode::degenerate, f.first_refusal, o.log};
  std::optional<InertialResult> inertial;
  if (o.inertial.use) {
    auto found = run_inertial(o.inertial, o, f.found);
    if (!found) return found.error();
    inertial = *std::move(found);
  }
  Facts facts = facts_of(f);
  facts.insert(facts.end(), radar.begin(), radar.end());
  const auto path =
      inertial ? write_path(*inertial, o.path("path.tum"), o.write()) : Result<void>{};
  const auto done = first_error({io::write_file(o.path("velocity.csv"), csv(f), o.write()), path,
                                 write_report(o, f, facts, inertial)});
  if (!done || o.quiet) return done;
  if (inertial) facts.insert(facts.end(), inertial->facts.begin(), inertial->facts.end());
  if (!f.first_refusal.empty()) facts.emplace_back("first refused", f.first_refusal);
  std::printf("%s\nreport: %s\n", to_text(facts, 18).c_str(), o.path("report.html").c_str());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Velocity of a radar from the radial speeds of each frame, by RANSAC and least squares on "
      "the inliers.\nLOG is " +
      std::string(kRobotLogs) +
      ". Writes velocity.csv and report.html. If the radar's driver sets no stamps, use --stamps "
      "received.");
  Options o;
  app.add_file("LOG", o.log, "the recorded frames").required();
  add_out(app, o);
  app.add_flag("--plane", o.velocity.plane, "the radar measures no elevation");
  app.add_positive("--inlier", o.velocity.inlier_m_s, "largest error of an inlier, m/s");
  app.add_option("--min-range", o.velocity.min_range_m, "smallest range of a point, m")
      .not_negative()
      .show_default();
  app.add_option("--min-snr", o.velocity.min_snr_db,
                 "smallest signal-to-noise ratio of a point, dB")
      .show_default();
  add_chirps(app, o.chirps);
  o.inertial.add_options(app);
  add_seed(app, o, kSeedHelp);
  add_robot_topics(app, o.topics);
  add_force_and_quiet(app, o);
  add_json(app, o);
  app.example("radar.bag --out velocity", "velocity at each frame of a ROS recording");
  app.example("radar.bag --inertial --lever 0.03 0.03 -0.06 --out path",
              "the path of a radar and an inertial unit carried together");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("radar_velocity", run(o));
}
