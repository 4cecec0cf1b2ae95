#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include <wayfare/logger/device_messages.hpp>
#include <wayfare/logger/logger.hpp>
#include <wayfare/logger/messages.hpp>

namespace {

void require(bool good) {
  if (!good) std::abort();
}

}  // namespace

// The first byte selects the type of message; what is read is written and read again.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace wayfare::logger;
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  switch (data[0] % 8) {
    case 0: {
      const auto scan = parse_laser_scan(text);
      if (!scan) break;
      const auto again = parse_laser_scan(laser_scan_json(*scan, "a"));
      require(again && again->ranges_m.size() == scan->ranges_m.size());
      break;
    }
    case 1: {
      const auto cloud = parse_point_cloud(text);
      if (!cloud) break;
      const auto again = parse_point_cloud(point_cloud_json(*cloud, "a"));
      require(again && again->points.size() == cloud->points.size());
      break;
    }
    case 2: {
      const auto sample = parse_imu(text);
      if (!sample) break;
      const auto again = parse_imu(imu_json(*sample, "a"));
      require(again && again->time == sample->time);
      break;
    }
    case 3: {
      const auto nodes = parse_lidar_nodes(text);
      if (!nodes) break;
      const auto again = parse_lidar_nodes(lidar_nodes_json(*nodes, "a"));
      require(again && again->size() == nodes->size());
      break;
    }
    case 4: {
      const auto radar = parse_radar_frame(text);
      if (radar) require(parse_radar_frame(radar_frame_json(*radar, "a")).has_value());
      break;
    }
    case 5: {
      const auto state = parse_mt_state(text);
      if (state) require(parse_mt_state(mt_state_json(*state, "a")).has_value());
      break;
    }
    case 6: {
      const auto mountings = parse_transforms(text);
      if (!mountings) break;
      const auto again = parse_transforms(transforms_json(*mountings, {}));
      require(again && again->size() == mountings->size());
      break;
    }
    default: {
      const auto status = status_of_line(text);
      if (status) require(status_line(*status).starts_with(*status));
    }
  }
  return 0;
}
