// The logger at ten times the devices' rates, with faults at random: soak_logger [--minutes M].
// Lines are unplugged and plugged in again, the disk stalls, is slow or full, recordings are
// stopped and begun. Every file can be read, has what the status counts, and misses nothing but
// what is counted as dropped.

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <wayfare/core/random.hpp>

#include "logger/simulated_devices.hpp"
#include "soak/soak.hpp"

namespace wayfare::soak {
namespace {

using namespace std::chrono_literals;
using testing::IllDisk;
using testing::TemporaryFolder;

constexpr std::size_t kLine = 16;  // bytes of a numbered line

/// A device that sends without end, behind a link that lasts when its line is unplugged.
class Line {
 public:
  /// `more(bytes)`: the next bytes to send, about as many.
  Line(std::string link, double bytes_per_s, std::function<std::string(std::size_t)> more)
      : link_(std::move(link)), bytes_per_s_(bytes_per_s), more_(std::move(more)) {
    plug();
  }
  ~Line() { unplug(); }
  Line(const Line&) = delete;
  Line& operator=(const Line&) = delete;

  void plug() {
    terminal_ =
        std::make_unique<logger::PseudoTerminal>(std::move(*logger::PseudoTerminal::open()));
    std::filesystem::remove(link_);
    std::filesystem::create_symlink(terminal_->path(), link_);
    stop_ = false;
    thread_ = std::thread([this] { send(); });
  }
  void unplug() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
    terminal_.reset();
  }

 private:
  void send() {
    while (!stop_) {
      const std::string bytes = more_(static_cast<std::size_t>(0.02 * bytes_per_s_));
      const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
      (void)terminal_->write({data, bytes.size()}, 500ms);
      std::this_thread::sleep_for(20ms);
    }
  }

  std::string link_;
  double bytes_per_s_;
  std::function<std::string(std::size_t)> more_;
  std::unique_ptr<logger::PseudoTerminal> terminal_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// Lines of consecutive numbers.
std::string numbered(std::uint64_t& next, std::size_t bytes) {
  std::string text;
  while (text.size() < bytes) {
    std::array<char, kLine + 1> line{};
    std::snprintf(line.data(), line.size(), "%015llu\n", static_cast<unsigned long long>(next++));
    text += line.data();
  }
  return text;
}

/// The next piece of a capture that repeats.
std::string piece(const std::string& capture, std::size_t& at, std::size_t bytes) {
  std::string text;
  for (; text.size() < bytes; at = (at + 1) % capture.size()) text += capture[at];
  return text;
}

struct Totals {
  std::uint64_t files = 0, bytes = 0, lines = 0, broken = 0;
};

/// Whole lines with increasing numbers; where lines are missing, the recording says so.
void check_numbers(const std::string& bytes, bool gaps_allowed, const std::string& where,
                   Totals& totals) {
  unsigned long long last = 0;
  bool any = false;
  std::size_t at = std::min(bytes.find('\n'), bytes.size());
  for (at = at == bytes.size() ? at : at + 1; at + kLine <= bytes.size();) {
    const std::string line = bytes.substr(at, kLine);
    const bool whole = line.back() == '\n' &&
                       line.find_first_not_of("0123456789\n") == std::string::npos &&
                       line.find('\n') == kLine - 1;
    if (!whole) {
      require(gaps_allowed, where + ": a line is broken: " + line);
      ++totals.broken;
      const std::size_t end = bytes.find('\n', at);
      at = end == std::string::npos ? bytes.size() : end + 1;
      continue;
    }
    const unsigned long long number = std::stoull(line);
    require(!any || number > last, where + ": lines out of order");
    require(!any || gaps_allowed || number == last + 1,
            where + ": lines are missing after " + std::to_string(last));
    last = number;
    any = true;
    ++totals.lines;
    at += kLine;
  }
}

void check_files(const std::string& folder, const std::vector<std::string>& names,
                 bool gaps_allowed, Totals& totals) {
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".mcap") continue;
    const auto reader = io::McapReader::open(entry.path().string());
    require(static_cast<bool>(reader), entry.path().string() + " cannot be read: " +
                                           (reader ? "" : reader.error().to_string()));
    for (const std::string& name : names) {
      const auto raw = testing::raw_channel(*reader, "/" + name + "/raw");
      require(raw.monotonic, name + ": times decrease");
      if (name.starts_with("numbers")) check_numbers(raw.bytes, gaps_allowed, name, totals);
      totals.bytes += raw.bytes.size();
    }
    ++totals.files;
    std::filesystem::remove(entry.path());
  }
}

int run(Time& time) {
  constexpr double kSpeed = 10.0;
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  std::filesystem::create_directories(out);
  IllDisk disk;
  std::vector<std::unique_ptr<Line>> lines;
  logger::LoggerOptions options;
  std::vector<std::string> names;
  const auto add = [&](const logger::DeviceDescription& device, double bytes_per_s, auto more) {
    lines.push_back(std::make_unique<Line>(folder / device.name, kSpeed * bytes_per_s, more));
    options.sensors.push_back({});
    options.sensors.back().device = device;
    options.sensors.back().port = folder / device.name;
    if (device.kind == "rplidar") options.sensors.back().mode = "listen";  // it answers no request
    names.push_back(device.name);
  };
  for (const std::string name : {"numbers_a", "numbers_b"})
    add({name, "raw", 921600, ""}, 20'000.0,
        [next = std::uint64_t{0}](std::size_t n) mutable { return numbered(next, n); });
  for (const auto& device : testing::four_devices())
    add(device.description, device.bytes_per_s,
        [capture = device.capture, at = std::size_t{0}](std::size_t n) mutable {
          return piece(capture, at, n);
        });
  options.folder = out;
  options.status_every = 200ms;
  options.queue_bytes = std::size_t{16} << 20;
  options.rotate_bytes = std::uint64_t{8} << 20;
  options.open_sink = disk.opener();
  auto logger = logger::Logger::start(options);
  require(static_cast<bool>(logger), logger ? "" : logger.error().to_string());
  Rng rng(static_cast<std::uint64_t>(std::chrono::system_clock::now().time_since_epoch().count()));
  Totals totals;
  std::uint64_t recordings = 0, failed = 0, unplugged = 0, dropped = 0;
  while (!time.is_over()) {
    require(static_cast<bool>((*logger)->begin()), "a recording cannot be begun");
    bool line_lost = false;
    for (auto faults = rng.below(6); faults > 0; --faults) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50 + rng.below(800)));
      const std::size_t which = rng.below(lines.size());
      switch (rng.below(5)) {
        case 0:
          disk.stall_ms = static_cast<int>(rng.below(1500));
          break;
        case 1:
          disk.slow_ms = static_cast<int>(rng.below(60));
          break;
        case 2:
          disk.room = rng.below(4'000'000);  // full after that
          break;
        case 3:
          lines[which]->unplug();
          std::this_thread::sleep_for(std::chrono::milliseconds(rng.below(700)));
          lines[which]->plug();
          line_lost = true;
          ++unplugged;
          break;
        default:
          break;
      }
    }
    std::this_thread::sleep_for(300ms);
    disk.slow_ms = 0;
    (*logger)->stop();
    require((*logger)->wait_until_stopped(60s), "the recording does not end");
    const logger::LoggerStatus status = (*logger)->status();
    require(
        status.state == logger::LoggerState::idle || status.state == logger::LoggerState::failed,
        std::string("state after a stop: ") + logger::name_of(status.state));
    failed += status.state == logger::LoggerState::failed ? 1 : 0;
    dropped += status.dropped;
    ++recordings;
    const std::uint64_t before = totals.bytes;
    check_files(out, names,
                line_lost || status.dropped > 0 || status.state == logger::LoggerState::failed,
                totals);
    std::uint64_t counted = 0;
    for (const auto& sensor : status.sensors) counted += sensor.recorded_bytes;
    require(counted <= totals.bytes - before,
            "more is counted as recorded than the files have: " + std::to_string(counted) +
                " and " + std::to_string(totals.bytes - before));
    disk.room = UINT64_MAX;
    require(memory_MB() < 400.0, "memory grows");
    time.show(std::to_string(recordings) + " recordings");
  }
  (*logger)->terminate();
  std::printf(
      "%llu recordings in %llu files, %.0f MB, %llu numbered lines; %llu ended by a full disk, "
      "%llu records "
      "dropped and counted, lines unplugged %llu times\n",
      static_cast<unsigned long long>(recordings), static_cast<unsigned long long>(totals.files),
      static_cast<double>(totals.bytes) / 1e6, static_cast<unsigned long long>(totals.lines),
      static_cast<unsigned long long>(failed), static_cast<unsigned long long>(dropped),
      static_cast<unsigned long long>(unplugged));
  return 0;
}

}  // namespace
}  // namespace wayfare::soak

int main(int argc, char** argv) {
  wayfare::soak::Time time(
      argc, argv, "Records simulated devices at ten times their rates, with faults at random.");
  return wayfare::soak::run(time);
}
