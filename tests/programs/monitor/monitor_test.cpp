// The monitor's server for browsers and other clients.

#include <atomic>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <wayfare/io/text_file.hpp>
#include "monitor_support.hpp"

namespace wayfare::examples {
namespace {

TEST(Monitor, AnswersWhatItsPageAsks) {
  const Recorded recorded;
  const auto server = serve({.recording = recorded.path});
  auto client = client_of(*server);
  EXPECT_THAT(client.Get("/")->body, HasSubstr("<title>wayfare monitor</title>"));
  const std::string contents = client.Get("/api/contents")->body;
  EXPECT_THAT(contents, HasSubstr(R"("messages":2200)"));
  EXPECT_THAT(contents,
              HasSubstr(R"({"messages":100,"schema":"foxglove.LaserScan","topic":"/lidar/scan"})"));
  // 2000 samples in 500 rows: minima and maxima of groups of eight.
  EXPECT_THAT(client.Get("/api/series?topic=/unit/imu&field=linear_acceleration.z&n=500")->body,
              HasSubstr(R"("stride":8)"));
  const auto scan =
      logger::parse_laser_scan(client.Get("/api/message?topic=/lidar/scan&t=7.3")->body);
  ASSERT_TRUE(scan);
  EXPECT_EQ(scan->time, at(7.2));
  EXPECT_THAT(client.Get("/api/walk?topic=/unit/imu")->body, HasSubstr("columns"));
  EXPECT_EQ(client.Get("/api/map.png")->body.substr(1, 3), "PNG");
  EXPECT_EQ(client.Get("/api/message?topic=/none&t=1")->status, 404);
  EXPECT_EQ(client.Get("/api/series?topic=/lidar/raw&field=x")->status, 404);
  EXPECT_EQ(client.Get("/api/events")->status, 404);
  EXPECT_EQ(client.Get("/../etc/passwd")->status, 404);
}

TEST(Monitor, ExportsWhatWasDecoded) {
  const Recorded recorded;
  const auto server = serve({.recording = recorded.path});
  auto client = client_of(*server);
  std::istringstream csv(client.Get("/export.csv?topic=/unit/imu")->body);
  std::string line;
  std::getline(csv, line);
  EXPECT_EQ(line, "t_s,gx_radps,gy_radps,gz_radps,ax_mps2,ay_mps2,az_mps2,mx_uT,my_uT,mz_uT");
  for (const MargSample& s : recorded.samples) {
    ASSERT_TRUE(std::getline(csv, line));
    std::vector<double> v;
    std::istringstream fields(line.substr(line.find(',') + 1));
    for (std::string field; std::getline(fields, field, ',');) v.push_back(std::stod(field));
    ASSERT_EQ(v.size(), 9U);
    EXPECT_EQ(Eigen::Vector3d(v[0], v[1], v[2]), s.angular_rate_radps);
    EXPECT_EQ(Eigen::Vector3d(v[3], v[4], v[5]), s.specific_force_mps2);
    EXPECT_EQ(Eigen::Vector3d(v[6], v[7], v[8]), s.magnetic_field_uT);
  }
  EXPECT_FALSE(std::getline(csv, line));
  EXPECT_THAT(client.Get("/export.csv?topic=/radar/points")->body,
              HasSubstr("1700000000.000000000,1.5,0.5,0,0.4,20\n"));
  const auto original = io::McapReader::open(recorded.path);
  std::istringstream beams(client.Get("/export.csv?topic=/lidar/scan")->body);
  std::getline(beams, line);
  EXPECT_EQ(line, "t_s,bearing_rad,range_m");
  original->read({io::McapOrder::file, {"/lidar/scan"}}, [&](const io::McapMessage& m) {
    const auto scan = logger::parse_laser_scan(m.data);
    bool same = scan.has_value();
    for (std::size_t i = 0; same && i < scan->ranges_m.size(); ++i) {
      std::string t, bearing, range;
      std::getline(std::getline(beams, t, ','), bearing, ',');
      std::getline(beams, range);
      same = t == io::format_nanoseconds(scan->time.nanoseconds()) &&
             std::stod(bearing) == scan->bearing(i).radians() &&
             std::stof(range) == scan->ranges_m[i];
    }
    EXPECT_TRUE(same) << m.sequence;
    return same;
  });
  EXPECT_FALSE(std::getline(beams, line));
  for (const std::string topic : {"", "/lidar/scan"}) {
    const auto copy =
        io::McapReader::parse(client.Get("/export.mcap?topic=" + topic)->body, "export");
    ASSERT_TRUE(copy);
    EXPECT_TRUE(copy->contents().indexed);
    io::McapQuery query;
    if (!topic.empty()) query.topics = {topic};
    EXPECT_EQ(read_all(*copy), read_all(*original, query));
  }
}

TEST(Monitor, DemandsItsToken) {
  const Recorded recorded;
  // Other addresses than loopback always have a token.
  EXPECT_EQ(serve({.recording = recorded.path, .host = "0.0.0.0"})->token().size(), 32U);
  EXPECT_EQ(serve({.recording = recorded.path})->token(), "");
  const auto server = serve({.recording = recorded.path, .token = "sesame"});
  auto client = client_of(*server);
  for (const std::string path : {"/", "/api/contents", "/export.mcap", "/none"}) {
    EXPECT_EQ(client.Get(path)->status, 401) << path;
    EXPECT_EQ(client.Get(path + "?token=sesam")->status, 401) << path;
    EXPECT_EQ(client.Get(path, {{"Authorization", "Bearer Sesame"}})->status, 401) << path;
  }
  EXPECT_EQ(client.Post("/api/command", "B", "text/plain")->status, 401);
  EXPECT_EQ(client.Get("/api/contents?token=sesame")->status, 200);
  EXPECT_EQ(client.Get("/api/contents", {{"Authorization", "Bearer sesame"}})->status, 200);
}

TEST(Monitor, AHundredClientsDoNoHarm) {
  const Recorded recorded;
  const auto server = serve({.recording = recorded.path});
  std::atomic<int> answered{0}, refused{0}, odd{0};
  std::vector<std::thread> clients;
  for (int i = 0; i < 100; ++i)
    clients.emplace_back([&] {
      for (const char* path :
           {"/", "/api/contents", "/api/series?topic=/unit/imu&field=angular_velocity.x"}) {
        const auto answer = client_of(*server).Get(path);
        const int status = answer ? answer->status : 0;
        ++(status == 200 ? answered : status == 429 || status == 503 ? refused : odd);
      }
    });
  for (std::thread& client : clients) client.join();
  EXPECT_EQ(odd, 0);
  EXPECT_GE(answered, 100);
  EXPECT_EQ(answered + refused, 300);
  EXPECT_TRUE(
      wait_for(20s, [&] { return client_of(*server).Get("/api/contents")->status == 200; }));
}

TEST(Monitor, ShowsAndControlsALiveLogger) {
  const Live live;
  const auto server = serve({.live = live.folder / "control", .listeners = 2});
  auto client = client_of(*server);
  const auto command = [&](const std::string& body) {
    const auto answer = client.Post("/api/command", by(*server), body, "text/plain");
    return answer ? answer->status : 0;
  };
  EXPECT_EQ(command("X"), 400);
  EXPECT_EQ(command("BS"), 400);
  EXPECT_TRUE(wait_for(20s, [&] { return command("B") == 200; }));
  EXPECT_TRUE(live.is(logger::LoggerState::recording));
  std::string events;
  client.Get("/api/events", [&](const char* data, std::size_t n) {
    events.append(data, n);
    return events.find("\"state\":\"recording\"") == events.npos && events.size() < 100'000;
  });
  EXPECT_THAT(events, HasSubstr("data: {\"state\":\"recording\""));
  // The growing recording can be viewed.
  EXPECT_TRUE(wait_for(20s, [&] { return client.Get("/api/contents")->status == 200; }));
  EXPECT_EQ(command("S"), 200);
  EXPECT_TRUE(live.is(logger::LoggerState::idle));

  std::atomic<bool> enough{false};
  std::vector<std::thread> listeners;
  std::atomic<int> listening{0};
  // The place of the stream above is free again once the server finds it closed.
  for (int i = 0; i < 2; ++i)
    listeners.emplace_back([&] {
      bool counted = false;
      const auto accepted = [](const httplib::Response& answer) { return answer.status == 200; };
      const auto listen = [&](const char*, std::size_t) {
        if (!counted) ++listening;
        counted = true;
        return !enough;
      };
      while (!counted && !enough) {
        client_of(*server).Get("/api/events", accepted, listen);
        std::this_thread::sleep_for(20ms);  // below the limit of requests
      }
    });
  EXPECT_TRUE(wait_for(20s, [&] { return listening == 2; }));
  int third = 0;
  client_of(*server).Get(
      "/api/events", [&](const httplib::Response& answer) { return third = answer.status, false; },
      [](const char*, std::size_t) { return false; });
  EXPECT_EQ(third, 503);
  enough = true;
  for (std::thread& listener : listeners) listener.join();
  EXPECT_EQ(command("T"), 200);
  EXPECT_TRUE(live.is(logger::LoggerState::terminated));
}

TEST(Monitor, OutlastsTheLogger) {
  auto live = std::make_unique<Live>();
  const auto server = serve({.live = live->folder / "control"});
  auto client = client_of(*server);
  const auto check = [&] {
    return client.Post("/api/command", by(*server), "C", "text/plain")->status;
  };
  EXPECT_TRUE(wait_for(20s, [&] { return check() == 200; }));
  live->running.reset();
  EXPECT_TRUE(wait_for(20s, [&] { return check() == 502; }));
  EXPECT_EQ(client.Get("/api/contents")->status, 404);
}

TEST(Monitor, SaysWhatItCannotShow) {
  EXPECT_FALSE(MonitorServer::start({}));
  EXPECT_FALSE(MonitorServer::start({.recording = "/nowhere.mcap"}));
  EXPECT_FALSE(MonitorServer::start({.live = "/nowhere", .host = "nowhere.invalid", .port = 0}));
}

}  // namespace
}  // namespace wayfare::examples
