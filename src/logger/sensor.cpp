#include "logger/sensor.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

#include "logger/configure.hpp"

namespace wayfare::logger {
namespace {

using std::chrono::milliseconds;

constexpr Duration kSilence = std::chrono::seconds(2);

std::shared_ptr<const Stream> raw_stream(const SensorOptions& sensor) {
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

std::string joined(const std::string& text, const std::string& more) {
  return text + (text.empty() || more.empty() ? "" : "; ") + more;
}

}  // namespace

Sensor::Sensor(std::size_t number, const LoggerOptions& options,
               std::unique_ptr<DeviceDecoder> decoder, Recorder& recorder, const LoggerClock& clock)
    : number_(number),
      options_(options.sensors[number]),
      warn_after_(options.warn_after),
      raw_(raw_stream(options_)),
      decoder_(std::move(decoder)),
      recorder_(recorder),
      clock_(clock) {
  status_.name = options_.device.name;
  if (options_.device.kind == "rplidar" && options_.request.empty() && options_.mode != "listen")
    start_.emplace(options_.mode);
  thread_ = std::thread([this] { run(); });
}

Sensor::~Sensor() {
  quit_ = true;
  thread_.join();
}

SensorStatus Sensor::status() const {
  const std::lock_guard lock(mutex_);
  SensorStatus status = status_;
  if (status.state == SensorState::receiving && clock_.now() - last_bytes_ > kSilence)
    status.state = SensorState::silent;
  status.warning = joined(not_started_, status.warning);
  return status;
}

void Sensor::measure_rates(Duration interval) {
  const std::lock_guard lock(mutex_);
  const double s = std::max(to_seconds(interval), 1e-3);
  status_.bytes_per_s = static_cast<double>(status_.bytes - bytes_before_) / s;
  status_.messages_per_s = static_cast<double>(status_.decoding.messages - messages_before_) / s;
  bytes_before_ = status_.bytes;
  messages_before_ = status_.decoding.messages;
}

void Sensor::run() {
  while (!quit_) {
    if (auto port = open()) read(*port);
    for (int i = 0; i < 10 && !quit_; ++i) std::this_thread::sleep_for(milliseconds(50));
  }
}

std::optional<SerialPort> Sensor::open() {
  auto port = SerialPort::open(options_.port, {options_.device.baud, options_.dtr});
  if (port)
    if (const auto sent = configure(options_, quit_); !sent) port = sent.error();
  {
    const std::lock_guard lock(mutex_);
    status_.state = port ? SensorState::silent : SensorState::waiting;
    status_.note = port ? port->note() : port.error().to_string();
    status_.warning.clear();
    not_started_.clear();
  }
  if (!port) return std::nullopt;
  if (!options_.request.empty() && !port->write(options_.request)) return std::nullopt;
  if (start_) start_->restart();
  motor_on_ = false;
  if (options_.device.kind != "raw")
    check_.emplace(options_.device, warn_after_, decoder_->status());
  return std::move(*port);
}

void Sensor::read(SerialPort& port) {
  std::array<std::uint8_t, 16384> buffer;
  while (!quit_) {
    const bool waits = start_ && start_->state() == decode::RplidarStart::State::starting;
    const auto n = port.read(buffer, milliseconds(waits ? 10 : 100));
    if (!n) {
      const std::lock_guard lock(mutex_);
      status_.state = SensorState::waiting;
      status_.note = n.error().to_string();
      return;
    }
    const decode::Bytes bytes(buffer.data(), *n);
    if (*n != 0) take(bytes, clock_.now());
    if (start_) start(port, bytes);
  }
}

void Sensor::take(decode::Bytes bytes, LogTime now) {
  const std::uint32_t session = recorder_.session();
  if (session != 0)
    recorder_.add(session, {number_, true, raw_, now, now, {bytes.begin(), bytes.end()}});
  decoder_->feed(bytes, now, [&](DecodedMessage message) {
    recorder_.add(session,
                  {number_, false, message.stream, now, message.time, std::move(message.json)});
  });
  const DecodingStatus decoding = decoder_->status();
  if (check_) check_->add(bytes, decoding, now);
  const std::lock_guard lock(mutex_);
  status_.state = SensorState::receiving;
  status_.bytes += bytes.size();
  status_.decoding = decoding;
  if (check_) status_.warning = check_->warning();
  last_bytes_ = now;
}

void Sensor::start(SerialPort& port, decode::Bytes bytes) {
  const decode::RplidarRequest request = start_->step(bytes, clock_.now());
  if (start_->motor_by_dtr() && options_.dtr == ModemLine::keep && !std::exchange(motor_on_, true))
    port.set_dtr(ModemLine::off);
  // A line that is gone is met by the next read.
  if (request.size != 0) static_cast<void>(port.write(request.bytes()));
  const std::lock_guard lock(mutex_);
  if (request.size == 0 && not_started_ == start_->problem()) return;
  not_started_ = start_->problem();
  status_.note = joined(port.note(), start_->identity().text());
}

}  // namespace wayfare::logger
