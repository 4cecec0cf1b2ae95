#include "nav_config.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include <wayfare/io/text_file.hpp>

#include "command_line.hpp"
#include "json_object.hpp"
#include "nav_keys.hpp"
#include "program_files.hpp"

namespace wayfare::examples {
namespace {

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
  if (c.filter.odometer) fill(json["odometer"], odometer_keys(*c.filter.odometer));
  if (c.filter.carrier_phase)
    fill(json["carrier_phase"], carrier_phase_keys(*c.filter.carrier_phase));
}

}  // namespace

Result<NavConfig> parse_nav_config(const std::string& text, const std::string& source) {
  const Reader reader{source};
  const auto json = parse_json_object<Json>(text, source);
  if (!json) return json.error();
  NavConfig c;
  const std::map<std::string, io::NavFileFormat*> files = {{"imu_clock", &c.imu_clock},
                                                           {"ranges", &c.ranges},
                                                           {"fixes", &c.fixes},
                                                           {"wheels", &c.wheels},
                                                           {"truth", &c.truth}};
  for (const auto& [key, value] : json->items()) {
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
    } else if (key == "odometer") {
      if (!value.is_null())
        done = reader.section(odometer_keys(c.filter.odometer.emplace()), key, value);
    } else if (key == "carrier_phase") {
      if (!value.is_null())
        done = reader.section(carrier_phase_keys(c.filter.carrier_phase.emplace()), key, value);
    } else {
      done = reader.take(general_keys(c), key, value);
    }
    if (!done) return done.error();
  }
  return c;
}

Result<void> set_filter_options(const std::vector<std::string>& texts, NavConfig& config) {
  for (const std::string& text : texts) {
    const std::size_t equal = text.find('=');
    const std::string name = text.substr(0, equal);
    const std::vector<Key> keys = filter_keys(config.filter);
    const auto key =
        std::find_if(keys.begin(), keys.end(), [&](const Key& k) { return k.name == name; });
    if (equal == text.npos || key == keys.end())
      return bad_use(
          "--filter must be NAME=VALUE with the name of an option in \"filter\" of "
          "--print-config, not '" +
          text + "'");
    if (!key->set(Json::parse(text.substr(equal + 1), nullptr, false)))
      return bad_use("--filter " + name + ": must be " + key->expected);
  }
  return {};
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
    auto described = parse_json_object<Json>(file->bytes, path);
    if (!described) return described.error();
    json = *std::move(described);
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
  c.filter.odometer.emplace();
  Json json;
  json["imu"] = {{"columns", Json::array()}, {"skip_lines", 0}};
  for (const char* name : {"imu_clock", "ranges", "fixes", "wheels", "truth"})
    json[name] = {{"columns", Json::array()},
                  {"skip_lines", 0},
                  {"leap_seconds", 18},
                  {"velocity_late_s", 0.0}};
  fill_filter(json, c);
  json["start"] = nullptr;
  json["carrier_phase"] = nullptr;
  return json.dump(2) + "\n";
}

}  // namespace wayfare::examples
