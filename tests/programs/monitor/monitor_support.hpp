#pragma once

// A recording and a live logger for the monitor's server, and its clients.

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <memory>
#include <numbers>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <wayfare/logger/logger.hpp>
#include <wayfare/logger/messages.hpp>
#include "decode/rplidar_streams.hpp"
#include "decode/ti_streams.hpp"
#include "decode/xbus_streams.hpp"
#include "logger/simulated_devices.hpp"
#include "monitor/server.hpp"

// After Eigen: <resolv.h>, which it includes, defines a macro of a name there.
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

/// Headers of a command from the page of the server.
inline httplib::Headers by(const MonitorServer& server) {
  return {{"X-Wayfare", "1"}, {"Authorization", "Bearer " + server.token()}};
}

/// A line of two ends, each a serial port: what is written to one is read from the other.
class Line {
 public:
  /// `flip` changes the bits of every byte to the second end, as a wrong rate does.
  explicit Line(std::uint8_t flip = 0) : flip_(flip) {}
  ~Line() {
    stop_ = true;
    thread_.join();
  }
  [[nodiscard]] const std::string& first() const { return a_.path(); }
  [[nodiscard]] const std::string& second() const { return b_.path(); }

 private:
  static void pass(logger::PseudoTerminal& from, logger::PseudoTerminal& to, std::uint8_t flip) {
    std::array<std::uint8_t, 4096> bytes;
    const auto n = from.read(bytes, 5ms).value_or(0);
    for (std::size_t i = 0; i < n; ++i) bytes[i] ^= flip;
    static_cast<void>(to.write(std::span(bytes).first(n), 100ms));
  }

  logger::PseudoTerminal a_ = std::move(*logger::PseudoTerminal::open());
  logger::PseudoTerminal b_ = std::move(*logger::PseudoTerminal::open());
  std::uint8_t flip_;
  std::atomic<bool> stop_{false};
  std::thread thread_{[this] {
    while (!stop_) pass(a_, b_, flip_), pass(b_, a_, 0);
  }};
};

/// A unit, a laser scanner and a radar that are played over and over; the logger has a serial
/// control line.
struct LiveDevices {
  explicit LiveDevices(const Line& line) {
    logger::LoggerOptions options;
    options.folder = folder.path().string();
    options.control_port = line.first();
    options.status_every = 200ms;
    const auto device = [&](const char* name, const char* kind, std::string bytes, double per_s) {
      devices.push_back(std::make_unique<testing::Played>(
          testing::SimulatedDevice{{name, kind, 115200, ""}, per_s, std::move(bytes)}, 1.0, 120.0));
      logger::SensorOptions sensor;
      sensor.device = {name, kind, 115200, ""};
      sensor.port = devices.back()->path();
      if (sensor.device.kind == "rplidar") sensor.mode = "listen";  // it answers no request
      options.sensors.push_back(sensor);
    };
    device("unit", "xsens", unit(), 2600.0);
    device("lidar", "rplidar", room(), 5000.0);
    device("radar", "ti_mmwave", frames(), 3000.0);
    running = std::move(*logger::Logger::start(options));
    for (const auto& played : devices) played->start();
  }

  /// MTData2 of a unit that nods once a second.
  static std::string unit() {
    decode::Stream all;
    for (int i = 0; i < 100; ++i) {
      const float swing = std::sin(0.02F * std::numbers::pi_v<float> * static_cast<float>(i));
      decode::Stream data;
      const auto packet = [&](std::uint16_t id, float x, float y, float z) {
        decode::put(data, id);
        decode::put<std::uint8_t>(data, 12);
        for (const float v : {x, y, z}) decode::put(data, std::bit_cast<std::uint32_t>(v));
      };
      packet(0x4020, 2.0F * swing, 0.0F, 9.8F);
      packet(0x8020, 0.0F, swing, 0.1F);
      decode::append(all, decode::message(decode::XbusId::mt_data2, data));
    }
    return {all.begin(), all.end()};
  }
  /// Revolutions in a room six by four metres, for two minutes: of one answer to a request.
  static std::string room() {
    decode::Stream all = decode::descriptor(decode::RplidarResponse::node, 5, true);
    for (int i = 0; i < 400 * 360; ++i) {
      const double a = (i % 360) * std::numbers::pi / 180.0;
      const double reach_m = std::min(3.0 / std::abs(std::cos(a)), 2.0 / std::abs(std::sin(a)));
      decode::append(
          all, decode::node(i % 360 * 64, static_cast<int>(4000.0 * reach_m), 15, i % 360 == 0));
    }
    return {all.begin(), all.end()};
  }
  static std::string frames() {
    decode::Stream all;
    for (std::uint32_t i = 1; i <= 20; ++i)
      decode::append(all, decode::frame(i, 3, {decode::float_points(3), decode::side_info(3)}));
    return {all.begin(), all.end()};
  }

  TemporaryFolder folder;
  std::vector<std::unique_ptr<testing::Played>> devices;
  std::unique_ptr<logger::Logger> running;
};

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
