#include <wayfare/ros/ros2_node.hpp>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <map>
#include <set>
#include <utility>

#include <wayfare/ros/convert.hpp>
#include <wayfare/ros/serialise.hpp>

#include "ros/dds/arguments.hpp"
#include "ros/dds/domain.hpp"
#include "ros/dds/reception.hpp"

namespace wayfare::ros {
namespace {

using dds::Domain;
using dds::Entity;
using dds::Reception;
using dds::RosArguments;
using dds::TopicOf;

std::int64_t system_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

TopicOf topic_of(std::string name, const std::string& type, const std::string& hash) {
  return {std::move(name), type, hash.empty() ? std::string(type_hash(type)) : hash};
}

class Ros2Node final : public RawNode {
 public:
  Ros2Node(RosArguments arguments, dds::Reach reach)
      : arguments_(std::move(arguments)), reach_(reach) {}

  [[nodiscard]] const char* system() const override { return "ros2"; }
  bool connect() override;
  [[nodiscard]] bool ok() const override { return !interrupted(); }
  [[nodiscard]] std::vector<std::pair<std::string, std::string>> parameters() const override;
  [[nodiscard]] std::vector<PublishedTopic> topics() const override { return domain_->published(); }
  RawPublisher advertise(const std::string& topic, const TopicType& type, const Qos& qos) override;
  RawSubscription subscribe(const std::string& topic, const TopicType& type, const Qos& qos,
                            RawCallback callback) override;
  void spin(double seconds) override;
  [[nodiscard]] std::int64_t now_ns() const override {
    return simulated_ns_ ? *simulated_ns_ : system_ns();
  }
  void say(Severity severity, const std::string& text) const override;

 private:
  /// With its namespaces, after remapping; a name that is none is reported, and none results.
  [[nodiscard]] std::optional<std::string> resolved(const std::string& topic) const;
  /// Of subscribed topics: no message of another type is received.
  void report_other_types();

  RosArguments arguments_;
  dds::Reach reach_;
  std::optional<std::int64_t> simulated_ns_;
  std::optional<Domain> domain_;
  std::unique_ptr<Reception> reception_;
  std::map<std::string, std::string> subscribed_;              ///< topics and their types
  std::set<std::pair<std::string, std::string>> other_types_;  ///< reported
  std::chrono::steady_clock::time_point checked_{};
};

bool Ros2Node::connect() {
  auto domain = Domain::join(reach_);
  if (!domain) {
    say(Severity::error, domain.error().to_string());
    return false;
  }
  domain_.emplace(*std::move(domain));
  reception_ = std::make_unique<Reception>(*domain_);
  say(Severity::info,
      "ROS 2, domain " + std::to_string(reach_.domain) +
          (reach_.network ? ", on the network"
                          : ", on this computer only (ROS_LOCALHOST_ONLY=0: on the network)"));
  if (arguments_.parameter("use_sim_time") == "true") {
    simulated_ns_ = 0;
    subscribe("/clock", {std::string(Clock::kType.name), "", ""}, Qos::sensor_data(1),
              [this](std::string_view bytes, std::int64_t) {
                const auto clock = from_cdr<Clock>(bytes);
                const auto time = clock ? time_of(clock->clock) : Result<LogTime>(clock.error());
                if (time) simulated_ns_ = time->nanoseconds();
              });
  }
  return ok();
}

std::vector<std::pair<std::string, std::string>> Ros2Node::parameters() const {
  auto own = arguments_.parameters;
  std::erase_if(own, [](const auto& p) { return p.first == "use_sim_time"; });
  return own;
}

std::optional<std::string> Ros2Node::resolved(const std::string& topic) const {
  auto full = arguments_.topic(topic);
  if (full) return *full;
  say(Severity::error, full.error().to_string());
  return std::nullopt;
}

RawPublisher Ros2Node::advertise(const std::string& topic, const TopicType& type, const Qos& qos) {
  const RawPublisher none{[](std::string_view) {}, [] { return std::size_t{0}; }};
  const auto name = resolved(topic);
  if (!name) return none;
  auto writer = domain_->writer(topic_of(*name, type.name, ""), qos);
  if (!writer) return say(Severity::error, writer.error().to_string()), none;
  const auto shared = std::make_shared<Entity>(*std::move(writer));
  auto said = std::make_shared<bool>(false);
  return {[this, shared, said, name](std::string_view bytes) {
            const dds_return_t code = dds_write(shared->get(), &bytes);
            if (code < 0 && !std::exchange(*said, true))
              say(Severity::error,
                  "messages on '" + *name + "' are not sent: " + dds_strretcode(code));
          },
          [shared] {
            dds_publication_matched_status_t status{};
            dds_get_publication_matched_status(shared->get(), &status);
            return std::size_t{status.current_count};
          }};
}

RawSubscription Ros2Node::subscribe(const std::string& topic, const TopicType& type, const Qos& qos,
                                    RawCallback callback) {
  const auto name = resolved(topic);
  if (!name) return {topic, [] { return std::uint64_t{0}; }};
  const auto made =
      reception_->subscribe(topic_of(*name, type.name, type.hash), qos, std::move(callback));
  if (!made) {
    say(Severity::error, made.error().to_string());
    return {*name, [] { return std::uint64_t{0}; }};
  }
  subscribed_[*name] = type.name;
  return {*name, [subscription = *made] { return subscription->lost(); }};
}

void Ros2Node::spin(double seconds) {
  reception_->wait(seconds);
  reception_->deliver([this](const std::string& notice) { say(Severity::warning, notice); });
  const auto now = std::chrono::steady_clock::now();
  if (now < checked_ + std::chrono::seconds(1)) return;
  checked_ = now;
  report_other_types();
}

void Ros2Node::report_other_types() {
  for (const PublishedTopic& p : topics()) {
    const auto ours = subscribed_.find(p.name);
    if (ours == subscribed_.end() || ours->second == p.type) continue;
    if (!other_types_.insert({p.name, p.type}).second) continue;
    say(Severity::error, "leaves out a publisher of '" + p.name + "': its type is " +
                             ros2_name(p.type) + ", not " + ros2_name(ours->second));
  }
}

// As ROS 2 does, to standard error.
void Ros2Node::say(Severity severity, const std::string& text) const {
  const char* level = severity == Severity::info      ? "INFO"
                      : severity == Severity::warning ? "WARN"
                                                      : "ERROR";
  const std::int64_t ns = now_ns();
  std::string name = arguments_.node.ns == "/" ? "" : arguments_.node.ns.substr(1) + ".";
  for (char& c : name)
    if (c == '/') c = '.';
  std::fprintf(stderr, "[%s] [%lld.%09lld] [%s%s]: %s\n", level,
               static_cast<long long>(ns / 1'000'000'000),
               static_cast<long long>(ns % 1'000'000'000), name.c_str(),
               arguments_.node.name.c_str(), text.c_str());
}

}  // namespace

Result<std::unique_ptr<RawNode>> ros2_node(std::vector<std::string>& arguments,
                                           const std::string& name, const Ros2Options& options) {
  static_cast<void>(interrupted());
  auto ours = dds::take_ros_arguments(arguments, name);
  if (!ours) return ours.error();
  const auto reach = dds::reach_of(options);
  if (!reach) return reach.error();
  return std::unique_ptr<RawNode>(std::make_unique<Ros2Node>(*std::move(ours), *reach));
}

}  // namespace wayfare::ros
