// Maps, and poses with covariance.

#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>

#include <Eigen/Core>

#include <wayfare/ros/convert.hpp>

namespace wayfare::ros {
namespace {

/// Of x, y, z and rotations about them: those in the plane.
constexpr std::array<std::size_t, 3> kPlane = {0, 1, 5};

/// Rotates differences about the axes of a pose to those about the axes of its frame.
Eigen::Matrix3d to_frame(const SE2d& pose) {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = pose.rotation().matrix();
  return turn;
}

/// The shortest decimal number that rounds to this one.
double shortest(float value) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  double number = 0.0;
  std::from_chars(text.data(), end, number);
  return number;
}

Error wrong_map(std::string what) { return {ErrorCode::invalid, std::move(what), "map"}; }

/// Errors: see grid_image_of.
Result<void> check_size(const OccupancyGrid& m) {
  const std::string sizes =
      std::to_string(m.info.width) + " x " + std::to_string(m.info.height) + " cells";
  const std::uint64_t cells = std::uint64_t{m.info.width} * m.info.height;
  if (cells == 0) return wrong_map("has no cells: " + sizes);
  if (cells != m.data.size())
    return wrong_map("is of " + sizes + ", but has " + std::to_string(m.data.size()));
  if (!(m.info.resolution >= 0.001F && m.info.resolution <= 10.0F))
    return wrong_map("has cells of " + std::to_string(m.info.resolution) +
                     " m; from a millimetre to ten metres are possible");
  return {};
}

}  // namespace

Result<Gaussian<SE2d>> gaussian_of(const PoseWithCovariance& message) {
  const auto pose = plane_pose_of(message.pose);
  if (!pose) return pose.error();
  Eigen::Matrix3d covariance;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      covariance(static_cast<int>(i), static_cast<int>(j)) =
          message.covariance[6 * kPlane[i] + kPlane[j]];
  if (!is_positive_semidefinite(covariance))
    return Error{ErrorCode::invalid, "is not finite, symmetric and positive semi-definite",
                 "covariance"};
  const Eigen::Matrix3d turn = to_frame(*pose);
  return Gaussian<SE2d>{*pose, turn.transpose() * covariance * turn};
}

PoseWithCovarianceStamped message_of(const Gaussian<SE2d>& pose, LogTime time,
                                     std::string_view frame) {
  PoseWithCovarianceStamped message{header_of(time, frame), {pose_of(pose.mean)}};
  const Eigen::Matrix3d turn = to_frame(pose.mean);
  const Eigen::Matrix3d covariance = turn * pose.covariance * turn.transpose();
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      message.pose.covariance[6 * kPlane[i] + kPlane[j]] =
          covariance(static_cast<int>(i), static_cast<int>(j));
  return message;
}

OccupancyGrid message_of(const io::GridImage& map, LogTime time, std::string_view frame) {
  OccupancyGrid message;
  message.header = header_of(time, frame);
  message.info = {message.header.stamp, static_cast<float>(map.resolution_m),
                  static_cast<std::uint32_t>(map.width), static_cast<std::uint32_t>(map.height),
                  pose_of(map.origin)};
  message.data.reserve(map.occupancy.size());
  for (const float p : map.occupancy)
    message.data.push_back(p >= 0.0F && p <= 1.0F
                               ? static_cast<std::int8_t>(std::lround(100.0F * p))
                               : std::int8_t{-1});
  return message;
}

Result<io::GridImage> grid_image_of(const OccupancyGrid& message) {
  if (auto ok = check_size(message); !ok) return ok.error();
  const auto origin = plane_pose_of(message.info.origin);
  if (!origin) return wrong_map("has an origin whose " + origin.error().to_string());
  io::GridImage image{
      message.info.width, message.info.height, shortest(message.info.resolution), *origin, {}};
  image.occupancy.reserve(message.data.size());
  for (const std::int8_t percent : message.data) {
    if (percent < -1 || percent > 100)
      return wrong_map("has a cell of " + std::to_string(percent) + " percent");
    image.occupancy.push_back(percent < 0 ? std::numeric_limits<float>::quiet_NaN()
                                          : static_cast<float>(percent) / 100.0F);
  }
  return image;
}

}  // namespace wayfare::ros
