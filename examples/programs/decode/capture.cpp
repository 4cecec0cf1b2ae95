#include <algorithm>

#include <wayfare/decode/stream_decoder.hpp>
#include <wayfare/io/mcap.hpp>
#include <wayfare/io/text_file.hpp>

#include "tables.hpp"

namespace wayfare::examples {

namespace {

constexpr std::string_view kRaw = "application/octet-stream";

/// The channel of bytes to read.
Result<io::McapChannel> raw_channel(const io::McapContents& contents, const std::string& topic,
                                    const std::string& kind, const std::string& path) {
  std::vector<io::McapChannel> fit;
  std::string there;
  for (const io::McapChannel& channel : contents.channels) {
    if (channel.message_encoding != kRaw) continue;
    const auto of = channel.metadata.find("kind");
    const std::string channel_kind = of == channel.metadata.end() ? "raw" : of->second;
    there += (there.empty() ? "" : ", ") + channel.topic + " (" + channel_kind + ")";
    if (topic.empty() ? channel_kind == kind : channel.topic == topic) fit.push_back(channel);
  }
  if (fit.size() == 1) return fit.front();
  if (there.empty()) return Error{ErrorCode::not_found, "holds no bytes of devices", path};
  const std::string what = topic.empty()
                               ? (fit.empty() ? "no device of kind " : "several of kind ") + kind +
                                     "; name one by --topic"
                               : "no bytes on " + topic;
  return Error{ErrorCode::not_found, "holds " + what + ": " + there, path};
}

Result<Capture> from_recording(const std::string& path, const std::string& topic,
                               const std::string& kind, std::string& damage) {
  const auto reader = io::McapReader::open(path);
  if (!reader) return reader.error();
  const auto channel = raw_channel(reader->contents(), topic, kind, path);
  if (!channel) return channel.error();
  Capture capture;
  io::Problems problems = reader->contents().problems;
  for (const Error& error :
       reader
           ->read({io::McapOrder::file, {channel->topic}},
                  [&](const io::McapMessage& m) {
                    capture.bytes += m.data;
                    capture.arrivals.push_back({capture.bytes.size(), m.log_time});
                    return true;
                  })
           .first())
    problems.add(error);
  if (problems.count() != 0) damage = problems.first().front().to_string();
  return capture;
}

}  // namespace

LogTime Capture::arrival(std::uint64_t end, double baud) const {
  if (arrivals.empty()) return LogTime::from_seconds(10.0 * static_cast<double>(end) / baud);
  auto at = std::lower_bound(arrivals.begin(), arrivals.end(), end,
                             [](const Arrival& a, std::uint64_t e) { return a.end < e; });
  if (at == arrivals.end()) --at;
  // Bytes behind it in the same read came later on the line.
  return at->time - from_seconds(10.0 * static_cast<double>(at->end - end) / baud);
}

Result<Capture> read_capture(const std::string& path, const std::string& topic,
                             const std::string& kind, std::string& damage) {
  if (path.ends_with(".mcap")) return from_recording(path, topic, kind, damage);
  auto content = io::read_file(path);
  if (!content) return content.error();
  if (content->damage) damage = content->damage->to_string();
  return Capture{std::move(content->bytes), {}};
}

}  // namespace wayfare::examples
