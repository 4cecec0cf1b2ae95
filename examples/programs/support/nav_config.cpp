#include "nav_config.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <optional>

#include <nlohmann/json.hpp>

#include <wayfare/core/se3.hpp>
#include <wayfare/io/text_file.hpp>

#include "program_files.hpp"

namespace wayfare::examples {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegree = std::numbers::pi / 180.0;

struct Key {
  std::string name;
  std::function<bool(const Json&)> set;  ///< false for a value that is not allowed
  std::function<Json()> get;
  std::string expected;  ///< "a number"
};

double rounded(double v) { return v == 0.0 ? 0.0 : std::stod(std::to_string(v * 1e9)) / 1e9; }

/// A number of at least `least`; the option is `factor` times the number.
Key number(const std::string& name, double& value, double factor = 1.0, double least = 0.0) {
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

Key boolean(const std::string& name, bool& value) {
  return {name,
          [&value](const Json& j) {
            if (j.is_boolean()) value = j.get<bool>();
            return j.is_boolean();
          },
          [&value] { return Json(value); }, "true or false"};
}

std::optional<Eigen::Vector3d> three(const Json& j) {
  if (!j.is_array() || j.size() != 3) return std::nullopt;
  Eigen::Vector3d v;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!j[i].is_number() || !(std::abs(j[i].get<double>()) < 1e6)) return std::nullopt;
    v[static_cast<Eigen::Index>(i)] = j[i].get<double>();
  }
  return v;
}

Json json_of(const Eigen::Vector3d& v) { return {rounded(v[0]), rounded(v[1]), rounded(v[2])}; }

/// One positive number for all axes, or three.
Key axes(const std::string& name, Eigen::Vector3d& value, double factor = 1.0) {
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
Key factor(const std::string& name, Eigen::Vector3d& value) {
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

Key vector(const std::string& name, Eigen::Vector3d& value) {
  return {name,
          [&value](const Json& j) {
            const auto v = three(j);
            if (v) value = *v;
            return v.has_value();
          },
          [&value] { return json_of(value); }, "three numbers"};
}

Key rotation(const std::string& name, SO3d& q_body_imu) {
  return {name,
          [&q_body_imu](const Json& j) {
            const auto v = three(j);
            if (v) q_body_imu = rotation_from_roll_pitch_yaw(kDegree * *v);
            return v.has_value();
          },
          [&q_body_imu] { return json_of(roll_pitch_yaw_rad(q_body_imu) / kDegree); },
          "three numbers: roll, pitch, yaw"};
}

std::vector<Key> imu_noise_keys(ImuNoise& n) {
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

std::vector<Key> filter_keys(GnssInsOptions& o) {
  return {number("clock_bias_walk_m_per_sqrt_s", o.clock.bias_walk_m_per_sqrt_s),
          number("clock_drift_walk_mps_per_sqrt_s", o.clock.drift_walk_mps_per_sqrt_s),
          number("range_sigma_scale", o.range_sigma_scale),
          number("gate_sigma", o.gate_sigma),
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

Key angle(const std::string& name, Angle& value, double limit_deg) {
  return {name,
          [&value, limit_deg](const Json& j) {
            if (!j.is_number() || !(std::abs(j.get<double>()) <= limit_deg)) return false;
            value = Angle::degrees(j.get<double>());
            return true;
          },
          [&value] { return Json(value.degrees()); },
          "a number of degrees within " + std::to_string(std::lround(limit_deg))};
}

std::vector<Key> start_keys(GnssInsStart& s, std::optional<double>& time_s) {
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

std::vector<Key> general_keys(NavConfig& c) {
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

struct Reader {
  std::string source;

  [[nodiscard]] Error error(const std::string& what) const {
    return {ErrorCode::parse, what, source};
  }

  [[nodiscard]] Result<void> take(const std::vector<Key>& keys, const std::string& name,
                                  const Json& value) const {
    const auto key =
        std::find_if(keys.begin(), keys.end(), [&](const Key& k) { return k.name == name; });
    if (key == keys.end())
      return error("unknown option '" + name + "'; --print-config lists all options");
    if (!key->set(value)) return error("option '" + name + "' must be " + key->expected);
    return {};
  }

  [[nodiscard]] Result<void> section(const std::vector<Key>& keys, const std::string& name,
                                     const Json& value) const {
    if (!value.is_object()) return error("'" + name + "' must be an object of options");
    for (const auto& [key, v] : value.items())
      if (auto done = take(keys, key, v); !done) return done;
    return {};
  }

  [[nodiscard]] Result<void> start(const Json& value, NavConfig& config) const {
    if (value.is_null()) return {};
    config.start.emplace();
    if (auto done = section(start_keys(*config.start, config.start_time_s), "start", value); !done)
      return done;
    if (value.contains("lat_deg") && value.contains("lon_deg")) return {};
    return error("'start' needs lat_deg and lon_deg");
  }

  [[nodiscard]] Result<void> file(const std::string& name, const Json& value,
                                  io::NavFileFormat& description) const {
    if (!value.is_object()) return error("'" + name + "' must describe a file");
    for (const auto& [key, v] : value.items()) {
      const std::string where = name + "." + key;
      if (key == "columns" && v.is_array()) {
        for (const Json& column : v) {
          if (!column.is_string()) return error("'" + where + "' must be names of columns");
          description.format.columns.push_back(column.get<std::string>());
        }
      } else if (key == "columns" && v.is_object()) {
        if (auto done = choices(where, v, description.format); !done) return done;
      } else if (key == "skip_lines" && v.is_number_unsigned()) {
        description.format.skip_lines = v.get<std::size_t>();
      } else if (key == "leap_seconds" && v.is_number_integer() &&
                 std::abs(v.get<double>()) < 1000.0) {
        description.format.leap_seconds = v.get<int>();
      } else if (key == "velocity_late_s" && v.is_number() && std::abs(v.get<double>()) < 10.0) {
        description.velocity_late_s = v.get<double>();
      } else {
        return error("'" + where +
                     "' is not allowed; a file has columns (names in order, or an object of name "
                     "and heading or number), skip_lines, leap_seconds "
                     "(integers) and velocity_late_s (seconds)");
      }
    }
    return {};
  }

  /// {"gx_degps": "Gyro X", "gy_degps": 3}
  [[nodiscard]] Result<void> choices(const std::string& where, const Json& value,
                                     io::ColumnFormat& format) const {
    for (const auto& [name, column] : value.items()) {
      if (column.is_string()) {
        format.choices.push_back({name, column.get<std::string>()});
      } else if (column.is_number_unsigned()) {
        format.choices.push_back({name, std::to_string(column.get<unsigned>())});
      } else {
        return error("'" + where + "." + name + "' must be a heading, or a number from 1");
      }
    }
    return {};
  }

  [[nodiscard]] Result<void> imu(const Json& value, NavConfig& config) const {
    const Json parts = value.is_array() ? value : Json::array({value});
    for (const Json& part : parts) {
      config.imu.emplace_back();
      if (auto done = file("imu", part, config.imu.back()); !done) return done;
    }
    return {};
  }
};

void fill(Json& to, const std::vector<Key>& keys) {
  for (const Key& k : keys) to[k.name] = k.get();
}

void fill_filter(Json& json, NavConfig& c) {
  fill(json, general_keys(c));
  fill(json["imu_noise"], imu_noise_keys(c.filter.imu));
  fill(json["filter"], filter_keys(c.filter));
}

}  // namespace

Result<NavConfig> parse_nav_config(const std::string& text, const std::string& source) {
  const Reader reader{source};
  const Json json = Json::parse(text, nullptr, false, true);
  if (!json.is_object()) return reader.error("expected a JSON object of options");
  NavConfig c;
  const std::map<std::string, io::NavFileFormat*> files = {
      {"imu_clock", &c.imu_clock}, {"ranges", &c.ranges}, {"fixes", &c.fixes}, {"truth", &c.truth}};
  for (const auto& [key, value] : json.items()) {
    Result<void> done;
    if (key == "note") {
      c.note = value.is_string() ? value.get<std::string>() : std::string();
    } else if (key == "imu") {
      done = reader.imu(value, c);
    } else if (const auto file = files.find(key); file != files.end()) {
      done = reader.file(key, value, *file->second);
    } else if (key == "start") {
      done = reader.start(value, c);
    } else if (key == "imu_noise") {
      done = reader.section(imu_noise_keys(c.filter.imu), key, value);
    } else if (key == "filter") {
      done = reader.section(filter_keys(c.filter), key, value);
    } else {
      done = reader.take(general_keys(c), key, value);
    }
    if (!done) return done.error();
  }
  return c;
}

Result<NavConfig> read_nav_config(const std::string& path) {
  if (path.empty()) return NavConfig{};
  const auto file = io::read_file(path);
  if (!file) return file.error();
  return parse_nav_config(file->bytes, path);
}

std::string format_nav_config(const NavConfig& config) {
  NavConfig c = config;
  Json json;
  if (!c.note.empty()) json["note"] = c.note;
  fill_filter(json, c);
  return json.dump(2) + "\n";
}

Result<std::string> updated_nav_config(const std::string& path, const NavConfig& config) {
  Json json = Json::object();
  if (!path.empty()) {
    const auto file = io::read_file(path);
    if (!file) return file.error();
    json = Json::parse(file->bytes, nullptr, false, true);
    if (!json.is_object()) return Error{ErrorCode::parse, "expected a JSON object", path};
  }
  NavConfig c = config;
  for (const Key& key : general_keys(c))
    if (key.name != "truth_is_antenna" && key.name != "truth_is_true" &&
        key.name != "elevation_mask_deg" && key.name != "min_cn0_dbhz")
      json[key.name] = key.get();
  return json.dump(2) + "\n";
}

std::string default_nav_config() {
  NavConfig c;
  Json json;
  json["imu"] = {{"columns", Json::array()}, {"skip_lines", 0}};
  for (const char* name : {"imu_clock", "ranges", "fixes", "truth"})
    json[name] = {{"columns", Json::array()},
                  {"skip_lines", 0},
                  {"leap_seconds", 18},
                  {"velocity_late_s", 0.0}};
  fill_filter(json, c);
  json["start"] = nullptr;
  return json.dump(2) + "\n";
}

}  // namespace wayfare::examples
