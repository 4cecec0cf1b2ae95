// Bytes that become no measurement: swapped devices, a wrong baud rate, text.
#include "logger/line_check.hpp"

#include <bit>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "decode/rplidar_streams.hpp"
#include "decode/ti_streams.hpp"
#include "decode/xbus_streams.hpp"
#include "logger/one_device.hpp"
#include "logger/simulated_devices.hpp"

namespace wayfare::logger {
namespace {

using namespace std::chrono_literals;
using decode::Stream;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::wayfare::testing::sensor;
using ::wayfare::testing::TemporaryFolder;
using ::wayfare::testing::wait_for;

Stream radar_bytes() {
  Stream all;
  for (std::uint32_t i = 1; i <= 100; ++i)
    decode::append(all, decode::frame(i, 9, {decode::float_points(9), decode::side_info(9)}));
  return all;
}

Stream lidar_bytes() {
  Stream all = decode::descriptor(decode::RplidarResponse::node, 5, true);
  for (int i = 0; i < 6000; ++i)
    decode::append(all, decode::node(i % 300 * 76, 4000 + 13 * i % 900, 15, i % 300 == 0));
  return all;
}

Stream unit_bytes() {
  Stream all;
  for (int i = 0; i < 700; ++i) {
    Stream data;
    for (const std::uint16_t id : {std::uint16_t{0x4020}, std::uint16_t{0x8020}}) {
      decode::put(data, id);
      decode::put<std::uint8_t>(data, 12);
      for (int k = 0; k < 3; ++k)
        decode::put(data, std::bit_cast<std::uint32_t>(0.37F * static_cast<float>(i + k)));
    }
    decode::append(all, decode::message(decode::XbusId::mt_data2, data));
  }
  return all;
}

std::vector<std::pair<std::string, Stream>> devices() {
  return {{"ti_mmwave", radar_bytes()}, {"rplidar", lidar_bytes()}, {"xsens", unit_bytes()}};
}

/// What a port of one rate reads of bytes sent at another: start bit, eight data bits, stop bit,
/// each sampled in its middle by the reader's clock. A byte without a stop bit is read as zero.
Stream misread(const Stream& bytes, double sent_baud, double read_baud) {
  std::vector<bool> line;
  for (const std::uint8_t byte : bytes) {
    line.push_back(false);
    for (int bit = 0; bit < 8; ++bit) line.push_back((byte >> bit & 1) != 0);
    line.push_back(true);
  }
  const double ratio = sent_baud / read_baud;  // bits sent in the time of one that is read
  const auto level = [&](double at) {
    const auto i = static_cast<std::size_t>(at);
    return i >= line.size() || line[i];
  };
  Stream read;
  for (double at = 0.0; at < static_cast<double>(line.size());) {
    if (level(at)) {
      at = std::floor(at) + 1.0;
      continue;
    }
    unsigned byte = 0;
    for (int bit = 0; bit < 8; ++bit) byte |= (level(at + ratio * (1.5 + bit)) ? 1U : 0U) << bit;
    const double stop = at + ratio * 9.5;
    read.push_back(static_cast<std::uint8_t>(level(stop) ? byte : 0U));
    for (at = stop; !level(at);) at = std::floor(at) + 1.0;
  }
  return read;
}

/// The first warning about bytes that a decoder of `kind` reads at 10 kB/s.
struct Found {
  std::string warning, last;
  Duration after{0};
};

Found check(const std::string& kind, const Stream& bytes) {
  const DeviceDescription device{"d", kind, 115200, ""};
  const auto decoder = make_decoder(device);
  LineCheck line(device, 3s);
  Found found;
  const LogTime start = LogTime::from_seconds(1e9);
  constexpr std::size_t kPiece = 500;
  for (int i = 0; i < 120; ++i) {  // six seconds
    Stream piece;
    for (std::size_t k = 0; k < kPiece; ++k)
      piece.push_back(bytes[(kPiece * static_cast<std::size_t>(i) + k) % bytes.size()]);
    const LogTime now = start + 50ms * i;
    (*decoder)->feed(piece, now, [](const DecodedMessage&) {});
    line.add(piece, (*decoder)->status(), now);
    found.last = line.warning();
    if (found.warning.empty()) found.warning = found.last, found.after = now - start;
  }
  return found;
}

TEST(LineCheck, IsSilentAboutADeviceOfItsKind) {
  for (const auto& [kind, bytes] : devices()) EXPECT_EQ(check(kind, bytes).warning, "") << kind;
}

TEST(LineCheck, RecognisesTheOtherDevices) {
  for (const auto& [kind, bytes] : devices())
    for (const auto& [other, unused] : devices()) {
      if (other == kind) continue;
      const Found found = check(other, bytes);
      EXPECT_THAT(found.warning,
                  AllOf(HasSubstr("of a device of kind " + kind), HasSubstr("swapped")))
          << other;
      EXPECT_GE(found.after, 3s);
      EXPECT_LE(found.after, 4s);
    }
}

TEST(LineCheck, NamesTheBaudRate) {
  for (const auto& [kind, bytes] : devices())
    for (const double sent : {9600.0, 57600.0, 230400.0, 256000.0, 460800.0, 921600.0}) {
      const Found found = check(kind, misread(bytes, sent, 115200.0));
      EXPECT_THAT(found.last, HasSubstr("is the baud rate 115200")) << kind << ' ' << sent;
      EXPECT_LE(found.after, 4s);
    }
  EXPECT_EQ(misread(unit_bytes(), 115200.0, 115200.0), unit_bytes());
}

TEST(LineCheck, RecognisesText) {
  const std::string prompt =
      "mmwDemo:/>profileCfg 0 77 267 7 57.14 0 0 70 1 256 5209 0 0 30\r\nDone\r\n";
  EXPECT_THAT(check("ti_mmwave", {prompt.begin(), prompt.end()}).warning, HasSubstr("text"));
}

TEST(LineCheck, TellsOfMessagesThatAreNoMeasurements) {
  Stream settings;
  for (int i = 0; i < 50; ++i)
    decode::append(settings, decode::message(static_cast<decode::XbusId>(0x11), Stream(20, 1)));
  EXPECT_THAT(check("xsens", settings).warning, HasSubstr("none is a measurement"));
}

TEST(LineCheck, TheWarningEndsWithTheFault) {
  Stream bytes = misread(unit_bytes(), 57600.0, 115200.0);
  bytes.resize(40'000);  // four seconds
  decode::append(bytes, unit_bytes());
  const Found found = check("xsens", bytes);
  EXPECT_THAT(found.warning, HasSubstr("baud rate"));
  EXPECT_EQ(found.last, "");
}

// Every capture at hand, read by the decoders of the other kinds.
TEST(LineCheck, RecognisesCaptures) {
  WAYFARE_NEEDS_RECORDING(radar, "devices/ti_mmwave/awr1843_sdk3.6/mer1.dat.gz");
  WAYFARE_NEEDS_RECORDING(lidar,
                          "devices/rplidar/legacy_scan_bin/living_room_116_steps/frame_0008.bin");
  WAYFARE_NEEDS_RECORDING(station, "devices/xsens/awinda_mtb/Static/pose1/MT_012012B9_000.mtb.gz");
  const std::vector<std::pair<std::string, std::string>> captures = {
      {"ti_mmwave", radar}, {"rplidar", lidar}, {"xsens", station}};
  for (const auto& [kind, path] : captures)
    for (const auto& [other, unused] : captures) {
      // A station's log begins with its settings.
      const std::string all = io::read_file(path)->bytes, text = all.substr(all.size() / 2, 60'000);
      const Found found = check(other, {text.begin(), text.end()});
      if (other == kind) {
        EXPECT_EQ(found.warning, "") << path;
      } else {
        EXPECT_THAT(found.warning, HasSubstr("of a device of kind " + kind)) << other;
      }
    }
}

// Three devices, each on the port of the next one.
TEST(Logger, WarnsOfSwappedDevices) {
  const TemporaryFolder folder;
  LoggerOptions options;
  options.folder = folder.path().string();
  options.warn_after = 300ms;
  std::vector<std::unique_ptr<::wayfare::testing::Played>> played;
  const auto all = devices();
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string bytes(all[i].second.begin(), all[i].second.end());
    const DeviceDescription device{"d" + std::to_string(i), all[(i + 1) % 3].first, 115200, ""};
    played.push_back(std::make_unique<::wayfare::testing::Played>(
        ::wayfare::testing::SimulatedDevice{device, 20'000.0, bytes}, 1.0, 10.0));
    options.sensors.push_back(sensor(device, played.back()->path()));
  }
  auto logger = Logger::start(options);
  ASSERT_TRUE(logger);
  for (auto& device : played) device->start();
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string expected = "of a device of kind " + all[i].first;
    const auto warning = [&] { return (*logger)->status().sensors[i].warning; };
    EXPECT_TRUE(wait_for(20s, [&] { return warning().find(expected) != std::string::npos; }))
        << warning();
    EXPECT_THAT(to_json((*logger)->status()), HasSubstr(expected));
  }
}

}  // namespace
}  // namespace wayfare::logger
