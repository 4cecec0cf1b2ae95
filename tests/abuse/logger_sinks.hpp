#pragma once

// Sinks in memory that are slow and that fail, and a logger with one raw device whose records are
// numbered.

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/io/mcap.hpp>
#include <wayfare/logger/logger.hpp>
#include "logger/waiting.hpp"

namespace wayfare::tests {

/// What the sinks of a test do, and what they took. Changed while they work.
class Disk {
 public:
  struct File {
    std::string path, bytes;
  };
  std::atomic<int> delay_us{0};          ///< of every write
  std::atomic<std::int64_t> writes{-1};  ///< until all fail; negative: any number
  std::atomic<std::int64_t> syncs{-1};   ///< likewise
  std::atomic<std::int64_t> creations{-1};
  std::atomic<bool> half{false};  ///< a write that fails takes half of its bytes
  std::function<void()> on_write = {};

  auto opener() {
    return [this](const std::string& path) -> Result<std::unique_ptr<io::ByteSink>> {
      if (spent(creations)) return Error{ErrorCode::io, "the disk is gone", path};
      const auto file = std::make_shared<File>(File{path, {}});
      const std::lock_guard lock(mutex_);
      files_.push_back(file);
      return std::unique_ptr<io::ByteSink>(new Sink(*this, file));
    };
  }
  [[nodiscard]] std::vector<std::shared_ptr<File>> files() const {
    const std::lock_guard lock(mutex_);
    return files_;
  }
  /// Everything works again.
  void repair() { writes = syncs = creations = -1; }

 private:
  class Sink final : public io::ByteSink {
   public:
    Sink(Disk& disk, std::shared_ptr<File> file) : disk_(disk), file_(std::move(file)) {}
    Result<void> write(std::string_view bytes) override {
      std::this_thread::sleep_for(std::chrono::microseconds(disk_.delay_us));
      if (disk_.on_write) disk_.on_write();
      if (spent(disk_.writes)) {
        if (disk_.half) file_->bytes += bytes.substr(0, bytes.size() / 2);
        return Error{ErrorCode::io, "no space left", file_->path};
      }
      file_->bytes += bytes;
      return {};
    }
    Result<void> sync() override {
      if (spent(disk_.syncs)) return Error{ErrorCode::io, "cannot be flushed", file_->path};
      return {};
    }

   private:
    Disk& disk_;
    const std::shared_ptr<File> file_;
  };

  static bool spent(std::atomic<std::int64_t>& left) {
    std::int64_t n = left;
    while (n > 0 && !left.compare_exchange_weak(n, n - 1)) {
    }
    return n == 0;
  }

  mutable std::mutex mutex_;
  std::vector<std::shared_ptr<File>> files_;
};

/// The records of the device in a file, each of which is one number.
inline std::vector<std::uint32_t> numbers_in(const std::string& bytes) {
  std::vector<std::uint32_t> numbers;
  const auto reader = io::McapReader::parse(bytes, "memory");
  if (!reader) return numbers;
  reader->read({io::McapOrder::file, {"/unit/raw"}}, [&](const io::McapMessage& m) {
    EXPECT_EQ(m.data.size(), 8U) << "one record for each piece";
    numbers.push_back(static_cast<std::uint32_t>(std::stoul(std::string(m.data))));
    return true;
  });
  return numbers;
}

/// A logger of one device on a pseudo-terminal, into `disk`.
struct Bench {
  explicit Bench(Disk& d) : disk(d), terminal(std::move(*logger::PseudoTerminal::open())) {
    logger::SensorOptions sensor;
    sensor.device = {"unit", "raw", 115200, ""};
    sensor.port = terminal.path();
    options.sensors = {sensor};
    options.folder = "/";
    options.status_every = std::chrono::hours(1);  // the device's are the only records
    options.flush_every = std::chrono::milliseconds(1);
    options.open_sink = disk.opener();
  }
  void start() {
    auto started = logger::Logger::start(options);
    ASSERT_TRUE(started) << started.error().to_string();
    logger = std::move(*started);
  }
  /// Sends the next number as one piece, and waits until it is read. What is sent before the logger
  /// has opened the line is lost.
  void send() {
    ASSERT_TRUE(wait_for([](const auto& s) { return s.state != logger::SensorState::waiting; }));
    std::string text = std::to_string(next++);
    text.insert(0, 8 - text.size(), '0');
    const auto* data = reinterpret_cast<const std::uint8_t*>(text.data());
    ASSERT_EQ(terminal.write({data, 8}, std::chrono::seconds(20)).value_or(0), 8U);
    ASSERT_TRUE(wait_for([&](const auto& s) { return s.bytes == 8U * next; }));
  }
  /// Waits until `is` holds for the device.
  bool wait_for(const std::function<bool(const logger::SensorStatus&)>& is) const {
    return testing::wait_for(std::chrono::minutes(1),
                             [&] { return is(logger->status().sensors[0]); });
  }

  Disk& disk;
  logger::PseudoTerminal terminal;
  logger::LoggerOptions options;
  std::unique_ptr<logger::Logger> logger;
  std::uint32_t next = 0;  ///< number of pieces sent
};

}  // namespace wayfare::tests
