#include "config.hpp"

#include <algorithm>
#include <string>

namespace wayfare::examples {
namespace {

void add_sensor(const std::string& prefix, RbpfSensorOptions& o, std::vector<OptionField>& all) {
  const auto add = [&](const char* name, auto& value) {
    all.push_back(option_field(name, value));
    all.back().name = prefix + all.back().name;
  };
  add("gate_lateral_m", o.gate.lateral_m);
  add("gate_turn_deg", o.gate.turn);
  add("max_correction_m", o.max_correction_m);
  add("max_turn_correction_deg", o.max_turn_correction);
  add("search_sigmas", o.search_sigmas);
  add("min_score", o.min_score);
  add("min_points", o.min_points);
  add("independent_points", o.independent_points);
  add("max_range_m", o.max_range_m);
  add("map_travel_m", o.map_travel_m);
  add("map_turn_deg", o.map_turn);
}

}  // namespace

std::vector<OptionField> fields(RadarSlamConfig& c) {
  std::vector<OptionField> all = {
      option_field("particles", c.slam.particles),
      option_field("resample_below", c.slam.resample_below),
      option_field("radar_frames", c.sync.scans),
      option_field("samples", c.slam.proposal.samples),
      option_field("headings", c.slam.proposal.headings),
      option_field("reach_sigmas", c.slam.proposal.reach_sigmas),
      option_field("update_travel_m", c.slam.update_travel_m),
      option_field("update_turn_deg", c.slam.update_turn),
      option_field("update_time_s", c.slam.update_time_s),
      option_field("radar_hit_probability", c.slam.radar_hit_probability),
      option_field("lidar_p_free", c.slam.lidar_model.p_free),
      option_field("lidar_p_hit", c.slam.lidar_model.p_hit),
      option_field("wheel_slip_m_per_sqrt_m", c.reckoning.wheels.slip_m_per_sqrt_m),
      option_field("wheel_scale", c.reckoning.wheels.scale),
      option_field("gyro_scale", c.reckoning.gyro.scale),
      option_field("gyro_walk_rad_per_sqrt_s", c.reckoning.gyro.angle_random_walk_rad_per_sqrt_s)};
  add_sensor("lidar_", c.slam.lidar, all);
  add_sensor("radar_", c.slam.radar, all);
  return all;
}

Result<void> read_config(const std::string& path, RadarSlamConfig& c) {
  if (path.empty()) return {};
  if (auto ok = read_option_fields(path, fields(c)); !ok) return ok;
  c.sync.min_scans = std::min(c.sync.min_scans, c.sync.scans);
  const auto error = [&](const char* what) { return Error{ErrorCode::parse, what, path}; };
  const InverseLidarModel& model = c.slam.lidar_model;
  for (const double p : {model.p_free, model.p_hit, c.slam.radar_hit_probability})
    if (p >= 1.0) return error("probabilities must be below 1");
  if (c.slam.proposal.samples > 1 << 20 || c.slam.proposal.headings > 1 << 12)
    return error("at most 1048576 samples and 4096 headings are allowed");
  if (c.slam.particles > 100000 || c.sync.scans > 1000)
    return error("at most 100000 particles and 1000 radar frames are allowed");
  return {};
}

bool has_gate(const RadarSlamOptions& o) {
  const MatchGate never;
  const auto set = [&](const MatchGate& g) {
    return g.lateral_m < never.lateral_m || g.turn < never.turn;
  };
  return set(o.lidar.gate) || set(o.radar.gate);
}

}  // namespace wayfare::examples
