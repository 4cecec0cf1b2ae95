#pragma once

// One device of a logger.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include <wayfare/decode/rplidar_start.hpp>
#include <wayfare/logger/logger.hpp>
#include <wayfare/logger/serial_port.hpp>

#include "logger/line_check.hpp"
#include "logger/recorder.hpp"

namespace wayfare::logger {

/// A thread that reads a device's line, stamps and decodes the bytes and queues them; starts an
/// RPLIDAR.
class Sensor {
 public:
  /// Of sensor `number` of the options, which is also its number in the recorder.
  Sensor(std::size_t number, const LoggerOptions& options, std::unique_ptr<DeviceDecoder> decoder,
         Recorder& recorder, const LoggerClock& clock);
  Sensor(const Sensor&) = delete;
  Sensor& operator=(const Sensor&) = delete;
  ~Sensor();

  /// Without the recorder's counts.
  [[nodiscard]] SensorStatus status() const;
  /// Rates since the previous call, `interval` ago.
  void measure_rates(Duration interval);

 private:
  void run();
  [[nodiscard]] std::optional<SerialPort> open();
  void read(SerialPort& port);
  void take(decode::Bytes bytes, LogTime now);
  void start(SerialPort& port, decode::Bytes bytes);

  const std::size_t number_;
  const SensorOptions options_;
  const Duration warn_after_;
  const std::shared_ptr<const Stream> raw_;
  // These are used by the thread only.
  const std::unique_ptr<DeviceDecoder> decoder_;
  std::optional<decode::RplidarStart> start_;
  std::optional<LineCheck> check_;  ///< of the open line
  bool motor_on_ = false;

  Recorder& recorder_;
  const LoggerClock& clock_;
  std::atomic<bool> quit_{false};

  mutable std::mutex mutex_;
  SensorStatus status_;
  std::string not_started_;  ///< why an RPLIDAR does not scan
  LogTime last_bytes_;
  std::uint64_t bytes_before_ = 0, messages_before_ = 0;

  std::thread thread_;
};

}  // namespace wayfare::logger
