// Series, ranges and exports of parts of a recording.

#include <sstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "monitor_support.hpp"

namespace wayfare::examples {
namespace {

using nlohmann::json;

/// A unit at 100 Hz that is silent from 4 to 6 s, its mounting, a cloud with fields of its own, and
/// a sensor that no program knows.
struct Mixed {
  Mixed() {
    auto writer = *io::McapWriter::create(path);
    const auto channel = [&](const char* topic, const char* schema, const std::string& text) {
      return *writer.add_channel(topic, "json", *writer.add_schema(schema, "jsonschema", text));
    };
    const auto tf = channel("/tf_static", "foxglove.FrameTransform", "{}");
    const auto unit = channel("/unit/imu", "wayfare.Imu", "{}");
    const auto cloud = channel("/lidar/nodes", "foxglove.PointCloud", "{}");
    const auto air = channel("/air", "example.Air",
                             R"({"properties":{"inner":{"properties":{"p":{"type":"number"}}},)"
                             R"("list":{"type":"array"},"text":{"type":"string"}}})");
    const auto put = [&](std::uint16_t to, double t, const std::string& text) {
      EXPECT_TRUE(writer.write(to, at(t), at(t - 0.001), text));
    };
    put(tf, 0.0, R"({"parent_frame_id":"base","child_frame_id":"lidar"})");
    for (int i = 0; i < 1000; ++i)
      if (i < 400 || i >= 600)
        put(unit, 0.01 * i, json({{"a", {{"x", i}, {"list", {1, i}}}}, {"on", true}}).dump());
    // Little-endian 1.5F, and the integers 7 and 300.
    put(cloud, 1.0,
        R"({"point_stride":7,"fields":[{"name":"x","offset":0,"type":7},)"
        R"({"name":"quality","offset":4,"type":1},{"name":"angle","offset":5,"type":3}],)"
        R"("data":"AADAPwcsAQ=="})");
    put(air, 2.0, R"({"inner":{"p":101.25},"list":[1,2],"text":"a,\"b\""})");
    put(air, 9.0, "{\"text\":\n null}");
    EXPECT_TRUE(writer.close());
  }
  TemporaryFolder folder;
  std::string path = folder / "mixed.mcap";
};

TEST(MonitorQueries, SeriesAreOfAnyField) {
  const Mixed mixed;
  const auto server = serve({.recording = mixed.path});
  auto client = client_of(*server);
  const auto series = [&](const std::string& query) {
    return json::parse(client.Get("/api/series?topic=/unit/imu" + query)->body);
  };
  const json some = series("&field=a.x&field=a.list.1&field=on&field=none&from=1&until=1.045");
  EXPECT_EQ(some["columns"][0], json({100, 101, 102, 103, 104}));
  EXPECT_EQ(some["columns"][0], some["columns"][1]);
  EXPECT_EQ(some["columns"][2], json({1, 1, 1, 1, 1}));
  EXPECT_TRUE(some["columns"][3][0].is_null());
  // Times of measurement, not of logging.
  EXPECT_NEAR(some["t"][0].get<double>(), 0.999, 1e-9);
}

TEST(MonitorQueries, SeriesShowGapsAndPeaks) {
  const Mixed mixed;
  const auto server = serve({.recording = mixed.path});
  auto client = client_of(*server);
  for (const char* n : {"&n=2000", "&n=40"}) {
    const json all =
        json::parse(client.Get(std::string("/api/series?topic=/unit/imu&field=a.x") + n)->body);
    const json& x = all["columns"][0];
    std::size_t gaps = 0, at_gap = 0;
    for (std::size_t i = 0; i < x.size(); ++i)
      if (x[i].is_null()) ++gaps, at_gap = i;
    ASSERT_EQ(gaps, 1U) << n;
    // The middle between 3.989 and 5.999 s.
    EXPECT_NEAR(all["t"][at_gap].get<double>(), 4.994, 1e-9);
    EXPECT_EQ(x[at_gap - 1], 399);
    EXPECT_EQ(x[at_gap + 1], 600);
    EXPECT_EQ(x.front(), 0);
    EXPECT_EQ(x.back(), 999);
  }
}

// Ten messages at a time, as from a device without a clock.
TEST(MonitorQueries, GroupsOfMessagesAreNoGaps) {
  const TemporaryFolder folder;
  auto writer = *io::McapWriter::create(folder / "groups.mcap");
  const auto channel = *writer.add_channel("/x", "json");
  for (int i = 0; i < 1000; ++i) {
    const int tens = i / 10;
    const double t = 0.1 * tens + 0.001 * (i % 10) + (i < 500 ? 0.0 : 1.0);
    EXPECT_TRUE(writer.write(channel, at(t), at(t), json({{"x", i}}).dump()));
  }
  EXPECT_TRUE(writer.close());
  const auto server = serve({.recording = folder / "groups.mcap"});
  const json x =
      json::parse(client_of(*server).Get("/api/series?topic=/x&field=x")->body)["columns"][0];
  EXPECT_EQ(std::ranges::count_if(x, [](const json& v) { return v.is_null(); }), 1);
  EXPECT_TRUE(x[500].is_null());
}

TEST(MonitorQueries, RangesHaveWhatHoldsAtTheirBeginning) {
  const Mixed mixed;
  const auto server = serve({.recording = mixed.path});
  auto client = client_of(*server);
  const auto range = [&](const std::string& query) {
    std::istringstream lines(client.Get("/api/range?" + query)->body);
    std::vector<json> all;
    for (std::string line; std::getline(lines, line);) all.push_back(json::parse(line));
    return all;
  };
  const auto part = range("topic=/unit/imu&topic=/tf_static&from=5&until=6.015&before=1");
  ASSERT_EQ(part.size(), 9U);
  EXPECT_EQ(part[0]["topic"], "/tf_static");
  EXPECT_EQ(part[2]["topic"], "/unit/imu");
  EXPECT_EQ(part[3]["a"]["x"], 399);
  EXPECT_EQ(part[5]["a"]["x"], 600);
  EXPECT_NEAR(part[4]["t"].get<double>() - at(6.0).seconds(), 0.0, 1e-6);
  EXPECT_NEAR(part[4]["m"].get<double>() - at(5.999).seconds(), 0.0, 1e-6);
  EXPECT_NEAR(part.back()["until"].get<double>(), 6.015, 1e-9);
  // A line end in a message is white space.
  EXPECT_EQ(range("topic=/air&from=8&until=10")[1], json({{"text", nullptr}}));
  EXPECT_EQ(range("topic=/none&from=0&until=1").size(), 1U);
  EXPECT_EQ(range("from=0&until=1").size(), 1U);
  EXPECT_EQ(range("topic=/air&from=-5&until=nan&before=1").size(), 5U);
}

TEST(MonitorQueries, LongRangesComeInParts) {
  const TemporaryFolder folder;
  auto writer = *io::McapWriter::create(folder / "long.mcap");
  const auto channel = *writer.add_channel("/big", "json");
  const std::string text = '"' + std::string(100'000, 'x') + '"';
  for (int i = 0; i < 60; ++i) EXPECT_TRUE(writer.write(channel, at(i), at(i), text));
  EXPECT_TRUE(writer.close());
  const auto server = serve({.recording = folder / "long.mcap"});
  auto client = client_of(*server);
  int messages = 0;
  for (double from = 0.0; from < 59.0;) {
    const std::string body =
        client.Get("/api/range?topic=/big&until=59&from=" + std::to_string(from))->body;
    EXPECT_LT(body.size(), 5'000'000U);
    messages += static_cast<int>(std::ranges::count(body, '\n') - 1) / 2;
    const double until = json::parse(body.substr(body.rfind('\n', body.size() - 2) + 1))["until"];
    ASSERT_GT(until, from);
    from = until;
  }
  EXPECT_EQ(messages, 60);
}

TEST(MonitorQueries, ExportsAreOfAnIntervalAndOfAnySchema) {
  const Mixed mixed;
  const auto server = serve({.recording = mixed.path});
  auto client = client_of(*server);
  EXPECT_EQ(client.Get("/export.csv?topic=/air")->body,
            "t_s,inner.p,list,text\n"
            "1700000001.999000000,101.25,\"[1,2]\",\"a,\"\"b\"\"\"\n"
            "1700000008.999000000,,,\n");
  EXPECT_EQ(client.Get("/export.csv?topic=/air&from=5&until=20")->body,
            "t_s,inner.p,list,text\n1700000008.999000000,,,\n");
  EXPECT_EQ(client.Get("/export.csv?topic=/lidar/nodes")->body,
            "t_s,x_m,quality,angle\n1700000000.999000000,1.5,7,300\n");
  const auto part = io::McapReader::parse(client.Get("/export.mcap?from=7&until=7.495")->body, "");
  ASSERT_TRUE(part);
  // Half a second of the unit, and the mounting that holds there.
  EXPECT_EQ(part->contents().statistics.messages, 51U);
  EXPECT_EQ(part->contents().statistics.first, at(7.0));
  std::vector<std::string> topics;
  part->read({}, [&](const io::McapMessage& m) {
    topics.push_back(m.channel->topic);
    return true;
  });
  EXPECT_EQ(topics.front(), "/tf_static");
}

}  // namespace
}  // namespace wayfare::examples
