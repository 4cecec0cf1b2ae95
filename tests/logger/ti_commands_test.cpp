// A configuration sent to a simulated radar on a pseudo-terminal.
#include <wayfare/logger/ti_commands.hpp>

#include <atomic>
#include <chrono>
#include <string>
#include <thread>
#include <utility>

#include <gmock/gmock.h>

namespace wayfare::logger {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

/// Answers each line: an error to those that begin with `refused`, nothing to those with `ignored`.
class SimulatedRadar {
 public:
  SimulatedRadar(std::string refused, std::string ignored)
      : refused_(std::move(refused)), ignored_(std::move(ignored)) {
    thread_ = std::thread([this] { run(); });
  }
  ~SimulatedRadar() {
    quit_ = true;
    thread_.join();
  }
  [[nodiscard]] const std::string& path() const { return terminal_.path(); }
  [[nodiscard]] int lines() const { return lines_; }

 private:
  void run() {
    std::array<std::uint8_t, 256> buffer{};
    std::string held;
    while (!quit_) {
      const auto n = terminal_.read(buffer, 10ms);
      held.append(buffer.begin(), buffer.begin() + static_cast<long>(n.value_or(0)));
      for (auto end = held.find('\n'); end != held.npos; end = held.find('\n')) {
        answer(held.substr(0, end));
        held.erase(0, end + 1);
      }
    }
  }
  void answer(const std::string& line) {
    ++lines_;
    if (!ignored_.empty() && line.starts_with(ignored_)) return;
    const bool refuse = !refused_.empty() && line.starts_with(refused_);
    const std::string text = line + "\r\n" + (refuse ? "Error -1" : "Done") + "\n\rmmwDemo:/>";
    static_cast<void>(
        terminal_.write({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, 1s));
  }

  PseudoTerminal terminal_ = std::move(*PseudoTerminal::open());
  std::string refused_, ignored_;
  std::atomic<bool> quit_{false};
  std::atomic<int> lines_{0};
  std::thread thread_;
};

constexpr std::string_view kConfig =
    "% radar\nsensorStop\nflushCfg\nchannelCfg 15 5 0\nsensorStart\n";

Result<void> send(const SimulatedRadar& radar, Duration timeout) {
  auto port = SerialPort::open(radar.path());
  if (!port) return port.error();
  return send_ti_config(*port, kConfig, "radar.cfg", timeout);
}

TEST(TiCommands, AreSentAndAnswered) {
  const SimulatedRadar radar("", "");
  const auto sent = send(radar, 5s);
  EXPECT_TRUE(sent) << sent.error().to_string();
  EXPECT_EQ(radar.lines(), 4);
}

TEST(TiCommands, AnErrorHasItsLine) {
  const SimulatedRadar radar("channelCfg", "");
  const auto sent = send(radar, 5s);
  ASSERT_FALSE(sent);
  EXPECT_THAT(sent.error().to_string(),
              HasSubstr("radar.cfg:4: 'channelCfg 15 5 0': the sensor answered 'Error -1'"));
  EXPECT_EQ(radar.lines(), 3) << "nothing is sent after an error";
}

TEST(TiCommands, NoAnswerIsAnError) {
  const SimulatedRadar radar("", "flushCfg");
  const auto sent = send(radar, 100ms);
  ASSERT_FALSE(sent);
  EXPECT_THAT(sent.error().to_string(), HasSubstr("radar.cfg:3: 'flushCfg': no answer"));
}

TEST(TiCommands, CanBeStopped) {
  const SimulatedRadar radar("", "sensorStop");
  auto port = SerialPort::open(radar.path());
  ASSERT_TRUE(port);
  const std::atomic<bool> stop{true};
  const auto sent = send_ti_config(*port, kConfig, "radar.cfg", 60s, &stop);
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace wayfare::logger
