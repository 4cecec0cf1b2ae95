#include "nav_config.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <optional>
#include <string_view>

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

Key vector(const std::string& name, Eigen::Vector3d& value) {
  return {name,
          [&value](const Json& j) {
            const auto v = three(j);
            if (v) value = *v;
            return v.has_value();
          },
          [&value] { return json_of(value); }, "three numbers"};
}

Key mounting(SO3d& q_body_imu) {
  return {"mounting_deg",
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
          number("start_heading_sigma_deg", o.start_heading_sigma_rad, kDegree)};
}

std::vector<Key> general_keys(NavConfig& c) {
  return {mounting(c.filter.q_body_imu),
          vector("antenna_lever_arm_m", c.filter.antenna_lever_arm_m),
          number("imu_time_offset_s", c.filter.imu_time_offset_s, 1.0, -1e6),
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

namespace {

/// Other observations may bring their navigation messages.
bool is_rinex(const std::string& path) {
  if (path.empty()) return false;
  const auto file = io::read_file(path);
  return file && file->bytes.substr(0, 81).find("RINEX") != std::string::npos;
}

}  // namespace

Result<io::NavRecording> load_nav_recording(const NavFiles& files, const NavConfig& config,
                                            const std::function<void(double)>& progress) {
  if (files.observations.empty() && files.ranges.empty() && files.fixes.empty())
    return bad_use("satellite measurements are needed: --obs and --nav, --ranges, or --fixes");
  if (files.ranges.empty() && files.navigation.empty() && is_rinex(files.observations))
    return bad_use("raw observations need a navigation file (--nav)");
  const auto imu = [&](const std::string& path, const io::ColumnFormat& format) {
    return ros::read_imu(path, format, files.topics);
  };
  const auto fixes = [&](const std::string& path, const io::ColumnFormat& format) {
    return ros::read_fixes(path, format, files.topics);
  };
  return io::read_nav_recording(files, config, {progress, print_problems, imu, fixes});
}

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
  return json.dump(2) + "\n";
}

}  // namespace wayfare::examples
