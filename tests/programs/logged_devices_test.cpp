// Data of simulated devices, recorded by a logger or its decoders and processed by the programs: a
// walk must agree with that from text columns, a path with the truth.

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <numbers>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <wayfare/decode/xbus.hpp>
#include <wayfare/io/mcap.hpp>
#include <wayfare/io/nav_text.hpp>
#include <wayfare/io/tum.hpp>
#include <wayfare/logger/device_decoder.hpp>
#include <wayfare/logger/device_messages.hpp>
#include <wayfare/logger/logger.hpp>
#include "logger/simulated_devices.hpp"

namespace wayfare {
namespace {

using ::wayfare::testing::raw_channel;
using ::wayfare::testing::TemporaryFolder;
using ::wayfare::testing::wait_for;

void put_vector(std::vector<std::uint8_t>& out, std::uint16_t kind, const Eigen::Vector3d& v) {
  const std::size_t at = out.size();
  out.resize(at + 15);
  decode::store_be(kind, &out[at]);
  out[at + 2] = 12;
  for (std::size_t i = 0; i < 3; ++i)
    decode::store_be(static_cast<float>(v[static_cast<int>(i)]), &out[at + 3 + 4 * i]);
}

/// One MTData2 message: sample time in 0.1 ms, rate, acceleration, field.
std::vector<std::uint8_t> message(const MargSample& s, Duration since) {
  std::vector<std::uint8_t> data = {0x10, 0x60, 4, 0, 0, 0, 0};
  decode::store_be(static_cast<std::uint32_t>(since / std::chrono::microseconds(100)), &data[3]);
  put_vector(data, 0x8020, s.angular_rate_radps);
  put_vector(data, 0x4020, s.specific_force_mps2);
  if (s.magnetic_field_uT.allFinite()) put_vector(data, 0xC020, s.magnetic_field_uT / 49.0);
  std::vector<std::uint8_t> out(data.size() + 8);
  out.resize(decode::write_xbus(0xFF, decode::XbusId::mt_data2, data, out));
  return out;
}

/// A block of bytes of a device, and the arrival time of its end.
struct Arrival {
  Duration at{0};
  std::vector<std::uint8_t> bytes;
};

/// Records the decoded messages of the arrivals; returns their number.
std::size_t record(const logger::DeviceDescription& device, const std::vector<Arrival>& arrivals,
                   const std::string& path) {
  auto writer = io::McapWriter::create(path);
  auto decoder = logger::make_decoder(device);
  if (!writer || !decoder) return 0;
  const LogTime start = LogTime::from_nanoseconds(1'700'000'000'000'000'000);
  std::map<std::string, std::uint16_t> channels;
  for (const Arrival& arrival : arrivals) {
    (*decoder)->feed(arrival.bytes, start + arrival.at, [&](logger::DecodedMessage m) {
      const auto [channel, is_new] = channels.emplace(m.stream->topic, 0);
      if (is_new) {
        const auto schema =
            writer->add_schema(m.stream->schema, "jsonschema", m.stream->schema_json);
        channel->second = *writer->add_channel(m.stream->topic, m.stream->encoding, *schema);
      }
      EXPECT_TRUE(writer->write(channel->second, start + arrival.at, m.time, m.json));
    });
  }
  EXPECT_TRUE(writer->close());
  return (*decoder)->status().messages;
}

/// The walk as messages with delays of up to 20 ms.
std::vector<Arrival> sent(const MargRecording& walk) {
  std::vector<Arrival> arrivals;
  std::mt19937 random(1);
  Duration last{0};
  for (const MargSample& sample : walk) {
    const Duration since = sample.time - walk.front().time;
    last = std::max(last, since + std::chrono::microseconds(random() % 20'000));
    arrivals.push_back({last, message(sample, since)});
  }
  return arrivals;
}

/// The number after `what` in the program's table.
double found(const std::string& table, const std::string& what) {
  const auto at = table.find("\n" + what + " ");
  return at == table.npos ? std::nan("") : std::atof(table.c_str() + at + what.size() + 1);
}

std::string output_of(const std::string& command) {
  std::string text;
  FILE* pipe = ::popen((command + " 2>&1").c_str(), "r");
  char buffer[4096];
  for (std::size_t n = 0; (n = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;)
    text.append(buffer, n);
  EXPECT_EQ(::pclose(pipe), 0) << text;
  return text;
}

TEST(LoggedDevices, AWalkIsReckonedAsItsColumnsAre) {
  const TemporaryFolder folder;
  const auto walk = io::read_marg(WAYFARE_WALK);
  ASSERT_TRUE(walk);
  const std::string path = folder / "walk.mcap";
  ASSERT_EQ(record({"unit", "xsens", 115200, ""}, sent(walk->samples), path), walk->samples.size());
  const auto pedestrian = [&](const std::string& file, const std::string& out) {
    return output_of(WAYFARE_PEDESTRIAN " '" + file + "' --out '" + (folder / out) + "'");
  };
  const std::string columns = pedestrian(WAYFARE_WALK, "columns");
  const std::string logged = pedestrian(path, "logged");
  EXPECT_GT(found(columns, "steps"), 70.0) << columns;
  EXPECT_EQ(found(logged, "steps"), found(columns, "steps")) << logged;
  // Single precision on the wire, and stamps by the least late of the arrivals.
  EXPECT_NEAR(found(logged, "length"), found(columns, "length"), 0.005 * found(columns, "length"));
  // The replay walks the same steps, in the axes of the filter's defaults.
  const std::string replayed = output_of(WAYFARE_REPLAY " '" + path + "' --speed 1e6 --truth '" +
                                         (folder / "logged/trajectory.tum") + "'");
  EXPECT_THAT(replayed, ::testing::ContainsRegex("replayed, aligned +0.0[0-9]+ +0.0"));
}

/// Distance to the walls of a room from inside it.
double to_the_wall(const Eigen::Vector2d& p, double direction) {
  const double c = std::cos(direction), s = std::sin(direction);
  const double x = c > 0.0 ? (5.0 - p.x()) / c : (-3.0 - p.x()) / c;
  const double y = s > 0.0 ? (2.5 - p.y()) / s : (-2.0 - p.y()) / s;
  return std::min(x, y);
}

constexpr double kSpeed = 0.15, kTurning = 0.04, kTurn_s = 0.15;

/// An RPLIDAR moving through the room: a descriptor, then revolutions of 300 nodes.
std::vector<Arrival> swept(int turns) {
  std::vector<Arrival> arrivals = {{Duration(0), {0xA5, 0x5A, 5, 0, 0, 0x40, 0x81}}};
  for (int turn = 0; turn < turns; ++turn) {
    const double t = kTurn_s * turn;
    for (int i = 0; i < 300; ++i) {
      const double clockwise = 1.2 * i;
      const double range =
          to_the_wall({kSpeed * t, 0.0}, kTurning * t - clockwise * std::numbers::pi / 180.0);
      const auto angle = static_cast<unsigned>(std::lround(clockwise * 64.0));
      const auto distance = static_cast<unsigned>(std::lround(range * 4000.0));
      const bool first = i == 0;
      std::vector<std::uint8_t> node = {
          static_cast<std::uint8_t>(40U << 2 | (first ? 1U : 2U)),
          static_cast<std::uint8_t>(angle << 1 | 1U), static_cast<std::uint8_t>(angle >> 7),
          static_cast<std::uint8_t>(distance), static_cast<std::uint8_t>(distance >> 8)};
      arrivals.push_back({from_seconds(t + 0.0005 * (i + 1)), std::move(node)});
    }
  }
  return arrivals;
}

/// The trajectory that a system wrote.
Trajectory track_of(const std::string& out) {
  const auto track = io::read_tum(out + "/trajectory.tum");
  EXPECT_TRUE(track) << out;
  return track ? io::planar(track->trajectory) : Trajectory{};
}

/// Compares the motion with the truth, relative to the first scan, which looks along the path.
void expect_true_path(const Trajectory& poses, double within_m) {
  const double lasts_s = kTurn_s * static_cast<double>(poses.size() - 1);
  const SE2d moved = poses.front().T_map_base.raw().inverse() * poses.back().T_map_base.raw();
  EXPECT_NEAR(moved.translation().norm(), kSpeed * lasts_s, within_m);
  EXPECT_NEAR(moved.heading().radians(), kTurning * lasts_s, 0.02);
}

TEST(LoggedDevices, ScansGoThroughTheSystems) {
  const TemporaryFolder folder;
  const std::string path = folder / "room.mcap";
  constexpr int kTurns = 60;
  // The first revolution, which is incomplete, and the last, which is not terminated, are missing.
  ASSERT_GE(record({"lidar", "rplidar", 115200, ""}, swept(kTurns), path), kTurns - 2U);
  for (const std::string program : {WAYFARE_GRAPH_SLAM, WAYFARE_RADAR_SLAM}) {
    const std::string out = folder / std::filesystem::path(program).filename().string();
    output_of(program + " '" + path + "' --quiet --out '" + out + "'");
    const Trajectory poses = track_of(out);
    ASSERT_GE(poses.size(), kTurns - 2U);
    const double lasts_s = to_seconds(poses.back().time - poses.front().time);
    EXPECT_NEAR(lasts_s, kTurn_s * static_cast<double>(poses.size() - 1), 0.1 * kTurn_s);
    // Without wheels the particle filter uses a scan every second: its last pose may be as old.
    expect_true_path(poses, program == WAYFARE_GRAPH_SLAM ? 0.05 : kSpeed);
  }
}

/// A device on a pseudo-terminal, in real time.
class Device {
 public:
  explicit Device(const std::vector<Arrival>& arrivals)
      : terminal_(std::move(*logger::PseudoTerminal::open())) {
    for (const Arrival& a : arrivals) bytes_.insert(bytes_.end(), a.bytes.begin(), a.bytes.end());
    std::size_t end = 0, begin = 0;
    for (const Arrival& a : arrivals) {
      end += a.bytes.size();
      // In blocks, as the operating system delivers them.
      if (end - begin < 32 && end < bytes_.size()) continue;
      stream_.push_back({a.at, decode::Bytes(bytes_).subspan(begin, end - begin)});
      begin = end;
    }
  }
  void start() {
    thread_ = std::thread([this] { EXPECT_TRUE(logger::play(terminal_, stream_, 1.0, stop_)); });
  }
  void finish() { thread_.join(); }
  [[nodiscard]] const std::string& path() const { return terminal_.path(); }
  [[nodiscard]] std::size_t size() const { return bytes_.size(); }

 private:
  logger::PseudoTerminal terminal_;
  std::vector<std::uint8_t> bytes_;
  std::vector<logger::TimedBytes> stream_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// Records while `devices` sends; returns the file once the given number of bytes has arrived from
/// each.
std::string record_with(const logger::LoggerOptions& options, const std::vector<std::size_t>& bytes,
                        const std::function<void()>& devices) {
  auto logger = logger::Logger::start(options);
  EXPECT_TRUE(logger && (*logger)->begin());
  devices();
  EXPECT_TRUE(wait_for(std::chrono::seconds(20), [&] {
    const auto sensors = (*logger)->status().sensors;
    for (std::size_t i = 0; i < bytes.size(); ++i)
      if (sensors[i].bytes != bytes[i]) return false;
    return true;
  }));
  (*logger)->stop();
  EXPECT_TRUE((*logger)->wait_until_stopped(std::chrono::seconds(20)));
  return (*logger)->status().file;
}

TEST(LoggedDevices, ALoggersRecordingGoesThroughTheSystems) {
  const TemporaryFolder folder;
  auto walk = io::read_marg(WAYFARE_WALK);
  ASSERT_TRUE(walk);
  walk->samples.resize(350);  // 14 s
  ASSERT_TRUE(io::write_marg(folder / "walk.csv", walk->samples));
  Device unit(sent(walk->samples)), lidar(swept(80));
  logger::LoggerOptions options;
  options.folder = folder.path().string();
  options.sensors.resize(2);
  options.sensors[0].device = {"unit", "xsens", 115200, ""};
  options.sensors[0].port = unit.path();
  options.sensors[1].device = {"lidar", "rplidar", 115200, ""};
  options.sensors[1].port = lidar.path();
  options.sensors[1].mounting =
      SE3d(Eigen::Vector3d(0.1, 0.2, 0.3), SO3d::exp(Eigen::Vector3d(0.0, 0.0, 1.5)));
  const std::string path = record_with(options, {unit.size(), lidar.size()}, [&] {
    unit.start(), lidar.start();
    unit.finish(), lidar.finish();
  });

  const auto pedestrian = [&](const std::string& file, const std::string& out) {
    return output_of(WAYFARE_PEDESTRIAN " '" + file + "' --out '" + (folder / out) + "'");
  };
  const std::string columns = pedestrian(folder / "walk.csv", "columns");
  const std::string logged = pedestrian(path, "logged");
  EXPECT_GT(found(columns, "steps"), 10.0) << columns;
  EXPECT_NEAR(found(logged, "steps"), found(columns, "steps"), 1.0) << logged;
  EXPECT_NEAR(found(logged, "length"), found(columns, "length"), 0.1 * found(columns, "length"));
  for (const std::string program : {WAYFARE_GRAPH_SLAM, WAYFARE_RADAR_SLAM}) {
    const std::string out = folder / std::filesystem::path(program).filename().string();
    output_of(program + " '" + path + "' --quiet --out '" + out + "'");
    const Trajectory poses = track_of(out);
    ASSERT_GE(poses.size(), 78U);
    expect_true_path(poses, program == WAYFARE_GRAPH_SLAM ? 0.05 : kSpeed);
  }
  const auto mountings = logger::read_mountings(path);
  ASSERT_TRUE(mountings);
  ASSERT_EQ(mountings->size(), 1U);
  EXPECT_EQ((*mountings)[0].parent, "base_link");
  EXPECT_EQ((*mountings)[0].child, "lidar");
  EXPECT_EQ((*mountings)[0].pose.translation(), Eigen::Vector3d(0.1, 0.2, 0.3));
  // Every node of it as a table, and every whole revolution's nodes as messages.
  EXPECT_THAT(output_of(WAYFARE_DECODE " rplidar '" + path + "' --csv --out '" +
                        (folder / "nodes.csv") + "'"),
              ::testing::HasSubstr(std::to_string(80 * 300) + " points in 80 revolutions"));
  // Where a block of it is damaged, the place is named, and the rest is decoded.
  const std::string damaged = folder / "damaged.mcap";
  std::filesystem::copy_file(path, damaged);
  std::fstream file(damaged, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(static_cast<std::streamoff>(std::filesystem::file_size(path) / 2)).write("damage", 6);
  file.close();
  EXPECT_THAT(output_of(WAYFARE_DECODE " rplidar '" + damaged + "' --csv --out '" +
                        (folder / "rest.csv") + "'"),
              ::testing::ContainsRegex("skipped: .*damaged.mcap, byte [0-9]+: .*revolutions"));
  const auto reader = io::McapReader::open(path);
  std::size_t nodes = 0;
  reader->read({io::McapOrder::file, {"/lidar/nodes"}}, [&](const io::McapMessage& m) {
    const auto points = logger::parse_lidar_nodes(m.data);
    EXPECT_TRUE(points);
    for (const auto& p : *points) nodes += p.point.quality == 40 ? 1 : 0;
    return true;
  });
  EXPECT_GE(nodes, 78U * 300U);
  // Replayed twenty times as fast: to the systems, and to another logger.
  const std::string live = WAYFARE_REPLAY " '" + path + "' --speed 20 ";
  EXPECT_THAT(output_of(live + "--system pedestrian"), ::testing::HasSubstr("350 samples"));
  EXPECT_THAT(output_of(live + "--system graph_slam"),
              ::testing::HasSubstr("scans, 0 loop closures"));
  const std::string ptys = folder / "ptys";
  std::thread replay([&] { output_of(live + "--wait 2 --ptys '" + ptys + "'"); });
  EXPECT_TRUE(wait_for(std::chrono::seconds(20), [&] {
    return std::filesystem::exists(ptys + "/unit") && std::filesystem::exists(ptys + "/lidar");
  }));
  options.sensors[0].port = ptys + "/unit";
  options.sensors[1].port = ptys + "/lidar";
  const std::string again =
      record_with(options, {unit.size(), lidar.size()}, [&] { replay.join(); });
  for (const char* topic : {"/unit/raw", "/lidar/raw"})
    EXPECT_TRUE(raw_channel(*io::McapReader::open(again), topic).bytes ==
                raw_channel(*io::McapReader::open(path), topic).bytes)
        << topic;
}

}  // namespace
}  // namespace wayfare
