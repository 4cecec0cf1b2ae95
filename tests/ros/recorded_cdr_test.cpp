// Messages that ROS 2 itself wrote: decoded to their values, and encoded to the same bytes.

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/ros/recording.hpp>
#include <wayfare/ros/serialise.hpp>

#include "sample_messages.hpp"

namespace wayfare::ros {
namespace {

std::string from_hexadecimal(std::string_view digits) {
  std::string out;
  for (std::size_t i = 0; i + 1 < digits.size(); i += 2)
    out += static_cast<char>(std::stoi(std::string(digits.substr(i, 2)), nullptr, 16));
  return out;
}

/// A transform of the turtles' tutorial, recorded under ROS 2 (published with Foxglove's reader of
/// its messages, MIT).
TEST(RecordedCdr, ATransformOfATurtle) {
  const std::string turtle = from_hexadecimal(
      "0001000001000000286fae6169ddd73108000000747572746c6531000e000000747572746c65315f616865616400"
      "000000000000000000000000f03f0000000000000000000000000000000000000000000000000000000000000000"
      "0000000000000000000000000000f03f");
  const auto message = from_cdr<TfMessage>(turtle);
  ASSERT_TRUE(message) << message.error().to_string();
  ASSERT_EQ(message->transforms.size(), 1U);
  const TransformStamped& t = message->transforms[0];
  EXPECT_EQ(t.header.stamp, (Stamp{1638821672, 836230505}));
  EXPECT_EQ(t.header.frame_id, "turtle1");
  EXPECT_EQ(t.child_frame_id, "turtle1_ahead");
  EXPECT_EQ(t.transform.translation.x, 1.0);
  EXPECT_EQ(t.transform.translation.y, 0.0);
  EXPECT_EQ(t.transform.rotation.w, 1.0);
  EXPECT_EQ(to_cdr(*message), turtle);
}

/// Whether the bytes are those of `written` but for padding at their end.
bool same_but_padding(std::string_view written, std::string_view recorded) {
  constexpr std::size_t kMostPadding = 7;
  return recorded.starts_with(written) && recorded.size() <= written.size() + kMostPadding &&
         std::all_of(recorded.begin() + static_cast<std::ptrdiff_t>(written.size()), recorded.end(),
                     [](char c) { return c == '\0'; });
}

/// Whether messages of this type are among ours, and if so decoded and encoded again.
template <class M>
bool written_again(const RecordedMessage& recorded, std::map<std::string, std::size_t>& count) {
  if (recorded.topic.type != M::kType.name) return false;
  const auto message = from_cdr<M>(recorded.data);
  EXPECT_TRUE(message) << recorded.topic.name << ": " << message.error().to_string();
  if (message) {
    EXPECT_TRUE(same_but_padding(to_cdr(*message), recorded.data))
        << recorded.topic.name << " of " << recorded.topic.type;
  }
  ++count[recorded.topic.type];
  return true;
}

template <std::size_t... I>
void write_again(const RecordedMessage& recorded, std::map<std::string, std::size_t>& count,
                 std::index_sequence<I...>) {
  (written_again<std::tuple_element_t<I, testing::AllMessages>>(recorded, count) || ...);
}

TEST(RecordedCdr, FilesOfRosbag2) {
  const std::string folder = WAYFARE_DATA_DIR "/ros2";
  std::error_code none;
  std::vector<std::string> paths;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder, none))
    if (entry.path().extension() == ".mcap") paths.push_back(entry.path().string());
  if (paths.empty()) GTEST_SKIP() << "needs recordings of rosbag2 in " << folder;
  std::map<std::string, std::size_t> count;
  for (const std::string& path : paths) {
    SCOPED_TRACE(path);
    const auto file = RecordingFile::open(path);
    if (!file) continue;  // without messages
    std::set<std::string> topics;
    for (const Topic& topic : file->topics()) topics.insert(topic.name);
    file->read(topics, [&](const RecordedMessage& recorded) {
      write_again(recorded, count,
                  std::make_index_sequence<std::tuple_size_v<testing::AllMessages>>());
      return !HasFailure();
    });
  }
  std::size_t all = 0;
  for (const auto& [type, n] : count) {
    RecordProperty(type.substr(type.find('/') + 1), static_cast<int>(n));
    all += n;
  }
  EXPECT_GT(all, 0U) << "no message of a known type in " << paths.size() << " files";
}

}  // namespace
}  // namespace wayfare::ros
