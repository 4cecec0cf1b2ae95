#include "job.hpp"

#include <wayfare/io/tum.hpp>

#include "outputs.hpp"
#include "support/progress_line.hpp"

namespace wayfare::examples {
namespace {

/// For logs of unknown lasers and wheels; without gyro, the yaw rate is that of the odometry.
CorridorInsOptions log_defaults(bool has_gyro) {
  CorridorInsOptions o;
  o.walls.range_noise_m = 0.015;
  o.walls.flatness_m = 0.01;
  o.walls.split_m = 0.05;
  o.square_sigma_rad = 0.01;
  o.wall_offset_sigma_m = 0.02;
  o.wall_direction_sigma_rad = 0.01;
  o.noise.slip_m_per_sqrt_m = 0.02;
  o.noise.acceleration_sigma_m_s2 = 1e-6;
  o.start_scale = 0.03;
  o.start_bias_rad_s = 0.06;
  o.start_drift_rad_s2 = has_gyro ? 6e-6 : 1e-9;
  o.greatest_acceleration_m_s2 = 20.0;  // the times of odometry are not exact
  o.rest_calibrates = has_gyro;         // odometry at rest has zero yaw rate
  if (!has_gyro) {
    o.noise.angle_random_walk_rad_per_sqrt_s = 0.01;
    o.noise.bias_sigma_rad_s = 1e-5;
    o.gyro_range_rad_s = 20.0;
    o.turn_error = 0.1;
  }
  return o;
}

std::vector<OptionField> fields(CorridorInsOptions& o) {
  return {
      option_field("range_noise_m", o.walls.range_noise_m),
      option_field("flatness_m", o.walls.flatness_m),
      option_field("reach_m", o.walls.max_range_m),
      option_field("split_m", o.walls.split_m),
      option_field("least_support_m", o.walls.min_support_m),
      option_field("least_correlation", o.walls.min_correlation),
      option_field("angle_random_walk_rad_per_sqrt_s", o.noise.angle_random_walk_rad_per_sqrt_s),
      option_field("bias_sigma_rad_s", o.noise.bias_sigma_rad_s),
      option_field("bias_tau_s", o.noise.bias_tau_s),
      option_field("slip_m_per_sqrt_m", o.noise.slip_m_per_sqrt_m),
      option_field("start_bias_rad_s", o.start_bias_rad_s),
      option_field("start_drift_rad_s2", o.start_drift_rad_s2),
      option_field("start_scale", o.start_scale),
      option_field("greatest_acceleration_m_s2", o.greatest_acceleration_m_s2),
      option_field("wall_offset_sigma_m", o.wall_offset_sigma_m),
      option_field("wall_direction_sigma_rad", o.wall_direction_sigma_rad),
      option_field("turn_error", o.turn_error),
      option_field("square_sigma_rad", o.square_sigma_rad),
      option_field("tracking_m", o.walls.tracking_m),
      option_field("gate_probability", o.gate_probability)};
}

Result<Job> simulated_job(const CorridorArguments& o) {
  sim::CorridorDriveParams p;
  p.pattern = o.simulated == 1 ? sim::MotionPattern::straight : sim::MotionPattern::curved;
  auto drive = sim::simulate_corridors(p, Rng(o.seed));
  if (!drive) return drive.error();
  Job job{drive->recording, options_for(p, Aiding::end_walls), drive->recording.truth,
          *std::move(drive), p.rest_s};
  return job;
}

Result<Job> log_job(const CorridorArguments& o) {
  auto recording = read_robot_log(o.log, o.topics);
  if (!recording) return recording.error();
  const bool has_gyro = !recording->gyro.empty() && !recording->wheels.empty();
  Job job{*std::move(recording), log_defaults(has_gyro), {}, {}, 0.0};
  job.options.T_base_laser = job.recording.T_base_laser;
  job.reference = job.recording.truth;
  if (o.reference.empty()) return job;
  const auto file = io::read_tum(o.reference);
  if (!file) return file.error();
  job.reference = io::planar(file->trajectory);
  return job;
}

/// Several passes over the log, each with the bias of the last: the result then does not depend on
/// the initial bias error.
Result<CorridorRun> run_passes(const Job& job, const CorridorArguments& o, double added_rad_s) {
  const auto motion = motion_of(job.recording, added_rad_s);
  CorridorInsOptions options = job.options;
  const int passes = job.drive ? 1 : o.passes;
  ProgressLine progress("corridors", o.quiet);
  for (int pass = 0;; ++pass) {
    auto run = run_corridor_ins(job.recording, motion, options, {}, [&](double fraction) {
      progress.update((pass + fraction) / passes);
    });
    if (!run || pass + 1 >= passes) {
      if (run) progress.finish();
      return run;
    }
    options.start_bias_value_rad_s = run->epochs.back().gyro_bias.value;
  }
}

}  // namespace

Result<Job> make_job(const CorridorArguments& o) {
  auto job = o.simulated > 0 ? simulated_job(o) : log_job(o);
  if (!job) return job;
  if (!o.config.empty()) {
    if (auto ok = read_option_fields(o.config, fields(job->options)); !ok) return ok.error();
  }
  if (o.no_walls_across) job->options.use_end_walls = false;
  if (o.rest) job->options.rest_calibrates = true;
  if (o.origin.size() == 3) job->options.latitude_rad = Angle::degrees(o.origin[0]).radians();
  return job;
}

std::string corridor_options_text() {
  CorridorInsOptions defaults = log_defaults(false);
  return option_fields_text(fields(defaults));
}

Result<Runs> run_all(const Job& job, const CorridorArguments& o) {
  const double added = Angle::degrees(o.added_bias_deg_s).radians();
  auto aided = run_passes(job, o, added);
  if (!aided) return aided.error();
  CorridorInsOptions alone = job.options;
  alone.use_walls = false;
  auto unaided = run_corridor_ins(job.recording, motion_of(job.recording, added), alone);
  if (!unaided) return unaided.error();
  Runs runs{*std::move(aided), *std::move(unaided), {}};
  if (added == 0.0) return runs;
  auto plain = run_passes(job, o, 0.0);
  if (!plain) return plain.error();
  runs.without_added = *std::move(plain);
  return runs;
}

}  // namespace wayfare::examples
