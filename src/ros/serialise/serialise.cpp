#include <wayfare/ros/serialise.hpp>

#include <utility>

#include "ros/serialise/archive.hpp"
#include "ros/serialise/describe.hpp"

namespace wayfare::ros {
namespace {

constexpr Layout kRos1{};
constexpr std::size_t kMostPadding = 7;

Layout cdr(bool big_endian, std::size_t max_align) { return {big_endian, max_align, true, false}; }

Error too_short(std::string_view name, const Reader& reader) {
  return {ErrorCode::parse, "ends within its field " + std::string(reader.failed_at()),
          std::string(name)};
}

template <class M>
Result<M> read(std::string_view bytes, const Layout& layout, std::size_t spare) {
  Reader reader(bytes, layout);
  M message;
  M::fields(message, reader);
  if (!reader.ok()) return too_short(M::kType.name, reader);
  if (reader.left() > spare)
    return Error{ErrorCode::parse,
                 "has " + std::to_string(reader.left()) + " bytes more than its fields",
                 std::string(M::kType.name)};
  return message;
}

template <class M>
std::string write(const M& message, const Layout& layout) {
  Writer writer(layout);
  M::fields(message, writer);
  return writer.take();
}

/// Of the two bytes that give a message's encoding.
Result<Layout> layout_of(std::string_view bytes, std::string_view name) {
  if (bytes.size() < 4)
    return Error{ErrorCode::parse, "is shorter than CDR's four bytes", std::string(name)};
  const auto high = static_cast<std::uint8_t>(bytes[0]), low = static_cast<std::uint8_t>(bytes[1]);
  if (high == 0 && low <= 1) return cdr(low == 0, 8);
  if (high == 0 && (low == 6 || low == 7)) return cdr(low == 6, 4);
  return Error{ErrorCode::unsupported,
               "is encoded as CDR kind " + std::to_string(256 * high + low) +
                   "; plain CDR (kinds 0, 1, 6 and 7) is read",
               std::string(name)};
}

}  // namespace

template <Message M>
std::string to_cdr(const M& message, ByteOrder order) {
  const bool big = order == ByteOrder::big;
  return std::string{'\0', static_cast<char>(big ? 0 : 1), '\0', '\0'} +
         write(message, cdr(big, 8));
}

template <Message M>
Result<M> from_cdr(std::string_view bytes) {
  const auto layout = layout_of(bytes, M::kType.name);
  if (!layout) return layout.error();
  return read<M>(bytes.substr(4), *layout, kMostPadding);
}

template <Message M>
std::string to_ros1(const M& message) {
  return write(message, kRos1);
}

template <Message M>
Result<M> from_ros1(std::string_view bytes) {
  return read<M>(bytes, kRos1, 0);
}

template <Message M>
std::string definition(Dialect dialect) {
  return Describer(dialect).whole(M{});
}

#define WAYFARE_ROS_MESSAGE(M)                         \
  template std::string to_cdr<M>(const M&, ByteOrder); \
  template Result<M> from_cdr<M>(std::string_view);    \
  template std::string to_ros1<M>(const M&);           \
  template Result<M> from_ros1<M>(std::string_view);   \
  template std::string definition<M>(Dialect);
WAYFARE_ROS_MESSAGE(Header)
WAYFARE_ROS_MESSAGE(LaserScan)
WAYFARE_ROS_MESSAGE(PointCloud2)
WAYFARE_ROS_MESSAGE(Imu)
WAYFARE_ROS_MESSAGE(MagneticField)
WAYFARE_ROS_MESSAGE(NavSatFix)
WAYFARE_ROS_MESSAGE(Odometry)
WAYFARE_ROS_MESSAGE(TfMessage)
WAYFARE_ROS_MESSAGE(PoseStamped)
WAYFARE_ROS_MESSAGE(Path)
WAYFARE_ROS_MESSAGE(OccupancyGrid)
WAYFARE_ROS_MESSAGE(RadarScan)
#undef WAYFARE_ROS_MESSAGE

std::string ros2_name(std::string_view ros1_name) {
  const std::size_t slash = ros1_name.find('/');
  if (slash == std::string_view::npos || ros1_name.find('/', slash + 1) != std::string_view::npos)
    return std::string(ros1_name);
  return std::string(ros1_name.substr(0, slash)) + "/msg" + std::string(ros1_name.substr(slash));
}

std::string ros1_name(std::string_view ros2_name) {
  constexpr std::string_view kMiddle = "/msg/";
  const std::size_t middle = ros2_name.find(kMiddle);
  if (middle == std::string_view::npos) return std::string(ros2_name);
  return std::string(ros2_name.substr(0, middle)) + "/" +
         std::string(ros2_name.substr(middle + kMiddle.size()));
}

}  // namespace wayfare::ros
