// The monitor under hostile load: soak_monitor [--minutes M]. Strangers send broken, endless, slow
// and foreign requests, idle streams and commands without the token; one user is answered all the
// while, within seconds, and neither memory nor open files grow.

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

#include <wayfare/core/random.hpp>

#include "programs/monitor/monitor_support.hpp"
#include "soak/soak.hpp"

namespace wayfare::soak {
namespace {

using namespace std::chrono_literals;

/// What strangers send; some never end, some are not HTTP.
std::string hostile_request(Rng& rng) {
  static const std::array<std::string, 12> heads = {
      "GET / HTTP/1.1\r\nHost: evil.example\r\n\r\n",
      "GET /api/events?topic=/unit/imu HTTP/1.1\r\nHost: localhost\r\n\r\n",
      "GET /export.csv?topic=/unit/imu HTTP/1.1\r\nHost: localhost\r\n\r\n",
      "GET /api/series?topic=/unit/imu&field=a&from=-1e308&to=nan HTTP/1.1\r\nHost: "
      "localhost\r\n\r\n",
      "POST /api/command HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1\r\n\r\nT",
      "POST /api/command HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99999999999\r\n\r\n",
      "POST /api/command HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: "
      "chunked\r\n\r\nFFFFFFFFFFFFFFFF\r\n",
      "GET /../../../../etc/passwd HTTP/1.1\r\nHost: localhost\r\n\r\n",
      "GET /%2e%2e/%00%ff?%=&&== HTTP/1.1\r\nHost: localhost\r\n\r\n",
      "GET / HTTP/1.1\r\nRange: bytes=0-,-1,5-1,0-0,0-0,0-0\r\nHost: localhost\r\n\r\n",
      "GET / HT",
      std::string("\x16\x03\x01\x02\0\x01\0", 7)};
  std::string text = heads[rng.below(heads.size())];
  switch (rng.below(4)) {
    case 0:
      for (auto k = 1 + rng.below(8); k > 0; --k)
        text[rng.below(text.size())] = static_cast<char>(rng());
      break;
    case 1:
      text += std::string(rng.below(200'000), static_cast<char>(rng()));
      break;
    case 2:
      text.resize(rng.below(text.size()));
      break;
    default:
      break;
  }
  return text;
}

/// Connects, sends, reads a little or nothing, stays for a while.
void attack(int port, std::uint64_t seed, const std::atomic<bool>& stop,
            std::atomic<std::uint64_t>& requests) {
  Rng rng(seed);
  std::vector<int> open;
  while (!stop) {
    const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    (void)::connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address);
    std::this_thread::sleep_for(std::chrono::microseconds(rng.below(4000)));
    const std::string text = hostile_request(rng);
    (void)::send(fd, text.data(), text.size(), MSG_NOSIGNAL);
    ++requests;
    if (rng.below(3) == 0) {
      std::array<char, 4096> answer{};
      (void)::recv(fd, answer.data(), answer.size(), MSG_DONTWAIT);
    }
    open.push_back(fd);
    while (open.size() > 60 || (!open.empty() && rng.below(2) == 0)) {
      const std::size_t k = rng.below(open.size());
      ::close(open[k]);
      open.erase(open.begin() + static_cast<std::ptrdiff_t>(k));
    }
  }
  for (const int fd : open) ::close(fd);
}

int run(Time& time) {
  const examples::Live live;
  auto server =
      examples::serve({.live = live.folder / "control", .token_file = live.folder / "token"});
  require(server != nullptr, "the monitor does not start");
  std::atomic<bool> stop{false};
  std::atomic<std::uint64_t> requests{0};
  std::vector<std::thread> attackers;
  for (std::uint64_t k = 0; k < 4; ++k)
    attackers.emplace_back([&, k] { attack(server->port(), k + 1, stop, requests); });
  std::uint64_t answered = 0, turned_away = 0;
  double worst_s = 0.0, begin_MB = 0.0;
  long begin_files = 0;
  for (std::uint64_t round = 0; !time.is_over(); ++round) {
    const auto asked = Clock::now();
    auto client = examples::client_of(*server);
    const auto page = client.Get("/api/about", examples::by(*server));
    // In a crowd a connection may be closed at once; it may not be left waiting.
    require(page || Clock::now() - asked < 5s, "no answer");
    (page && page->status == 200 ? answered : turned_away) += 1;
    worst_s = std::max(worst_s, std::chrono::duration<double>(Clock::now() - asked).count());
    require(worst_s < 10.0, "an answer took more than ten seconds");
    if (round == 200) begin_MB = memory_MB(), begin_files = open_files();
    if (round > 200) require(memory_MB() < begin_MB + 100.0, "memory grows");
    if (round > 200) require(open_files() < begin_files + 600, "open files grow");
    std::this_thread::sleep_for(20ms);
    time.show(std::to_string(requests.load()) + " hostile requests");
  }
  stop = true;
  for (std::thread& attacker : attackers) attacker.join();
  require(examples::wait_for(60s,
                             [&] {
                               const auto page = examples::client_of(*server).Get("/api/about");
                               return page && page->status == 200;
                             }),
          "no answer after the attack");
  require(answered > turned_away,
          "the user was turned away more often than answered: " + std::to_string(turned_away));
  std::printf(
      "%llu hostile requests; the user was answered %llu times and turned away %llu times, at most "
      "after "
      "%.2f s; %.0f MB of memory\n",
      static_cast<unsigned long long>(requests.load()), static_cast<unsigned long long>(answered),
      static_cast<unsigned long long>(turned_away), worst_s, memory_MB());
  return 0;
}

}  // namespace
}  // namespace wayfare::soak

int main(int argc, char** argv) {
  wayfare::soak::Time time(argc, argv, "Attacks a monitor of a live logger.");
  return wayfare::soak::run(time);
}
