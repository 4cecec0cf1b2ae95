#include <wayfare/ros/serialise.hpp>

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "ros/serialise/archive.hpp"

namespace wayfare::ros {
namespace {

/// The text of a message's definition, from its list of fields.
class Describer {
 public:
  explicit Describer(Dialect dialect) : dialect_(dialect) {}

  template <class T>
  void operator()(const char* name, const T& value) {
    line(type_of(value), name);
  }
  void ros1_only(const char* name, std::uint32_t value) {
    if (dialect_ == Dialect::ros1) line(type_of(value), name);
  }

  template <class M>
  [[nodiscard]] std::string whole(const M& message) {
    body(message);
    std::string text = own_;
    for (const auto& [name, definition] : within_)
      text += std::string(80, '=') + "\nMSG: " + name + "\n" + definition;
    return text;
  }

 private:
  void line(const std::string& type, const char* name) { own_ += type + " " + name + "\n"; }

  template <class M>
  void body(const M& message) {
    own_ += M::kType.constants;
    M::fields(message, *this);
  }

  template <class T>
  requires std::is_arithmetic_v<T>
  static std::string type_of(T) {
    if constexpr (std::is_same_v<T, bool>) return "bool";
    const char* kind = std::is_floating_point_v<T> ? "float" : std::is_signed_v<T> ? "int" : "uint";
    return kind + std::to_string(8 * sizeof(T));
  }
  static std::string type_of(const std::string&) { return "string"; }
  std::string type_of(const Stamp&) {
    if (dialect_ == Dialect::ros1) return "time";
    add("builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n");
    return "builtin_interfaces/Time";
  }
  template <class T>
  std::string type_of(const std::vector<T>&) {
    return type_of(T{}) + "[]";
  }
  template <class T, std::size_t N>
  std::string type_of(const std::array<T, N>&) {
    return type_of(T{}) + "[" + std::to_string(N) + "]";
  }
  template <class M>
  requires requires { M::kType; }
  std::string type_of(const M& message) {
    const std::string name(M::kType.name);
    for (const auto& there : within_)
      if (there.name == name) return name;
    const std::size_t place = within_.size();
    within_.push_back({name, {}});
    std::string outer;
    outer.swap(own_);
    body(message);
    outer.swap(own_);
    within_[place].definition = std::move(outer);
    return name;
  }
  void add(const std::string& name, const std::string& definition) {
    for (const auto& there : within_)
      if (there.name == name) return;
    within_.push_back({name, definition});
  }

  struct Part {
    std::string name, definition;
  };
  Dialect dialect_;
  std::string own_;
  std::vector<Part> within_;
};

constexpr Encoding kRos1{};
constexpr std::size_t kMostPadding = 7;

Encoding cdr(bool big_endian, std::size_t max_align) {
  return {big_endian, max_align, true, false};
}

Error too_short(std::string_view name, const Reader& reader) {
  return {ErrorCode::parse, "ends within its field " + std::string(reader.failed_at()),
          std::string(name)};
}

template <class M>
Result<M> read(std::string_view bytes, const Encoding& encoding, std::size_t spare) {
  Reader reader(bytes, encoding);
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
std::string write(const M& message, const Encoding& encoding) {
  Writer writer(encoding);
  M::fields(message, writer);
  return writer.take();
}

/// Of the two bytes that give a message's encoding.
Result<Encoding> encoding_of(std::string_view bytes, std::string_view name) {
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
  const auto encoding = encoding_of(bytes, M::kType.name);
  if (!encoding) return encoding.error();
  return read<M>(bytes.substr(4), *encoding, kMostPadding);
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
WAYFARE_ROS_MESSAGE(JointState)
WAYFARE_ROS_MESSAGE(String)
WAYFARE_ROS_MESSAGE(NavSatFix)
WAYFARE_ROS_MESSAGE(Odometry)
WAYFARE_ROS_MESSAGE(TfMessage)
WAYFARE_ROS_MESSAGE(PoseStamped)
WAYFARE_ROS_MESSAGE(PoseWithCovarianceStamped)
WAYFARE_ROS_MESSAGE(Path)
WAYFARE_ROS_MESSAGE(OccupancyGrid)
WAYFARE_ROS_MESSAGE(RadarScan)
WAYFARE_ROS_MESSAGE(Clock)
WAYFARE_ROS_MESSAGE(PoseArray)
WAYFARE_ROS_MESSAGE(ParticleCloud)
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
