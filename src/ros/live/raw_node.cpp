// Compiled as C++17: roscpp's headers use features removed in C++20.

#include <wayfare/ros/detail/raw_node.hpp>

#include <ros/callback_queue.h>
#include <ros/ros.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <thread>

namespace {

/// A message of any type, as bytes.
struct AnyMessage {
  std::string bytes;
};

std::atomic<bool> ended{false};

}  // namespace

namespace ros {
namespace message_traits {

struct Any {
  static const char* value(const AnyMessage&) { return "*"; }
  static const char* value() { return "*"; }
};
template <>
struct MD5Sum<AnyMessage> : Any {};
template <>
struct DataType<AnyMessage> : Any {};

}  // namespace message_traits

namespace serialization {

template <>
struct Serializer<AnyMessage> {
  static void write(OStream& out, const AnyMessage& m) {
    const auto n = static_cast<std::uint32_t>(m.bytes.size());
    std::memcpy(out.advance(n), m.bytes.data(), n);
  }
  static void read(IStream& in, AnyMessage& m) {
    const std::uint32_t n = in.getLength();
    m.bytes.assign(reinterpret_cast<const char*>(in.advance(n)), n);
  }
  static std::uint32_t serializedLength(const AnyMessage& m) {
    return static_cast<std::uint32_t>(m.bytes.size());
  }
};

}  // namespace serialization
}  // namespace ros

namespace wayfare::ros {
namespace {

constexpr std::uint32_t kSendQueue = 1000;  ///< a burst must not displace earlier messages

/// A parameter in the notation of a command line; empty for lists and structures.
std::string text_of(XmlRpc::XmlRpcValue& value) {
  switch (value.getType()) {
    case XmlRpc::XmlRpcValue::TypeBoolean:
      return static_cast<bool>(value) ? "true" : "false";
    case XmlRpc::XmlRpcValue::TypeInt:
      return std::to_string(static_cast<int>(value));
    case XmlRpc::XmlRpcValue::TypeDouble: {
      char text[32];
      std::snprintf(text, sizeof text, "%.17g", static_cast<double>(value));
      return text;
    }
    case XmlRpc::XmlRpcValue::TypeString:
      return static_cast<std::string>(value);
    default:
      return "";
  }
}

}  // namespace

struct RawNode::Connected {
  ::ros::NodeHandle node;
  std::vector<::ros::Subscriber> subscribers;
};

RawNode::RawNode(std::vector<std::string>& arguments, const std::string& name) {
  // Output of ROS must appear at once, in a file or pipe as well.
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  int argc = static_cast<int>(argv.size());
  argv.push_back(nullptr);
  ::ros::init(argc, argv.data(), name, ::ros::init_options::NoSigintHandler);
  arguments = std::vector<std::string>(argv.begin(), argv.begin() + argc);
  std::signal(SIGINT, [](int) { ended = true; });
  std::signal(SIGTERM, [](int) { ended = true; });
}

RawNode::~RawNode() {
  connected_.reset();
  if (::ros::isStarted()) ::ros::shutdown();
}

bool RawNode::connect() {
  for (bool said = false; !::ros::master::check(); said = true) {
    if (!said)
      std::fprintf(stderr, "%s waits for the ROS master at %s\n",
                   ::ros::this_node::getName().c_str(), ::ros::master::getURI().c_str());
    if (ended) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
  }
  if (!ended) connected_ = std::make_unique<Connected>();
  return !ended;
}

bool RawNode::ok() const { return !ended && ::ros::ok(); }

std::vector<std::pair<std::string, std::string>> RawNode::parameters() const {
  std::vector<std::pair<std::string, std::string>> found;
  XmlRpc::XmlRpcValue all;
  if (!::ros::param::get("~", all) || all.getType() != XmlRpc::XmlRpcValue::TypeStruct)
    return found;
  for (auto& [name, value] : all)
    if (std::string text = text_of(value); !text.empty()) found.emplace_back(name, std::move(text));
  return found;
}

RawPublisher RawNode::advertise(const std::string& topic, const TopicType& type, bool latched) {
  ::ros::AdvertiseOptions options(topic, kSendQueue, type.md5, type.name, type.definition);
  options.latch = latched;
  const ::ros::Publisher publisher = connected_->node.advertise(options);
  return {[publisher](const std::string& bytes) { publisher.publish(AnyMessage{bytes}); },
          [publisher] { return std::size_t{publisher.getNumSubscribers()}; }};
}

void RawNode::subscribe(const std::string& topic, const TopicType& type, std::uint32_t queue,
                        std::function<void(const std::string&)> callback) {
  ::ros::SubscribeOptions options;
  options.init<AnyMessage>(
      topic, queue,
      [callback = std::move(callback)](const boost::shared_ptr<AnyMessage const>& message) {
        callback(message->bytes);
      });
  options.md5sum = type.md5;
  options.datatype = type.name;
  // Small messages are sent at once, without coalescing.
  options.transport_hints = ::ros::TransportHints().tcpNoDelay();
  connected_->subscribers.push_back(connected_->node.subscribe(options));
}

void RawNode::spin(double seconds) {
  ::ros::getGlobalCallbackQueue()->callAvailable(::ros::WallDuration(seconds));
}

std::int64_t RawNode::now_ns() const {
  return static_cast<std::int64_t>(::ros::Time::now().toNSec());
}

void RawNode::say(Severity severity, const std::string& text) const {
  if (severity == Severity::info) {
    ROS_INFO_STREAM(text);
  } else if (severity == Severity::warning) {
    ROS_WARN_STREAM(text);
  } else {
    ROS_ERROR_STREAM(text);
  }
}

}  // namespace wayfare::ros
