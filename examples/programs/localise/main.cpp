// Monte-Carlo localisation of a robot on a known map from its log.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <wayfare/io/map_image.hpp>
#include <wayfare/slam/localisation.hpp>

#include "outputs.hpp"
#include "support/progress_line.hpp"
#include "support/slam_doubt.hpp"
#include "support/slam_program.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Options : SlamArguments {
  std::string map, radar_map, sensors;
  std::vector<double> initial;  // x, y, heading
  bool global = false, beam = false;
  LocalisationOptions localisation;
  LocalisationMapOptions map_options;
};

struct Maps {
  io::GridImage image;
  std::shared_ptr<const LocalisationMap> map;
};

/// Both maps in the frame of the lower left corner of `image`, whose origin is the pose of that
/// frame in the map.
Result<Maps> read_maps(const Options& o) {
  auto image = io::read_map(o.map);
  if (!image) return image.error();
  std::optional<OccupancyGrid> radar;
  if (!o.radar_map.empty() && o.sensors != "lidar") {
    const auto radar_image = io::read_map(o.radar_map);
    if (!radar_image) return radar_image.error();
    radar = io::occupancy_grid(*radar_image, image->origin.inverse() * radar_image->origin);
    if (!radar->bounds()) return Error{ErrorCode::invalid, "the map is empty", o.radar_map};
  }
  const auto map =
      LocalisationMap::make(io::occupancy_grid(*image), o.map_options, radar ? &*radar : nullptr);
  if (!map) return Error{map.error().code, map.error().message, o.map};
  return Maps{*std::move(image), *map};
}

std::optional<Gaussian<SE2d>> start_of(const Options& o, const SE2d& T_map_grid) {
  if (o.initial.empty()) return std::nullopt;
  const SE2d pose(o.initial[0], o.initial[1], Angle::radians(o.initial[2]));
  return Gaussian<SE2d>{T_map_grid.inverse() * pose,
                        Eigen::Vector3d(0.25, 0.25, 0.07).asDiagonal()};
}

/// From the frame of the image's corner to the map's.
void move_to_map(LocalisationRun& run, const SE2d& T_map_grid) {
  for (LocalisationOutcome& s : run.outcomes) s.T_map_base.mean = T_map_grid * s.T_map_base.mean;
  for (ParticleSnapshot& shot : run.snapshots)
    for (PoseParticle& p : shot.particles) p.T_map_base = T_map_grid * p.T_map_base;
}

Result<Timed<LocalisationRun>> localise(const Options& o, const Maps& maps,
                                        const Recording& recording) {
  ProgressLine progress("localising", o.quiet);
  LocalisationControl control;
  control.snapshots_at = {0.0, 0.005, 0.02, 0.1, 0.5, 1.0};
  control.progress = std::ref(progress);
  auto run = run_localisation(recording, maps.map, o.localisation, o.seed,
                              start_of(o, maps.image.origin), control);
  if (!run) return Error{run.error().code, run.error().message, o.log};
  const double took_s = progress.finish();
  move_to_map(*run, maps.image.origin);
  return Timed<LocalisationRun>{*std::move(run), took_s};
}

std::string status_of(const LocalisationOutcome& last) {
  if (last.particles == 0) return "no usable measurements";
  if (last.converged)
    return "converged, with " + eval::fixed(100.0 * last.mass, 0) + " % of the weight";
  if (last.clusters > 1)
    return "not converged: " + std::to_string(last.clusters) + " clusters are left";
  return "not converged: the measurements do not fit the map";
}

Facts facts_of(const Timed<LocalisationRun>& timed) {
  const auto& outcomes = timed.slam.outcomes;
  using O = LocalisationOutcome;
  const auto count = [&](bool O::*flag) { return std::ranges::count(outcomes, true, flag); };
  const auto seconds_at = [&](const O& o) { return to_seconds(o.time - outcomes.front().time); };
  const auto radar = std::ranges::count(outcomes, RangeSensor::radar, &O::sensor);
  const auto first = std::ranges::find(outcomes, true, &O::converged);
  const double converged = 100.0 * static_cast<double>(count(&O::converged));
  return {
      {"scans", std::to_string(outcomes.size()) + " (" + std::to_string(radar) + " of radar), " +
                    std::to_string(count(&O::weighed)) + " weighted"},
      {"first converged",
       first == outcomes.end() ? "never" : "after " + eval::fixed(seconds_at(*first), 1) + " s"},
      {"converged",
       eval::fixed(converged / static_cast<double>(outcomes.size()), 1) + " % of the scans"},
      {"at the end", status_of(outcomes.back())},
      {"searches", std::to_string(count(&O::searched)) + ", relocalised " +
                       std::to_string(count(&O::relocalised))},
      {"refused", std::to_string(timed.slam.refused_scans) + " scans, odometry at " +
                      std::to_string(count(&O::odometry_refused))},
      {"took", speed(timed.took_s, seconds_at(outcomes.back()), 2)}};
}

void add_doubts(const LocalisationRun& run, bool has_odometry, Doubt& doubt) {
  const auto& outcomes = run.outcomes;
  const LocalisationOutcome& last = outcomes.back();
  if (!last.converged) doubt.add("at the end " + status_of(last));
  doubt_share(doubt, run.refused_scans, outcomes.size() + run.refused_scans, "scans are refused");
  const auto refused = std::ranges::count(outcomes, true, &LocalisationOutcome::odometry_refused);
  if (has_odometry)
    doubt_share(doubt, static_cast<std::size_t>(refused), outcomes.size(),
                "scans have no plausible odometry");
}

Result<Doubt> run(const Options& o) {
  if (!std::isfinite(o.localisation.max_range_m)) return bad_use("--max-range must be a number");
  if (!std::all_of(o.initial.begin(), o.initial.end(), [](double v) { return std::isfinite(v); }))
    return bad_use("--initial must be three numbers");
  if (o.sensors != "lidar" && !o.sensors.empty() && o.radar_map.empty())
    return bad_use("localisation by radar needs a --radar-map");
  if (auto ready = o.prepare({"trajectory.tum", "poses.csv", "report.html"}); !ready)
    return ready.error();
  const auto maps = read_maps(o);
  if (!maps) return maps.error();
  Doubt doubt;
  const auto recording = read_robot_log(o.log, o.topics, true, &doubt);
  if (!recording) return recording.error();
  const auto truth = o.read_truth(*recording);
  if (!truth) return truth.error();
  const auto timed = localise(o, *maps, *recording);
  if (!timed) return timed.error();
  print_refused_scans(timed->slam.refused_scans, timed->slam.first_refusal);
  add_doubts(timed->slam, !recording->odometry.empty(), doubt);
  const LocalisationOutputs outputs{"Localisation of " + o.log + " on " + o.map,
                                    maps->image,
                                    timed->slam,
                                    *truth,
                                    facts_of(*timed),
                                    doubt.why};
  if (auto done = write_localisation(o, outputs); !done) return done.error();
  if (!o.quiet)
    std::printf("%s%s\nreport: %s\n", to_text(outputs.facts).c_str(),
                to_text(localisation_errors(outputs)).c_str(), o.path("report.html").c_str());
  return doubt;
}

void add_options(CommandLine& app, Options& o) {
  app.add_file("LOG", o.log, std::string("the recorded log: ") + kRobotLogs).required();
  app.add_file("MAP", o.map, "the .yaml file of a map, as map_server and graph_slam write it")
      .required();
  add_out(app, o);
  app.add_file("--radar-map", o.radar_map,
               "the .yaml file of a map of radar detections, as radar_slam writes it beside MAP: "
               "the log's radar is then used as well");
  app.add_option("--sensors", o.sensors, "lidar, radar or both; by default those with a map")
      .one_of({"lidar", "radar", "both"});
  app.add_option("--initial", o.initial,
                 "x,y,heading in the map, m and rad: initial pose, to within half a metre and 15 "
                 "degrees")
      .delimiter(',')
      .expected(3);
  app.add_flag("--global", o.global, "search the whole map (the default without --initial)")
      .excludes("--initial");
  o.truth.add_options(app);
  app.add_flag("--beam", o.beam, "the beam model instead of the likelihood field");
  app.add_number("--beams", o.localisation.beams, 4, 10000, "beams used per scan");
  app.add_positive("--max-range", o.localisation.max_range_m, "farther returns are not used, m");
  app.add_number("--particles", o.localisation.max_particles, 100, 10000000,
                 "largest number of particles");
  app.add_positive("--sigma", o.map_options.lidar.sigma_m, "of a range, m");
  add_seed(app, o, kSeedHelp);
  add_threads(app, o.threads);
  add_robot_topics(app, o.topics);
  add_force_and_quiet(app, o);
  add_json(app, o);
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Localise a robot on a known map from its log of scans and odometry, by Monte-Carlo "
      "localisation with LiDAR, radar or both.\nWrites trajectory.tum (the converged poses), "
      "poses.csv (every scan) and report.html.");
  Options o;
  add_options(app, o);
  app.example("robot.log map.yaml --out localised",
              "finds the pose on the whole map, then follows it");
  app.example("robot.log map.yaml --initial 1.5,2,0 --out localised",
              "from x = 1.5 m, y = 2 m, heading 0");
  if (const auto code = app.parse(argc, argv)) return *code;
  if (o.beam) o.localisation.model = ScanLikelihood::beam;
  o.localisation.use_lidar = o.sensors != "radar";
  o.localisation.threads = o.threads;
  return exit_code("localise", run(o));
}
