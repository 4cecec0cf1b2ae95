#pragma once

// Devices on pseudo-terminals, and faulty disks.

#include <atomic>
#include <chrono>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <wayfare/io/text_file.hpp>
#include <wayfare/logger/device_decoder.hpp>
#include <wayfare/logger/logger.hpp>
#include "io/mcap_samples.hpp"
#include "io/support.hpp"
#include "logger/waiting.hpp"

namespace wayfare::testing {

/// A capture, or if absent noise of the same length.
inline std::string capture_or_noise(const std::string& name) {
  const std::string path = recording(name);
  if (!path.empty()) return io::read_file(path)->bytes;
  std::mt19937 random(static_cast<unsigned>(name.size()));
  std::string bytes(100'000, '\0');
  for (char& b : bytes) b = static_cast<char>(random());
  return bytes;
}

struct SimulatedDevice {
  logger::DeviceDescription description;
  double bytes_per_s;   ///< of the real device
  std::string capture;  ///< repeated
};

inline std::vector<SimulatedDevice> four_devices() {
  const std::string living = "devices/rplidar/legacy_scan_bin/living_room_116_steps/frame_0008.bin";
  return {{{"radar", "ti_mmwave", 921600, ""},
           35000.0,
           capture_or_noise("devices/ti_mmwave/awr1843_sdk3.6/mer1.dat.gz")},
          {{"lidar", "rplidar", 115200, ""}, 10000.0, capture_or_noise(living)},
          {{"wearables", "raw", 921600, ""},
           46000.0,
           capture_or_noise("devices/xsens/awinda_mtb/Static/pose1/MT_012012B9_000.mtb.gz")},
          {{"old_radar", "raw", 921600, ""},
           35000.0,
           capture_or_noise("devices/ti_mmwave/xwr1642_sdk1.2/oob_output_data.bin.gz")}};
}

/// Plays a device into its own pseudo-terminal.
class Played {
 public:
  Played(const SimulatedDevice& device, double speed, double seconds)
      : terminal_(std::move(*logger::PseudoTerminal::open())), speed_(speed) {
    const auto n = static_cast<std::size_t>(device.bytes_per_s * speed * seconds);
    while (sent_.size() < n) sent_ += device.capture;
    sent_.resize(n);
    const decode::Bytes bytes(reinterpret_cast<const std::uint8_t*>(sent_.data()), n);
    stream_ = logger::at_rate(bytes, device.bytes_per_s);
  }
  ~Played() { stop(); }

  void start() {
    thread_ =
        std::thread([this] { played_ = play(terminal_, stream_, speed_, stop_).value_or(0); });
  }
  void finish() { thread_.join(); }
  void stop() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }
  [[nodiscard]] const std::string& path() const { return terminal_.path(); }
  [[nodiscard]] const std::string& bytes() const { return sent_; }  ///< to be sent
  [[nodiscard]] std::uint64_t played() const { return played_; }

 private:
  logger::PseudoTerminal terminal_;
  double speed_;
  std::string sent_;
  std::vector<logger::TimedBytes> stream_;
  std::atomic<bool> stop_{false};
  std::atomic<std::uint64_t> played_{0};
  std::thread thread_;
};

/// A file on a disk that stalls on request, or is full from some size on.
class IllDisk {
 public:
  std::atomic<int> stall_ms{0};  ///< of the next write
  std::atomic<int> slow_ms{0};   ///< of every write
  std::atomic<bool> stuck{false};
  std::atomic<int> waiting{0};  ///< writes during a stall
  std::atomic<std::uint64_t> room{UINT64_MAX};

  /// Opens the logger's recordings.
  auto opener() {
    return [this](const std::string& path) -> Result<std::unique_ptr<io::ByteSink>> {
      auto file = io::FileSink::create(path);
      if (!file) return file.error();
      return std::unique_ptr<io::ByteSink>(new Sink(*this, std::move(*file)));
    };
  }

 private:
  class Sink final : public io::ByteSink {
   public:
    Sink(IllDisk& disk, std::unique_ptr<io::ByteSink> file) : disk_(disk), file_(std::move(file)) {}
    Result<void> write(std::string_view bytes) override {
      std::this_thread::sleep_for(
          std::chrono::milliseconds(disk_.stall_ms.exchange(0) + disk_.slow_ms));
      ++disk_.waiting;
      while (disk_.stuck) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      --disk_.waiting;
      if (bytes.size() > disk_.room) return Error{ErrorCode::io, "no space left on the disk"};
      disk_.room -= bytes.size();
      return file_->write(bytes);
    }
    Result<void> sync() override { return file_->sync(); }

   private:
    IllDisk& disk_;
    std::unique_ptr<io::ByteSink> file_;
  };
};

/// Concatenates a channel's messages, and tests whether their stamps never decrease.
struct RawChannel {
  std::string bytes;
  bool monotonic = true;
};

inline RawChannel raw_channel(const io::McapReader& reader, const std::string& topic) {
  RawChannel raw;
  LogTime last;
  reader.read({io::McapOrder::file, {topic}}, [&](const io::McapMessage& m) {
    raw.bytes += m.data;
    raw.monotonic = raw.monotonic && m.log_time >= last;
    last = m.log_time;
    return true;
  });
  return raw;
}

}  // namespace wayfare::testing
