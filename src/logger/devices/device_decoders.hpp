#pragma once

#include <string>
#include <string_view>

#include <wayfare/logger/device_decoder.hpp>
#include <wayfare/logger/messages.hpp>

namespace wayfare::logger {

[[nodiscard]] Result<std::unique_ptr<DeviceDecoder>> make_ti_decoder(
    const DeviceDescription& device);
[[nodiscard]] Result<std::unique_ptr<DeviceDecoder>> make_rplidar_decoder(
    const DeviceDescription& device);
[[nodiscard]] Result<std::unique_ptr<DeviceDecoder>> make_xsens_decoder(
    const DeviceDescription& device);

inline std::shared_ptr<const Stream> json_stream(std::string topic, const MessageSchema& schema) {
  return std::make_shared<const Stream>(
      Stream{std::move(topic), "json", std::string(schema.name), std::string(schema.json), {}});
}

}  // namespace wayfare::logger
