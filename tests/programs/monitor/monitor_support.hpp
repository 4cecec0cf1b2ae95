#pragma once

// A recording and a live logger for the monitor's server, and its clients.

#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <wayfare/logger/logger.hpp>
#include <wayfare/logger/messages.hpp>
#include "logger/simulated_devices.hpp"
#include "monitor/server.hpp"

// After Eigen: one of its headers redefines a name that Eigen uses.
#include <httplib.h>

namespace wayfare::examples {

using namespace std::chrono_literals;
using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::wayfare::testing::read_all;
using ::wayfare::testing::TemporaryFolder;
using ::wayfare::testing::wait_for;

inline LogTime at(double s) {
  return LogTime::from_nanoseconds(1'700'000'000'000'000'000) + from_seconds(s);
}

/// Twenty seconds of a walk in a room four metres wide, with a radar that detects one object.
struct Recorded {
  Recorded() {
    auto writer = io::McapWriter::create(path);
    const auto channel = [&](const char* topic, const logger::MessageSchema& schema) {
      return *writer->add_channel(
          topic, "json",
          *writer->add_schema(std::string(schema.name), "jsonschema", std::string(schema.json)));
    };
    const auto unit = channel("/unit/imu", logger::imu_schema());
    const auto lidar = channel("/lidar/scan", logger::laser_scan_schema());
    const auto radar = channel("/radar/points", logger::point_cloud_schema());
    for (int i = 0; i < 2000; ++i) {
      const double t = 0.01 * i, bob = 3.0 * std::sin(2.0 * std::numbers::pi * 1.8 * t);
      samples.push_back({at(t), {0.0, 0.0, 0.1}, {0.2, 0.0, 9.81 + bob}, {20.0, 0.0, -40.0}});
      EXPECT_TRUE(writer->write(unit, at(t), at(t), logger::imu_json(samples.back(), "unit")));
      if (i % 20 != 0) continue;
      LaserScan scan{at(t), Angle::degrees(-180.0), Angle::degrees(1.0), 0.1F, 12.0F, {}};
      for (int k = 0; k < 360; ++k) {
        const double a = scan.bearing(static_cast<std::size_t>(k)).radians();
        const double reach = std::min(3.0 / std::abs(std::cos(a)), 2.0 / std::abs(std::sin(a)));
        scan.ranges_m.push_back(static_cast<float>(reach));
      }
      EXPECT_TRUE(writer->write(lidar, at(t), at(t), logger::laser_scan_json(scan, "lidar")));
      const RadarScan cloud{at(t), {{1.5F, 0.5F, 0.0F, 0.4F, 20.0F}}};
      EXPECT_TRUE(writer->write(radar, at(t), at(t), logger::point_cloud_json(cloud, "radar")));
    }
    EXPECT_TRUE(writer->close());
  }
  TemporaryFolder folder;
  std::string path = folder / "walk.mcap";
  std::vector<MargSample> samples;
};

inline std::unique_ptr<MonitorServer> serve(MonitorOptions options) {
  options.port = 0;
  auto server = MonitorServer::start(options);
  EXPECT_TRUE(server) << (server ? "" : server.error().to_string());
  return server ? std::move(*server) : nullptr;
}

inline httplib::Client client_of(const MonitorServer& server) {
  httplib::Client client("127.0.0.1", server.port());
  client.set_read_timeout(120);
  return client;
}

/// A logger with one unit.
struct Live {
  Live() {
    logger::LoggerOptions options;
    options.folder = folder.path().string();
    options.control_socket = folder / "control";
    options.status_every = 100ms;
    logger::SensorOptions sensor;
    sensor.device = {"unit", "raw", 115200, ""};
    sensor.port = terminal.path();
    options.sensors = {sensor};
    running = std::move(*logger::Logger::start(options));
  }
  [[nodiscard]] bool is(logger::LoggerState state) const {
    return wait_for(20s, [&] { return running->status().state == state; });
  }
  TemporaryFolder folder;
  logger::PseudoTerminal terminal = std::move(*logger::PseudoTerminal::open());
  std::unique_ptr<logger::Logger> running;
};

}  // namespace wayfare::examples
