// Draws the scans of a log along a path: over a map and a floor plan, with the matcher's scores and
// the sensor models.

#include <algorithm>
#include <cstdio>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <wayfare/io/report.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/io/tum.hpp>

#include "scene.hpp"
#include "scores.hpp"
#include "sensor_model.hpp"
#include "support/plans.hpp"
#include "support/slam_program.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Options : SlamArguments {
  std::string path_file, map, plan, sensors = "both";
  std::optional<double> at_s, from_s, to_s, score_s;
  std::size_t frames = 0;
  double around_m = 0.0;
  bool sensor_model = false;
  ScoreOptions score;
};

struct Inputs {
  Recording recording;
  Trajectory path;
  Truth truth;
  LogTime first, last;  ///< of the measurements
};

std::string span_text(LogTime from, LogTime until) {
  return eval::fixed(from.seconds(), 3) + " to " + eval::fixed(until.seconds(), 3) + " s";
}

Result<Inputs> read_inputs(const Options& o) {
  Inputs in;
  auto recording = read_robot_log(o.log, o.topics);
  if (!recording) return recording.error();
  in.recording = *std::move(recording);
  if (o.sensors == "lidar") in.recording.radar.clear();
  if (o.sensors == "radar") in.recording.scans.clear();
  if (in.recording.scans.empty() && in.recording.radar.empty())
    return Error{ErrorCode::not_found, "contains no scans of the chosen sensors", o.log};
  const std::vector<LogTime> times = times_of(in.recording);
  in.first = times.front(), in.last = times.back();
  auto file = io::read_poses(o.path_file);
  if (!file) return file.error();
  print_problems(file->problems);
  in.path = std::move(file->trajectory);
  if (in.path.front().time > in.last || in.path.back().time < in.first)
    return Error{ErrorCode::not_found,
                 "does not overlap with the log: its poses are from " +
                     span_text(in.path.front().time, in.path.back().time) + ", the scans from " +
                     span_text(in.first, in.last),
                 o.path_file};
  auto truth = o.read_truth(in.recording);
  if (!truth) return truth.error();
  in.truth = *std::move(truth);
  return in;
}

/// A time of the command line, after the first scan, on the log's clock.
Result<LogTime> time_of(const Inputs& in, const char* option, double after_s) {
  const double length_s = to_seconds(in.last - in.first);
  if (after_s >= 0.0 && after_s <= length_s) return in.first + from_seconds(after_s);
  return bad_use(std::string(option) + " " + eval::fixed(after_s, 1) +
                 " is outside the log, whose scans take " + eval::fixed(length_s, 1) + " s");
}

Result<ScanChoice> choice_of(const Inputs& in, const Options& o) {
  ScanChoice choice;
  const bool part = o.at_s || o.from_s || o.to_s;
  if (o.frames > 0 && !part && !o.score_s)
    return bad_use("--frames needs --at, --from, --to or --score");
  if (o.frames > 0 && part) choice.frames = o.frames;
  for (const auto& [given, option, time] :
       {std::tuple(o.from_s, "--from", &choice.from), std::tuple(o.to_s, "--to", &choice.until),
        std::tuple(o.at_s, "--at", &choice.from)}) {
    if (!given) continue;
    const auto found = time_of(in, option, *given);
    if (!found) return found.error();
    *time = *found;
  }
  if (o.sensors == "none") choice.scans = choice.frames = 0;
  if (o.at_s && o.sensors != "none") {
    choice.scans = 1;
    if (o.frames == 0) choice.frames = ScoreOptions().frames;
  }
  return choice;
}

Result<io::GridImage> read_unrotated_map(const std::string& path) {
  auto map = io::read_map(path);
  if (!map) return map;
  if (map->origin.heading().radians() != 0.0)
    return Error{ErrorCode::invalid, "its origin is rotated, which pictures with axes cannot show",
                 path};
  return map;
}

/// From the truth's frame to the path's, by rigid alignment; the same frame without truth.
SE2d T_path_truth(const Inputs& in) {
  if (!in.truth.known()) return {};
  const eval::Evaluation errors = eval::evaluate(in.path, in.truth);
  return errors.rigid.times.empty() ? SE2d() : errors.rigid.alignment.inverse();
}

Result<Scene> scene_of(const Inputs& in, const Options& o) {
  const auto choice = choice_of(in, o);
  if (!choice) return choice.error();
  Scene scene;
  scene.title = "Scans of " + o.log;
  if (!o.map.empty()) {
    auto map = read_unrotated_map(o.map);
    if (!map) return map.error();
    scene.map = *std::move(map);
  }
  scene.T_map_plan = T_path_truth(in);
  if (!o.plan.empty()) {
    auto plan = read_walls(o.plan, o.seed);
    if (!plan) return plan.error();
    scene.plan = *std::move(plan);
  }
  scene.points = place_scans(in.recording, in.path, *choice);
  if (o.sensors != "none" && scene.points.scans + scene.points.frames == 0)
    return Error{ErrorCode::not_found, "has no poses at the chosen time", o.path_file};
  const auto chosen = [&](LogTime t) {
    return o.at_s || (t >= choice->from && t <= choice->until);
  };
  for (const StampedPose& p : in.path)
    if (chosen(p.time)) scene.path.push_back(p);
  for (const StampedPose& p : in.truth.poses)
    if (chosen(p.time))
      scene.truth.push_back(
          {p.time, Transform2<frame::Map, frame::Base>(scene.T_map_plan * p.T_map_base.raw())});
  if (o.at_s) scene.at = pose_at(in.path, std::max(choice->from, in.path.front().time));
  if (scene.at) scene.view = {scene.at->translation(), o.around_m};
  return scene;
}

Result<std::vector<Scores>> scores_for(const Inputs& in, const Options& o) {
  if (!o.score_s) return std::vector<Scores>();
  const auto at = time_of(in, "--score", *o.score_s);
  if (!at) return at.error();
  ScoreOptions options = o.score;
  options.at = *at;
  options.seed = o.seed;
  if (o.frames > 0) options.frames = o.frames;
  return scores_at(in.recording, in.path, options);
}

/// Plots with the file of each.
using Pictures = std::vector<std::pair<std::string, io::Plot>>;

std::vector<std::string> files_of(const Options& o) {
  std::vector<std::string> files = {"scans.svg", "report.html"};
  if (o.sensor_model) files.insert(files.end(), {"inverse_model.svg", "likelihood.svg"});
  if (o.score_s)
    for (const char* sensor : {"lidar", "radar"})
      for (const char* kind : {"score_", "tau_", "along_", "across_"})
        files.push_back(std::string(kind) + sensor + ".svg");
  return files;
}

Result<void> add_sensor_models(io::Report& report, Pictures& pictures) {
  auto models = sensor_models();
  if (!models) return models.error();
  report.heading("Sensor models");
  pictures.emplace_back("inverse_model.svg", (*models)[0]);
  pictures.emplace_back("likelihood.svg", (*models)[1]);
  for (const io::Plot& plot : *models) report.plot(plot);
  return {};
}

void add_scores(const std::vector<Scores>& all, io::Report& report, Pictures& pictures) {
  for (const Scores& s : all) {
    report.heading("Scores, " + s.sensor).facts(s.facts);
    for (const auto& [kind, plot] :
         {std::pair("score_", &s.surface), std::pair("tau_", &s.tau), std::pair("along_", &s.along),
          std::pair("across_", &s.across)}) {
      pictures.emplace_back(kind + s.file + ".svg", *plot);
      report.plot(*plot);
    }
  }
}

void print_results(const Facts& facts, const std::vector<Scores>& scores) {
  std::printf("%s", to_text(facts).c_str());
  for (const Scores& s : scores)
    std::printf("\nScores, %s\n%s", s.sensor.c_str(), to_text(s.facts).c_str());
}

Result<void> run(const Options& o) {
  if (auto ready = o.prepare(files_of(o)); !ready) return ready;
  const auto in = read_inputs(o);
  if (!in) return in.error();
  const auto scene = scene_of(*in, o);
  if (!scene) return scene.error();
  const auto scores = scores_for(*in, o);
  if (!scores) return scores.error();
  const Facts facts = {{"LiDAR", std::to_string(scene->points.scans) + " scans, " +
                                     std::to_string(scene->points.lidar_m.size()) + " points"},
                       {"radar", std::to_string(scene->points.frames) + " frames, " +
                                     std::to_string(scene->points.radar_m.size()) + " points"}};
  io::Report report("Scans of " + o.log);
  Pictures pictures = {{"scans.svg", scene_plot(*scene)}};
  report.facts(facts).plot(pictures.front().second);
  add_scores(*scores, report, pictures);
  if (o.sensor_model)
    if (auto done = add_sensor_models(report, pictures); !done) return done;
  for (const auto& [file, plot] : pictures)
    if (auto ok = io::write_file(o.path(file), io::to_svg_document(plot), o.write()); !ok)
      return ok;
  if (auto ok = report.write(o.path("report.html"), o.write()); !ok) return ok;
  if (!o.quiet) print_results(facts, *scores);
  return {};
}

void add_options(CommandLine& app, Options& o) {
  app.add_file("LOG", o.log, "the recorded log").required();
  app.add_file("TRAJECTORY", o.path_file, "poses of the robot on the log's clock, TUM text")
      .required();
  add_out(app, o);
  app.add_file("--map", o.map, "a map in the trajectory's frame, such as SLAM's map.yaml");
  app.add_option("--plan", o.plan,
                 "a floor plan (text, or .yaml of a map picture) or the name of a simulated world, "
                 "in the frame of the true poses, if there are any, to which the trajectory is "
                 "aligned; else in the trajectory's");
  app.add_option("--sensors", o.sensors,
                 "radar, lidar, both, or none for the map, the plan and the paths alone")
      .one_of({"radar", "lidar", "both", "none"})
      .show_default();
  const Option at = app.add_option("--at", o.at_s,
                                   "one LiDAR scan and --frames radar frames (by default 20), s "
                                   "after the first scan");
  app.add_option("--from", o.from_s, "begin, s after the first scan").excludes(at.name());
  app.add_option("--to", o.to_s, "end, s after the first scan").excludes(at.name());
  app.add_option("--frames", o.frames,
                 "radar frames of --at and of the scan of --score; of a span, the first ones")
      .range(1, 100000);
  app.add_option("--around", o.around_m, "only what is within this many metres of the robot")
      .positive()
      .needs(at.name());
  app.add_option(
      "--score", o.score_s,
      "the scan matcher's score of the scan at this time, s, in the map of the scans before it, "
      "and the samples of tau");
  app.add_option("--window", o.score.window_m, "half the width of the search window: of --score, m")
      .range(0.05, 3.0)
      .show_default();
  app.add_option("--motion-sigma", o.score.motion_m,
                 "of --score: standard deviation of the motion about the trajectory's pose, m")
      .range(0.001, 3.0)
      .show_default();
  app.add_option("--samples", o.score.samples, "of tau, at least").range(1, 1000000).show_default();
  app.add_flag("--sensor-model", o.sensor_model, "also draw the sensor models of radar_slam");
  o.truth.add_options(app);
  add_seed(app, o, kSeedHelp);
  add_robot_topics(app, o.topics);
  add_force_and_quiet(app, o);
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Draw a log's scans along a trajectory: LiDAR and radar points over a map and a floor plan, "
      "for the whole log, a span or a moment.\nLOG is " +
      std::string(kRobotLogs) +
      ". Writes scans.svg and report.html; with --score also score_, tau_, along_ and across_ "
      "pictures of each sensor, with --sensor-model inverse_model.svg and likelihood.svg.");
  app.example("robot.log out/trajectory.tum --map out/map.yaml --out pictures",
              "all scans over the map");
  app.example("robot.log out/trajectory.tum --at 60 --frames 40 --around 6 --out moment",
              "one LiDAR scan and forty radar frames, 6 m about the robot");
  Options o;
  add_options(app, o);
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("draw_scans", run(o));
}
