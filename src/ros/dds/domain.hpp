#pragma once

// Membership in a DDS domain.

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <dds/dds.h>

#include <wayfare/core/result.hpp>
#include <wayfare/ros/ros2_node.hpp>

namespace wayfare::ros::dds {

/// An entity of DDS, deleted at the end of its lifetime.
class Entity {
 public:
  Entity() = default;
  explicit Entity(dds_entity_t handle) : handle_(handle) {}
  Entity(Entity&& other) noexcept : handle_(std::exchange(other.handle_, 0)) {}
  Entity& operator=(Entity&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~Entity() {
    if (handle_ > 0) dds_delete(handle_);
  }
  [[nodiscard]] dds_entity_t get() const { return handle_; }

 private:
  dds_entity_t handle_ = 0;
};

/// Who may find a node.
struct Reach {
  unsigned domain = 0;
  bool network = false;  ///< other computers, too
};

/// By options and environment. Error: a domain outside 0 to 232.
[[nodiscard]] Result<Reach> reach_of(const Ros2Options& options);

/// A topic or endpoint for ROS messages of a type.
struct TopicOf {
  std::string name;       ///< "/scan"
  std::string type;       ///< "sensor_msgs/LaserScan"
  std::string type_hash;  ///< or empty
};

/// What a publisher offers.
[[nodiscard]] Qos offered_by(const dds_builtintopic_endpoint_t& publisher);

/// Joined until destroyed.
class Domain {
 public:
  /// Errors: of the network interfaces, or of CYCLONEDDS_URI.
  [[nodiscard]] static Result<Domain> join(const Reach& reach);
  Domain(Domain&&) = default;
  Domain& operator=(Domain&&) = default;
  ~Domain();

  /// Errors: of DDS.
  [[nodiscard]] Result<Entity> writer(const TopicOf& topic, const Qos& qos) const;
  /// `listener` is copied.
  [[nodiscard]] Result<Entity> reader(const TopicOf& topic, const Qos& qos,
                                      const dds_listener_t* listener) const;
  /// Of other nodes, as far as they are known yet.
  [[nodiscard]] std::vector<PublishedTopic> published() const;

 private:
  Domain() = default;
  [[nodiscard]] Result<Entity> topic(const TopicOf& topic) const;
  Entity participant_, publications_;
};

}  // namespace wayfare::ros::dds
