#include "ros/dds/domain.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string_view>

#include "ros/dds/cdr_type.hpp"
#include "ros/dds/loopback.hpp"
#include "ros/dds/names.hpp"

namespace wayfare::ros::dds {
namespace {

constexpr std::string_view kTopicPrefix = "rt";
constexpr std::string_view kHashBegin = "typehash=", kHashEnd = ";";

std::string environment(const char* name) {
  const char* value = std::getenv(name);  // NOLINT(concurrency-mt-unsafe): nothing here sets it
  return value == nullptr ? "" : value;
}

Error error_of(dds_return_t code, std::string what) {
  return {ErrorCode::io, std::string("DDS: ") + dds_strretcode(code), std::move(what)};
}

/// Nodes on this computer find one another by unicast to the ports of the first 60, without
/// multicast, of which the loopback interface is not capable.
constexpr const char* kThisComputer =
    "<CycloneDDS><Domain Id=\"any\"><General>"
    "<Interfaces><NetworkInterface address=\"127.0.0.1\"/></Interfaces>"
    "<AllowMulticast>false</AllowMulticast>"
    "<MaxMessageSize>65500B</MaxMessageSize><FragmentSize>60000B</FragmentSize></General>"
    "<Discovery><ParticipantIndex>auto</ParticipantIndex>"
    "<MaxAutoParticipantIndex>60</MaxAutoParticipantIndex>"
    "<Peers><Peer address=\"127.0.0.1\"/></Peers></Discovery>"
    "</Domain></CycloneDDS>";

struct DeleteQos {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using QosPtr = std::unique_ptr<dds_qos_t, DeleteQos>;

QosPtr dds_qos(const Qos& qos, const std::string& type_hash) {
  constexpr dds_duration_t kBlocking = DDS_SECS(1);  // of a full queue
  QosPtr q(dds_create_qos());
  const auto depth = static_cast<std::int32_t>(std::clamp<std::size_t>(qos.depth, 1, 1U << 30U));
  dds_qset_reliability(q.get(),
                       qos.reliability == Reliability::reliable ? DDS_RELIABILITY_RELIABLE
                                                                : DDS_RELIABILITY_BEST_EFFORT,
                       kBlocking);
  dds_qset_history(q.get(), DDS_HISTORY_KEEP_LAST, depth);
  if (qos.durability == Durability::transient_local) {
    dds_qset_durability(q.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
    dds_qset_durability_service(q.get(), 0, DDS_HISTORY_KEEP_LAST, depth, DDS_LENGTH_UNLIMITED,
                                DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  }
  if (!type_hash.empty()) {
    const std::string data = std::string(kHashBegin) + type_hash + std::string(kHashEnd);
    dds_qset_userdata(q.get(), data.data(), data.size());
  }
  return q;
}

std::string type_hash_of(const dds_qos_t* qos) {
  void* bytes = nullptr;
  std::size_t size = 0;
  if (!dds_qget_userdata(qos, &bytes, &size) || bytes == nullptr) return "";
  const std::string data(static_cast<const char*>(bytes), size);
  dds_free(bytes);
  const std::size_t begin = data.find(kHashBegin);
  if (begin == data.npos) return "";
  const std::size_t first = begin + kHashBegin.size();
  return data.substr(first, std::min(data.find(kHashEnd, first), data.size()) - first);
}

}  // namespace

Qos offered_by(const dds_builtintopic_endpoint_t& publisher) {
  const dds_qos_t* const qos = publisher.qos;
  Qos found;
  dds_reliability_kind_t reliability = DDS_RELIABILITY_RELIABLE;
  dds_durability_kind_t durability = DDS_DURABILITY_VOLATILE;
  dds_history_kind_t history = DDS_HISTORY_KEEP_LAST;
  dds_duration_t blocking = 0;
  std::int32_t depth = 0;
  if (dds_qget_reliability(qos, &reliability, &blocking) &&
      reliability == DDS_RELIABILITY_BEST_EFFORT)
    found.reliability = Reliability::best_effort;
  if (dds_qget_durability(qos, &durability) && durability != DDS_DURABILITY_VOLATILE)
    found.durability = Durability::transient_local;
  if (dds_qget_history(qos, &history, &depth) && depth > 0)
    found.depth = static_cast<std::size_t>(depth);
  return found;
}

Result<Reach> reach_of(const Ros2Options& options) {
  Reach reach;
  const std::string domain = environment("ROS_DOMAIN_ID");
  const char* end = domain.data() + domain.size();
  if (options.domain) {
    reach.domain = *options.domain;
  } else if (!domain.empty() && std::from_chars(domain.data(), end, reach.domain).ptr != end) {
    return Error{ErrorCode::invalid, "is no domain of ROS 2, 0 to 232", "ROS_DOMAIN_ID=" + domain};
  }
  if (reach.domain > 232)
    return Error{ErrorCode::invalid, "is no domain of ROS 2, 0 to 232",
                 std::to_string(reach.domain)};
  const std::string range = environment("ROS_AUTOMATIC_DISCOVERY_RANGE");
  reach.network = options.network.value_or(environment("ROS_LOCALHOST_ONLY") == "0" ||
                                           range == "SUBNET" || range == "SYSTEM_DEFAULT");
  return reach;
}

Result<Domain> Domain::join(const Reach& reach) {
  std::string configuration = reach.network ? "" : kThisComputer;
  const std::string own = environment("CYCLONEDDS_URI");
  if (!own.empty()) configuration += (configuration.empty() ? "" : ",") + own;
  // Of several nodes in a process the first one configures the domain.
  const dds_entity_t created = dds_create_domain(reach.domain, configuration.c_str());
  if (created < 0 && created != DDS_RETCODE_PRECONDITION_NOT_MET)
    return error_of(created, "domain " + std::to_string(reach.domain));
  Domain domain;
  domain.participant_ = Entity(dds_create_participant(reach.domain, nullptr, nullptr));
  if (domain.participant_.get() < 0)
    return error_of(domain.participant_.get(), "domain " + std::to_string(reach.domain));
  // An own configuration may have other ports.
  if (!reach.network && !bind_to_loopback(reach.domain) && own.empty())
    return Error{ErrorCode::io, "DDS: its sockets could not be bound to this computer",
                 "domain " + std::to_string(reach.domain)};
  domain.publications_ = Entity(dds_create_reader(
      domain.participant_.get(), DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr));
  return domain;
}

Domain::~Domain() {
  const dds_entity_t participant = participant_.get();
  if (participant <= 0) return;
  const dds_entity_t domain = dds_get_parent(participant);
  dds_domainid_t id = 0;
  dds_get_domainid(participant, &id);
  publications_ = Entity();
  participant_ = Entity();
  // The last one of the process.
  if (dds_lookup_participant(id, nullptr, 0) == 0) dds_delete(domain);
}

Result<Entity> Domain::topic(const TopicOf& topic) const {
  ddsi_sertype* type = cdr_type(dds_type(topic.type));
  if (type == nullptr) return Error{ErrorCode::io, "no memory", topic.name};
  const std::string name = std::string(kTopicPrefix) + topic.name;
  const dds_entity_t made =
      dds_create_topic_sertype(participant_.get(), name.c_str(), &type, nullptr, nullptr, nullptr);
  if (made < 0) return error_of(made, topic.name);
  return Entity(made);
}

Result<Entity> Domain::writer(const TopicOf& topic, const Qos& qos) const {
  const auto of = this->topic(topic);
  if (!of) return of.error();
  const dds_entity_t made = dds_create_writer(participant_.get(), of->get(),
                                              dds_qos(qos, topic.type_hash).get(), nullptr);
  if (made < 0) return error_of(made, topic.name);
  return Entity(made);
}

Result<Entity> Domain::reader(const TopicOf& topic, const Qos& qos,
                              const dds_listener_t* listener) const {
  const auto of = this->topic(topic);
  if (!of) return of.error();
  const dds_entity_t made = dds_create_reader(participant_.get(), of->get(),
                                              dds_qos(qos, topic.type_hash).get(), listener);
  if (made < 0) return error_of(made, topic.name);
  return Entity(made);
}

std::vector<PublishedTopic> Domain::published() const {
  constexpr std::uint32_t kAtOnce = 4096;
  std::vector<void*> samples(kAtOnce, nullptr);
  std::vector<dds_sample_info_t> infos(kAtOnce);
  const dds_return_t n =
      dds_read(publications_.get(), samples.data(), infos.data(), kAtOnce, kAtOnce);
  dds_guid_t own{};
  dds_get_guid(participant_.get(), &own);
  std::vector<PublishedTopic> found;
  for (dds_return_t i = 0; i < n; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const auto& endpoint = *static_cast<const dds_builtintopic_endpoint_t*>(samples[at]);
    if (!infos[at].valid_data || infos[at].instance_state != DDS_ALIVE_INSTANCE_STATE ||
        std::memcmp(endpoint.participant_key.v, own.v, sizeof own.v) == 0)
      continue;
    const std::string_view name = endpoint.topic_name;
    if (!name.starts_with(std::string(kTopicPrefix) + "/")) continue;
    found.push_back({std::string(name.substr(kTopicPrefix.size())), ros1_type(endpoint.type_name),
                     type_hash_of(endpoint.qos), offered_by(endpoint)});
  }
  if (n > 0) dds_return_loan(publications_.get(), samples.data(), n);
  return found;
}

}  // namespace wayfare::ros::dds
