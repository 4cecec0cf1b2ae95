// Compiled as C++17: roscpp's headers use features removed in C++20.

#include <wayfare/ros/ros1_node.hpp>

#include <ros/callback_queue.h>
#include <ros/ros.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <thread>

namespace {

/// A message of any type, as bytes.
struct AnyMessage {
  std::string bytes;
};

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

struct Connected {
  ::ros::NodeHandle node;
  std::vector<::ros::Subscriber> subscribers;
};

class Ros1Node final : public RawNode {
 public:
  Ros1Node(std::vector<std::string>& arguments, const std::string& name) {
    // Output of ROS must appear at once, in a file or pipe as well.
    std::setvbuf(stdout, nullptr, _IOLBF, 0);
    std::vector<char*> argv;
    argv.reserve(arguments.size() + 1);
    for (std::string& argument : arguments) argv.push_back(argument.data());
    int argc = static_cast<int>(argv.size());
    argv.push_back(nullptr);
    ::ros::init(argc, argv.data(), name, ::ros::init_options::NoSigintHandler);
    arguments = std::vector<std::string>(argv.begin(), argv.begin() + argc);
  }
  ~Ros1Node() override {
    connected_.reset();
    if (::ros::isStarted()) ::ros::shutdown();
  }

  [[nodiscard]] const char* system() const override { return "ros1"; }
  bool connect() override;
  [[nodiscard]] bool ok() const override { return !interrupted() && ::ros::ok(); }
  [[nodiscard]] std::vector<std::pair<std::string, std::string>> parameters() const override;
  [[nodiscard]] std::vector<PublishedTopic> topics() const override;
  RawPublisher advertise(const std::string& topic, const TopicType& type, const Qos& qos) override;
  RawSubscription subscribe(const std::string& topic, const TopicType& type, const Qos& qos,
                            RawCallback callback) override;
  void spin(double seconds) override {
    ::ros::getGlobalCallbackQueue()->callAvailable(::ros::WallDuration(seconds));
  }
  [[nodiscard]] std::int64_t now_ns() const override {
    return static_cast<std::int64_t>(::ros::Time::now().toNSec());
  }
  void say(Severity severity, const std::string& text) const override;

 private:
  std::unique_ptr<Connected> connected_;
};

bool Ros1Node::connect() {
  for (bool said = false; !::ros::master::check(); said = true) {
    if (!said)
      std::fprintf(stderr, "%s waits for the ROS master at %s\n",
                   ::ros::this_node::getName().c_str(), ::ros::master::getURI().c_str());
    if (interrupted()) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
  }
  if (!interrupted()) connected_ = std::make_unique<Connected>();
  return connected_ != nullptr;
}

std::vector<std::pair<std::string, std::string>> Ros1Node::parameters() const {
  std::vector<std::pair<std::string, std::string>> found;
  XmlRpc::XmlRpcValue all;
  if (!::ros::param::get("~", all) || all.getType() != XmlRpc::XmlRpcValue::TypeStruct)
    return found;
  for (auto& [name, value] : all)
    if (std::string text = text_of(value); !text.empty()) found.emplace_back(name, std::move(text));
  return found;
}

std::vector<PublishedTopic> Ros1Node::topics() const {
  ::ros::master::V_TopicInfo all;
  ::ros::master::getTopics(all);
  std::vector<PublishedTopic> found;
  for (const auto& topic : all) found.push_back({topic.name, topic.datatype, {}, {}});
  return found;
}

RawPublisher Ros1Node::advertise(const std::string& topic, const TopicType& type, const Qos& qos) {
  ::ros::AdvertiseOptions options(topic,
                                  std::max(kSendQueue, static_cast<std::uint32_t>(qos.depth)),
                                  type.md5, type.name, type.definition);
  options.latch = qos.durability == Durability::transient_local;
  const ::ros::Publisher publisher = connected_->node.advertise(options);
  return {
      [publisher](std::string_view bytes) { publisher.publish(AnyMessage{std::string(bytes)}); },
      [publisher] { return std::size_t{publisher.getNumSubscribers()}; }};
}

RawSubscription Ros1Node::subscribe(const std::string& topic, const TopicType& type, const Qos& qos,
                                    RawCallback callback) {
  ::ros::SubscribeOptions options;
  options.initByFullCallbackType<const ::ros::MessageEvent<AnyMessage const>&>(
      topic, static_cast<std::uint32_t>(qos.depth),
      [callback = std::move(callback)](const ::ros::MessageEvent<AnyMessage const>& event) {
        callback(event.getConstMessage()->bytes,
                 static_cast<std::int64_t>(event.getReceiptTime().toNSec()));
      });
  options.md5sum = type.md5;
  options.datatype = type.name;
  // Small messages are sent at once, without coalescing.
  options.transport_hints = ::ros::TransportHints().tcpNoDelay();
  connected_->subscribers.push_back(connected_->node.subscribe(options));
  return {connected_->subscribers.back().getTopic(), [] { return std::uint64_t{0}; }};
}

// To standard output, errors and warnings to standard error, and to /rosout.
void Ros1Node::say(Severity severity, const std::string& text) const {
  if (severity == Severity::info) {
    ROS_INFO_STREAM(text);
  } else if (severity == Severity::warning) {
    ROS_WARN_STREAM(text);
  } else {
    ROS_ERROR_STREAM(text);
  }
}

}  // namespace

std::unique_ptr<RawNode> ros1_node(std::vector<std::string>& arguments, const std::string& name) {
  static_cast<void>(interrupted());
  return std::make_unique<Ros1Node>(arguments, name);
}

}  // namespace wayfare::ros
