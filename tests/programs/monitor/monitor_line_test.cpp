// The monitor over a serial line, and maps of growing recordings.

#include <functional>
#include <string>

#include <nlohmann/json.hpp>

#include <wayfare/slam/graph_slam.hpp>
#include "monitor/recording_view.hpp"
#include "support/slam_outputs.hpp"

#include "monitor_support.hpp"

namespace wayfare::examples {
namespace {

using nlohmann::json;

/// Reads events until `done` with what was received so far.
std::string events_until(httplib::Client& client,
                         const std::function<bool(const std::string&)>& done) {
  std::string events;
  client.Get("/api/events", [&](const char* data, std::size_t n) {
    events.append(data, n);
    return !done(events) && events.size() < 1'000'000;
  });
  return events;
}
std::string events_with(httplib::Client& client, const std::string& text) {
  return events_until(client, [&](const std::string& e) { return e.find(text) != e.npos; });
}

/// The last complete status.
json last_status(const std::string& events) {
  const auto end = events.rfind("\n\n"), begin = events.rfind("data: {", end);
  return json::parse(events.substr(begin + 6, end - begin - 6), nullptr, false);
}

TEST(MonitorOverALine, ShowsOneSampleOfEachSensorAndControls) {
  const Line line;
  const LiveDevices live(line);
  const auto server = serve({.live = line.second(), .baud = 115200});
  auto client = client_of(*server);
  const auto has_samples = [](const std::string& events) {
    const json status = last_status(events);
    if (!status.is_object()) return false;
    for (const json& sensor : status["sensors"])
      if (!sensor.contains("latest")) return false;
    return true;
  };
  const json status = last_status(events_until(client, has_samples));
  ASSERT_TRUE(status.is_object());
  ASSERT_EQ(status["sensors"].size(), 3U);
  EXPECT_LT(status.dump().size(), 3000U);
  const json &unit = status["sensors"][0]["latest"], &lidar = status["sensors"][1]["latest"],
             &radar = status["sensors"][2]["latest"];
  EXPECT_NEAR(unit["force"][2].get<double>(), 9.8, 0.011);
  EXPECT_NEAR(unit["rate"][2].get<double>(), 0.1, 0.0011);
  // The sectors of five degrees ahead of and beside the scanner, in a room six by four metres.
  ASSERT_EQ(lidar["cm"].size(), 72U);
  EXPECT_NEAR(lidar["step_deg"].get<double>(), 5.0, 1e-4);
  const auto sector = [&](double deg) {
    const double from = lidar["from_deg"], step = lidar["step_deg"];
    const auto i = static_cast<std::size_t>(std::lround((deg - from) / step));
    return lidar["cm"][i % 72].get<double>();
  };
  EXPECT_NEAR(sector(2.0), 300.0, 3.0);
  EXPECT_NEAR(sector(90.0), 200.0, 3.0);
  EXPECT_EQ(radar["cm"].size(), 3U);
  const auto command = [&](const char* body) {
    return client.Post("/api/command", by(*server), body, "text/plain")->status;
  };
  EXPECT_EQ(command("C"), 200);
  EXPECT_EQ(command("B"), 200);
  EXPECT_TRUE(wait_for(
      20s, [&] { return live.running->status().state == logger::LoggerState::recording; }));
  EXPECT_THAT(events_with(client, "\"state\":\"recording\""), HasSubstr("recording"));
  EXPECT_EQ(command("S"), 200);
  EXPECT_TRUE(
      wait_for(20s, [&] { return live.running->status().state == logger::LoggerState::idle; }));
  // The recording has the measurements themselves.
  const auto file = io::McapReader::open(live.running->status().file);
  ASSERT_TRUE(file);
  file->read({io::McapOrder::file, {"/logger/status"}}, [](const io::McapMessage& m) {
    EXPECT_EQ(m.data.find("latest"), m.data.npos);
    return true;
  });
}

// A rate that is another, a line on which nobody speaks, one that is none, and one that is absent.
TEST(MonitorOverALine, SaysWhatIsWrongWithTheLine) {
  const Line garbled(0x5A), silent;
  const LiveDevices live(garbled);
  const auto said = [](const std::string& path, const std::string& text) {
    const auto server = serve({.live = path});
    auto client = client_of(*server);
    return events_with(client, text);
  };
  EXPECT_THAT(said(garbled.second(), "another --baud"),
              HasSubstr("bytes without a status: another --baud, or no logger?"));
  EXPECT_THAT(said(silent.second(), "nothing arrives"),
              HasSubstr("connected, but nothing arrives: is the logger running?"));
  EXPECT_THAT(said(live.folder / "nowhere", "nowhere"), HasSubstr("cannot be opened"));
  ASSERT_TRUE(io::write_file(live.folder / "file", "no line"));
  EXPECT_THAT(said(live.folder / "file", "is not"), HasSubstr("is not a serial line"));
}

// A recording that grows: the map of its beginning, then the map of all.
TEST(MonitorMap, GrowsWithTheRecording) {
  const TemporaryFolder folder;
  const std::string path = folder / "growing.mcap";
  auto writer = io::McapWriter::create(path);
  const auto schema = logger::laser_scan_schema();
  const auto channel = *writer->add_channel(
      "/lidar/scan", "json",
      *writer->add_schema(std::string(schema.name), "jsonschema", std::string(schema.json)));
  const RecordingView view(path);
  Recording all;
  // Along a corridor with a recess every two metres.
  const auto walk = [&](int from, int to) {
    for (int i = from; i < to; ++i) {
      LaserScan scan{at(0.1 * i), Angle::degrees(-180.0), Angle::degrees(1.0), 0.1F, 10.5F, {}};
      for (int k = 0; k < 360; ++k) {
        const double a = scan.bearing(static_cast<std::size_t>(k)).radians(), x = 0.05 * i;
        double reach = 0.1;
        for (; reach < 11.0; reach += 0.01) {
          const double u = x + reach * std::cos(a), v = std::abs(reach * std::sin(a));
          const bool recess = std::fmod(u + 20.0, 2.0) < 0.6;
          if (v > (recess ? 1.5 : 1.0) || u < -3.0 || u > 30.0) break;
        }
        scan.ranges_m.push_back(static_cast<float>(reach));
      }
      all.scans.push_back(*logger::parse_laser_scan(logger::laser_scan_json(scan, "lidar")));
      EXPECT_TRUE(
          writer->write(channel, at(0.1 * i), at(0.1 * i), logger::laser_scan_json(scan, "lidar")));
    }
  };
  EXPECT_TRUE(writer->flush());
  EXPECT_THAT(view.map_png(600.0).error().to_string(), HasSubstr("there are no laser scans"));
  walk(0, 40);
  EXPECT_TRUE(writer->flush());
  // The contents of a growing recording are read again after two seconds.
  std::string first;
  EXPECT_TRUE(wait_for(20s, [&] {
    auto map = view.map_png(600.0);
    return map && !(first = *std::move(map)).empty();
  }));
  const auto offline = run_graph_slam(all);
  ASSERT_TRUE(offline);
  EXPECT_EQ(first, io::encode_png(map_picture(offline->map, offline->trajectory)).value_or(""));
  walk(40, 120);
  EXPECT_TRUE(writer->close());
  std::string second;
  EXPECT_TRUE(wait_for(20s, [&] { return (second = view.map_png(600.0).value_or("")) != first; }));
  // Big-endian width in the header of a PNG: four metres of way more.
  const auto width = [](const std::string& png) {
    return static_cast<unsigned char>(png[18]) << 8 | static_cast<unsigned char>(png[19]);
  };
  EXPECT_GT(width(second), width(first));
  // Scans after the limit are not used.
  const RecordingView short_view(path);
  EXPECT_EQ(short_view.map_png(3.95).value_or(""), first);
}

}  // namespace
}  // namespace wayfare::examples
