// Records several devices. Ends on SIGINT, SIGTERM, or the remote command T.

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/logger/logger.hpp>

#include "set_right.hpp"
#include "support/command_line.hpp"
#include "support/json_object.hpp"

namespace {

using namespace wayfare;
using namespace std::chrono_literals;

using Json = nlohmann::ordered_json;
using logger::ModemLine;

/// Sets an option; returns what is wrong with the value, or nothing.
using Setter = std::function<std::optional<std::string>(const Json&)>;
using Setters = std::map<std::string, Setter>;

Setter text(std::string& to) {
  return [&](const Json& v) -> std::optional<std::string> {
    if (!v.is_string()) return "must be a string";
    to = v.get<std::string>();
    return std::nullopt;
  };
}

Setter number(double least, double most, std::function<void(double)> set) {
  return [least, most, set = std::move(set)](const Json& v) -> std::optional<std::string> {
    const double x = v.is_number() ? v.get<double>() : std::nan("");
    if (!(x >= least && x <= most))
      return "must be a number from " + Json(least).dump() + " to " + Json(most).dump();
    set(x);
    return std::nullopt;
  };
}

Setter duration(double least_s, Duration& to) {
  return number(least_s, 3600.0, [&](double s) { to = from_seconds(s); });
}

Setter rate(int& to) {
  return number(50.0, 1e7, [&](double x) { to = static_cast<int>(x); });
}

std::optional<std::string> set_dtr(const Json& v, ModemLine& to) {
  const std::map<std::string, ModemLine> lines = {
      {"keep", ModemLine::keep}, {"on", ModemLine::on}, {"off", ModemLine::off}};
  const auto line = lines.find(v.is_string() ? v.get<std::string>() : "");
  if (line == lines.end()) return "must be keep, on or off";
  to = line->second;
  return std::nullopt;
}

/// Pairs of hexadecimal digits, separated by spaces.
std::optional<std::string> set_bytes(const Json& v, std::vector<std::uint8_t>& to) {
  std::string digits;
  for (const char c : v.is_string() ? v.get<std::string>() : std::string("?"))
    if (c != ' ') digits += c;
  if (digits.size() % 2 != 0 || digits.find_first_not_of("0123456789abcdefABCDEF") != digits.npos)
    return "must be bytes in hexadecimal, such as \"A5 20\"";
  for (std::size_t i = 0; i < digits.size(); i += 2)
    to.push_back(static_cast<std::uint8_t>(std::stoi(digits.substr(i, 2), nullptr, 16)));
  return std::nullopt;
}

/// Position in metres, then yaw, pitch and roll in degrees, applied in this order.
std::optional<std::string> set_mounting(const Json& v, std::optional<SE3d>& to) {
  const bool six = v.is_array() && v.size() == 6 &&
                   std::all_of(v.begin(), v.end(), [](const Json& x) { return x.is_number(); });
  if (!six) return "must be [x, y, z, yaw_deg, pitch_deg, roll_deg]";
  Eigen::Matrix<double, 6, 1> n;
  for (int i = 0; i < 6; ++i) n[i] = v[static_cast<std::size_t>(i)].get<double>();
  const auto turn = [&](int i, const Eigen::Vector3d& axis) {
    return SO3d::exp(Angle::degrees(n[i]).radians() * axis);
  };
  to = SE3d(n.head<3>(), turn(3, Eigen::Vector3d::UnitZ()) * turn(4, Eigen::Vector3d::UnitY()) *
                             turn(5, Eigen::Vector3d::UnitX()));
  return std::nullopt;
}

/// Calls the setter of each key of `json`.
Result<void> apply(const Json& json, const Setters& setters, const std::string& where,
                   const std::string& path) {
  if (!json.is_object()) return Error{ErrorCode::parse, "expected a JSON object" + where, path};
  for (const auto& [key, value] : json.items()) {
    const auto setter = setters.find(key);
    if (setter == setters.end())
      return Error{ErrorCode::parse, "unknown option '" + key + "'" + where, path};
    if (const auto wrong = setter->second(value))
      return Error{ErrorCode::parse, "option '" + key + "'" + where + " " + *wrong, path};
  }
  return {};
}

Result<logger::SensorOptions> read_sensor(const Json& json, const std::string& path) {
  logger::SensorOptions s;
  std::string file;
  const auto done = apply(json,
                          {{"name", text(s.device.name)},
                           {"kind", text(s.device.kind)},
                           {"port", text(s.port)},
                           {"baud", rate(s.device.baud)},
                           {"configuration", text(file)},
                           {"command_port", text(s.command_port)},
                           {"mounting", [&](const Json& v) { return set_mounting(v, s.mounting); }},
                           {"dtr", [&](const Json& v) { return set_dtr(v, s.dtr); }},
                           {"mode", text(s.mode)},
                           {"request", [&](const Json& v) { return set_bytes(v, s.request); }}},
                          " of a sensor", path);
  if (!done) return done.error();
  if (s.device.name.find_first_of("/ ") != std::string::npos)
    return Error{ErrorCode::parse, "a sensor's name must not contain spaces or slashes", path};
  if (s.port.empty())
    return Error{ErrorCode::parse, "sensor " + s.device.name + " needs a port", path};
  if (file.empty()) return s;
  const auto folder = std::filesystem::path(path).parent_path();
  const auto content = io::read_file((folder / file).string());
  if (!content) return content.error();
  s.device.configuration = content->bytes;
  return s;
}

/// A logger's options from a JSON file, as docs/how-to/logger.md describes it. Configuration files
/// of sensors are relative to its folder. Errors: not JSON, an unknown key, a value out of range.
Result<logger::LoggerOptions> read_logger_config(const std::string& path) {
  const auto file = io::read_file(path);
  if (!file) return file.error();
  const auto json = examples::parse_json_object<Json>(file->bytes, path);
  if (!json) return json.error();
  logger::LoggerOptions o;
  Json sensors;
  const auto control = [&](const Json& v) -> std::optional<std::string> {
    const auto done = apply(v,
                            {{"port", text(o.control_port)},
                             {"baud", rate(o.control_baud)},
                             {"socket", text(o.control_socket)}},
                            " of control", path);
    return done ? std::nullopt : std::optional(done.error().message);
  };
  const auto done = apply(
      *json,
      {{"folder", text(o.folder)},
       {"prefix", text(o.prefix)},
       {"base_frame", text(o.base_frame)},
       {"flush_s", duration(0.001, o.flush_every)},
       {"sync_s", duration(0.0, o.sync_every)},
       {"rotate_mb",
        number(0.0, 1e9,
               [&](double mb) { o.rotate_bytes = static_cast<std::uint64_t>(mb * 1e6); })},
       {"rotate_min",
        number(0.0, 1e6, [&](double min) { o.rotate_every = from_seconds(60.0 * min); })},
       {"queue_mb", number(0.01, 16384.0,
                           [&](double mb) { o.queue_bytes = static_cast<std::size_t>(mb * 1e6); })},
       {"control", control},
       {"sensors",
        [&](const Json& v) -> std::optional<std::string> {
          if (!v.is_array()) return "must be a list";
          sensors = v;
          return std::nullopt;
        }}},
      "", path);
  if (!done) return done.error();
  for (const Json& s : sensors) {
    auto sensor = read_sensor(s, path);
    if (!sensor) return sensor.error();
    o.sensors.push_back(std::move(*sensor));
  }
  return o;
}

/// An example for the three supported devices.
std::string example_logger_config() {
  return R"({
  "folder": "recordings",
  "prefix": "walk",
  "flush_s": 0.1,
  "sync_s": 1.0,
  "queue_mb": 64,
  "control": {"port": "/dev/ttyUSB2", "baud": 57600, "socket": "logger.sock"},
  "sensors": [
    {"name": "radar", "kind": "ti_mmwave", "port": "/dev/ttyACM1", "baud": 921600},
    {"name": "lidar", "kind": "rplidar", "port": "/dev/ttyUSB0", "baud": 115200,
     "mode": "typical", "mounting": [0.1, 0.0, 0.3, 180.0, 0.0, 0.0]},
    {"name": "imu", "kind": "xsens", "port": "/dev/ttyUSB1", "baud": 115200}
  ]
}
)";
}

volatile std::sig_atomic_t end_requested = 0;

/// Prints warnings, and why a recording failed, on the standard error, each when it begins.
class Warnings {
 public:
  void print(const logger::LoggerStatus& s) {
    print("recording", s.error.empty() ? s.warning : s.error);
    for (const logger::SensorStatus& sensor : s.sensors) print(sensor.name, sensor.warning);
  }

 private:
  void print(const std::string& name, const std::string& warning) {
    std::string kind = warning;  // without its numbers
    std::erase_if(kind, [](char c) { return c >= '0' && c <= '9'; });
    if (std::exchange(told_[name], kind) == kind || warning.empty()) return;
    std::fprintf(stderr, "logger: warning: %s: %s\n", name.c_str(), warning.c_str());
  }

  std::map<std::string, std::string> told_;
};

struct Arguments {
  std::string config;
  bool record = false;
  bool quiet = false;
  examples::SetRight set_right;
};

void print(const logger::LoggerStatus& s) {
  std::printf("%-10s %8.1f s %10.3f MB  %llu dropped", logger::name_of(s.state), s.seconds,
              static_cast<double>(s.written) * 1e-6, static_cast<unsigned long long>(s.dropped));
  for (const logger::SensorStatus& sensor : s.sensors)
    std::printf("  | %s %s %.1f kB/s %s", sensor.name.c_str(), logger::name_of(sensor.state),
                sensor.bytes_per_s * 1e-3, sensor.decoding.sample.c_str());
  if (!s.error.empty()) std::printf("  | %s", s.error.c_str());
  std::printf("\n");
  std::fflush(stdout);
}

Result<void> run(const Arguments& a) {
  if (!a.set_right.files.empty()) return examples::set_right(a.set_right);
  if (a.config.empty()) return examples::bad_use("--config is required");
  auto options = read_logger_config(a.config);
  if (!options) return options.error();
  std::error_code code;
  std::filesystem::create_directories(options->folder, code);
  auto started = logger::Logger::start(std::move(*options));
  if (!started) return started.error();
  logger::Logger& logger = **started;
  if (a.record)
    if (auto begun = logger.begin(); !begun) return begun;
  Warnings warnings;
  for (int tick = 1; logger.status().state != logger::LoggerState::terminated; ++tick) {
    std::this_thread::sleep_for(50ms);
    if (end_requested != 0) logger.terminate();
    if (tick % 20 != 0) continue;
    const logger::LoggerStatus status = logger.status();
    if (!a.quiet) print(status);
    warnings.print(status);
  }
  const logger::LoggerStatus end = logger.status();
  if (!a.quiet) print(end);
  if (!a.quiet && !end.file.empty())
    std::printf(
        "recording: %s%s\n", end.file.c_str(),
        end.files > 1 ? (", the last of " + std::to_string(end.files) + " files").c_str() : "");
  if (!end.error.empty()) return Error{ErrorCode::io, end.error};
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  examples::CommandLine app(
      "Record several devices into one MCAP file: their bytes and the decoded messages. Begins on "
      "the remote command B, or immediately with --record.");
  Arguments a;
  app.add_file("--config", a.config, "JSON file of sensors and options; see --print-config");
  app.add_flag("--record", a.record, "begin to record immediately");
  app.add_flag("--quiet", a.quiet, "print no progress: no status on the terminal");
  app.add_print(
      "--print-config", [] { return example_logger_config(); },
      "print an example of --config, and exit");
  app.add_file("--set-right", a.set_right.files,
               "recordings of one run of the logger: shows how the computer's clock was set, and "
               "with --out writes copies with stamps by that clock, instead of recording")
      .take_all()
      .excludes("--config");
  app.add_option("--out", a.set_right.out, "folder of the copies")
      .shown_as("DIR")
      .needs("--set-right");
  app.add_option("--reading", a.set_right.reading,
                 "number of the reading of the clock that is right; by default the last one")
      .range(1, 1'000'000)
      .needs("--out");
  app.example("--config sensors.json --record", "records at once; Ctrl-C ends");
  app.example("--set-right walk-20260501T120000Z.mcap --out right",
              "a copy whose stamps are by the clock as it was set last");
  if (const auto code = app.parse(argc, argv)) return *code;
  const auto end = [](int) { end_requested = 1; };
  std::signal(SIGINT, end);
  std::signal(SIGTERM, end);
  // A file-size limit and a disconnected listener are reported as errors of the write.
  std::signal(SIGXFSZ, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
  return examples::exit_code("logger", run(a));
}
