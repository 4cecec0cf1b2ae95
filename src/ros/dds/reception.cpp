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

std::uint64_t lost_by(const Entity& reader) {
  dds_sample_lost_status_t status{};
  if (reader.get() > 0) dds_get_sample_lost_status(reader.get(), &status);
  return status.total_count;
}

}  // namespace

Result<Entity> Subscription::open(const Qos& qos, dds_on_data_available_fn on_data) {
  const std::unique_ptr<dds_listener_t, DeleteListener> listener(dds_create_listener(this));
  dds_lset_data_available(listener.get(), on_data);
  dds_lset_requested_incompatible_qos(
      listener.get(),
      [](dds_entity_t, const dds_requested_incompatible_qos_status_t status, void* subscription) {
        static_cast<Subscription*>(subscription)->refuse(status.last_policy_id);
      });
  return in_.domain_.reader(topic_, qos, listener.get());
}

bool Subscription::offers_less(dds_entity_t reader, dds_instance_handle_t publication) {
  const auto known = offers_less_.find(publication);
  if (known != offers_less_.end()) return known->second;
  bool less = true;
  if (auto* endpoint = dds_get_matched_publication_data(reader, publication)) {
    const Qos offered = offered_by(*endpoint);
    less = (qos_.reliability == Reliability::reliable &&
            offered.reliability == Reliability::best_effort) ||
           (qos_.durability == Durability::transient_local &&
            offered.durability == Durability::volatile_messages);
    dds_builtintopic_free_endpoint(endpoint);
  }
  return offers_less_[publication] = less;
}

void Subscription::take(dds_entity_t reader, bool is_second) {
  constexpr std::uint32_t kAtOnce = 64;
  std::array<ddsi_serdata*, kAtOnce> data{};
  std::array<dds_sample_info_t, kAtOnce> infos{};
  for (dds_return_t n = kAtOnce; n == kAtOnce;) {
    n = dds_takecdr(reader, data.data(), kAtOnce, infos.data(), DDS_ANY_STATE);
    for (dds_return_t i = 0; i < n; ++i) {
      SerialisedPtr bytes(data[static_cast<std::size_t>(i)]);
      const dds_sample_info_t& info = infos[static_cast<std::size_t>(i)];
      if (!info.valid_data || (is_second && !offers_less(reader, info.publication_handle)))
        continue;
      const std::scoped_lock lock(in_.mutex_);
      queue_.push_back({++in_.arrivals_, system_ns(), std::move(bytes)});
      if (queue_.size() > qos_.depth) queue_.pop_front(), ++dropped_;
    }
  }
  const std::scoped_lock lock(in_.mutex_);
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

std::string Subscription::ask_for_less() {
  std::string notice;
  {
    const std::scoped_lock lock(in_.mutex_);
    if (std::exchange(best_effort_offered_, false) && less_.reliability == Reliability::reliable) {
      less_.reliability = Reliability::best_effort;
      notice = "a publisher of '" + topic_.name + "' offers best effort: what it loses stays lost";
    }
    if (std::exchange(volatile_offered_, false) &&
        less_.durability == Durability::transient_local) {
      less_.durability = Durability::volatile_messages;
      notice = "a publisher of '" + topic_.name + "' keeps no messages for late subscribers";
    }
  }
  if (notice.empty()) return "";
  lost_before_ += lost_by(second_);
  second_ = Entity();  // without the lock: waits for callbacks under way
  auto opened = open(less_, [](dds_entity_t reader, void* subscription) {
    static_cast<Subscription*>(subscription)->take(reader, true);
  });
  if (!opened) return notice + "; " + opened.error().to_string();
  second_ = *std::move(opened);
  return notice;
}

std::uint64_t Subscription::lost() const {
  const std::uint64_t others = lost_before_ + lost_by(reader_) + lost_by(second_);
  const std::scoped_lock lock(in_.mutex_);
  return others + dropped_;
}

Reception::~Reception() {
  // Before what callbacks use.
  for (const auto& s : subscriptions_) s->reader_ = Entity(), s->second_ = Entity();
}

Result<const Subscription*> Reception::subscribe(const TopicOf& topic, const Qos& qos,
                                                 RawCallback callback) {
  std::unique_ptr<Subscription> made(new Subscription(*this, topic, qos, std::move(callback)));
  auto opened = made->open(qos, [](dds_entity_t reader, void* subscription) {
    static_cast<Subscription*>(subscription)->take(reader, false);
  });
  if (!opened) return opened.error();
  made->reader_ = *std::move(opened);
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
  // By index: a callback may subscribe.  NOLINTNEXTLINE(modernize-loop-convert)
  for (std::size_t i = 0; i < subscriptions_.size(); ++i)
    if (const std::string notice = subscriptions_[i]->ask_for_less(); !notice.empty())
      report(notice);
}

}  // namespace wayfare::ros::dds
