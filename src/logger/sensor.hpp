#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include <wayfare/logger/logger.hpp>
#include <wayfare/logger/serial_port.hpp>

#include "logger/recorder.hpp"

namespace wayfare::logger {

/// One device: a thread that reads its line, stamps and decodes the bytes and queues them.
class Sensor {
 public:
  /// `number` is what the recorder counts its messages by.
  Sensor(std::size_t number, SensorOptions options, std::unique_ptr<DeviceDecoder> decoder,
         Recorder& recorder, const LoggerClock& clock);
  Sensor(const Sensor&) = delete;
  Sensor& operator=(const Sensor&) = delete;
  ~Sensor();

  /// Without what the recorder counts.
  [[nodiscard]] SensorStatus status() const;
  /// Rates since the previous call, `interval` ago.
  void measure_rates(Duration interval);

 private:
  void run();
  [[nodiscard]] std::optional<SerialPort> open();
  void read(SerialPort& port);
  void take(decode::Bytes bytes, LogTime now);

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
