#include <array>

#include <wayfare/ros/ros2_node.hpp>

namespace wayfare::ros {
namespace {

struct TypeHash {
  std::string_view type, hash;
};

constexpr std::array<TypeHash, 18> kHashes{
    {{"geometry_msgs/PoseArray",
      "RIHS01_af0cc36d190e104d546d168d6b39df04fa4b4ccecf59cb4c9ed328d3d5004aa0"},
     {"geometry_msgs/PoseStamped",
      "RIHS01_10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8"},
     {"geometry_msgs/PoseWithCovarianceStamped",
      "RIHS01_26432f9803e43727d3c8f668d1fdb3c630f548af631e2f4e31382371bfea3b6e"},
     {"nav2_msgs/ParticleCloud",
      "RIHS01_193d8cb88ca2b98cd81ece15342744f054bb398ebfa8f6369914432303f42b11"},
     {"nav_msgs/OccupancyGrid",
      "RIHS01_8d348150c12913a31ee0ec170fbf25089e4745d17035792a1ba94d6f0bc0cfc7"},
     {"nav_msgs/Odometry",
      "RIHS01_3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0"},
     {"nav_msgs/Path", "RIHS01_1957a5bb3cee5da65c4e52e52b65a93df227efce4c20f8458b36e73066ca334b"},
     {"rosgraph_msgs/Clock",
      "RIHS01_692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564"},
     {"sensor_msgs/Imu", "RIHS01_7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b"},
     {"sensor_msgs/JointState",
      "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e"},
     {"sensor_msgs/LaserScan",
      "RIHS01_64c191398013af96509d518dac71d5164f9382553fce5c1f8cca5be7924bd828"},
     {"sensor_msgs/MagneticField",
      "RIHS01_e80f32f56a20486c9923008fc1a1db07bbb273cbbf6a5b3bfa00835ee00e4dff"},
     {"sensor_msgs/NavSatFix",
      "RIHS01_62223ab3fe210a15976021da7afddc9e200dc9ec75231c1b6a557fc598a65404"},
     {"sensor_msgs/PointCloud2",
      "RIHS01_9198cabf7da3796ae6fe19c4cb3bdd3525492988c70522628af5daa124bae2b5"},
     {"std_msgs/Header", "RIHS01_f49fb3ae2cf070f793645ff749683ac6b06203e41c891e17701b1cb597ce6a01"},
     {"std_msgs/String", "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"},
     {"tf2_msgs/TFMessage",
      "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"},
     {"wayfare_msgs/RadarScan",
      "RIHS01_a87d000229916a2d4294e44de929fd7758a732c430ee4389395152433f441c8c"}}};

}  // namespace

std::string_view type_hash(std::string_view ros1_name) {
  for (const TypeHash& h : kHashes)
    if (h.type == ros1_name) return h.hash;
  return {};
}

}  // namespace wayfare::ros
