// Requests of strangers: other sites' pages, endless headers, slow connections, other users.

#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <string>
#include <vector>

#include "logger/listening.hpp"
#include "monitor_support.hpp"

namespace wayfare::examples {
namespace {

TEST(Monitor, KeepsOtherSitesOut) {
  const Recorded recorded;
  const auto server = serve({.recording = recorded.path});
  auto client = client_of(*server);
  for (const char* host : {"evil.example", "127.evil.com", "127.0.0.1.nip.io", "127.0.0.1.",
                           "127.1", "127.0.0.256", "localhost.evil.com", "::2", "[::1].evil.com",
                           "0x7f000001", "2130706433", "128.0.0.1", "a"})
    EXPECT_EQ(client.Get("/api/contents", {{"Host", host}})->status, 403) << host;
  for (const char* host : {"localhost:1", "LocalHost", "127.0.0.1", "127.8.9.1:80", "[::1]:8090"})
    EXPECT_EQ(client.Get("/api/contents", {{"Host", host}})->status, 200) << host;
  const std::string here = "localhost:" + std::to_string(server->port());
  const auto from = [&](const std::string& origin) {
    return client.Get("/api/contents", {{"Host", here}, {"Origin", origin}})->status;
  };
  EXPECT_EQ(from("http://" + here), 200);
  for (const char* origin :
       {"http://evil.example", "https://localhost", "http://localhost:1", "null"})
    EXPECT_EQ(from(origin), 403) << origin;
  EXPECT_EQ(client.Post("/api/command", "B", "text/plain")->status, 403);
}

TEST(Monitor, HasFurtherNames) {
  const Recorded recorded;
  const auto server = serve({.recording = recorded.path, .host_names = {"robot.example"}});
  auto client = client_of(*server);
  EXPECT_EQ(client.Get("/api/contents", {{"Host", "Robot.Example:8090"}})->status, 200);
  EXPECT_EQ(client.Get("/api/contents", {{"Host", "a.robot.example"}})->status, 403);
}

TEST(Monitor, CommandsNeedTheToken) {
  const Live live;
  const std::string file = live.folder / "token";
  auto server = serve({.live = live.folder / "control", .token_file = file});
  auto client = client_of(*server);
  const auto command = [&](const httplib::Headers& headers) {
    return client.Post("/api/command", headers, "C", "text/plain")->status;
  };
  EXPECT_TRUE(wait_for(20s, [&] { return command(by(*server)) == 200; }));
  EXPECT_EQ(command({{"X-Wayfare", "1"}}), 401);
  EXPECT_EQ(command({{"X-Wayfare", "1"}, {"Authorization", "Bearer "}}), 401);
  httplib::Headers foreign = by(*server);
  foreign.emplace("Origin", "http://evil.example");
  EXPECT_EQ(command(foreign), 403);
  EXPECT_EQ(client.Get("/api/about")->status, 200);
  EXPECT_THAT(server->url(), HasSubstr("/#token=" + server->token()));
  // Other users cannot read the file.
  std::string token;
  std::getline(std::ifstream(file), token);
  EXPECT_EQ(token, server->token());
  struct stat status {};
  ASSERT_EQ(::stat(file.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0600U);
  server.reset();
  EXPECT_NE(::stat(file.c_str(), &status), 0);
}

TEST(Monitor, ATokensFileReplacesALink) {
  const Live live;
  const std::string target = live.folder / "target", file = live.folder / "token";
  std::ofstream(target) << "kept";
  ASSERT_EQ(::symlink(target.c_str(), file.c_str()), 0);
  const auto server = serve({.live = live.folder / "control", .token_file = file});
  std::string content;
  std::getline(std::ifstream(target), content);
  EXPECT_EQ(content, "kept");
  EXPECT_FALSE(MonitorServer::start(
      {.live = live.folder / "control", .port = 0, .token_file = live.folder / "none/token"}));
}

TEST(Monitor, BoundsRequestsInSizeAndRate) {
  const Recorded recorded;
  const auto server = serve({.recording = recorded.path, .requests_per_s = 20.0});
  auto client = client_of(*server);
  EXPECT_EQ(client.Post("/api/command", std::string(10'000, 'B'), "text/plain")->status, 413);
  EXPECT_EQ(client.Get("/" + std::string(10'000, 'x'))->status, 414);
  const auto header = client.Get("/", {{"X-Long", std::string(100'000, 'x')}});
  EXPECT_TRUE(!header || header->status >= 400);
  int refused = 0;
  for (int i = 0; i < 100; ++i) refused += client_of(*server).Get("/")->status == 429 ? 1 : 0;
  EXPECT_GT(refused, 20);
  EXPECT_TRUE(wait_for(20s, [&] { return client_of(*server).Get("/")->status == 200; }));
}

int connected(int port) {
  const int fd = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(::connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  return fd;
}

/// A connection that sends only `text`.
int half_a_request(int port, const std::string& text) {
  const int fd = connected(port);
  EXPECT_EQ(::send(fd, text.data(), text.size(), MSG_NOSIGNAL), static_cast<ssize_t>(text.size()));
  return fd;
}

TEST(Monitor, SlowClientsHoldNobodyUp) {
  const Recorded recorded;
  const auto server = serve({.recording = recorded.path});
  std::vector<int> slow;
  for (int i = 0; i < 40; ++i)
    slow.push_back(half_a_request(server->port(), i % 2 == 0
                                                      ? "GET /api/contents HT"
                                                      : "GET /export.csv?topic=/unit/imu "
                                                        "HTTP/1.1\r\nHost: localhost\r\n\r\n"));
  auto client = client_of(*server);
  EXPECT_EQ(client.Get("/")->status, 200);
  // Incomplete requests time out.
  EXPECT_TRUE(wait_for(20s, [&] {
    char byte = 0;
    return ::recv(slow[0], &byte, 1, MSG_DONTWAIT) == 0 || (errno != EAGAIN);
  }));
  for (const int fd : slow) ::close(fd);
}

TEST(Monitor, TricklingConnectionsDelayNobody) {
  const Recorded recorded;
  // Without a shorter deadline in a crowd the client below would wait for ten minutes.
  const auto server = serve({.recording = recorded.path, .connections = 32, .request_s = 600.0});
  std::vector<int> slow;
  for (int i = 0; i < 40; ++i) slow.push_back(half_a_request(server->port(), "GET / HT"));
  auto client = client_of(*server);
  const auto answer = client.Get("/");
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->status, 200);
  for (const int fd : slow) ::close(fd);
}

// Streams that are not read, more of them than there are connections.
TEST(Monitor, IdleStreamsDelayNobody) {
  const Live live;
  const auto server = serve({.live = live.folder / "control"});
  std::vector<int> idle;
  for (int i = 0; i < 140; ++i)
    idle.push_back(half_a_request(
        server->port(), "GET /api/events?topic=/unit/imu HTTP/1.1\r\nHost: localhost\r\n\r\n"));
  auto client = client_of(*server);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(client_of(*server).Get("/api/about")->status, 200);
  // All but the listeners are refused.
  int streams = 0, refused = 0;
  for (const int fd : idle) {
    std::string answer(12, '\0');
    EXPECT_EQ(::recv(fd, answer.data(), answer.size(), MSG_WAITALL), 12);
    ++(answer == "HTTP/1.1 200" ? streams : refused);
  }
  EXPECT_EQ(streams, 32);
  EXPECT_EQ(refused, 108);
  EXPECT_EQ(client.Post("/api/command", by(*server), "C", "text/plain")->status, 200);
  for (const int fd : idle) ::close(fd);
}

/// Heads of requests, and pieces of which they never have enough.
const std::vector<std::pair<std::string, std::string>>& endless_requests() {
  static const std::vector<std::pair<std::string, std::string>> all{
      {"GET /", std::string(5000, 'x')},
      {"GET / HTTP/1.1\r\nX-Long: ", std::string(5000, 'x')},
      {"GET / HTTP/1.1\r\n", "X-Many: " + std::string(1000, 'x') + "\r\n"},
      {"POST /api/command HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n",
       "3e8\r\n" + std::string(1000, 'x') + "\r\n"},
      {"POST /api/command HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n", std::string(5000, '1')}};
  return all;
}

/// Sends `head`, then pieces up to `most` bytes or until the server closes the connection.
std::size_t send_pieces(int fd, const std::string& head, const std::string& piece,
                        std::size_t most) {
  std::size_t sent = 0;
  for (const std::string* part = &head; sent < most; part = &piece) {
    const ssize_t n = ::send(fd, part->data(), part->size(), MSG_NOSIGNAL);
    if (n <= 0) break;
    sent += static_cast<std::size_t>(n);
  }
  return sent;
}

TEST(Monitor, CutsEndlessRequestsOff) {
  constexpr std::size_t kMost = 64'000'000;  // the system buffers megabytes
  const Recorded recorded;
  const auto server = serve({.recording = recorded.path, .token = "sesame"});
  for (const auto& [head, piece] : endless_requests()) {
    const int fd = connected(server->port());
    EXPECT_LT(send_pieces(fd, head, piece, kMost), kMost) << head;
    ::close(fd);
  }
}

/// Bytes of this process in memory, the server's among them.
double resident_bytes() {
  double all = 0.0, resident = 0.0;
  std::ifstream("/proc/self/statm") >> all >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE));
}

TEST(Monitor, ListensOnThisComputerOnly) {
  const auto before = testing::listened_addresses();
  const Recorded recorded;
  MonitorOptions options;
  options.recording = recorded.path;
  const auto server = serve(options);
  auto now = testing::listened_addresses();
  for (const std::string& address : before) std::erase(now, address);
  ASSERT_EQ(now.size(), 1U);
  EXPECT_THAT(now[0], ::testing::StartsWith("0100007F:")) << "127.0.0.1";
  options.host = "0.0.0.0";  // what the test finds where it is asked for
  const auto open = serve(options);
  EXPECT_THAT(testing::listened_addresses(),
              ::testing::Contains(::testing::StartsWith("00000000:")));
}

TEST(Monitor, TenThousandHostileRequestsTakeNoMemory) {
  constexpr std::size_t kBytes = 20'000;  // more than the server reads of one request
  const Recorded recorded;
  const auto server = serve({.recording = recorded.path, .token = "sesame"});
  const auto attack = [&](std::size_t requests) {
    for (std::size_t i = 0; i < requests; ++i) {
      const auto& [head, piece] = endless_requests()[i % endless_requests().size()];
      const int fd = connected(server->port());
      send_pieces(fd, head, piece, kBytes);
      char answer[256];
      while (::recv(fd, answer, sizeof answer, 0) > 0) {
      }
      ::close(fd);
    }
  };
  attack(1000);
  const double before = resident_bytes();
  attack(10'000);
  EXPECT_LT(resident_bytes(), 1.2 * before);
  EXPECT_TRUE(
      wait_for(20s, [&] { return client_of(*server).Get("/?token=sesame")->status == 200; }));
}

}  // namespace
}  // namespace wayfare::examples
