#include <wayfare/io/bag.hpp>

#include <algorithm>
#include <utility>

#include "io/recording/bag_records.hpp"

namespace wayfare::io {

using bag::Op;

namespace {

/// The fields of a header, sorted by name as in ROS.
using Pairs = std::map<std::string_view, std::string>;

/// Seconds, then nanoseconds.
std::uint64_t wire_time(LogTime time) {
  const auto ns = static_cast<std::uint64_t>(time.nanoseconds());
  return (ns % 1'000'000'000) << 32U | ns / 1'000'000'000;
}

std::string header(const Pairs& pairs) {
  std::string out;
  for (const auto& [name, value] : pairs) put(out, std::string(name) + "=" + value);
  return out;
}

void put_record(std::string& out, Op op, Pairs pairs, std::string_view data) {
  pairs["op"] = packed(static_cast<std::uint8_t>(op));
  out += packed(header(pairs), data);
}

void put_connection(std::string& out, const BagConnection& c) {
  Pairs about{{"message_definition", c.definition},
              {"md5sum", c.md5},
              {"topic", c.topic},
              {"type", c.type}};
  if (c.latching) about.emplace("latching", "1");
  put_record(out, Op::connection, {{"conn", packed(c.id)}, {"topic", c.topic}}, header(about));
}

/// The bag's first record, of fixed length.
std::string head(std::uint64_t index, std::size_t connections, std::size_t chunks) {
  const std::string fields =
      header({{"chunk_count", packed(static_cast<std::uint32_t>(chunks))},
              {"conn_count", packed(static_cast<std::uint32_t>(connections))},
              {"index_pos", packed(index)},
              {"op", packed(static_cast<std::uint8_t>(Op::head))}});
  return packed(fields, std::string(bag::kHeadBytes - fields.size(), ' '));
}

}  // namespace

BagWriter::BagWriter(std::size_t chunk_bytes)
    : chunk_bytes_(chunk_bytes), out_(std::string(bag::kMagic) + head(0, 0, 0)) {}

std::uint32_t BagWriter::add_connection(BagConnection connection) {
  connection.id = static_cast<std::uint32_t>(connections_.size());
  connections_.push_back(std::move(connection));
  described_.push_back(false);
  return connections_.back().id;
}

Result<void> BagWriter::write(std::uint32_t connection, LogTime time, std::string_view data) {
  if (finished_) return Error{ErrorCode::invalid, "the bag is finished"};
  if (connection >= connections_.size())
    return Error{ErrorCode::invalid, "no connection " + std::to_string(connection)};
  const BagConnection& c = connections_[connection];
  if (time < LogTime() || time.nanoseconds() / 1'000'000'000 > 0xFFFFFFFF)
    return Error{ErrorCode::invalid, "a time before 1970 or after 2106", c.topic};
  if (!described_[connection]) {
    put_connection(chunk_, c);
    described_[connection] = true;
  }
  open_.first = open_.counts.empty() ? time : std::min(open_.first, time);
  open_.last = open_.counts.empty() ? time : std::max(open_.last, time);
  ++open_.counts[connection];
  entries_[connection].push_back({wire_time(time), static_cast<std::uint32_t>(chunk_.size())});
  put_record(chunk_, Op::message, {{"conn", packed(connection)}, {"time", packed(wire_time(time))}},
             data);
  if (chunk_.size() >= chunk_bytes_) close_chunk();
  return {};
}

void BagWriter::close_chunk() {
  if (chunk_.empty()) return;
  open_.at = out_.size();
  put_record(out_, Op::chunk,
             {{"compression", "none"}, {"size", packed(static_cast<std::uint32_t>(chunk_.size()))}},
             chunk_);
  for (const auto& [connection, list] : entries_) {
    std::string data;
    for (const Entry& e : list) data += packed(e.time, e.offset);
    put_record(out_, Op::index,
               {{"conn", packed(connection)},
                {"count", packed(static_cast<std::uint32_t>(list.size()))},
                {"ver", packed(bag::kIndexVersion)}},
               data);
  }
  chunks_.push_back(std::exchange(open_, {}));
  chunk_.clear();
  entries_.clear();
}

std::string BagWriter::finish() {
  if (std::exchange(finished_, true)) return {};
  close_chunk();
  const std::uint64_t index = out_.size();
  for (const BagConnection& c : connections_) put_connection(out_, c);
  for (const Chunk& chunk : chunks_) {
    std::string counts;
    for (const auto& [connection, count] : chunk.counts) counts += packed(connection, count);
    put_record(out_, Op::chunk_info,
               {{"chunk_pos", packed(chunk.at)},
                {"count", packed(static_cast<std::uint32_t>(chunk.counts.size()))},
                {"end_time", packed(wire_time(chunk.last))},
                {"start_time", packed(wire_time(chunk.first))},
                {"ver", packed(bag::kIndexVersion)}},
               counts);
  }
  const std::string first = head(index, connections_.size(), chunks_.size());
  std::copy(first.begin(), first.end(), out_.begin() + bag::kMagic.size());
  return std::exchange(out_, {});
}

}  // namespace wayfare::io
