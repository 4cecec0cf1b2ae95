#include "logger/devices/device_decoders.hpp"

namespace wayfare::logger {
namespace {

class RawDecoder final : public DeviceDecoder {
 public:
  void feed(decode::Bytes, LogTime, const Sink&) override {}
  [[nodiscard]] DecodingStatus status() const override { return {}; }
};

}  // namespace

std::vector<std::string> device_kinds() { return {"raw", "ti_mmwave", "rplidar", "xsens"}; }

Result<std::unique_ptr<DeviceDecoder>> make_decoder(const DeviceDescription& device) {
  if (device.kind == "raw") return std::unique_ptr<DeviceDecoder>(new RawDecoder);
  if (device.kind == "ti_mmwave") return make_ti_decoder(device);
  if (device.kind == "rplidar") return make_rplidar_decoder(device);
  if (device.kind == "xsens") return make_xsens_decoder(device);
  std::string known;
  for (const std::string& kind : device_kinds()) known += (known.empty() ? "" : ", ") + kind;
  return Error{ErrorCode::invalid, "unknown kind of device '" + device.kind + "'; known: " + known,
               device.name};
}

}  // namespace wayfare::logger
