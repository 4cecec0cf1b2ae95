#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include <wayfare/logger/device_messages.hpp>
#include <wayfare/logger/logger.hpp>
#include <wayfare/logger/serial_port.hpp>

#include "logger/control_line.hpp"
#include "logger/disk_watch.hpp"
#include "logger/recorder.hpp"
#include "logger/sensor.hpp"

namespace wayfare::logger {
namespace {

using std::chrono::milliseconds;

/// Each line has one reader: no other program, sensor or remote control.
Result<void> check_ports(const LoggerOptions& options) {
  std::map<std::string, std::string> users;  // of the device that a path leads to
  const auto add = [&](const std::string& port, const std::string& user) -> Result<void> {
    std::error_code code;
    const auto real = std::filesystem::canonical(port, code);
    const auto [other, is_new] = users.emplace(code ? port : real.string(), user);
    if (!is_new)
      return Error{ErrorCode::invalid, "is the port of " + other->second + " and of " + user, port};
    if (const auto process = process_of_line(port))
      return Error{ErrorCode::io, "is in use by process " + std::to_string(*process), port};
    return {};
  };
  for (const SensorOptions& s : options.sensors)
    if (auto added = add(s.port, s.device.name); !added) return added;
  return options.control_port.empty() ? Result<void>() : add(options.control_port, "the control");
}

Result<void> check(const LoggerOptions& options) {
  std::set<std::string> names = {"logger"};
  if (options.sensors.empty()) return Error{ErrorCode::invalid, "a logger needs a sensor"};
  for (const SensorOptions& s : options.sensors) {
    if (s.device.name.empty() || !names.insert(s.device.name).second)
      return Error{ErrorCode::invalid, "a sensor's name is empty or taken", s.device.name};
    if (s.device.baud <= 0) return Error{ErrorCode::invalid, "needs a baud rate", s.device.name};
    if (s.mode != SensorOptions{}.mode && s.device.kind != "rplidar")
      return Error{ErrorCode::invalid, "has no scan modes: it is no rplidar", s.device.name};
  }
  if (auto sound = check_ports(options); !sound) return sound;
  const Duration least = milliseconds(1);
  if (options.flush_every < least || options.sync_every < Duration(0) ||
      options.status_every < least || options.warn_after < least)
    return Error{ErrorCode::invalid, "an interval is too short"};
  return {};
}

constexpr std::string_view kStatusSchema =
    R"({"title":"wayfare.LoggerStatus","type":"object","properties":{"state":{"type":"string"},)"
    R"("file":{"type":"string"},"seconds":{"type":"number"},"written":{"type":"integer"},)"
    R"("dropped":{"type":"integer"},"error":{"type":"string"},"sensors":{"type":"array"}}})";

}  // namespace

struct Logger::Impl {
  explicit Impl(LoggerOptions given, ControlLine control_line)
      : options(std::move(given)),
        recorder(options, clock, [this] { return head(); }),
        control(std::move(control_line)) {}
  ~Impl() {
    quit = true;
    if (thread.joinable()) thread.join();
    recorder.stop();
  }

  [[nodiscard]] LoggerStatus status() const {
    LoggerStatus status;
    const std::vector<Tally> tallies = recorder.fill(status);
    for (std::size_t i = 0; i < sensors.size(); ++i) {
      status.sensors.push_back(sensors[i]->status());
      status.sensors.back().recorded_bytes = tallies[i].raw_bytes;
      status.sensors.back().dropped = tallies[i].dropped;
      status.dropped += tallies[i].dropped;
    }
    const std::lock_guard lock(disk_mutex);
    if (status.state == LoggerState::recording && !full_soon.empty())
      status.warning += (status.warning.empty() ? "" : "; ") + full_soon;
    return status;
  }

  Result<void> begin() {
    io::McapMetadata about = {{"sensors", std::to_string(options.sensors.size())},
                              {"clock", "monotonic, set to UTC when the logger started"},
                              {"run", run}};
    for (const SensorOptions& s : options.sensors) about["sensor " + s.device.name] = s.device.kind;
    return recorder.begin(about);
  }

  /// The messages with which every file begins.
  [[nodiscard]] std::vector<LoggedMessage> head() const {
    std::vector<LoggedMessage> messages{message_of(clock.read())};
    std::vector<Mounting> mountings;
    for (const SensorOptions& s : options.sensors)
      if (s.mounting) mountings.push_back({options.base_frame, s.device.name, *s.mounting});
    const LogTime now = messages.front().published;
    if (!mountings.empty())
      messages.push_back(
          {options.sensors.size(), false, transforms, now, now, transforms_json(mountings, now)});
    return messages;
  }
  [[nodiscard]] LoggedMessage message_of(const ClockReading& reading) const {
    return {options.sensors.size(), false,         clock_stream,
            reading.stamp,          reading.stamp, clock_reading_json(reading)};
  }

  void obey(Command command) {
    // A failure is in the status.
    if (command == Command::begin) static_cast<void>(begin());
    if (command == Command::stop) recorder.stop();
    if (command == Command::terminate) recorder.terminate();
    report = true;
  }

  void coordinate() {
    constexpr milliseconds kPoll(20);
    LogTime last = clock.now(), answered = last - kPoll;
    ClockWatch watch(clock);
    while (!quit) {
      if (const auto correction = watch.correction())
        recorder.add(recorder.session(), message_of(*correction), true);
      control.poll(kPoll, [&](Command command) { obey(command); });
      const LogTime now = clock.now();
      const bool due = now - last >= options.status_every;
      if (due) {
        for (const auto& sensor : sensors) sensor->measure_rates(now - last);
        last = now;
      }
      // One client's flood of commands must not fill the lines of the others.
      const bool answer = report && now - answered >= kPoll;
      if (due || answer) tell(due);
      if (!answer) continue;
      answered = now;
      report = false;
    }
  }

  /// Words for a disk that is full soon.
  void watch_disk(const LoggerStatus& now) {
    disk.add(now.time, now.written, now.disk_free);
    const auto left_s = disk.seconds_left();
    const bool soon = left_s && *left_s <= to_seconds(options.warn_disk);
    std::array<char, 80> text{};
    if (soon)
      std::snprintf(text.data(), text.size(), "the disk is full in %.0f min at %.2f MB/s",
                    *left_s / 60.0, *disk.rate() * 1e-6);
    const std::lock_guard lock(disk_mutex);
    full_soon = text.data();
  }

  void tell(bool record) {
    LoggerStatus now = status();
    if (record) watch_disk(now);
    control.send(status_line(to_json(now)));
    if (!record) return;
    // The recording has all measurements.
    for (SensorStatus& sensor : now.sensors) sensor.decoding.latest.clear();
    // It may be dropped where the queue is full: the next one counts what was dropped.
    recorder.add(recorder.session(),
                 {sensors.size(), false, stream, now.time, now.time, to_json(now)});
  }

  const LoggerOptions options;
  const LoggerClock clock{options.wall_clock};
  /// Which files have one clock.
  const std::string run =
      std::to_string(clock.now().nanoseconds()) + "-" + std::to_string(::getpid());
  const std::shared_ptr<const Stream> stream = std::make_shared<const Stream>(
      Stream{"/logger/status", "json", "wayfare.LoggerStatus", std::string(kStatusSchema), {}});
  const std::shared_ptr<const Stream> clock_stream =
      std::make_shared<const Stream>(Stream{std::string(kClockTopic),
                                            "json",
                                            std::string(clock_reading_schema().name),
                                            std::string(clock_reading_schema().json),
                                            {}});
  const std::shared_ptr<const Stream> transforms =
      std::make_shared<const Stream>(Stream{"/tf_static",
                                            "json",
                                            std::string(transforms_schema().name),
                                            std::string(transforms_schema().json),
                                            {}});
  Recorder recorder;
  std::vector<std::unique_ptr<Sensor>> sensors;
  ControlLine control;
  std::atomic<bool> quit{false};
  bool report = false;  ///< of the coordinating thread
  DiskWatch disk;       ///< of the coordinating thread
  mutable std::mutex disk_mutex;
  std::string full_soon;
  std::thread thread;
};

Logger::Logger(detail::Owned<Impl> impl) : impl_(std::move(impl)) {}

Result<std::unique_ptr<Logger>> Logger::start(LoggerOptions options) {
  if (auto sound = check(options); !sound) return sound.error();
  // Absolute, since readers of the status may be in another folder.
  std::error_code code;
  const auto folder = std::filesystem::absolute(options.folder, code);
  if (!code) options.folder = folder.lexically_normal().string();
  std::vector<std::unique_ptr<DeviceDecoder>> decoders;
  for (const SensorOptions& s : options.sensors) {
    auto decoder = make_decoder(s.device);
    if (!decoder) return decoder.error();
    decoders.push_back(std::move(*decoder));
  }
  auto control =
      ControlLine::open(options.control_port, options.control_baud, options.control_socket);
  if (!control) return control.error();
  auto impl = detail::make_owned<Impl>(std::move(options), std::move(*control));
  for (std::size_t i = 0; i < decoders.size(); ++i)
    impl->sensors.push_back(std::make_unique<Sensor>(i, impl->options, std::move(decoders[i]),
                                                     impl->recorder, impl->clock));
  impl->thread = std::thread([raw = impl.get()] { raw->coordinate(); });
  return std::unique_ptr<Logger>(new Logger(std::move(impl)));
}

Result<void> Logger::begin() { return impl_->begin(); }
void Logger::stop() { impl_->recorder.stop(); }
void Logger::terminate() { impl_->recorder.terminate(); }
LoggerStatus Logger::status() const { return impl_->status(); }
bool Logger::wait_until_stopped(Duration timeout) {
  return impl_->recorder.wait_until_stopped(timeout);
}

}  // namespace wayfare::logger
