#include "recording_view.hpp"

#include <array>
#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <system_error>
#include <vector>

#include <nlohmann/json.hpp>

#include <wayfare/io/mcap.hpp>
#include <wayfare/logger/messages.hpp>
#include <wayfare/pedestrian/pedestrian.hpp>

#include "message_text.hpp"
#include "recording_csv.hpp"
#include "recording_query.hpp"

namespace wayfare::examples {
namespace {

/// Forwards a writer's bytes.
class ForwardSink final : public io::ByteSink {
 public:
  explicit ForwardSink(const PieceSink& sink) : sink_(sink) {}
  Result<void> write(std::string_view bytes) override {
    if (!sink_(bytes)) return Error{ErrorCode::cancelled, "the client has disconnected"};
    return {};
  }
  Result<void> sync() override { return {}; }

 private:
  const PieceSink& sink_;
};

}  // namespace

Result<RecordingView::Reader> RecordingView::reader() const {
  using std::chrono::steady_clock;
  const std::lock_guard lock(mutex_);
  std::error_code code;
  const std::uint64_t size = std::filesystem::file_size(path_, code);
  const auto now = steady_clock::now();
  if (reader_ && (size == size_ || now < reopen_)) return reader_;
  auto opened = io::McapReader::open(path_);
  if (!opened) return opened.error();
  reader_ = std::make_shared<const io::McapReader>(std::move(*opened));
  size_ = size;
  // A growing file is reread completely, which must not slow down the recording.
  const auto took = steady_clock::now() - now;
  reopen_ = now + std::max<steady_clock::duration>(std::chrono::seconds(2), 20 * took);
  return reader_;
}

Result<std::string> RecordingView::contents() const {
  const auto file = reader();
  if (!file) return file.error();
  return contents_text(path_, (*file)->contents());
}

Result<std::string> RecordingView::message(const std::string& topic, double t_s) const {
  const auto file = reader();
  if (!file) return file.error();
  const io::McapContents& c = (*file)->contents();
  const io::McapChannel* channel = find_topic(c, topic);
  if (channel == nullptr || channel->message_encoding != "json") return no_topic(topic);
  std::string found;
  read_last(**file, topic, c.statistics.first + from_seconds(t_s),
            [&](const io::McapMessage& m) { found = m.data; });
  return found.empty() ? "null" : found;
}

Result<std::string> RecordingView::walk(const std::string& topic) const {
  const auto logged = logger::read_marg_recording(path_, topic);
  if (!logged) return logged.error();
  Pedestrian pedestrian{PedestrianParameters{}};
  std::array<std::vector<double>, 4> columns;
  for (const MargSample& sample : logged->samples)
    pedestrian.add(sample, [&](const PedestrianPose& p) {
      columns[0].push_back(to_seconds(p.time - logged->samples.front().time));
      columns[1].push_back(p.position_m.x());
      columns[2].push_back(p.position_m.y());
      columns[3].push_back(p.heading.degrees());
    });
  return nlohmann::json({{"columns", columns}}).dump();
}

Result<std::string> RecordingView::map_png(double most_s) const {
  const auto file = reader();
  if (!file) return file.error();
  const auto& c = (*file)->contents();
  for (const io::McapChannel& channel : c.channels)
    if (schema_of(c, channel) == logger::laser_scan_schema().name)
      return map_.png(**file, channel.topic, most_s);
  return Error{ErrorCode::not_found, "there are no laser scans"};
}

double RecordingView::map_cell_m() { return ScanMap::cell_m(); }

Result<void> RecordingView::csv(const std::string& topic, const Interval& interval,
                                const PieceSink& sink) const {
  const auto file = reader();
  if (!file) return file.error();
  const io::McapContents& c = (*file)->contents();
  const io::McapChannel* channel = find_topic(c, topic);
  if (channel == nullptr) return no_topic(topic);
  CsvFormat format = csv_format(c, *channel);
  std::string lines = format.head;
  bool taken = true;
  (*file)->read(query_of(c, {topic}, interval), [&](const io::McapMessage& m) {
    format.lines(lines, m);
    if (lines.size() < 65536) return true;
    taken = sink(lines);
    lines.clear();
    return taken;
  });
  if (!taken || !sink(lines)) return Error{ErrorCode::cancelled, "the client has disconnected"};
  return {};
}

Result<void> RecordingView::mcap(const std::set<std::string>& topics, const Interval& interval,
                                 const PieceSink& sink) const {
  const auto file = reader();
  if (!file) return file.error();
  const io::McapContents& c = (*file)->contents();
  auto writer = io::McapWriter::create(std::make_unique<ForwardSink>(sink));
  if (!writer) return writer.error();
  std::map<std::uint16_t, std::uint16_t> schemas, channels;
  const auto channel_of = [&](const io::McapChannel& from) -> Result<std::uint16_t> {
    if (const auto known = channels.find(from.id); known != channels.end()) return known->second;
    std::uint16_t schema = 0;
    for (const io::McapSchema& s : c.schemas) {
      if (s.id != from.schema) continue;
      if (!schemas.contains(s.id)) {
        const auto id = writer->add_schema(s.name, s.encoding, s.data);
        if (!id) return id.error();
        schemas[s.id] = *id;
      }
      schema = schemas[s.id];
    }
    auto id = writer->add_channel(from.topic, from.message_encoding, schema, from.metadata);
    if (id) channels[from.id] = *id;
    return id;
  };
  Result<void> done;
  const auto copy = [&](const io::McapMessage& m, LogTime logged) {
    const auto channel = channel_of(*m.channel);
    done = channel ? writer->write(*channel, logged, m.publish_time, m.data)
                   : Result<void>(channel.error());
    return done.has_value();
  };
  const io::McapQuery query = query_of(c, topics, interval);
  // Of the poses of sensors before the interval, those that hold at its beginning.
  if (interval.from_s > 0.0)
    for (const io::McapChannel& channel : c.channels)
      if (schema_of(c, channel).find("FrameTransform") != std::string::npos && done)
        read_last(**file, channel.topic, query.from - Duration(1),
                  [&](const io::McapMessage& m) { copy(m, query.from); });
  if (done) (*file)->read(query, [&](const io::McapMessage& m) { return copy(m, m.log_time); });
  for (const auto& [name, pairs] : c.metadata)
    if (done) done = writer->add_metadata(name, pairs);
  return done ? writer->close() : done;
}

}  // namespace wayfare::examples
