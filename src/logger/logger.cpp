#include <atomic>
#include <filesystem>
#include <set>
#include <system_error>
#include <thread>
#include <utility>

#include <wayfare/logger/logger.hpp>
#include <wayfare/logger/messages.hpp>

#include "logger/control_line.hpp"
#include "logger/recorder.hpp"
#include "logger/sensor.hpp"

namespace wayfare::logger {
namespace {

using std::chrono::milliseconds;

Result<void> check(const LoggerOptions& options) {
  std::set<std::string> names = {"logger"};
  if (options.sensors.empty()) return Error{ErrorCode::invalid, "a logger needs a sensor"};
  for (const SensorOptions& s : options.sensors) {
    if (s.device.name.empty() || !names.insert(s.device.name).second)
      return Error{ErrorCode::invalid, "a sensor's name is empty or taken", s.device.name};
    if (s.device.baud <= 0) return Error{ErrorCode::invalid, "needs a baud rate", s.device.name};
  }
  const Duration least = milliseconds(1);
  if (options.flush_every < least || options.sync_every < Duration(0) ||
      options.status_every < least)
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
      : options(std::move(given)), recorder(options, clock), control(std::move(control_line)) {}
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
    return status;
  }

  Result<void> begin() {
    io::McapMetadata about = {{"sensors", std::to_string(options.sensors.size())},
                              {"clock", "monotonic, set to UTC when the logger started"}};
    for (const SensorOptions& s : options.sensors) about["sensor " + s.device.name] = s.device.kind;
    return recorder.begin(about);
  }

  void obey(Command command) {
    // A failure is in the status.
    if (command == Command::begin) static_cast<void>(begin());
    if (command == Command::stop) recorder.stop();
    if (command == Command::terminate) recorder.terminate();
    report = true;
  }

  void coordinate() {
    LogTime last = clock.now();
    while (!quit) {
      control.poll(milliseconds(20), [&](Command command) { obey(command); });
      const LogTime now = clock.now();
      const bool due = now - last >= options.status_every;
      if (due) {
        for (const auto& sensor : sensors) sensor->measure_rates(now - last);
        last = now;
      }
      if (due || report) tell(due);
      report = false;
    }
  }

  void tell(bool record) {
    const LoggerStatus now = status();
    std::string json = to_json(now);
    control.send(status_line(json));
    // It may be dropped where the queue is full: the next one counts what was dropped.
    if (record)
      recorder.add(recorder.session(),
                   {sensors.size(), false, stream, now.time, now.time, std::move(json)});
  }

  const LoggerOptions options;
  const LoggerClock clock;
  Recorder recorder;
  std::vector<std::unique_ptr<Sensor>> sensors;
  ControlLine control;
  std::atomic<bool> quit{false};
  bool report = false;  ///< of the coordinating thread
  const std::shared_ptr<const Stream> stream = std::make_shared<const Stream>(
      Stream{"/logger/status", "json", "wayfare.LoggerStatus", std::string(kStatusSchema), {}});
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
    impl->sensors.push_back(std::make_unique<Sensor>(
        i, impl->options.sensors[i], std::move(decoders[i]), impl->recorder, impl->clock));
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
