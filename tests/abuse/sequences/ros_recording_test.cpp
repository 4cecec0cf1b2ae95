// Random calls of RecordingWriter, in both formats, beside a plain list of messages; the files are
// then read whole, truncated and damaged.

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/ros/convert.hpp>
#include <wayfare/ros/recording.hpp>

#include "abuse/abuse.hpp"
#include "io/support.hpp"
#include "ros/sample_recording.hpp"

namespace wayfare::ros {
namespace {

using ::wayfare::testing::TemporaryFolder;

class Recordings : public ::testing::TestWithParam<const char*> {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const {
    return folder_ / (name + GetParam());
  }
  [[nodiscard]] static bool is_bag() { return GetParam() == std::string(".bag"); }
  [[nodiscard]] static Dialect dialect() { return is_bag() ? Dialect::ros1 : Dialect::ros2; }

  void put(const std::string& to, const std::string& bytes) const {
    std::ofstream(to, std::ios::binary) << bytes;
  }

 private:
  TemporaryFolder folder_;
};

using Messages = std::map<std::string, std::vector<std::pair<LogTime, std::string>>>;

Messages read_all(const RecordingFile& file) {
  std::set<std::string> topics;
  for (const Topic& topic : file.topics()) topics.insert(topic.name);
  Messages all;
  static_cast<void>(file.read(topics, [&](const RecordedMessage& m) {
    all[m.topic.name].emplace_back(m.received, std::string(m.data));
    return true;
  }));
  return all;
}

TEST_P(Recordings, AreReadAsTheListsOfMessages) {
  for (std::uint64_t seed = 0; seed < 150; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    const std::string name = path(std::to_string(seed));
    auto writer = RecordingWriter::create(name);
    ASSERT_TRUE(writer);
    Messages written;
    std::map<std::string, int> type_of;
    std::string calls;
    const auto write = [&](const std::string& topic, int type, LogTime time, const auto& message) {
      const auto done = writer->write(topic, time, message);
      calls += topic + ":" + std::to_string(type) + (done ? " " : "! ");
      const bool fits = type_of.emplace(topic, type).first->second == type;
      EXPECT_EQ(done.has_value(), fits && time >= LogTime()) << calls;
      if (done) written[topic].emplace_back(time, to_bytes(message, dialect()));
    };
    for (std::uint64_t n = rng.below(60); n > 0 && !HasFailure(); --n) {
      const std::string topic = "/" + std::to_string(rng.below(4));
      const auto time = LogTime::from_nanoseconds(
          rng.below(20) == 0 ? -1
                             : static_cast<std::int64_t>(1e18) + static_cast<int>(rng.below(9)));
      const LogTime stamp = LogTime::from_nanoseconds(1 + static_cast<int>(rng.below(9)));
      switch (rng.below(4)) {
        case 0:
          write(topic, 0, time, message_of(GyroSample{stamp, rng.uniform()}, "imu"));
          break;
        case 1:
          write(topic, 1, time, Header{0, stamp_of(stamp), "frame"});
          break;
        case 2:
          write(topic, 2, time, PoseStamped{header_of(stamp, "map"), {}});
          break;
        default:
          calls += "move ";
          RecordingWriter elsewhere(std::move(*writer));
          *writer = std::move(elsewhere);
      }
    }
    ASSERT_TRUE(writer->close());
    ASSERT_FALSE(writer->close());
    ASSERT_FALSE(writer->write("/0", LogTime(), Header{}));
    ASSERT_FALSE(writer->write("/new", LogTime(), Header{}));
    const auto file = RecordingFile::open(name);
    ASSERT_TRUE(file) << file.error().to_string();
    EXPECT_TRUE(file->problems().empty());
    ASSERT_EQ(read_all(*file), written) << calls;
    EXPECT_TRUE(RecordingFile::is_one(name) || written.empty());
  }
}

TEST_P(Recordings, AreNotOverwrittenAndNotLost) {
  const std::string name = path("there");
  put(name, "before");
  EXPECT_FALSE(RecordingWriter::create(name)) << "before anything was recorded";
  auto writer = RecordingWriter::create(name, {io::Existing::replace});
  ASSERT_TRUE(writer);
  EXPECT_TRUE(writer->close());
  // The folder appears only after the end of the drive.
  const std::string late = path("later/x");
  auto early = RecordingWriter::create(late);
  ASSERT_EQ(early.has_value(), is_bag());
  if (!early) return;
  ASSERT_TRUE(early->write("/a", LogTime(), Header{}));
  ASSERT_FALSE(early->close());
  std::filesystem::create_directories(std::filesystem::path(late).parent_path());
  ASSERT_TRUE(early->close());
  const auto file = RecordingFile::open(late);
  ASSERT_TRUE(file);
  EXPECT_EQ(read_all(*file).size(), 1U);
}

TEST_P(Recordings, TimesThatStampsDoNotHave) {
  Recording run = ::wayfare::testing::sample_run(3);
  for (const LogTime time : {LogTime(), LogTime::from_nanoseconds(-5),
                             LogTime::from_nanoseconds((1LL << 31) * 1'000'000'000),
                             LogTime::from_nanoseconds(INT64_MAX)}) {
    run.odometry.back().time = time;
    std::sort(run.odometry.begin(), run.odometry.end(),
              [](const auto& a, const auto& b) { return a.time < b.time; });
    auto writer = RecordingWriter::create(path("late"), {io::Existing::replace});
    ASSERT_TRUE(writer);
    const auto done = write_robot(*writer, run);
    ASSERT_FALSE(done);
    EXPECT_NE(done.error().message.find("time"), std::string::npos);
    run = ::wayfare::testing::sample_run(3);
  }
  auto writer = RecordingWriter::create(path("empty"));
  ASSERT_TRUE(writer);
  EXPECT_TRUE(write_robot(*writer, Recording{}));
  EXPECT_TRUE(writer->close());
  const auto file = RecordingFile::open(path("empty"));
  ASSERT_TRUE(file);
  EXPECT_FALSE(read_robot(*file));
  EXPECT_FALSE(read_marg(*file));
  EXPECT_FALSE(read_vehicle(*file));
}

// Receipts at the two ends of time: their difference does not fit 64 bits.
TEST_P(Recordings, ReceiptsOfAnyTime) {
  const Recording run = ::wayfare::testing::sample_run(2);
  const LogTime end = is_bag() ? LogTime::from_nanoseconds((1LL << 32) * 1'000'000'000 - 1)
                               : LogTime::from_nanoseconds(INT64_MAX);
  auto writer = RecordingWriter::create(path("ends"));
  ASSERT_TRUE(writer);
  ASSERT_TRUE(writer->write("/scan", end, message_of(run.scans[0], "laser")));
  Odometry last = message_of(run.odometry[0], "odom", "base_link");
  last.header.stamp = {INT32_MAX, 0};
  ASSERT_TRUE(writer->write("/odom", LogTime(), last));
  ASSERT_TRUE(writer->close());
  const auto file = RecordingFile::open(path("ends"));
  ASSERT_TRUE(file);
  const auto robot = read_robot(*file);
  ASSERT_FALSE(robot);
  EXPECT_NE(robot.error().message.find("clocks differ"), std::string::npos)
      << robot.error().to_string();
}

TEST_P(Recordings, DamagedAnywhereAreReadOrRefused) {
  ::wayfare::testing::write_sample(path("good"), ::wayfare::testing::sample_run(12));
  const auto content = io::read_file(path("good"));
  ASSERT_TRUE(content);
  for (std::uint64_t seed = 0; seed < 150; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    std::string bytes = content->bytes;
    for (std::uint64_t n = 1 + rng.below(20); n > 0; --n)
      bytes[rng.below(bytes.size())] = static_cast<char>(rng.below(256));
    if (rng.below(3) == 0) bytes.resize(rng.below(bytes.size()));
    put(path("bad"), bytes);
    static_cast<void>(RecordingFile::is_one(path("bad")));
    const auto file = RecordingFile::open(path("bad"));
    if (!file) continue;
    const auto robot = read_robot(*file);
    if (robot) {
      for (const OdometrySample& o : robot->recording.odometry)
        ASSERT_TRUE(o.T_odom_base.raw().translation().allFinite());
      ASSERT_TRUE(std::is_sorted(robot->recording.scans.begin(), robot->recording.scans.end(),
                                 [](const auto& a, const auto& b) { return a.time < b.time; }));
    }
    static_cast<void>(read_marg(*file));
    static_cast<void>(read_vehicle(*file));
  }
}

TEST_P(Recordings, TwoThreadsWriteAndReadTheSame) {
  const auto both = tests::in_two_threads([this](int i) {
    const std::string name = path("thread" + std::to_string(i));
    ::wayfare::testing::write_sample(name, ::wayfare::testing::sample_run(5));
    return io::read_file(name)->bytes;
  });
  EXPECT_EQ(both[0], both[1]);
  const auto file = RecordingFile::open(path("thread0"));
  ASSERT_TRUE(file);
  const auto read = tests::in_two_threads([&](int) { return read_all(*file); });
  EXPECT_EQ(read[0], read[1]);
}

// Other suffixes, folders and nothing at all.
TEST(RecordingFiles, OfNoKindAreRefused) {
  const TemporaryFolder folder;
  for (const char* name : {"a", "a.txt", ".bag.gz", "", "mcap", "a.BAG"})
    EXPECT_FALSE(RecordingWriter::create(folder / name)) << name;
  for (const char* name : {"none.bag", "none.mcap", "none", ""}) {
    EXPECT_FALSE(RecordingFile::open(folder / name)) << name;
    EXPECT_FALSE(read_imu(folder / name, {})) << name;
    EXPECT_FALSE(read_fixes(folder / name, {})) << name;
  }
}

INSTANTIATE_TEST_SUITE_P(Containers, Recordings, ::testing::Values(".bag", ".mcap"),
                         [](const auto& i) { return std::string(i.param).substr(1); });

}  // namespace
}  // namespace wayfare::ros
