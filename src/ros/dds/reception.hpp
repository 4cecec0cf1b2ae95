#pragma once

// Messages in the order of their arrival, on DDS's thread, until the node's thread takes them.

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "ros/dds/cdr_type.hpp"
#include "ros/dds/domain.hpp"

namespace wayfare::ros::dds {

class Subscription;

/// The subscriptions of a node. Its functions are for one thread.
class Reception {
 public:
  explicit Reception(const Domain& domain) : domain_(domain) {}
  ~Reception();

  /// Up to `qos.depth` messages are queued. Error: of DDS.
  [[nodiscard]] Result<const Subscription*> subscribe(const TopicOf& topic, const Qos& qos,
                                                      RawCallback callback);
  /// Waits up to `seconds` for a message.
  void wait(double seconds);
  /// Calls the callbacks of what is queued. Publishers that offer less than was asked for are
  /// received too from then on; `report` gets a notice.
  void deliver(const std::function<void(const std::string&)>& report);

 private:
  friend class Subscription;
  const Domain& domain_;
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::uint64_t arrivals_ = 0;  ///< number of the last one
  bool waiting_ = false;        ///< something is queued, or to be weakened
  std::vector<std::unique_ptr<Subscription>> subscriptions_;
};

/// One subscription.
class Subscription {
 public:
  /// Lost on the way or in the full queue.
  [[nodiscard]] std::uint64_t lost() const;

 private:
  friend class Reception;
  struct Message {
    std::uint64_t number;  ///< of arrival
    std::int64_t received_ns;
    SerialisedPtr bytes;
  };
  Subscription(Reception& in, TopicOf topic, const Qos& qos, RawCallback callback)
      : in_(in), topic_(std::move(topic)), qos_(qos), callback_(std::move(callback)), less_(qos) {}
  [[nodiscard]] Result<Entity> open(const Qos& qos, dds_on_data_available_fn on_data);
  // On DDS's thread.
  void take(dds_entity_t reader, bool is_second);
  void refuse(std::uint32_t policy);
  [[nodiscard]] bool offers_less(dds_entity_t reader, dds_instance_handle_t publication);
  /// Opens the second reader, which asks for less; empty if nothing is to be said.
  [[nodiscard]] std::string ask_for_less();

  Reception& in_;
  TopicOf topic_;
  Qos qos_;
  RawCallback callback_;
  // Of the node's thread. The second reader is for publishers that offer less than `qos_`; it hears
  // the others, too, and leaves them out.
  Entity reader_, second_;
  Qos less_;
  std::uint64_t lost_before_ = 0;
  // Of DDS's thread.
  std::map<dds_instance_handle_t, bool> offers_less_;
  // Of both threads.
  std::deque<Message> queue_;
  std::uint64_t dropped_ = 0;
  bool best_effort_offered_ = false, volatile_offered_ = false;
};

}  // namespace wayfare::ros::dds
