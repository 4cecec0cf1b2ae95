// SLAM by a Rao-Blackwellised particle filter on a recorded log: radar, LiDAR, or both.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/eval/table.hpp>
#include <wayfare/slam/radar_slam.hpp>
#include <wayfare/sync/radar_odometry.hpp>

#include "config.hpp"
#include "support/chirp_config.hpp"
#include "support/slam_doubt.hpp"
#include "support/slam_program.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Options : SlamArguments {
  std::string relations, sensors, config_file, chirps;
  std::size_t particles = 0;
  bool draw_scans = false, relations_by_scan = false, radar_odometry = false;
  RadarSlamConfig config;
};

struct Inputs {
  Recording recording;
  Truth truth;
  std::vector<eval::Relation> relations;
  SlamSensors sensors = SlamSensors::lidar;
  std::optional<Chirps> chirps;
  Facts facts;  ///< of the radar's odometry
  Doubt doubt;
};

/// --sensors, by default those of the recording.
SlamSensors sensors_of(const Options& o, const Recording& recording) {
  const bool radar = !recording.radar.empty(), lidar = !recording.scans.empty();
  if (o.sensors == "both" || (o.sensors.empty() && radar && lidar)) return SlamSensors::both;
  if (o.sensors == "radar" || (o.sensors.empty() && radar)) return SlamSensors::radar;
  return SlamSensors::lidar;
}

/// By --chirps and --radar-odometry.
Result<void> prepare_radar(const Options& o, Inputs& inputs) {
  RadarOdometryOptions odometry;
  if (!o.chirps.empty()) {
    const auto chirps = read_chirps(o.chirps);
    if (!chirps) return chirps.error();
    inputs.chirps = *chirps;
    apply(*chirps, odometry.velocity);
    inputs.recording.radar_max_speed_m_s = chirps->limits.max_speed_mps;
  }
  if (!o.radar_odometry) return {};
  if (inputs.recording.radar.empty())
    return Error{ErrorCode::not_found, "--radar-odometry: contains no radar points", o.log};
  const RadarOdometry found = radar_odometry(inputs.recording, odometry);
  inputs.facts = {{"radar odometry", "wheels replaced for " + eval::fixed(found.slipped_s, 1) +
                                         " s of slip and " + eval::fixed(found.silent_s, 1) +
                                         " s of silence, radar's speed times " +
                                         eval::fixed(1.0 / found.radar_scale, 3)}};
  inputs.recording = with_radar_odometry(std::move(inputs.recording), odometry);
  return {};
}

Result<Inputs> read_inputs(const Options& o) {
  Inputs inputs;
  auto recording = read_robot_log(o.log, o.topics, false, &inputs.doubt);
  if (!recording) return recording.error();
  if (recording->scans.empty() && recording->radar.empty())
    return Error{ErrorCode::not_found, "contains neither laser scans nor radar points", o.log};
  inputs.recording = *std::move(recording);
  if (auto ok = prepare_radar(o, inputs); !ok) return ok.error();
  auto truth = o.read_truth(inputs.recording);
  if (!truth) return truth.error();
  inputs.truth = *std::move(truth);
  auto relations = read_relations_or_none(o.relations);
  if (!relations) return relations.error();
  if (o.relations_by_scan) relations = eval::relations_by_scan(*relations, inputs.recording.scans);
  if (!relations) return relations.error();
  inputs.relations = *std::move(relations);
  inputs.sensors = sensors_of(o, inputs.recording);
  return inputs;
}

Result<Timed<RadarSlamRun>> run_filter(const Inputs& inputs, const Options& o) {
  RadarSlamOptions options = o.config.slam;
  options.threads = o.threads;
  options.seed = o.seed;
  if (o.particles > 0) options.particles = o.particles;
  if (options.particles == 0) options.particles = particles_of(inputs.sensors);
  SyncParams sync = o.config.sync;
  if (inputs.chirps) {
    apply(*inputs.chirps, sync.array);
    options.radar.max_range_m =
        std::min(options.radar.max_range_m, inputs.chirps->limits.max_range_m);
  }
  return run_timed("particle filter", o.quiet, [&](ProgressLine& progress) {
    return run_radar_slam(inputs.recording, options, inputs.sensors, std::ref(progress),
                          o.config.reckoning, sync);
  });
}

/// All options of --config with their defaults; the number of particles with LiDAR.
std::string config_text() {
  RadarSlamConfig defaults;
  return option_fields_text(fields(defaults));
}

std::string matches_text(const RbpfStatistics& s, const RadarSlamOptions& options) {
  std::string text =
      std::to_string(s.matches) + ", " + std::to_string(s.matches_refused) + " refused";
  if (has_gate(options)) text += ", " + std::to_string(s.matches_gated) + " rejected by the gate";
  return text;
}

eval::Table particles_table(const RadarSlamRun& slam) {
  eval::Table table({{"particle"}, {"weight"}, {"x", "m"}, {"y", "m"}, {"heading", "deg"}});
  for (std::size_t i = 0; i < slam.particles.size() && i < 50; ++i) {
    const SE2d pose = slam.particles[i].T_map_base.raw();
    table.add_row({std::to_string(i + 1), eval::fixed(std::exp(slam.log_weights[i]), 4),
                   eval::fixed(pose.x(), 3), eval::fixed(pose.y(), 3),
                   eval::fixed(pose.heading().degrees(), 2)});
  }
  return table;
}

SlamOutputs outputs_of(const Options& o, const Inputs& inputs, const Timed<RadarSlamRun>& run,
                       const PoseGraph2& no_graph) {
  const RadarSlamRun& slam = run.slam;
  const double recording_s = to_seconds(slam.trajectory.back().time - slam.trajectory.front().time);
  const RbpfStatistics& s = slam.statistics;
  SlamOutputs outputs{
      "Particle filter SLAM of " + o.log,
      inputs.recording,
      slam.trajectory,
      slam.map(),
      no_graph,
      inputs.truth,
      {{"particles", std::to_string(slam.particles.size())},
       {"scans", std::to_string(s.scans) + ", " + std::to_string(s.updates) + " used, " +
                     std::to_string(s.without_points) + " with too few points"},
       {"matches", matches_text(s, o.config.slam)},
       {"resampled", std::to_string(s.resampled) + " times"},
       {"recording", eval::fixed(recording_s, 1) + " s"},
       {"took", speed(run.took_s, recording_s, 2)}},
      {}};
  for (const auto& fact : piece_facts(s)) outputs.facts.push_back(fact);
  for (const auto& fact : inputs.facts) outputs.facts.push_back(fact);
  if (inputs.chirps)
    for (const auto& [name, text] : facts_of(*inputs.chirps))
      outputs.facts.emplace_back("radar " + name, text);
  for (const SensorFault& f : slam.faults)
    outputs.facts.emplace_back("fault", f.what + " from " + eval::fixed(f.from.seconds(), 1) +
                                            " to " + eval::fixed(f.until.seconds(), 1) + " s");
  if (slam.lidar_map.bounds() && slam.radar_map.bounds()) outputs.radar_map = &slam.radar_map;
  outputs.particle_paths = slam.paths;
  outputs.draw_scans = o.draw_scans;
  if (!inputs.relations.empty())
    outputs.tables.emplace_back("Error over relations",
                                eval::relations_table("particle filter", inputs.recording,
                                                      slam.trajectory, inputs.relations));
  return outputs;
}

/// Pieces are joined by LiDAR scans.
void add_doubts(const RadarSlamRun& slam, const Inputs& inputs, Doubt& doubt) {
  const Recording& recording = inputs.recording;
  const RbpfStatistics& s = slam.statistics;
  doubt_share(doubt, slam.refused_scans, s.scans + slam.refused_scans, "scans are refused");
  doubt_share(doubt, s.matches_refused, s.matches + s.matches_refused, "matches are refused");
  doubt_odometry(doubt, recording, slam.trajectory);
  if (inputs.sensors == SlamSensors::radar) doubt_leaps(doubt, recording);
  if (const auto why = piece_doubt(s, slam.crossings, s.scans); !why.empty()) doubt.add(why);
}

Result<Doubt> run(Options o) {
  if (auto ok = read_config(o.config_file, o.config); !ok) return ok.error();
  const auto more = picture_files(o.config.slam.keep_paths, o.draw_scans);
  if (auto ready = prepare_folder(o.out, o.write(), more); !ready) return ready.error();
  if (auto ready = o.prepare_json(); !ready) return ready.error();
  auto inputs = read_inputs(o);
  if (!inputs) return inputs.error();
  const auto run = run_filter(*inputs, o);
  if (!run) return run.error();
  print_refused_scans(run->slam.refused_scans, run->slam.first_refusal);
  const PoseGraph2 no_graph;
  SlamOutputs outputs = outputs_of(o, *inputs, *run, no_graph);
  add_doubts(run->slam, *inputs, inputs->doubt);
  outputs.doubt = inputs->doubt.why;
  if (!o.quiet)
    std::printf("%s%s", to_text(outputs.facts).c_str(), to_text(tables_of(outputs)).c_str());
  outputs.tables.emplace_back("Particles at the end", particles_table(run->slam));
  const auto report = write_slam_outputs(o.out, outputs, o.write(), o.json);
  if (!report) return report.error();
  if (!o.quiet) std::printf("\nreport: %s\n", report->c_str());
  return std::move(inputs->doubt);
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "SLAM on a recorded robot log by a Rao-Blackwellised particle filter with radar, LiDAR or "
      "both.\nLOG is " +
      std::string(kRobotLogs) +
      "; CARMEN text may have RADAR, WHEELS and GYRO lines. Writes trajectory.tum, map.pgm, "
      "map.yaml, map.png and report.html; with both sensors also radar_map.pgm and radar_map.yaml, "
      "for localise.");
  Options o;
  o.config.slam.particles = 0;
  app.add_file("LOG", o.log, "the recorded log").required();
  add_out(app, o);
  app.add_option("--sensors", o.sensors, "radar, lidar or both; by default those of the log")
      .one_of({"radar", "lidar", "both"});
  app.add_option("--particles", o.particles, "of the filter; by default 30, for radar alone 10")
      .range(1, 100000);
  o.truth.add_options(app);
  app.add_file("--relations", o.relations, "true relative poses, to compare with");
  add_relations_by_scan(app, o.relations_by_scan);
  add_threads(app, o.threads);
  add_seed(app, o, kSeedHelp);
  app.add_file(
      "--config", o.config_file,
      "JSON file of options, such as {\"radar_frames\": 40, \"radar_gate_lateral_m\": 0.1}; "
      "see --print-config. Gates reject matches farther from the motion than this to the "
      "side or in heading; at 1000 m and 180 deg, the defaults, never");
  app.add_print("--print-config", config_text,
                "print all options of --config with their defaults, and exit");
  app.add_flag(
      "--paths", o.config.slam.keep_paths,
      "also write the paths of all particles: particles.csv, particles.svg, and in the report");
  app.add_flag("--scans", o.draw_scans,
               "also draw the LiDAR and radar points along the path: scans.svg, and in the report");
  add_chirps(app, o.chirps);
  app.add_flag("--radar-odometry", o.radar_odometry,
               "the radar's velocity beside the wheels, and instead of wheels that slip or are "
               "missing");
  add_robot_topics(app, o.topics);
  add_force_and_quiet(app, o);
  add_json(app, o);
  app.example("robot.log --out radar", "with the sensors that the log has");
  app.example("robot.log --sensors radar --particles 20 --out radar", "by radar alone");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("radar_slam", run(o));
}
