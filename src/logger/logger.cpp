#include <algorithm>
#include <array>
#include <atomic>
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

#include "logger/configure.hpp"
#include "logger/control_line.hpp"
#include "logger/recorder.hpp"

namespace wayfare::logger {
namespace {

using std::chrono::milliseconds;

/// One device: a thread that reads its line, stamps and decodes the bytes and queues them.
class Sensor {
 public:
  /// The recorder counts its messages by `number`.
  Sensor(std::size_t number, SensorOptions options, std::unique_ptr<DeviceDecoder> decoder,
         Recorder& recorder, const LoggerClock& clock)
      : number_(number),
        options_(std::move(options)),
        raw_(raw_stream(options_)),
        decoder_(std::move(decoder)),
        recorder_(recorder),
        clock_(clock) {
    status_.name = options_.device.name;
    thread_ = std::thread([this] { run(); });
  }
  Sensor(const Sensor&) = delete;
  Sensor& operator=(const Sensor&) = delete;
  ~Sensor() {
    quit_ = true;
    thread_.join();
  }

  /// Without the recorder's counts.
  [[nodiscard]] SensorStatus status() const {
    const std::lock_guard lock(mutex_);
    SensorStatus status = status_;
    if (status.state == SensorState::receiving && clock_.now() - last_bytes_ > kSilence)
      status.state = SensorState::silent;
    return status;
  }

  /// Rates since the previous call, `interval` ago.
  void measure_rates(Duration interval) {
    const std::lock_guard lock(mutex_);
    const double s = std::max(to_seconds(interval), 1e-3);
    status_.bytes_per_s = static_cast<double>(status_.bytes - bytes_before_) / s;
    status_.messages_per_s = static_cast<double>(status_.decoding.messages - messages_before_) / s;
    bytes_before_ = status_.bytes;
    messages_before_ = status_.decoding.messages;
  }

 private:
  static constexpr Duration kSilence = std::chrono::seconds(2);

  static std::shared_ptr<const Stream> raw_stream(const SensorOptions& sensor) {
    const DeviceDescription& d = sensor.device;
    return std::make_shared<const Stream>(Stream{"/" + d.name + "/raw",
                                                 "application/octet-stream",
                                                 "",
                                                 "",
                                                 {{"kind", d.kind},
                                                  {"port", sensor.port},
                                                  {"baud", std::to_string(d.baud)},
                                                  {"configuration", d.configuration}}});
  }

  void run() {
    while (!quit_) {
      if (auto port = open()) read(*port);
      for (int i = 0; i < 10 && !quit_; ++i) std::this_thread::sleep_for(milliseconds(50));
    }
  }

  [[nodiscard]] std::optional<SerialPort> open() {
    auto port = SerialPort::open(options_.port, {options_.device.baud, options_.dtr});
    if (port)
      if (const auto sent = configure(options_, quit_); !sent) port = sent.error();
    const std::lock_guard lock(mutex_);
    status_.state = port ? SensorState::silent : SensorState::waiting;
    status_.note = port ? port->note() : port.error().to_string();
    if (!port) return std::nullopt;
    if (!options_.request.empty() && !port->write(options_.request)) return std::nullopt;
    return std::move(*port);
  }

  void read(SerialPort& port) {
    std::array<std::uint8_t, 16384> buffer;
    while (!quit_) {
      const auto n = port.read(buffer, milliseconds(100));
      if (!n) {
        const std::lock_guard lock(mutex_);
        status_.state = SensorState::waiting;
        status_.note = n.error().to_string();
        return;
      }
      if (*n != 0) take({buffer.data(), *n}, clock_.now());
    }
  }

  void take(decode::Bytes bytes, LogTime now) {
    const std::uint32_t session = recorder_.session();
    if (session != 0)
      recorder_.add(session, {number_, true, raw_, now, now, {bytes.begin(), bytes.end()}});
    decoder_->feed(bytes, now, [&](DecodedMessage message) {
      recorder_.add(session,
                    {number_, false, message.stream, now, message.time, std::move(message.json)});
    });
    const std::lock_guard lock(mutex_);
    status_.state = SensorState::receiving;
    status_.bytes += bytes.size();
    status_.decoding = decoder_->status();
    last_bytes_ = now;
  }

  const std::size_t number_;
  const SensorOptions options_;
  const std::shared_ptr<const Stream> raw_;
  const std::unique_ptr<DeviceDecoder> decoder_;  ///< used by the thread only
  Recorder& recorder_;
  const LoggerClock& clock_;
  std::atomic<bool> quit_{false};

  mutable std::mutex mutex_;
  SensorStatus status_;
  LogTime last_bytes_;
  std::uint64_t bytes_before_ = 0, messages_before_ = 0;

  std::thread thread_;
};

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
  }
  if (auto sound = check_ports(options); !sound) return sound;
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
    auto begun = recorder.begin(about);
    if (begun) record_mountings();
    return begun;
  }

  /// Where the sensors are mounted, once in each file.
  void record_mountings() {
    std::vector<Mounting> mountings;
    for (const SensorOptions& s : options.sensors)
      if (s.mounting) mountings.push_back({options.base_frame, s.device.name, *s.mounting});
    if (mountings.empty()) return;
    LoggerStatus now;
    static_cast<void>(recorder.fill(now));
    const std::lock_guard lock(mounted_mutex);
    if (now.file == mounted_file) return;
    mounted_file = now.file;
    recorder.add(recorder.session(), {sensors.size(), false, transforms, now.time, now.time,
                                      transforms_json(mountings, now.time)});
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
    while (!quit) {
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

  void tell(bool record) {
    LoggerStatus now = status();
    control.send(status_line(to_json(now)));
    if (!record) return;
    record_mountings();
    // The recording has all measurements.
    for (SensorStatus& sensor : now.sensors) sensor.decoding.latest.clear();
    // It may be dropped where the queue is full: the next one counts what was dropped.
    recorder.add(recorder.session(),
                 {sensors.size(), false, stream, now.time, now.time, to_json(now)});
  }

  const LoggerOptions options;
  const LoggerClock clock;
  Recorder recorder;
  std::vector<std::unique_ptr<Sensor>> sensors;
  ControlLine control;
  std::atomic<bool> quit{false};
  bool report = false;  ///< of the coordinating thread
  std::mutex mounted_mutex;
  std::string mounted_file;  ///< that has the mountings
  const std::shared_ptr<const Stream> transforms =
      std::make_shared<const Stream>(Stream{"/tf_static",
                                            "json",
                                            std::string(transforms_schema().name),
                                            std::string(transforms_schema().json),
                                            {}});
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
