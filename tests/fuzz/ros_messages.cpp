// Arbitrary bytes as any message, and messages with some bytes changed: what is read is written
// unchanged and converts to valid measurements.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include <wayfare/ros/convert.hpp>
#include <wayfare/ros/serialise.hpp>

#include "ros/sample_messages.hpp"

namespace {

using namespace wayfare;

void use(const ros::LaserScan& m) {
  const auto scan = ros::laser_scan_of(m, LogTime());
  if (scan && (scan->ranges_m.size() != m.ranges.size() || scan->bearing_step.radians() < 0.0))
    std::abort();
}
void use(const ros::PointCloud2& m) {
  const auto scan = ros::radar_scan_of(m, LogTime());
  if (!scan) return;
  for (const RadarPoint& p : scan->points)
    if (!std::isfinite(p.x_m) || !std::isfinite(p.doppler_m_s)) std::abort();
}
void use(const ros::RadarScan& m) {
  const auto scan = ros::radar_scan_of(m, LogTime());
  if (scan && scan->points.size() > m.x.size()) std::abort();
}
void use(const ros::Imu& m) { static_cast<void>(ros::imu_of(m, LogTime())); }
void use(const ros::NavSatFix& m) { static_cast<void>(ros::fix_of(m, LogTime())); }
void use(const ros::Odometry& m) {
  const auto pose = ros::odometry_of(m, LogTime());
  if (pose && !pose->T_odom_base.raw().log().allFinite()) std::abort();
}
void use(const ros::PoseWithCovarianceStamped& m) {
  const auto pose = ros::gaussian_of(m.pose);
  if (pose && !(pose->mean.log().allFinite() && pose->covariance.allFinite())) std::abort();
}
void use(const ros::OccupancyGrid& m) {
  const auto image = ros::grid_image_of(m);
  if (image && (image->occupancy.size() != image->width * image->height ||
                !(image->resolution_m > 0.0) || !image->origin.log().allFinite()))
    std::abort();
}
template <class M>
void use(const M&) {}

template <class M>
void take(const std::string& bytes) {
  if (const auto m = ros::from_ros1<M>(bytes)) {
    if (ros::to_ros1(*m).size() != bytes.size()) std::abort();
    use(*m);
  }
  if (const auto m = ros::from_cdr<M>(bytes)) {
    const auto again = ros::from_cdr<M>(ros::to_cdr(*m, ros::ByteOrder::big));
    if (!again || ros::to_cdr(*again) != ros::to_cdr(*m)) std::abort();
    use(*m);
  }
}

/// Interprets `data` as offsets and the values to store there.
std::string changed(std::string bytes, const std::uint8_t* data, std::size_t size) {
  for (std::size_t i = 0; i + 2 < size && i < 60 && !bytes.empty(); i += 3)
    bytes[(256U * data[i] + data[i + 1]) % bytes.size()] = static_cast<char>(data[i + 2]);
  return bytes;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const std::string raw(reinterpret_cast<const char*>(data + 1), size - 1);
  std::size_t kind = 0;
  wayfare::testing::for_each_message([&](const auto& message) {
    using M = std::decay_t<decltype(message)>;
    if (kind++ != data[0] % std::tuple_size_v<wayfare::testing::AllMessages>) return;
    take<M>(raw);
    take<M>(changed(ros::to_ros1(message), data + 1, size - 1));
    take<M>(changed(ros::to_cdr(message), data + 1, size - 1));
  });
  return 0;
}
