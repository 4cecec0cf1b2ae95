// Type hashes of ROS 2 (RIHS01): SHA-256 of a message's description as JSON, REP 2016.

#include <array>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <map>
#include <string>
#include <type_traits>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/ros/messages.hpp>
#include <wayfare/ros/ros2_node.hpp>
#include <wayfare/ros/serialise.hpp>
#include "io/support.hpp"

namespace wayfare::ros {
namespace {

/// The JSON that is hashed, from a message's list of fields.
class TypeDescription {
 public:
  template <class T>
  void operator()(const char* name, const T& value) {
    fields_ += (fields_.empty() ? "" : ", ") + std::string("{\"name\": \"") + name +
               "\", \"type\": " + type_of(value, 0, 0) + "}";
  }
  void ros1_only(const char*, std::uint32_t) {}

  template <class M>
  [[nodiscard]] std::string json(const M& message) {
    const std::string own = described(message);
    std::string others;
    for (const auto& part : parts_) others += (others.empty() ? "" : ", ") + part.second;
    return "{\"type_description\": " + own + ", \"referenced_type_descriptions\": [" + others +
           "]}";
  }

 private:
  static std::string type(int id, std::size_t capacity, const std::string& nested = "") {
    return "{\"type_id\": " + std::to_string(id) + ", \"capacity\": " + std::to_string(capacity) +
           ", \"string_capacity\": 0, \"nested_type_name\": \"" + nested + "\"}";
  }
  static std::string with_fields(const std::string& name, const std::string& fields) {
    return "{\"type_name\": \"" + name + "\", \"fields\": [" + fields + "]}";
  }
  template <class M>
  std::string described(const M& message) {
    std::string outer;
    outer.swap(fields_);
    M::fields(message, *this);
    outer.swap(fields_);
    return with_fields(ros2_name(M::kType.name), outer);
  }
  /// `kind`: 0 a value, 48 an array, 144 a sequence.
  template <class T>
  requires std::is_arithmetic_v<T> std::string type_of(T, int kind, std::size_t capacity) {
    constexpr int kSize = sizeof(T) == 1 ? 0 : sizeof(T) == 2 ? 1 : sizeof(T) == 4 ? 2 : 3;
    const int id = std::is_same_v<T, bool>       ? 15
                   : std::is_floating_point_v<T> ? 8 + kSize
                   : std::is_signed_v<T>         ? 2 + 2 * kSize
                                                 : 3 + 2 * kSize;
    return type(id + kind, capacity);
  }
  std::string type_of(const std::string&, int kind, std::size_t capacity) {
    return type(17 + kind, capacity);
  }
  std::string type_of(const Stamp&, int kind, std::size_t capacity) {
    const std::string name = "builtin_interfaces/msg/Time";
    parts_[name] =
        with_fields(name, "{\"name\": \"sec\", \"type\": " + type(6, 0) +
                              "}, {\"name\": \"nanosec\", \"type\": " + type(7, 0) + "}");
    return type(1 + kind, capacity, name);
  }
  template <class T>
  std::string type_of(const std::vector<T>&, int, std::size_t) {
    return type_of(T{}, 144, 0);
  }
  template <class T, std::size_t N>
  std::string type_of(const std::array<T, N>&, int, std::size_t) {
    return type_of(T{}, 48, N);
  }
  template <class M>
  requires requires { M::kType; }
  std::string type_of(const M& message, int kind, std::size_t capacity) {
    const std::string name = ros2_name(M::kType.name);
    parts_[name] = described(message);
    return type(1 + kind, capacity, name);
  }

  std::string fields_;
  std::map<std::string, std::string> parts_;
};

/// By coreutils.
std::string sha256(const std::string& text) {
  const wayfare::testing::TemporaryFolder folder;
  std::ofstream(folder / "text") << text;
  std::FILE* const pipe = ::popen(("sha256sum " + (folder / "text")).c_str(), "r");
  std::array<char, 65> digits{};
  const std::size_t n = std::fread(digits.data(), 1, 64, pipe);
  ::pclose(pipe);
  return {digits.data(), n};
}

template <class... M>
void expect_hashes() {
  const auto one = [](std::string_view name, const std::string& json) {
    EXPECT_EQ(type_hash(name), "RIHS01_" + sha256(json)) << "of " << name;
  };
  (one(M::kType.name, TypeDescription().json(M{})), ...);
}

TEST(Ros2TypeHash, IsThatOfTheFields) {
  expect_hashes<Header, LaserScan, PointCloud2, Imu, MagneticField, JointState, String, NavSatFix,
                Odometry, TfMessage, PoseStamped, PoseWithCovarianceStamped, Path, OccupancyGrid,
                RadarScan, Clock, PoseArray, ParticleCloud>();
}

// As distributions of ROS 2 from Iron on show it: `ros2 topic info --verbose`.
TEST(Ros2TypeHash, IsThePublishedOne) {
  EXPECT_EQ(type_hash("std_msgs/String"),
            "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18");
  EXPECT_EQ(type_hash("rosgraph_msgs/Clock"),
            "RIHS01_692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564");
  EXPECT_EQ(type_hash("sensor_msgs/LaserScan"),
            "RIHS01_64c191398013af96509d518dac71d5164f9382553fce5c1f8cca5be7924bd828");
  EXPECT_EQ(type_hash("nav_msgs/OccupancyGrid"),
            "RIHS01_8d348150c12913a31ee0ec170fbf25089e4745d17035792a1ba94d6f0bc0cfc7");
  EXPECT_EQ(type_hash("tf2_msgs/TFMessage"),
            "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087");
  EXPECT_EQ(type_hash("unknown_msgs/Type"), "");
}

}  // namespace
}  // namespace wayfare::ros
