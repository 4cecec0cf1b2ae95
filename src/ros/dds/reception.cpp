#include "ros/dds/reception.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

namespace wayfare::ros::dds {
namespace {

std::int64_t system_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

struct DeleteListener {
  void operator()(dds_listener_t* listener) const { dds_delete_listener(listener); }
};

}  // namespace

Result<void> Subscription::open() {
  const std::unique_ptr<dds_listener_t, DeleteListener> listener(dds_create_listener(this));
  dds_lset_data_available(listener.get(), [](dds_entity_t reader, void* subscription) {
    static_cast<Subscription*>(subscription)->take(reader);
  });
  dds_lset_requested_incompatible_qos(
      listener.get(),
      [](dds_entity_t, const dds_requested_incompatible_qos_status_t status, void* subscription) {
        static_cast<Subscription*>(subscription)->refuse(status.last_policy_id);
      });
  auto reader = in_.domain_.reader(topic_, qos_, listener.get());
  if (!reader) return reader.error();
  reader_ = *std::move(reader);
  return {};
}

void Subscription::take(dds_entity_t reader) {
  const std::scoped_lock lock(in_.mutex_);
  constexpr std::uint32_t kAtOnce = 64;
  std::array<ddsi_serdata*, kAtOnce> data{};
  std::array<dds_sample_info_t, kAtOnce> infos{};
  for (dds_return_t n = kAtOnce; n == kAtOnce;) {
    n = dds_takecdr(reader, data.data(), kAtOnce, infos.data(), DDS_ANY_STATE);
    for (dds_return_t i = 0; i < n; ++i) {
      SerialisedPtr bytes(data[static_cast<std::size_t>(i)]);
      if (!infos[static_cast<std::size_t>(i)].valid_data) continue;
      queue_.push_back({++in_.arrivals_, system_ns(), std::move(bytes)});
    }
    while (queue_.size() > qos_.depth) queue_.pop_front(), ++dropped_;
  }
  in_.waiting_ = true;
  in_.arrived_.notify_one();
}

void Subscription::refuse(std::uint32_t policy) {
  const std::scoped_lock lock(in_.mutex_);
  if (policy == DDS_RELIABILITY_QOS_POLICY_ID) best_effort_offered_ = true;
  if (policy == DDS_DURABILITY_QOS_POLICY_ID) volatile_offered_ = true;
  in_.waiting_ = true;
  in_.arrived_.notify_one();
}

std::string Subscription::weaken() {
  std::string notice;
  {
    const std::scoped_lock lock(in_.mutex_);
    if (std::exchange(best_effort_offered_, false) && qos_.reliability == Reliability::reliable) {
      qos_.reliability = Reliability::best_effort;
      notice = "a publisher of '" + topic_.name + "' offers best effort: lost messages stay lost";
    }
    if (std::exchange(volatile_offered_, false) && qos_.durability == Durability::transient_local) {
      qos_.durability = Durability::volatile_messages;
      notice = "a publisher of '" + topic_.name + "' keeps no messages: those sent before are lost";
    }
  }
  if (notice.empty()) return "";
  lost_before_ += lost_on_the_way();
  reader_ = Entity();  // without the lock: waits for callbacks under way
  if (const auto ok = open(); !ok) notice += "; " + ok.error().to_string();
  return notice;
}

std::uint64_t Subscription::lost_on_the_way() const {
  dds_sample_lost_status_t status{};
  if (reader_.get() > 0) dds_get_sample_lost_status(reader_.get(), &status);
  return status.total_count;
}

std::uint64_t Subscription::lost() const {
  const std::uint64_t others = lost_before_ + lost_on_the_way();
  const std::scoped_lock lock(in_.mutex_);
  return others + dropped_;
}

Reception::~Reception() {
  for (const auto& s : subscriptions_) s->reader_ = Entity();  // before what callbacks use
}

Result<const Subscription*> Reception::subscribe(const TopicOf& topic, const Qos& qos,
                                                 RawCallback callback) {
  std::unique_ptr<Subscription> made(new Subscription(*this, topic, qos, std::move(callback)));
  if (auto ok = made->open(); !ok) return ok.error();
  subscriptions_.push_back(std::move(made));
  return subscriptions_.back().get();
}

void Reception::wait(double seconds) {
  std::unique_lock lock(mutex_);
  arrived_.wait_for(lock, std::chrono::duration<double>(seconds), [&] { return waiting_; });
}

void Reception::deliver(const std::function<void(const std::string&)>& report) {
  struct Due {
    Subscription* to;
    Subscription::Message message;
  };
  std::vector<Due> due;
  {
    const std::scoped_lock lock(mutex_);
    waiting_ = false;
    for (const auto& s : subscriptions_) {
      for (auto& message : s->queue_) due.push_back({s.get(), std::move(message)});
      s->queue_.clear();
    }
  }
  std::sort(due.begin(), due.end(),
            [](const Due& a, const Due& b) { return a.message.number < b.message.number; });
  for (const Due& d : due) d.to->callback_(bytes_of(*d.message.bytes), d.message.received_ns);
  // By index: a callback may subscribe.
  for (std::size_t i = 0; i < subscriptions_.size(); ++i)
    if (const std::string notice = subscriptions_[i]->weaken(); !notice.empty()) report(notice);
}

}  // namespace wayfare::ros::dds
