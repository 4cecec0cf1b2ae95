#include "node_program.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <span>
#include <sstream>
#include <utility>

#include <wayfare/ros/convert.hpp>
#ifdef WAYFARE_ROS1
#include <wayfare/ros/ros1_node.hpp>
#endif
#ifdef WAYFARE_ROS2
#include <wayfare/ros/ros2_node.hpp>
#endif

namespace wayfare::examples {
namespace {

std::optional<int> parse(CommandLine& options, std::vector<std::string> arguments) {
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  return options.parse(static_cast<int>(argv.size()), argv.data());
}

/// Parameters as options, except those on the command line.
void append(std::vector<std::string>& arguments,
            const std::vector<std::pair<std::string, std::string>>& parameters) {
  const auto given = arguments;
  for (auto [name, value] : parameters) {
    std::replace(name.begin(), name.end(), '_', '-');
    const std::string option = "--" + name;
    const bool there = std::any_of(given.begin(), given.end(), [&](const std::string& a) {
      return a == option || a.starts_with(option + "=");
    });
    if (there) continue;
    if (!value.starts_with('[')) {
      arguments.push_back(option + "=" + value);
      continue;
    }
    // Of several numbers: "[0.1, 0, 0]".
    for (char& c : value)
      if (c == '[' || c == ']' || c == ',') c = ' ';
    arguments.push_back(option);
    std::istringstream words(value);
    for (std::string word; words >> word;) arguments.push_back(word);
  }
}

bool is_for_ros1(const std::string& argument) { return argument.find(":=") != argument.npos; }

/// The program's own arguments.
std::vector<std::string> without_ros(const std::vector<std::string>& arguments) {
  std::vector<std::string> ours;
  bool ros2 = false;
  for (const std::string& a : arguments) {
    if (a == "--ros-args" || (ros2 && a == "--")) {
      ros2 = a == "--ros-args";
    } else if (!ros2 && !is_for_ros1(a)) {
      ours.push_back(a);
    }
  }
  return ours;
}

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

/// ROS's own setup scripts set ROS_VERSION; Debian's ROS 1 has none.
[[maybe_unused]] bool wants_ros1(const std::vector<std::string>& arguments) {
  if (std::find(arguments.begin(), arguments.end(), "--ros-args") != arguments.end()) return false;
  const std::string version = environment("ROS_VERSION");
  return version.empty() ? !environment("ROS_MASTER_URI").empty() : version == "1";
}

#ifdef WAYFARE_ROS2
Result<std::unique_ptr<ros::RawNode>> ros2_transport(std::vector<std::string>& arguments,
                                                     const std::string& name) {
  auto node = ros::ros2_node(arguments, name);
  const auto odd = std::find_if(arguments.begin(), arguments.end(), is_for_ros1);
  if (node && odd != arguments.end())
    return Error{ErrorCode::invalid,
                 "in ROS 2 belongs after --ros-args, as -r for names or -p for parameters; for "
                 "ROS 1 set ROS_VERSION=1",
                 *odd};
  return node;
}
#endif

Result<std::unique_ptr<ros::RawNode>> transport(std::vector<std::string>& arguments,
                                                const std::string& name) {
#if defined(WAYFARE_ROS1) && defined(WAYFARE_ROS2)
  if (wants_ros1(arguments)) return ros::ros1_node(arguments, name);
  return ros2_transport(arguments, name);
#elif defined(WAYFARE_ROS2)
  return ros2_transport(arguments, name);
#else
  if (!wants_ros1(arguments) && without_ros(arguments).size() != arguments.size() &&
      std::find(arguments.begin(), arguments.end(), "--ros-args") != arguments.end())
    return Error{ErrorCode::unsupported, "was built without ROS 2 (cyclonedds-dev)", name};
  return ros::ros1_node(arguments, name);
#endif
}

}  // namespace

StartedNode start_node(int argc, char** argv, const std::string& name, CommandLine& options) {
  options.footer(
      "Options may be given as the node's parameters as well, with underscores (map_period_s for "
      "--map-period-s). ROS 2: --ros-args -r scan:=/front/scan -p map_period_s:=2.0 "
      "--params-file FILE, domain "
      "ROS_DOMAIN_ID, this computer only unless ROS_LOCALHOST_ONLY=0. ROS 1, chosen by "
      "ROS_VERSION=1 or, without ROS_VERSION, by ROS_MASTER_URI: scan:=front/scan "
      "_map_period_s:=2.");
  std::vector<std::string> arguments(argv, argv + argc);
  // Before a node is made: for --help and wrong arguments.
  if (const auto code = parse(options, without_ros(arguments))) return {nullptr, *code};
  auto made = transport(arguments, name);
  if (!made) {
    std::fprintf(stderr, "%s: %s\n", name.c_str(), made.error().to_string().c_str());
    return {nullptr, 2};
  }
  auto node = std::make_unique<ros::Node>(*std::move(made));
  if (!node->raw().connect()) return {nullptr, 1};
  append(arguments, node->raw().parameters());
  if (const auto code = parse(options, arguments)) return {nullptr, *code};
  return {std::move(node), 0};
}

double steady_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

void check_clock(const ros::Node& node, const ros::Header& header) {
  const auto time = ros::time_of(header.stamp);
  if (!time) return;
  const LogTime now = LogTime::from_nanoseconds(node.now_ns());
  if (const auto ok = ros::check_clock(*time, now, from_seconds(10.0)); !ok)
    node.say(ros::Severity::info, "a replay, or clocks that differ: " + ok.error().to_string());
}

void say_all(const ros::Node& node, const std::vector<ros::Notice>& notices) {
  for (const ros::Notice& notice : notices) node.say(notice.severity, notice.text);
}

void say_counts(const ros::Node& node) {
  for (const ros::TopicCounts& c : node.counts())
    if (c.refused + c.lost > 0)
      node.say(ros::Severity::warning, c.topic + ": " + std::to_string(c.received) +
                                           " messages received, " + std::to_string(c.refused) +
                                           " refused, " + std::to_string(c.lost) + " lost");
}

void add_device_options(CommandLine& app, DeviceArguments& a) {
  app.add_option("--port", a.port, "the device's serial line, such as /dev/ttyUSB0").required();
  app.add_number("--baud", a.line.baud, 300, 10'000'000, "bits per second on the line");
  app.add_option("--frame", a.frame, "frame of the messages").show_default();
}

namespace {

/// Reports a device that is silent, or does not speak the expected language.
class DeviceWatch {
 public:
  DeviceWatch(const ros::Node& node, std::string port) : node_(node), port_(std::move(port)) {}

  void opened() { heard_s_ = understood_s_ = steady_s(), strange_bytes_ = 0; }
  void take(std::size_t bytes, std::uint64_t messages) {
    const double now_s = steady_s();
    if (bytes > 0) heard_s_ = now_s;
    strange_bytes_ += bytes;
    if (messages != messages_) understood_s_ = now_s, strange_bytes_ = 0;
    messages_ = messages;
    if (now_s > heard_s_ + kPatience_s) {
      say("silent", "no bytes from " + port_ + ": is the device on?");
    } else if (strange_bytes_ > 0 && now_s > understood_s_ + kPatience_s) {
      say("strange", std::to_string(strange_bytes_) + " bytes from " + port_ +
                         " without a message: another --baud, or another device?");
    }
  }

 private:
  static constexpr double kPatience_s = 2.0;

  void say(const char* about, std::string text) {
    notices_.add(ros::Severity::warning, about, std::move(text), steady_s());
    say_all(node_, notices_.take());
  }

  const ros::Node& node_;
  std::string port_;
  ros::Notices notices_;
  double heard_s_ = 0.0, understood_s_ = 0.0;
  std::size_t strange_bytes_ = 0;
  std::uint64_t messages_ = 0;
};

}  // namespace

void read_device(ros::Node& node, const DeviceArguments& a, const std::vector<std::uint8_t>& start,
                 const std::function<std::uint64_t(decode::Bytes, LogTime)>& take) {
  std::array<std::uint8_t, 4096> buffer{};
  ros::Notices notices;
  DeviceWatch watch(node, a.port);
  std::uint64_t messages = 0;
  while (node.ok()) {
    auto port = logger::SerialPort::open(a.port, a.line);
    if (!port) {
      notices.add(ros::Severity::warning, "port",
                  "waiting for the device: " + port.error().to_string(), steady_s());
      say_all(node, notices.take());
      node.spin(0.5);
      continue;
    }
    node.say(ros::Severity::info,
             "reading " + a.port + (port->note().empty() ? "" : ": " + port->note()));
    if (auto sent = port->write(start); !sent)
      node.say(ros::Severity::warning, sent.error().to_string());
    watch.opened();
    while (node.ok()) {
      const auto n = port->read(buffer, std::chrono::milliseconds(50));
      if (!n) {
        node.say(ros::Severity::warning, n.error().to_string());
        break;
      }
      const LogTime now = LogTime::from_nanoseconds(node.now_ns());
      if (*n > 0) messages = take(std::span(buffer).first(*n), now);
      watch.take(*n, messages);
      node.spin(0.0);
    }
  }
}

void say_statistics(const ros::Node& node, std::uint64_t messages,
                    const decode::DecoderStatistics& s) {
  node.say(ros::Severity::info, std::to_string(messages) + " messages, " +
                                    std::to_string(s.skipped_bytes) + " of " +
                                    std::to_string(s.bytes) + " bytes outside frames");
}

}  // namespace wayfare::examples
