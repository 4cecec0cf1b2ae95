#pragma once

// Decoding of a device's bytes to time-stamped messages, as they arrive.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/time.hpp>

namespace wayfare::logger {

/// A stream of messages of one type, as described in a recording. The topic identifies it.
struct Stream {
  std::string topic;
  std::string encoding = "json";
  std::string schema = {};       ///< name; empty: none
  std::string schema_json = {};  ///< its definition
  std::map<std::string, std::string> metadata = {};
};

struct DecodedMessage {
  std::shared_ptr<const Stream> stream;
  LogTime time;  ///< of the measurement
  std::string json;
};

/// Results of decoding so far.
struct DecodingStatus {
  std::uint64_t messages = 0;
  std::uint64_t skipped_bytes = 0;
  std::uint64_t damaged = 0;  ///< frames with a wrong checksum or wrong lengths
  std::string sample = {};    ///< summary of the last message
};

class DeviceDecoder {
 public:
  using Sink = std::function<void(DecodedMessage)>;

  virtual ~DeviceDecoder() = default;
  /// Takes the next bytes, the last of which arrived at `arrived`.
  virtual void feed(decode::Bytes bytes, LogTime arrived, const Sink& sink) = 0;
  [[nodiscard]] virtual DecodingStatus status() const = 0;
};

struct DeviceDescription {
  std::string name;           ///< of the sensor: frame of its messages, first part of its topics
  std::string kind = "raw";   ///< one of device_kinds()
  int baud = 115200;          ///< of its line, positive: determines the delay of the bytes
  std::string configuration;  ///< text of a TI radar's .cfg, if there is one
};

/// The kinds that `make_decoder` supports.
[[nodiscard]] std::vector<std::string> device_kinds();

/// Errors: an unknown kind, no positive baud rate, an invalid configuration. Kind "raw" decodes
/// nothing.
[[nodiscard]] Result<std::unique_ptr<DeviceDecoder>> make_decoder(const DeviceDescription& device);

}  // namespace wayfare::logger
