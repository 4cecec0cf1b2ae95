#include <wayfare/logger/clock_readings.hpp>

#include <algorithm>
#include <charconv>
#include <map>
#include <utility>

#include <nlohmann/json.hpp>

#include <wayfare/io/mcap.hpp>

#include "logger/clock_watch.hpp"
#include "logger/time_parts.hpp"

namespace wayfare::logger {
namespace {

std::string time_json(LogTime time) {
  const auto [sec, nsec] = seconds_and_rest(time);
  return "{\"sec\":" + std::to_string(sec) + ",\"nsec\":" + std::to_string(nsec) + '}';
}

std::optional<LogTime> time_of(const nlohmann::json& message, const char* key) {
  const auto it = message.find(key);
  if (it == message.end() || !it->is_object()) return std::nullopt;
  const auto sec = it->find("sec"), nsec = it->find("nsec");
  if (sec == it->end() || nsec == it->end() || !sec->is_number_integer() ||
      !nsec->is_number_integer())
    return std::nullopt;
  const double s = sec->get<double>(), ns = nsec->get<double>();
  if (!(s > -9e9 && s < 9e9 && ns >= 0.0 && ns < 1e9)) return std::nullopt;
  return LogTime::from_nanoseconds(sec->get<std::int64_t>() * 1'000'000'000 +
                                   nsec->get<std::int64_t>());
}

/// `text` after `expected`, if it begins so.
bool skip(std::string_view& text, std::string_view expected) {
  if (!text.starts_with(expected)) return false;
  text.remove_prefix(expected.size());
  return true;
}

std::optional<std::int64_t> skip_integer(std::string_view& text) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc()) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return value;
}

/// The text with every "timestamp" moved; nothing where one is written otherwise than by a logger.
std::optional<std::string> moved(std::string_view text, Duration offset) {
  // No string in a JSON text contains quotation marks that are not escaped.
  constexpr std::string_view kKey = "\"timestamp\":";
  std::string out;
  for (std::size_t at = 0; (at = text.find(kKey)) != text.npos;) {
    out += text.substr(0, at + kKey.size());
    text.remove_prefix(at + kKey.size());
    if (!skip(text, "{\"sec\":")) return std::nullopt;
    const auto sec = skip_integer(text);
    if (!sec || *sec > 9'000'000'000 || *sec < -9'000'000'000 || !skip(text, ",\"nsec\":"))
      return std::nullopt;
    const auto nsec = skip_integer(text);
    if (!nsec || *nsec < 0 || *nsec >= 1'000'000'000 || !skip(text, "}")) return std::nullopt;
    out += time_json(LogTime::from_nanoseconds(*sec * 1'000'000'000 + *nsec) + offset);
  }
  out += text;
  return out;
}

/// Copies messages of one file to another, with the channels and schemas they need.
class Mover {
 public:
  Mover(const io::McapContents& contents, io::McapWriter& writer, Duration offset)
      : contents_(contents), writer_(writer), offset_(offset) {}

  Result<void> copy(const io::McapMessage& message) {
    const auto channel = channel_of(*message.channel);
    if (!channel) return channel.error();
    std::string_view data = message.data;
    std::optional<std::string> text;
    if (message.channel->topic == kClockTopic) {
      if (auto reading = parse_clock_reading(data)) {
        reading->stamp += offset_;
        text = clock_reading_json(*reading);
      }
    } else if (message.channel->message_encoding == "json") {
      text = moved(data, offset_);
      if (!text)
        problems_.add({ErrorCode::parse, "a timestamp that no logger writes is kept",
                       message.channel->topic, message.sequence + 1U, 0});
    }
    if (text) data = *text;
    return writer_.write(*channel, message.log_time + offset_, message.publish_time + offset_,
                         data);
  }
  [[nodiscard]] const io::Problems& problems() const { return problems_; }

 private:
  Result<std::uint16_t> channel_of(const io::McapChannel& channel) {
    const auto known = channels_.find(channel.id);
    if (known != channels_.end()) return known->second;
    std::uint16_t schema = 0;
    for (const io::McapSchema& s : contents_.schemas) {
      if (s.id != channel.schema) continue;
      auto& id = schemas_[s.id];
      if (id == 0) {
        const auto added = writer_.add_schema(s.name, s.encoding, s.data);
        if (!added) return added.error();
        id = *added;
      }
      schema = id;
    }
    const auto added =
        writer_.add_channel(channel.topic, channel.message_encoding, schema, channel.metadata);
    if (added) channels_[channel.id] = *added;
    return added;
  }

  const io::McapContents& contents_;
  io::McapWriter& writer_;
  Duration offset_;
  std::map<std::uint16_t, std::uint16_t> channels_, schemas_;
  io::Problems problems_;
};

}  // namespace

MessageSchema clock_reading_schema() {
  constexpr std::string_view kName = "wayfare.ClockReading";
  constexpr std::string_view kSchema =
      R"({"title":"wayfare.ClockReading","type":"object","properties":{)"
      R"("timestamp":{"type":"object","title":"time","properties":)"
      R"({"sec":{"type":"integer"},"nsec":{"type":"integer"}}},)"
      R"("wall":{"type":"object","title":"time","properties":)"
      R"({"sec":{"type":"integer"},"nsec":{"type":"integer"}}},)"
      R"("offset_s":{"type":"number"}}})";
  return {kName, kSchema};
}

std::string clock_reading_json(const ClockReading& reading) {
  return "{\"timestamp\":" + time_json(reading.stamp) + ",\"wall\":" + time_json(reading.wall) +
         ",\"offset_s\":" + io::format_nanoseconds(reading.offset().count()) + '}';
}

Result<ClockReading> parse_clock_reading(std::string_view json) {
  const auto message = nlohmann::json::parse(json, nullptr, false);
  const auto stamp = time_of(message, "timestamp"), wall = time_of(message, "wall");
  if (!stamp || !wall) return Error{ErrorCode::parse, "is no wayfare.ClockReading"};
  return ClockReading{*stamp, *wall};
}

Result<RecordedClock> read_clock(const std::string& path) {
  const auto reader = io::McapReader::open(path);
  if (!reader) return reader.error();
  RecordedClock clock{path, {}, {}};
  const auto& metadata = reader->contents().metadata;
  if (const auto about = metadata.find("logger"); about != metadata.end())
    if (const auto run = about->second.find("run"); run != about->second.end())
      clock.run = run->second;
  reader->read({io::McapOrder::file, {std::string(kClockTopic)}}, [&](const io::McapMessage& m) {
    if (const auto reading = parse_clock_reading(m.data)) clock.readings.push_back(*reading);
    return true;
  });
  std::stable_sort(clock.readings.begin(), clock.readings.end(),
                   [](const ClockReading& a, const ClockReading& b) { return a.stamp < b.stamp; });
  if (clock.readings.empty())
    return Error{ErrorCode::not_found, "has no reading of the computer's clock", path};
  return clock;
}

Result<io::Problems> move_stamps(const std::string& from, const std::string& to, Duration offset) {
  const auto reader = io::McapReader::open(from);
  if (!reader) return reader.error();
  const io::McapContents& contents = reader->contents();
  auto writer = io::McapWriter::create(to, {.profile = contents.profile});
  if (!writer) return writer.error();
  auto metadata = contents.metadata;
  const std::string key = "stamps_moved_by_s";
  auto& before = metadata["logger"][key];
  const std::int64_t moved_ns = before.empty() ? 0 : io::parse_nanoseconds(before).value_or(0);
  before = io::format_nanoseconds(moved_ns + offset.count());
  for (const auto& [name, pairs] : metadata)
    if (auto added = writer->add_metadata(name, pairs); !added) return added.error();
  Mover mover(contents, *writer, offset);
  Result<void> done;
  io::Problems problems = reader->read({}, [&](const io::McapMessage& message) {
    done = mover.copy(message);
    return done.has_value();
  });
  if (!done) return done.error();
  if (auto closed = writer->close(); !closed) return closed.error();
  for (const Error& error : contents.problems.first()) problems.add(error);
  for (const Error& error : mover.problems().first()) problems.add(error);
  return problems;
}

}  // namespace wayfare::logger
