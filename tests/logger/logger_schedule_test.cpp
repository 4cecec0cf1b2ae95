// A thousand random schedules of commands from two threads: whatever their order, a logger ends in
// a state that agrees with its files.
#include <wayfare/logger/logger.hpp>

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <wayfare/core/random.hpp>
#include "logger/one_device.hpp"

namespace wayfare::logger {
namespace {

using namespace std::chrono_literals;
using ::wayfare::testing::MemorySink;
using ::wayfare::testing::raw_channel;

/// Files in memory, created and written slowly, and how many are open at once.
class Shelf {
 public:
  Shelf(std::uint64_t seed, std::size_t room) : rng_(seed), room_(room) {}

  auto opener() {
    return [this](const std::string&) -> Result<std::unique_ptr<io::ByteSink>> {
      const int most = ++open_;
      most_ = std::max<int>(most_, most);
      nap();
      const auto bytes = std::make_shared<std::string>();
      const std::lock_guard lock(mutex_);
      files_.push_back(bytes);
      return std::unique_ptr<io::ByteSink>(new Sink(*this, bytes));
    };
  }
  /// To be read once they are closed.
  [[nodiscard]] std::vector<std::shared_ptr<std::string>> files() const {
    const std::lock_guard lock(mutex_);
    return files_;
  }
  [[nodiscard]] int open() const { return open_; }
  [[nodiscard]] int most_open() const { return most_; }

 private:
  class Sink final : public io::ByteSink {
   public:
    Sink(Shelf& shelf, const std::shared_ptr<std::string>& bytes)
        : shelf_(shelf), memory_(bytes, shelf.room_) {}
    ~Sink() override { --shelf_.open_; }
    Result<void> write(std::string_view bytes) override {
      shelf_.nap();
      return memory_.write(bytes);
    }
    Result<void> sync() override { return {}; }

   private:
    Shelf& shelf_;
    MemorySink memory_;
  };

  void nap() {
    std::uint64_t us = 0;
    {
      const std::lock_guard lock(mutex_);
      us = rng_.below(4) == 0 ? rng_.below(3000) : 0;
    }
    std::this_thread::sleep_for(std::chrono::microseconds(us));
  }

  mutable std::mutex mutex_;
  Rng rng_;
  const std::size_t room_;
  std::vector<std::shared_ptr<std::string>> files_;
  std::atomic<int> open_{0}, most_{0};
};

/// Totals of all schedules, to check that every kind of event occurred.
struct Total {
  std::atomic<std::uint64_t> files{0}, bytes{0}, dropped{0}, failed{0}, terminated{0};
};

struct Schedule {
  std::uint64_t seed = 0;
  bool full = false;       ///< the disk has room for little
  bool narrow = false;     ///< and the queue
  bool destroyed = false;  ///< by whichever thread is the last, without having been stopped

  explicit Schedule(std::uint64_t number)
      : seed(number), full(number % 5 == 0), narrow(number % 3 == 0), destroyed(number % 2 == 0) {}

  static void command(std::shared_ptr<Logger> logger, PseudoTerminal& terminal,
                      std::uint64_t seed) {
    Rng rng(seed);
    for (int i = 0; i < 12; ++i) {
      switch (rng.below(8)) {
        case 0:
        case 1:
          static_cast<void>(logger->begin());  // an error is that of the state at that time
          break;
        case 2:
          logger->stop();
          break;
        case 3:
          if (rng.below(6) == 0) logger->terminate();
          break;
        case 4:
        case 5: {
          const std::vector<std::uint8_t> piece(1 + rng.below(600), 'x');
          static_cast<void>(terminal.write(piece, 20ms));
          break;
        }
        default:
          std::this_thread::sleep_for(std::chrono::microseconds(rng.below(4000)));
      }
      static_cast<void>(logger->status());
    }
  }

  /// `files` are closed.
  static std::uint64_t raw_bytes(const std::string& file) {
    const auto reader = io::McapReader::parse(file, "schedule");
    EXPECT_TRUE(reader);
    return reader ? raw_channel(*reader, "/unit/raw").bytes.size() : 0;
  }

  void run(const std::string& folder, Total& total) const {
    SCOPED_TRACE(seed);
    Shelf shelf(seed, full ? 900 : SIZE_MAX);
    auto terminal = PseudoTerminal::open();
    ASSERT_TRUE(terminal);
    LoggerOptions options;
    options.folder = folder;
    options.sensors = {::wayfare::testing::sensor({"unit", "raw", 115200, ""}, terminal->path())};
    options.status_every = options.flush_every = 1ms;
    options.open_sink = shelf.opener();
    if (narrow) options.queue_bytes = 700;
    auto started = Logger::start(options);
    ASSERT_TRUE(started);
    std::shared_ptr<Logger> logger = std::move(*started);
    std::thread one(command, logger, std::ref(*terminal), 2 * seed);
    std::thread two(command, logger, std::ref(*terminal), 2 * seed + 1);
    if (destroyed) logger.reset();
    one.join();
    two.join();
    if (logger) {
      logger->stop();
      ASSERT_TRUE(logger->wait_until_stopped(20s));
      check(logger->status(), shelf, total);
      logger.reset();
    }
    EXPECT_EQ(shelf.open(), 0);
    EXPECT_LE(shelf.most_open(), 1) << "two recordings at once";
    for (const auto& file : shelf.files()) {
      ++total.files;
      const auto reader = io::McapReader::parse(*file, "schedule");
      if (!full) {
        EXPECT_TRUE(reader && reader->contents().indexed);
      }
    }
  }

  void check(const LoggerStatus& status, const Shelf& shelf, Total& total) const {
    const bool ended = status.state == LoggerState::idle ||
                       status.state == LoggerState::terminated ||
                       (full && status.state == LoggerState::failed);
    EXPECT_TRUE(ended) << name_of(status.state);
    if (!full) {
      EXPECT_EQ(status.error, "");
    }
    const auto files = shelf.files();
    const bool created = !files.empty() && !files.back()->empty();
    EXPECT_EQ(status.written, created ? files.back()->size() : 0);
    const std::uint64_t raw = created ? raw_bytes(*files.back()) : 0;
    EXPECT_EQ(status.sensors[0].recorded_bytes, raw);
    if (!full && !narrow) {
      EXPECT_EQ(status.dropped, 0U);
    }
    total.bytes += raw;
    total.dropped += status.dropped;
    total.failed += status.error.empty() ? 0 : 1;
    total.terminated += status.state == LoggerState::terminated ? 1 : 0;
  }
};

TEST(LoggerSchedule, AThousandRandomSchedulesEndInAgreementWithTheirFiles) {
  constexpr std::uint64_t kSchedules = 1000, kLanes = 40;  // a lane mostly waits for its lines
  const ::wayfare::testing::TemporaryFolder folder;
  Total total;
  std::atomic<std::uint64_t> next{0};
  std::vector<std::thread> lanes;
  for (std::uint64_t lane = 0; lane < kLanes; ++lane)
    lanes.emplace_back([&] {
      for (std::uint64_t n = next++; n < kSchedules; n = next++)
        Schedule(n).run(folder.path().string(), total);
    });
  for (std::thread& lane : lanes) lane.join();
  EXPECT_GT(total.files, kSchedules / 2);
  EXPECT_GT(total.bytes, 0U);
  EXPECT_GT(total.dropped, 0U);
  EXPECT_GT(total.failed, 0U);
  EXPECT_GT(total.terminated, 0U);
}

}  // namespace
}  // namespace wayfare::logger
