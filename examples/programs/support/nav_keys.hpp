#pragma once

// The options of a recording's description, as keys of JSON objects.

#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <wayfare/core/se3.hpp>

#include "degree.hpp"
#include "nav_config.hpp"

namespace wayfare::examples {

using Json = nlohmann::ordered_json;

struct Key {
  std::string name;
  std::function<bool(const Json&)> set;  ///< false for a value that is not allowed
  std::function<Json()> get;
  std::string expected;  ///< "a number"
};

inline double rounded(double v) {
  return v == 0.0 ? 0.0 : std::stod(std::to_string(v * 1e9)) / 1e9;
}

/// A number of at least `least`; the option is `factor` times the number.
inline Key number(const std::string& name, double& value, double factor = 1.0, double least = 0.0) {
  return {name,
          [&value, factor, least](const Json& j) {
            if (!j.is_number()) return false;
            const double v = j.get<double>();
            if (!(v >= least) || !(v < 1e9)) return false;
            value = v * factor;
            return true;
          },
          [&value, factor] { return Json(rounded(value / factor)); },
          "a number" + (least == 0.0 ? std::string(" that is not negative") : std::string())};
}

/// A number above 0 and up to `most`, or of 0 if `or_none`.
inline Key limited(const std::string& name, double& value, double most, bool or_none = false) {
  return {name,
          [&value, most, or_none](const Json& j) {
            if (!j.is_number()) return false;
            const double v = j.get<double>();
            if (!(v > 0.0 || (or_none && v == 0.0)) || !(v <= most)) return false;
            value = v;
            return true;
          },
          [&value] { return Json(rounded(value)); },
          std::string(or_none ? "a number that is not negative" : "a positive number") +
              " of at most " + std::to_string(std::lround(most))};
}

inline Key boolean(const std::string& name, bool& value) {
  return {name,
          [&value](const Json& j) {
            if (j.is_boolean()) value = j.get<bool>();
            return j.is_boolean();
          },
          [&value] { return Json(value); }, "true or false"};
}

inline std::optional<Eigen::Vector3d> three(const Json& j) {
  if (!j.is_array() || j.size() != 3) return std::nullopt;
  Eigen::Vector3d v;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!j[i].is_number() || !(std::abs(j[i].get<double>()) < 1e6)) return std::nullopt;
    v[static_cast<Eigen::Index>(i)] = j[i].get<double>();
  }
  return v;
}

inline Json json_of(const Eigen::Vector3d& v) {
  return {rounded(v[0]), rounded(v[1]), rounded(v[2])};
}

/// One positive number for all axes, or three.
inline Key axes(const std::string& name, Eigen::Vector3d& value, double factor = 1.0) {
  return {name,
          [&value, factor](const Json& j) {
            std::optional<Eigen::Vector3d> v = three(j);
            if (j.is_number()) v = Eigen::Vector3d::Constant(j.get<double>());
            if (!v || !(v->minCoeff() > 0.0) || !(v->maxCoeff() < 1e9)) return false;
            value = factor * *v;
            return true;
          },
          [&value, factor] {
            const Eigen::Vector3d v = value / factor;
            return v.maxCoeff() == v.minCoeff() ? Json(rounded(v[0])) : json_of(v);
          },
          "a positive number, or three"};
}

/// Not zero.
inline Key factor(const std::string& name, Eigen::Vector3d& value) {
  return {name,
          [&value](const Json& j) {
            std::optional<Eigen::Vector3d> v = three(j);
            if (j.is_number()) v = Eigen::Vector3d::Constant(j.get<double>());
            if (!v || !(v->cwiseAbs().minCoeff() > 0.0) || !(v->cwiseAbs().maxCoeff() < 1e9))
              return false;
            value = *v;
            return true;
          },
          [&value] { return json_of(value); }, "a number that is not zero, or three"};
}

inline Key vector(const std::string& name, Eigen::Vector3d& value) {
  return {name,
          [&value](const Json& j) {
            const auto v = three(j);
            if (v) value = *v;
            return v.has_value();
          },
          [&value] { return json_of(value); }, "three numbers"};
}

inline Key rotation(const std::string& name, SO3d& q_body_imu) {
  return {name,
          [&q_body_imu](const Json& j) {
            const auto v = three(j);
            if (v) q_body_imu = rotation_from_roll_pitch_yaw(kDegree * *v);
            return v.has_value();
          },
          [&q_body_imu] { return json_of(roll_pitch_yaw_rad(q_body_imu) / kDegree); },
          "three numbers: roll, pitch, yaw"};
}

inline std::vector<Key> imu_noise_keys(ImuNoise& n) {
  return {axes("gyro_white_degps_per_sqrt_hz", n.gyro_white_rad_per_sqrt_s, kDegree),
          axes("accel_white_ug_per_sqrt_hz", n.accel_white_mps_per_sqrt_s, 9.80665e-6),
          axes("gyro_bias_degps", n.gyro_bias_radps.sigma, kDegree),
          axes("gyro_bias_tau_s", n.gyro_bias_radps.tau_s),
          axes("accel_bias_mps2", n.accel_bias_mps2.sigma),
          axes("accel_bias_tau_s", n.accel_bias_mps2.tau_s),
          axes("gyro_scale", n.gyro_scale.sigma),
          axes("gyro_scale_tau_s", n.gyro_scale.tau_s),
          axes("accel_scale", n.accel_scale.sigma),
          axes("accel_scale_tau_s", n.accel_scale.tau_s)};
}

inline std::vector<Key> filter_keys(GnssInsOptions& o) {
  return {number("clock_bias_walk_m_per_sqrt_s", o.clock.bias_walk_m_per_sqrt_s),
          number("clock_drift_walk_mps_per_sqrt_s", o.clock.drift_walk_mps_per_sqrt_s),
          number("range_sigma_scale", o.range_sigma_scale),
          number("gate_sigma", o.gate_sigma),
          limited("correlated_share", o.correlated.share, 1.0, true),
          limited("correlated_tau_s", o.correlated.tau_s, 1e9),
          limited("correlated_distance_m", o.correlated.distance_m, 1e9),
          number("robust_sigma", o.robust_sigma),
          number("gate_reopen_s", o.gate_reopen_s),
          boolean("non_holonomic_in_outage", o.non_holonomic_in_outage),
          number("non_holonomic_sigma_mps", o.non_holonomic_sigma_mps),
          boolean("zero_velocity_updates", o.zero_velocity_updates),
          number("gyro_vibration_share", o.gyro_vibration_share),
          number("max_imu_gap_s", o.max_imu_gap_s),
          number("gap_acceleration_mps2", o.gap_acceleration_mps2),
          number("gap_turn_rate_degps", o.gap_turn_rate_radps, kDegree),
          number("max_lateness_s", o.max_lateness_s),
          number("start_speed_mps", o.start_speed_mps),
          number("start_heading_sigma_deg", o.start_heading_sigma_rad, kDegree),
          boolean("start_without_velocity", o.start_without_velocity)};
}

inline std::vector<Key> odometer_keys(OdometerOptions& o) {
  return {number("speed_sigma_mps", o.speed_sigma_mps),
          number("scale_sigma", o.scale_sigma),
          number("scale_walk_per_sqrt_s", o.scale_walk_per_sqrt_s),
          number("direction_sigma_deg", o.direction_sigma_rad, kDegree),
          vector("lever_arm_m", o.lever_arm_m),
          number("lever_arm_sigma_m", o.lever_arm_sigma_m),
          number("gate_sigma", o.gate_sigma),
          number("cross_sigma_mps", o.cross_sigma_mps)};
}

inline std::vector<Key> carrier_phase_keys(CarrierPhaseOptions& o) {
  return {number("sigma_scale", o.sigma_scale), number("gate_sigma", o.gate_sigma),
          number("longest_interval_s", o.longest_interval_s)};
}

inline Key angle(const std::string& name, Angle& value, double limit_deg) {
  return {name,
          [&value, limit_deg](const Json& j) {
            if (!j.is_number() || !(std::abs(j.get<double>()) <= limit_deg)) return false;
            value = Angle::degrees(j.get<double>());
            return true;
          },
          [&value] { return Json(value.degrees()); },
          "a number of degrees within " + std::to_string(std::lround(limit_deg))};
}

inline std::vector<Key> start_keys(GnssInsStart& s, std::optional<double>& time_s) {
  return {{"time_s",
           [&time_s](const Json& j) {
             if (!j.is_number() || !(std::abs(j.get<double>()) < 9e9)) return false;
             time_s = j.get<double>();
             return true;
           },
           [&time_s] { return Json(time_s.value_or(0.0)); }, "a number of seconds"},
          angle("lat_deg", s.nav.position.latitude, 90.0),
          angle("lon_deg", s.nav.position.longitude, 360.0),
          number("h_m", s.nav.position.height_m, 1.0, -1e6),
          vector("velocity_ned_mps", s.nav.velocity_ned_mps),
          rotation("roll_pitch_yaw_deg", s.nav.q_nb),
          number("position_sigma_m", s.position_sigma_m),
          number("velocity_sigma_mps", s.velocity_sigma_mps),
          number("level_sigma_deg", s.level_sigma_rad, kDegree),
          number("heading_sigma_deg", s.heading_sigma_rad, kDegree)};
}

inline std::vector<Key> general_keys(NavConfig& c) {
  return {rotation("mounting_deg", c.filter.q_body_imu),
          vector("antenna_lever_arm_m", c.filter.antenna_lever_arm_m),
          number("imu_time_offset_s", c.filter.imu_time_offset_s, 1.0, -1e9),
          factor("gyro_factor", c.gyro_factor),
          factor("accel_factor", c.accel_factor),
          boolean("truth_is_antenna", c.truth_is_antenna),
          boolean("truth_is_true", c.truth_is_true),
          number("elevation_mask_deg", c.elevation_mask_deg, 1.0, -90.0),
          number("min_cn0_dbhz", c.min_cn0_dbhz)};
}

}  // namespace wayfare::examples
