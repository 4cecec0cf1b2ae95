// Replays a recording, or captures of devices, in real time: to pseudo-terminals in place of the
// devices, or to a system of the library.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include <wayfare/io/mcap.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/logger/device_decoder.hpp>
#include <wayfare/logger/messages.hpp>
#include <wayfare/pedestrian/pedestrian.hpp>
#include <wayfare/slam/graph_slam.hpp>

#include "support/command_line.hpp"
#include "support/truth.hpp"

namespace {

using namespace wayfare;
namespace fs = std::filesystem;

using Clock = std::chrono::steady_clock;

std::atomic<bool> stopped{false};

struct Arguments {
  std::string recording, ptys;
  std::vector<std::string> captures;
  std::string system;  ///< pedestrian or graph_slam; empty: by the recording's sensors
  std::string topic;   ///< of the inertial unit, if there are several
  double speed = 1.0;  ///< times real time
  double seconds = 0.0, wait_s = 0.0;
  examples::TruthOptions truth;
};

/// Waits in steps, to end early once the program is to stop; false if it is.
bool wait_until(Clock::time_point due) {
  while (!stopped && Clock::now() < due)
    std::this_thread::sleep_until(std::min(due, Clock::now() + std::chrono::milliseconds(50)));
  return !stopped;
}

/// Waits until each measurement is due.
class Pace {
 public:
  Pace(LogTime first, double speed) : first_(first), speed_(speed) {}

  /// Waits until `time`; returns the time since the first, or nothing if the program is to stop.
  [[nodiscard]] std::optional<double> until(LogTime time) const {
    const double since_s = to_seconds(time - first_);
    return wait_until(begin_ + from_seconds(since_s / speed_)) ? std::optional(since_s)
                                                               : std::nullopt;
  }

 private:
  LogTime first_;
  double speed_;
  Clock::time_point begin_ = Clock::now();
};

/// A device's bytes and their times.
struct Device {
  std::string name;
  std::string bytes;
  std::vector<logger::TimedBytes> stream;
};

decode::Bytes view(const std::string& s) {
  return {reinterpret_cast<const std::uint8_t*>(s.data()), s.size()};
}

/// NAME:BYTES_PER_SECOND:FILE, repeated for `seconds`.
Result<std::unique_ptr<Device>> capture(const std::string& text, double seconds) {
  const Error wrong = examples::bad_use(text + ": is not NAME:BYTES_PER_SECOND:FILE");
  const auto first = text.find(':');
  const auto second = first == text.npos ? first : text.find(':', first + 1);
  if (second == text.npos || first == 0) return wrong;
  const double rate = std::atof(text.substr(first + 1, second - first - 1).c_str());
  if (!(rate >= 1.0 && rate <= 1e9)) return wrong;
  const auto file = io::read_file(text.substr(second + 1));
  if (!file) return file.error();
  if (file->bytes.empty()) return Error{ErrorCode::invalid, "is empty", text};
  auto device = std::make_unique<Device>(Device{text.substr(0, first), file->bytes, {}});
  if (seconds > 0.0) {
    const auto n = static_cast<std::size_t>(rate * seconds);
    while (device->bytes.size() < n) device->bytes += file->bytes;
    device->bytes.resize(n);
  }
  device->stream = logger::at_rate(view(device->bytes), rate);
  return device;
}

/// The raw channels of a recording.
Result<std::vector<std::unique_ptr<Device>>> recorded(const std::string& path) {
  const auto reader = io::McapReader::open(path);
  if (!reader) return reader.error();
  std::vector<std::unique_ptr<Device>> devices;
  const LogTime begin = reader->contents().statistics.first;
  for (const io::McapChannel& channel : reader->contents().channels) {
    constexpr std::string_view kEnd = "/raw";
    if (!channel.topic.ends_with(kEnd) || channel.topic.size() < kEnd.size() + 2) continue;
    auto device = std::make_unique<Device>();
    device->name = channel.topic.substr(1, channel.topic.size() - kEnd.size() - 1);
    std::replace(device->name.begin(), device->name.end(), '/', '_');
    std::vector<std::pair<Duration, std::size_t>> pieces;
    reader->read({io::McapOrder::file, {channel.topic}}, [&](const io::McapMessage& m) {
      device->bytes += m.data;
      pieces.emplace_back(m.log_time - begin, m.data.size());
      return true;
    });
    std::size_t at = 0;
    for (const auto& [time, n] : pieces) {
      device->stream.push_back({time, view(device->bytes).subspan(at, n)});
      at += n;
    }
    devices.push_back(std::move(device));
  }
  if (devices.empty()) return Error{ErrorCode::not_found, "contains no raw channel", path};
  return devices;
}

/// Data that are not read before the terminal is closed are lost: waits until half a second after
/// they are read, five seconds at most.
void wait_until_read(const std::vector<logger::PseudoTerminal>& terminals) {
  for (int i = 0, read = 0; i < 100 && read < 10 && !stopped; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    const bool all = std::all_of(terminals.begin(), terminals.end(),
                                 [](const auto& t) { return t.unread() == 0; });
    read = all ? read + 1 : 0;
  }
}

Result<void> into_terminals(const Arguments& a,
                            const std::vector<std::unique_ptr<Device>>& devices) {
  std::error_code code;
  fs::create_directories(a.ptys, code);
  if (code) return Error{ErrorCode::io, "cannot be created: " + code.message(), a.ptys};
  std::vector<logger::PseudoTerminal> terminals;
  for (const auto& device : devices) {
    auto terminal = logger::PseudoTerminal::open();
    if (!terminal) return terminal.error();
    const fs::path link = fs::path(a.ptys) / device->name;
    if (fs::is_symlink(link)) fs::remove(link, code);
    fs::create_symlink(terminal->path(), link, code);
    if (code) return Error{ErrorCode::io, "cannot be created: " + code.message(), link.string()};
    std::printf("%s\n", link.c_str());
    terminals.push_back(std::move(*terminal));
  }
  std::fflush(stdout);
  wait_until(Clock::now() + from_seconds(a.wait_s));
  std::vector<std::thread> threads;
  std::vector<std::optional<Result<std::uint64_t>>> done(devices.size());
  for (std::size_t i = 0; i < devices.size(); ++i)
    threads.emplace_back(
        [&, i] { done[i] = logger::play(terminals[i], devices[i]->stream, a.speed, stopped); });
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < devices.size(); ++i) {
    if (!*done[i]) return done[i]->error();
    std::printf("%s: %llu of %zu bytes\n", devices[i]->name.c_str(),
                static_cast<unsigned long long>(**done[i]), devices[i]->bytes.size());
  }
  std::fflush(stdout);
  wait_until_read(terminals);
  for (const auto& device : devices) fs::remove(fs::path(a.ptys) / device->name, code);
  return {};
}

void print(double t_s, const SE2d& pose) {
  std::printf("%10.3f s  x %8.2f m  y %8.2f m  heading %7.1f deg\n", t_s, pose.x(), pose.y(),
              pose.heading().degrees());
}

Trajectory walk(const MargRecording& samples, double speed) {
  Pedestrian pedestrian{PedestrianParameters{}};
  Trajectory steps;
  const Pace pace(samples.front().time, speed);
  for (const MargSample& sample : samples) {
    const auto t_s = pace.until(sample.time);
    if (!t_s) break;
    pedestrian.add(sample, [&](const PedestrianPose& p) {
      const SE2d pose(p.position_m.x(), p.position_m.y(), p.heading);
      steps.push_back({p.time, Transform2<frame::Map, frame::Base>(pose)});
      print(*t_s, pose);
    });
  }
  std::printf("%zu samples, %zu steps\n", samples.size(),
              static_cast<std::size_t>(pedestrian.report().steps));
  return steps;
}

Result<Trajectory> map(const std::vector<LaserScan>& scans, double speed) {
  GraphSlam slam;
  const Pace pace(scans.front().time, speed);
  for (const LaserScan& scan : scans) {
    const auto t_s = pace.until(scan.time);
    if (!t_s) break;
    const auto outcome = slam.add_scan(scan, std::nullopt);
    if (outcome) {
      print(*t_s, outcome->T_map_base.raw());
    } else {
      std::fprintf(stderr, "refused: %s\n", outcome.error().to_string().c_str());
    }
  }
  if (auto done = slam.finish(); !done) return done.error();
  std::printf("%zu scans, %zu loop closures\n", slam.statistics().scans,
              slam.statistics().loop_closures);
  return slam.trajectory();
}

/// True poses of --truth for measurements at these times, then the system's run against them.
template <class Measurements, class Run>
Result<void> compared(const Arguments& a, const Measurements& measurements, const Run& run) {
  std::vector<LogTime> times;
  for (const auto& m : measurements) times.push_back(m.time);
  const auto truth = a.truth.read(a.recording, {}, times, {});
  if (!truth) return truth.error();
  const Result<Trajectory> poses = run(measurements, a.speed);
  if (!poses) return poses.error();
  const auto errors = examples::compare(*truth, {{"replayed", *poses}});
  std::fputs(examples::to_text(examples::error_tables(*truth, errors)).c_str(), stdout);
  return {};
}

/// Passes a recording's measurements to a system in real time and prints its poses.
Result<void> into_system(const Arguments& a) {
  if (a.system != "graph_slam") {
    const auto logged = logger::read_marg_recording(a.recording, a.topic);
    if (logged && !logged->samples.empty()) return compared(a, logged->samples, walk);
    const bool other = a.system.empty() && a.topic.empty() &&
                       (logged || logged.error().code == ErrorCode::not_found);
    if (!other)
      return logged ? Error{ErrorCode::not_found, "contains no sample", a.recording}
                    : logged.error();
  }
  const auto robot = logger::read_robot_recording(a.recording);
  if (!robot) return robot.error();
  if (robot->recording.scans.empty())
    return Error{ErrorCode::not_found, "contains no laser scan", a.recording};
  return compared(a, robot->recording.scans, map);
}

Result<void> run(const Arguments& a) {
  if (a.ptys.empty() && a.recording.empty())
    return examples::bad_use("needs a recording, or --capture and --ptys");
  if (a.ptys.empty()) return into_system(a);
  std::vector<std::unique_ptr<Device>> devices;
  if (!a.recording.empty()) {
    auto found = recorded(a.recording);
    if (!found) return found.error();
    devices = std::move(*found);
  }
  for (const std::string& text : a.captures) {
    auto device = capture(text, a.seconds);
    if (!device) return device.error();
    devices.push_back(std::move(*device));
  }
  if (devices.empty()) return examples::bad_use("needs a recording or --capture");
  return into_terminals(a, devices);
}

}  // namespace

int main(int argc, char** argv) {
  examples::CommandLine app(
      "Replay a logger's recording in real time: with --ptys the devices' bytes, to "
      "pseudo-terminals that a logger can open in their place; else the inertial unit to "
      "pedestrian dead reckoning, or the scans to graph SLAM.");
  Arguments a;
  app.add_file("RECORDING", a.recording, "a logger's recording (.mcap)");
  app.add_option("--ptys", a.ptys, "folder for links to the pseudo-terminals, one per device")
      .shown_as("DIR");
  app.add_option("--capture", a.captures,
                 "NAME:BYTES_PER_SECOND:FILE, a device's bytes instead of a recording; repeatable");
  app.add_option("--seconds", a.seconds, "duration to which captures are repeated, at real speed")
      .not_negative();
  app.add_number("--speed", a.speed, 1e-3, 1e6, "speed, times real time");
  app.add_option("--wait", a.wait_s, "seconds before the first byte").not_negative();
  app.add_option("--system", a.system,
                 "system to run; by default the one for which the recording has the sensor")
      .one_of({"pedestrian", "graph_slam"});
  a.truth.add_options(app);
  app.add_option("--topic", a.topic, "of the unit, in a recording (.mcap, .bag) of several units");
  app.example("recording.mcap --ptys lines",
              "the devices' bytes on pseudo-terminals in the folder");
  app.example("recording.mcap --system graph_slam", "the scans to graph SLAM, in real time");
  if (const auto code = app.parse(argc, argv)) return *code;
  std::signal(SIGINT, [](int) { stopped = true; });
  std::signal(SIGTERM, [](int) { stopped = true; });
  return examples::exit_code("replay", run(a));
}
