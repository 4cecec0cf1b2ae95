// The recorder as a process: what was played is what is in its file.

#include <signal.h>

#include <map>
#include <string>
#include <vector>

#include <wayfare/io/mcap.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/ros/recording.hpp>
#include "live.hpp"
#include "room_drive.hpp"

namespace wayfare {
namespace {

using ::testing::HasSubstr;
using testing::Live;
using testing::Process;

/// The messages of each topic as CDR.
std::map<std::string, std::vector<std::string>> messages_in(const std::string& path) {
  std::map<std::string, std::vector<std::string>> all;
  const auto file = ros::RecordingFile::open(path);
  EXPECT_TRUE(file) << path;
  if (!file) return all;
  std::set<std::string> topics;
  for (const ros::Topic& topic : file->topics()) topics.insert(topic.name);
  const auto problems = file->read(topics, [&](const ros::RecordedMessage& m) {
    // Messages on the wire end with padding.
    std::string bytes(m.data);
    bytes.resize((bytes.size() + 3) / 4 * 4);
    all[m.topic.name].push_back(std::move(bytes));
    return true;
  });
  EXPECT_EQ(problems.count(), 0U);
  return all;
}

TEST_F(Live, ARecordingOfTheTopicsIsWhatWasPlayed) {
  auto writer = ros::RecordingWriter::create(path("played.mcap"));
  ASSERT_TRUE(writer);
  ASSERT_TRUE(ros::write_robot(*writer, testing::room_drive()));
  ASSERT_TRUE(writer->close());
  auto other = node_->raw().advertise(
      topic("other"), {"other_msgs/Thing", "992ce8a1687cec8c8bd883ec73ca41d1", "string data\n"},
      ros::Qos::latched());
  const std::string thing("\0\1\0\0\2\0\0\0a\0\0\0", 12);
  other.publish(thing);
  Process recorder(
      {WAYFARE_RECORD_TOPICS, "--out", path("drive"), "--only", topic("scan"), "--only",
       topic("odom"), "--only", topic("tf_static"), "--only", topic("other")},
      path("recorder.txt"));
  ASSERT_EQ(play(path("played.mcap"), {"/scan", "/odom", "/tf_static"}).wait(120.0), 0)
      << recorder.output();
  EXPECT_EQ(recorder.end(SIGTERM), 0) << recorder.output();

  const auto played = messages_in(path("played.mcap"));
  auto recorded = messages_in(path("drive/drive_0.mcap"));
  for (const char* name : {"scan", "odom", "tf_static"})
    EXPECT_EQ(recorded[topic(name)], played.at(std::string("/") + name)) << name;
  const auto file = io::McapReader::open(path("drive/drive_0.mcap"));
  ASSERT_TRUE(file);
  EXPECT_EQ(file->contents().profile, "ros2");
  for (const io::McapSchema& schema : file->contents().schemas)
    if (schema.name == "sensor_msgs/msg/LaserScan") {
      EXPECT_EQ(schema.data, ros::definition<ros::LaserScan>(ros::Dialect::ros2));
    }
  const std::string metadata = io::read_file(path("drive/metadata.yaml")).value().bytes;
  EXPECT_THAT(metadata, HasSubstr("storage_identifier: mcap"));
  EXPECT_THAT(metadata, HasSubstr("name: " + topic("scan") + "\n        type: sensor_msgs/msg/" +
                                  "LaserScan\n"));
  EXPECT_THAT(metadata,
              HasSubstr("message_count: " + std::to_string(played.at("/scan").size()) + "\n"));
  if (is_ros2()) {
    ASSERT_EQ(recorded[topic("other")].size(), 1U) << recorder.output();
    EXPECT_EQ(recorded[topic("other")][0], thing);
    EXPECT_THAT(recorder.output(), HasSubstr("without a definition: the type is not known"));
  } else {
    EXPECT_THAT(recorder.output(), HasSubstr("its type other_msgs/Thing is not known"));
  }
}

}  // namespace
}  // namespace wayfare
