#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include <wayfare/logger/logger.hpp>
#include <wayfare/logger/serial_port.hpp>

#include "logger/recorder.hpp"

namespace wayfare::logger {

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
  using milliseconds = std::chrono::milliseconds;
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

}  // namespace wayfare::logger
