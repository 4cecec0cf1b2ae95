// How recordings end: nothing that was read is lost, and what is counted as recorded is in the
// file.
#include <wayfare/logger/logger.hpp>

#include <atomic>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "logger/one_device.hpp"
#include "logger/simulated_devices.hpp"

namespace wayfare::logger {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using ::wayfare::testing::has_read;
using ::wayfare::testing::IllDisk;
using ::wayfare::testing::OneDevice;
using ::wayfare::testing::raw_channel;
using ::wayfare::testing::wait_for;

/// The bytes of the device in a file, closed or not.
std::string raw_bytes(const std::string& file) {
  const auto reader = io::McapReader::open(file);
  EXPECT_TRUE(reader);
  return reader ? raw_channel(*reader, "/unit/raw").bytes : std::string();
}

bool is_closed(const std::string& file) {
  const auto reader = io::McapReader::open(file);
  return reader && reader->contents().indexed;
}

TEST(LoggerEnd, DestroyedWithASlowDiskItWritesAllThatWasRead) {
  OneDevice one;
  IllDisk disk;
  one.options.open_sink = disk.opener();
  auto logger = Logger::start(one.options);
  ASSERT_TRUE((*logger)->begin());
  disk.slow_ms = 300;
  std::string sent;
  for (int i = 0; i < 100; ++i) {
    const std::string piece(1000, static_cast<char>('a' + i % 26));
    one.send(piece);
    sent += piece;
  }
  ASSERT_TRUE(has_read(**logger, 100'000));
  // What counts as recorded is in the file already, whatever is still queued.
  const LoggerStatus status = (*logger)->status();
  EXPECT_LE(status.sensors[0].recorded_bytes, raw_bytes(status.file).size());
  logger->reset();
  EXPECT_TRUE(raw_bytes(status.file) == sent);
  EXPECT_TRUE(is_closed(status.file));
}

TEST(LoggerEnd, CountsAsRecordedOnlyWhatIsWritten) {
  OneDevice one;
  IllDisk disk;
  one.options.open_sink = disk.opener();
  one.options.flush_every = 10ms;
  auto logger = Logger::start(one.options);
  ASSERT_TRUE((*logger)->begin());
  disk.stuck = true;
  one.send(std::string(1000, 'a'));
  ASSERT_TRUE(has_read(**logger, 1000));
  ASSERT_TRUE(wait_for(20s, [&] { return disk.waiting > 0; }));
  EXPECT_EQ((*logger)->status().sensors[0].recorded_bytes, 0U);
  disk.stuck = false;
  EXPECT_TRUE(wait_for(20s, [&] { return (*logger)->status().sensors[0].recorded_bytes == 1000; }));
  (*logger)->stop();
  ASSERT_TRUE((*logger)->wait_until_stopped(20s));
  const LoggerStatus status = (*logger)->status();
  EXPECT_EQ(status.sensors[0].recorded_bytes, 1000U);
  EXPECT_EQ(status.written, std::filesystem::file_size(status.file));
}

TEST(LoggerEnd, WhatAFullDiskDidNotTakeIsDropped) {
  OneDevice one;
  IllDisk disk;
  one.options.open_sink = disk.opener();
  one.options.flush_every = 10ms;
  one.options.status_every = 1h;  // the disk fails on the device's bytes
  auto logger = Logger::start(one.options);
  ASSERT_TRUE((*logger)->begin());
  one.send(std::string(1000, 'a'));
  ASSERT_TRUE(wait_for(20s, [&] { return (*logger)->status().sensors[0].recorded_bytes == 1000; }));
  disk.room = 0;
  // The terminal passes on at most 4096 bytes at once, so that these are several records.
  one.send(std::string(20'000, 'b'));
  EXPECT_TRUE(wait_for(20s, [&] { return (*logger)->status().state == LoggerState::failed; }));
  const LoggerStatus status = (*logger)->status();
  EXPECT_THAT(status.error, HasSubstr("no space left"));
  EXPECT_EQ(status.sensors[0].recorded_bytes, 1000U);
  EXPECT_EQ(raw_bytes(status.file), std::string(1000, 'a'));
  EXPECT_GT(status.dropped, 0U);
  EXPECT_EQ(status.written, std::filesystem::file_size(status.file));
}

// --- commands while a recording is being created -------------------------------------------------

/// Creates files once it is allowed to.
struct SlowFolder {
  std::atomic<int> opening{0}, opened{0};
  std::atomic<bool> shut{true};
  std::atomic<bool> full{false};

  auto opener() {
    return [this](const std::string& path) -> Result<std::unique_ptr<io::ByteSink>> {
      ++opening;
      while (shut) std::this_thread::sleep_for(1ms);
      ++opened;
      if (full) return Error{ErrorCode::io, "no space left on the disk"};
      return io::FileSink::create(path);
    };
  }
};

class LoggerStarting : public ::testing::Test {
 protected:
  void SetUp() override {
    one_.options.open_sink = folder_.opener();
    logger_ = std::move(*Logger::start(one_.options));
    beginning_ = std::thread([this] { begun_ = logger_->begin().has_value(); });
    ASSERT_TRUE(wait_for(20s, [&] { return folder_.opening == 1; }));
    EXPECT_EQ(state(), LoggerState::starting);
  }
  void TearDown() override {
    create();
    logger_.reset();
  }
  void create() {
    folder_.shut = false;
    if (beginning_.joinable()) beginning_.join();
  }
  [[nodiscard]] LoggerState state() const { return logger_->status().state; }

  OneDevice one_;
  SlowFolder folder_;
  std::unique_ptr<Logger> logger_;
  std::atomic<bool> begun_{false};
  std::thread beginning_;
};

TEST_F(LoggerStarting, TerminatedItEndsAsSoonAsTheFileIsThere) {
  logger_->terminate();
  EXPECT_EQ(state(), LoggerState::stopping);
  EXPECT_FALSE(logger_->wait_until_stopped(1ms)) << "the file is still being created";
  create();
  EXPECT_TRUE(begun_);
  ASSERT_TRUE(logger_->wait_until_stopped(20s));
  EXPECT_EQ(state(), LoggerState::terminated);
  EXPECT_TRUE(is_closed(logger_->status().file));
  EXPECT_EQ(logger_->begin().error().code, ErrorCode::cancelled);
  EXPECT_EQ(state(), LoggerState::terminated);
}

TEST_F(LoggerStarting, StoppedItEndsAndCanBeginAgain) {
  logger_->stop();
  EXPECT_EQ(state(), LoggerState::stopping);
  create();
  ASSERT_TRUE(logger_->wait_until_stopped(20s));
  EXPECT_EQ(state(), LoggerState::idle);
  EXPECT_TRUE(is_closed(logger_->status().file));
  EXPECT_TRUE(logger_->begin());
  EXPECT_EQ(state(), LoggerState::recording);
}

TEST_F(LoggerStarting, TerminatedItStaysSoWhereTheFileCannotBeCreated) {
  folder_.full = true;
  logger_->terminate();
  create();
  EXPECT_FALSE(begun_);
  EXPECT_TRUE(logger_->wait_until_stopped(20s));
  EXPECT_EQ(state(), LoggerState::terminated);
  EXPECT_THAT(logger_->status().error, HasSubstr("no space left"));
}

TEST_F(LoggerStarting, AnotherBeginMakesNoSecondFile) {
  std::atomic<bool> also{false};
  std::thread other([&] { also = logger_->begin().has_value(); });
  create();
  other.join();
  EXPECT_TRUE(begun_);
  EXPECT_TRUE(also);
  EXPECT_EQ(folder_.opened, 1);
  EXPECT_EQ(state(), LoggerState::recording);
}

}  // namespace
}  // namespace wayfare::logger
