// How a radar moves, frame by frame, from its radial speeds alone.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include <wayfare/motion/radar_velocity.hpp>

#include "support/command_line.hpp"
#include "support/exit_code.hpp"
#include "support/program_files.hpp"
#include "support/slam_program.hpp"
#include "support/time_plot.hpp"

namespace {

using namespace wayfare;

struct Options : examples::SlamArguments {
  RadarVelocityOptions velocity;
};

struct Findings {
  std::vector<RadarVelocity> found;
  std::size_t frames = 0, points = 0;
  std::string first_refusal;
};

Findings find(const std::vector<RadarScan>& scans, const Options& o) {
  Findings f;
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

std::string csv(const Findings& f) {
  std::string text =
      "t_s,vx_mps,vy_mps,vz_mps,sigma_x_mps,sigma_y_mps,sigma_z_mps,points,inliers,residual_mps\n";
  for (const RadarVelocity& v : f.found) {
    const std::int64_t ns = v.time.nanoseconds();
    char line[256];
    std::snprintf(line, sizeof line, "%lld.%09lld,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%zu,%zu,%.6f\n",
                  static_cast<long long>(ns / 1'000'000'000),
                  static_cast<long long>(ns % 1'000'000'000), v.velocity_m_s.x(),
                  v.velocity_m_s.y(), v.velocity_m_s.z(), std::sqrt(v.covariance(0, 0)),
                  std::sqrt(v.covariance(1, 1)), std::sqrt(v.covariance(2, 2)), v.points, v.inliers,
                  v.residual_m_s);
    text += line;
  }
  return text;
}

double share(const RadarVelocity& v) {
  return static_cast<double>(v.inliers) / static_cast<double>(v.points);
}

/// The middle one of `value` over all frames, or the one below which a `part` of them lie.
template <class Value>
std::string quantile(const Findings& f, double part, int decimals, Value value) {
  std::vector<double> all;
  for (const RadarVelocity& v : f.found) all.push_back(value(v));
  if (all.empty()) return "-";
  std::sort(all.begin(), all.end());
  const auto at = static_cast<std::size_t>(part * static_cast<double>(all.size() - 1));
  return eval::fixed(all[at], decimals);
}

/// The frames in which the radar moved, beside those in which everything stood still.
Findings moving(const Findings& all) {
  constexpr double kMoves_m_s = 0.2;
  Findings some;
  for (const RadarVelocity& v : all.found)
    if (v.velocity_m_s.norm() > kMoves_m_s) some.found.push_back(v);
  return some;
}

std::vector<std::pair<std::string, std::string>> facts_of(const Findings& f) {
  const auto speed = [](const RadarVelocity& v) { return v.velocity_m_s.norm(); };
  const auto residual = [](const RadarVelocity& v) { return v.residual_m_s; };
  const auto sigma = [](const RadarVelocity& v) { return std::sqrt(v.covariance.trace()); };
  const Findings m = moving(f);
  std::size_t used = 0, inliers = 0;
  for (const RadarVelocity& v : f.found) used += v.points, inliers += v.inliers;
  return {{"frames", std::to_string(f.frames) + ", " + std::to_string(f.points) + " points"},
          {"velocity found", std::to_string(f.found.size()) + " frames"},
          {"inliers", std::to_string(inliers) + " of " + std::to_string(used) + " points, " +
                          eval::fixed(100.0 * static_cast<double>(inliers) /
                                          static_cast<double>(std::max<std::size_t>(used, 1)),
                                      1) +
                          " %"},
          {"share of inliers", "median " + quantile(f, 0.5, 3, share) + ", in the worst tenth " +
                                   quantile(f, 0.1, 3, share)},
          {"residual", "median " + quantile(f, 0.5, 3, residual) + " m/s"},
          {"sigma", "median " + quantile(f, 0.5, 3, sigma) + " m/s"},
          {"speed", "median " + quantile(f, 0.5, 3, speed) + ", largest " +
                        quantile(f, 1.0, 3, speed) + " m/s"},
          {"above 0.2 m/s", std::to_string(m.found.size()) + " frames: share of inliers " +
                                quantile(m, 0.5, 3, share) + ", residual " +
                                quantile(m, 0.5, 3, residual) + ", sigma " +
                                quantile(m, 0.5, 3, sigma) + " m/s"}};
}

Result<void> write_report(const Options& o, const Findings& f,
                          const std::vector<std::pair<std::string, std::string>>& facts) {
  io::Plot velocity = examples::time_plot("Velocity of the radar, its own axes", "velocity [m/s]");
  io::Plot inliers = examples::time_plot("Points that agree", "share of inliers");
  velocity.series = {{"forward", {}, {}}, {"left", {}, {}}, {"up", {}, {}}};
  inliers.series = {{"inliers", {}, {}, io::Mark::points}};
  for (const RadarVelocity& v : f.found) {
    const double t = to_seconds(v.time - f.found.front().time);
    for (std::size_t k = 0; k < 3; ++k) {
      velocity.series[k].x.push_back(t);
      velocity.series[k].y.push_back(v.velocity_m_s[static_cast<long>(k)]);
    }
    inliers.series[0].x.push_back(t);
    inliers.series[0].y.push_back(share(v));
  }
  io::Report report("Velocity of a radar by its Doppler", o.log);
  report.facts(facts).plot(velocity).plot(inliers);
  return report.write(o.out + "/report.html", o.write());
}

Result<void> run(const Options& o) {
  const auto recording = examples::read_robot_log(o.log, o.topics);
  if (!recording) return recording.error();
  if (recording->radar.empty()) return Error{ErrorCode::not_found, "holds no radar points", o.log};
  if (auto ready = examples::prepare_files(o.out, {"velocity.csv", "report.html"}, o.write());
      !ready)
    return ready;
  const Findings f = find(recording->radar, o);
  if (f.found.empty()) return Error{ErrorCode::degenerate, f.first_refusal, o.log};
  const auto facts = facts_of(f);
  if (auto ok = io::write_file(o.out + "/velocity.csv", csv(f), o.write()); !ok) return ok;
  if (auto ok = write_report(o, f, facts); !ok || o.quiet) return ok;
  for (const auto& [name, value] : facts) std::printf("%-18s %s\n", name.c_str(), value.c_str());
  if (!f.first_refusal.empty()) std::printf("%-18s %s\n", "first refused", f.first_refusal.c_str());
  std::printf("\nreport: %s/report.html\n", o.out.c_str());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  examples::CommandLine app(
      "Velocity of a radar from the radial speeds of each frame, by RANSAC and least squares on "
      "the points that agree.\nLOG is " +
      std::string(examples::kRobotLogs) +
      ". Writes velocity.csv and report.html. Where a radar's driver sets no stamps: --stamps "
      "received.");
  Options o;
  app.add_option("LOG", o.log, "the recorded frames").required().existing_file();
  examples::add_out(app, o, "folder for the results, made where needed");
  app.add_flag("--plane", o.velocity.plane, "the radar measures no elevation");
  app.add_option("--inlier", o.velocity.inlier_m_s, "largest error of a point that agrees, m/s")
      .positive()
      .show_default();
  app.add_option("--min-range", o.velocity.min_range_m, "of a point, metres")
      .not_negative()
      .show_default();
  app.add_option("--min-snr", o.velocity.min_snr_db, "of a point, dB").show_default();
  examples::add_seed(app, o, "of the draws: the same seed gives the same result");
  examples::add_robot_topics(app, o.topics);
  examples::add_manners(app, o);
  if (const auto code = app.parse(argc, argv)) return *code;
  return examples::exit_code("radar_velocity", run(o));
}
