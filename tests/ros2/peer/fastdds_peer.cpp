// A program on Fast DDS, for tests of ours on another implementation of DDS:
//
//   fastdds_peer publish TOPIC TYPE [--count N] [--size N] [--period-ms N] [--stay-s S]
//   fastdds_peer subscribe TOPIC TYPE N [--size N]
//   fastdds_peer play FILE [--speed X] [--stay-s S] [--raw]
//   fastdds_peer record TOPIC TYPE N FILE
//
// `publish` sends the samples 0, 1, … of Formula, `subscribe` compares N of them with it. `play`
// sends messages of a file with a message per record, `record` writes such a file; see records.hpp.
// With --raw the bytes are sent as they are, whatever they are, under the name of any type.
// TOPIC is DDS's name (rt/scan), TYPE that of ROS 2. Options of all: --best-effort,
// --transient-local, --depth N, --wait-for N (readers before the first message), --late-readers N
// (wait for after the last), --timeout-s S, --domain N (by default ROS_DOMAIN_ID),
// --every-interface (by default the loopback interface alone). The exit code is 0 where everything
// was as expected.

#include <chrono>
#include <cstdio>
#include <fstream>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>

#include "fast_messages.hpp"
#include "peer_options.hpp"
#include "raw_type.hpp"
#include "records.hpp"

namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using Clock = std::chrono::steady_clock;
using peer::FastMessage;
using peer::Options;

void sleep_s(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

/// Waits until it is true; false after the time.
template <class Condition>
bool within(double seconds, const Condition& condition) {
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  while (!condition()) {
    if (Clock::now() > end) return false;
    sleep_s(0.005);
  }
  return true;
}

/// A participant; on the loopback interface it also asks there for others without multicast.
class Domain {
 public:
  explicit Domain(const Options& o) : options_(o) {
    dds::DomainParticipantQos qos;
    qos.name("fastdds_peer");
    const auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    if (!o.every_interface) {
      udp->interfaceWhiteList = {"127.0.0.1"};
      udp->maxInitialPeersRange = 10;  // participants on this computer
      rtps::Locator_t here, group;
      rtps::IPLocator::setIPv4(here, 127, 0, 0, 1);
      rtps::IPLocator::setIPv4(group, 239, 255, 0, 1);
      group.port = static_cast<std::uint32_t>(7400 + 250 * o.domain);
      qos.wire_protocol().builtin.initialPeersList.push_back(here);
      qos.wire_protocol().builtin.initialPeersList.push_back(group);
    }
    qos.transport().use_builtin_transports = false;
    qos.transport().user_transports.push_back(udp);
    participant_ = dds::DomainParticipantFactory::get_instance()->create_participant(
        static_cast<std::uint32_t>(o.domain), qos);
    if (participant_ == nullptr) throw std::runtime_error("no participant");
  }
  ~Domain() {
    participant_->delete_contained_entities();
    dds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }
  Domain(const Domain&) = delete;
  Domain& operator=(const Domain&) = delete;

  dds::DataWriter* writer(const std::string& name, const std::string& type, bool transient_local) {
    if (publisher_ == nullptr)
      publisher_ = participant_->create_publisher(dds::PUBLISHER_QOS_DEFAULT);
    dds::DataWriterQos qos;
    set(qos, transient_local);
    // As ROS does: synchronous writers do not fragment.
    qos.publish_mode().kind = dds::ASYNCHRONOUS_PUBLISH_MODE;
    qos.reliable_writer_qos().times.heartbeatPeriod = eprosima::fastrtps::Duration_t(0.1);
    auto* writer = publisher_->create_datawriter(topic(name, type), qos);
    if (writer == nullptr) throw std::runtime_error("no writer of " + name);
    return writer;
  }
  dds::DataReader* reader(const std::string& name, const std::string& type) {
    auto* subscriber = participant_->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT);
    dds::DataReaderQos qos;
    set(qos, options_.transient_local);
    auto* reader = subscriber->create_datareader(topic(name, type), qos);
    if (reader == nullptr) throw std::runtime_error("no reader of " + name);
    return reader;
  }

 private:
  dds::Topic* topic(const std::string& name, const std::string& type) {
    dds::TypeSupport support = options_.raw
                                   ? dds::TypeSupport(new peer::RawType(peer::dds_name(type)))
                                   : FastMessage(type).type();
    support.register_type(participant_);
    return participant_->create_topic(name, support.get_type_name(), dds::TOPIC_QOS_DEFAULT);
  }
  template <class Qos>
  void set(Qos& qos, bool transient_local) const {
    qos.reliability().kind =
        options_.best_effort ? dds::BEST_EFFORT_RELIABILITY_QOS : dds::RELIABLE_RELIABILITY_QOS;
    qos.durability().kind =
        transient_local ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
    qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
    qos.history().depth = options_.depth;
    qos.resource_limits().max_samples = 0;
    qos.resource_limits().max_samples_per_instance = 0;
    qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  }

  const Options& options_;
  dds::DomainParticipant* participant_;
  dds::Publisher* publisher_ = nullptr;
};

bool has_readers(const Options& o, dds::DataWriter* writer, int wanted) {
  return within(o.timeout_s, [&] {
    dds::PublicationMatchedStatus status;
    writer->get_publication_matched_status(status);
    return status.current_count >= wanted;
  });
}

/// Stays until late readers are there, reliable ones have everything, and as long as asked for.
bool finish(const Options& o, dds::DataWriter* writer) {
  if (!has_readers(o, writer, o.late_readers)) return false;
  const bool done = o.best_effort ||
                    writer->wait_for_acknowledgments(eprosima::fastrtps::Duration_t(o.timeout_s)) ==
                        eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK;
  sleep_s(o.stay_s);
  return done;
}

int publish(const Options& o) {
  const std::string topic = o.words.at(1), type = o.words.at(2);
  Domain domain(o);
  dds::DataWriter* writer = domain.writer(topic, type, o.transient_local);
  if (!has_readers(o, writer, o.wait_for)) {
    std::fprintf(stderr, "no reader of %s\n", topic.c_str());
    return 1;
  }
  for (std::uint32_t sample = 0; sample < o.count; ++sample) {
    FastMessage message(type);
    message.fill(sample, o.size);
    if (!writer->write(message.data())) {
      std::fprintf(stderr, "sample %u could not be sent\n", sample);
      return 1;
    }
    sleep_s(o.period_s);
  }
  std::printf("sent %u\n", o.count);
  std::fflush(stdout);
  return finish(o, writer) ? 0 : 1;
}

/// Calls `take(message)` for each of the samples until it returns false; false after the time.
template <class Take>
bool receive(const Options& o, dds::DataReader* reader, const std::string& type, const Take& take) {
  FastMessage message(type);
  const auto end = Clock::now() + std::chrono::duration<double>(o.timeout_s);
  while (Clock::now() < end) {
    dds::SampleInfo info;
    if (reader->take_next_sample(message.data(), &info) !=
        eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK) {
      reader->wait_for_unread_message(eprosima::fastrtps::Duration_t(0.05));
    } else if (info.valid_data && !take(message)) {
      return true;
    }
  }
  return false;
}

int subscribe(const Options& o) {
  constexpr std::uint32_t kMostLost = 10'000;
  const std::string topic = o.words.at(1), type = o.words.at(2);
  const auto wanted = static_cast<std::uint32_t>(std::stoul(o.words.at(3)));
  Domain domain(o);
  dds::DataReader* reader = domain.reader(topic, type);
  std::printf("ready\n");
  std::fflush(stdout);
  std::uint32_t received = 0, next = 0, lost = 0;
  std::string wrong;
  const bool all = receive(o, reader, type, [&](FastMessage& message) {
    std::uint32_t sample = next;
    while (sample < next + kMostLost && !message.difference(sample, o.size).empty()) ++sample;
    if (sample == next + kMostLost) {
      wrong = "sample " + std::to_string(next) + ": " + message.difference(next, o.size);
      return false;
    }
    // A latecomer did not lose what was sent before.
    if (received > 0) lost += sample - next;
    next = sample + 1;
    return ++received < wanted;
  });
  std::printf("received %u of %u, lost %u, last %d %s\n", received, wanted, lost,
              static_cast<int>(next) - 1, wrong.c_str());
  return all && wrong.empty() && (o.best_effort || lost == 0) ? 0 : 1;
}

bool is_latched(const std::string& topic) {
  const auto ends_with = [&](const std::string& end) {
    return topic.size() >= end.size() &&
           topic.compare(topic.size() - end.size(), end.size(), end) == 0;
  };
  return ends_with("/tf_static") || ends_with("/map");
}

bool send(const Options& o, peer::Record record, dds::DataWriter* writer) {
  if (o.raw) return writer->write(&record.bytes);
  FastMessage message(record.type);
  return message.from_bytes(record.bytes) && writer->write(message.data());
}

int play(const Options& o) {
  const std::vector<peer::Record> records = peer::read_records(o.words.at(1));
  Domain domain(o);
  std::map<std::string, dds::DataWriter*> writers;
  for (const peer::Record& r : records)
    if (writers.find(r.topic) == writers.end())
      writers[r.topic] = domain.writer(r.topic, r.type, o.transient_local || is_latched(r.topic));
  for (const auto& [topic, writer] : writers)
    if (!has_readers(o, writer, o.wait_for)) {
      std::fprintf(stderr, "no reader of %s\n", topic.c_str());
      return 1;
    }
  const auto begin = Clock::now();
  for (const peer::Record& r : records) {
    const double at_s = 1e-9 * static_cast<double>(r.time_ns - records.front().time_ns) / o.speed;
    std::this_thread::sleep_until(
        begin + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(at_s)));
    if (!send(o, r, writers[r.topic])) {
      std::fprintf(stderr, "a message on %s could not be sent\n", r.topic.c_str());
      return 1;
    }
  }
  std::printf("sent %zu\n", records.size());
  std::fflush(stdout);
  bool done = true;
  for (const auto& writer : writers) done = finish(o, writer.second) && done;
  return done ? 0 : 1;
}

int record(const Options& o) {
  const std::string topic = o.words.at(1), type = o.words.at(2);
  const std::size_t wanted = std::stoul(o.words.at(3));
  Domain domain(o);
  dds::DataReader* reader = domain.reader(topic, type);
  std::ofstream file(o.words.at(4), std::ios::binary);
  std::printf("ready\n");
  std::fflush(stdout);
  std::size_t received = 0;
  const auto begin = Clock::now();
  const bool all = receive(o, reader, type, [&](FastMessage& message) {
    const auto at = std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now() - begin);
    peer::write_record(file, {at.count(), topic, type, message.to_bytes()});
    file.flush();
    return ++received < wanted;
  });
  std::printf("received %zu of %zu\n", received, wanted);
  return all && file ? 0 : 1;
}

int run(const Options& o) {
  const std::string mode = o.words.empty() ? "" : o.words[0];
  if (mode == "publish") return publish(o);
  if (mode == "subscribe") return subscribe(o);
  if (mode == "play") return play(o);
  if (mode == "record") return record(o);
  throw std::invalid_argument("modes are publish, subscribe, play and record");
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(peer::options_of(argc, argv));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "fastdds_peer: %s\n", error.what());
    return 2;
  }
}
