#include "recording_view.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <system_error>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include <wayfare/io/mcap.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/logger/messages.hpp>
#include <wayfare/pedestrian/pedestrian.hpp>

namespace wayfare::examples {
namespace {

using nlohmann::json;

/// Six columns over time for a plot. Minima and maxima of groups of samples, so that no peak is
/// lost.
class MinMaxRows {
 public:
  explicit MinMaxRows(std::uint64_t group) : group_(group) {}

  void add(double t, const std::array<double, 6>& values) {
    if (count_ == 0) begin_ = t, low_ = high_ = values;
    for (std::size_t k = 0; k < values.size(); ++k) {
      low_[k] = std::fmin(low_[k], values[k]);
      high_[k] = std::fmax(high_[k], values[k]);
    }
    end_ = t;
    if (++count_ == group_) close();
  }
  [[nodiscard]] json finished() {
    close();
    return {{"t", t_}, {"columns", columns_}, {"stride", group_}};
  }

 private:
  void close() {
    if (count_ > 0) put(begin_, low_);
    if (count_ > 1) put(end_, high_);
    count_ = 0;
  }
  void put(double t, const std::array<double, 6>& values) {
    t_.push_back(t);
    for (std::size_t k = 0; k < values.size(); ++k) columns_[k].push_back(values[k]);
  }

  std::uint64_t group_, count_ = 0;
  double begin_ = 0.0, end_ = 0.0;
  std::array<double, 6> low_{}, high_{};
  std::vector<double> t_;
  std::array<std::vector<double>, 6> columns_;
};

std::string schema_of(const io::McapContents& contents, const io::McapChannel& channel) {
  for (const io::McapSchema& s : contents.schemas)
    if (s.id == channel.schema) return s.name;
  return {};
}

/// Null if there is none.
const io::McapChannel* find_topic(const io::McapContents& contents, const std::string& topic) {
  for (const io::McapChannel& c : contents.channels)
    if (c.topic == topic) return &c;
  return nullptr;
}

Error no_topic(const std::string& topic) {
  return Error{ErrorCode::not_found, "there is no topic '" + topic + "'"};
}

/// A number that is not finite is an empty field.
template <class Number>
void put(std::string& out, Number value) {
  if (!std::isfinite(value)) return;
  std::array<char, 32> text;
  out.append(text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr);
}

/// Format of the lines of a message, by its schema; without one: time, length, bytes.
struct CsvFormat {
  const char* head;
  std::function<void(std::string&, const std::string& t, std::string_view data)> lines;
};

/// Lines of the messages that `parse` accepts: their time, then the numbers `write` passes on.
template <class Parse, class Write>
CsvFormat measured(const char* head, Parse parse, Write write) {
  return {head, [parse, write](std::string& out, const std::string&, std::string_view data) {
            const auto measurement = parse(data);
            if (!measurement) return;
            const std::string t = io::format_nanoseconds(measurement->time.nanoseconds());
            write(*measurement, [&](auto... numbers) {
              out += t;
              ((out += ',', put(out, numbers)), ...);
              out += '\n';
            });
          }};
}

CsvFormat csv_format(const std::string& schema) {
  if (schema == logger::imu_schema().name)
    return measured("t_s,gx_radps,gy_radps,gz_radps,ax_mps2,ay_mps2,az_mps2,mx_uT,my_uT,mz_uT\n",
                    logger::parse_imu, [](const MargSample& s, const auto& line) {
                      const auto &w = s.angular_rate_radps, &f = s.specific_force_mps2;
                      const auto& m = s.magnetic_field_uT;
                      line(w.x(), w.y(), w.z(), f.x(), f.y(), f.z(), m.x(), m.y(), m.z());
                    });
  if (schema == logger::laser_scan_schema().name)
    return measured("t_s,bearing_rad,range_m\n", logger::parse_laser_scan,
                    [](const LaserScan& s, const auto& line) {
                      for (std::size_t i = 0; i < s.ranges_m.size(); ++i)
                        line(s.bearing(i).radians(), s.ranges_m[i]);
                    });
  if (schema == logger::point_cloud_schema().name)
    return measured("t_s,x_m,y_m,z_m,doppler_mps,snr_db\n", logger::parse_point_cloud,
                    [](const RadarScan& s, const auto& line) {
                      for (const RadarPoint& p : s.points)
                        line(p.x_m, p.y_m, p.z_m, p.doppler_m_s, p.snr_db);
                    });
  return {"t_s,bytes,hex\n", [](std::string& out, const std::string& t, std::string_view data) {
            constexpr std::string_view kDigits = "0123456789abcdef";
            out += t + ',' + std::to_string(data.size()) + ',';
            for (const char c : data) {
              const auto byte = static_cast<unsigned char>(c);
              out += {kDigits[byte >> 4], kDigits[byte & 15U]};
            }
            out += '\n';
          }};
}

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
  const io::McapContents& c = (*file)->contents();
  json out = {{"path", path_},
              {"bytes", c.bytes},
              {"messages", c.statistics.messages},
              {"chunks", c.statistics.chunks},
              {"indexed", c.indexed},
              {"start_s", c.statistics.first.seconds()},
              {"seconds", to_seconds(c.statistics.last - c.statistics.first)},
              {"topics", json::array()},
              {"problems", json::array()}};
  for (const io::McapChannel& channel : c.channels) {
    const auto count = c.statistics.messages_of.find(channel.id);
    const std::string schema = schema_of(c, channel);
    out["topics"].push_back(
        {{"topic", channel.topic},
         {"schema", schema.empty() ? channel.message_encoding : schema},
         {"messages", count == c.statistics.messages_of.end() ? 0 : count->second}});
  }
  for (const Error& problem : c.problems.first())
    if (out["problems"].size() < 20) out["problems"].push_back(problem.to_string());
  return out.dump(-1, ' ', true, json::error_handler_t::replace);
}

Result<std::string> RecordingView::inertial(const std::string& topic, std::size_t most) const {
  const auto file = reader();
  if (!file) return file.error();
  const io::McapContents& c = (*file)->contents();
  const io::McapChannel* channel = find_topic(c, topic);
  if (channel == nullptr || schema_of(c, *channel) != logger::imu_schema().name)
    return no_topic(topic);
  const auto count = c.statistics.messages_of.find(channel->id);
  const std::uint64_t n = count == c.statistics.messages_of.end() ? 0 : count->second;
  MinMaxRows rows(n <= most ? 1 : 1 + 2 * (n - 1) / std::max<std::size_t>(most, 2));
  (*file)->read({io::McapOrder::file, {topic}}, [&](const io::McapMessage& m) {
    if (const auto sample = logger::parse_imu(m.data)) {
      const Eigen::Vector3d &f = sample->specific_force_mps2, &w = sample->angular_rate_radps;
      rows.add(to_seconds(sample->time - c.statistics.first),
               {f.x(), f.y(), f.z(), w.x(), w.y(), w.z()});
    }
    return true;
  });
  return rows.finished().dump();
}

Result<std::string> RecordingView::message(const std::string& topic, double t_s) const {
  const auto file = reader();
  if (!file) return file.error();
  const io::McapContents& c = (*file)->contents();
  const io::McapChannel* channel = find_topic(c, topic);
  if (channel == nullptr || channel->message_encoding != "json") return no_topic(topic);
  const LogTime until = c.statistics.first + from_seconds(t_s);
  // The last one before `until`, searched in growing intervals.
  for (double back_s = 1.0; back_s < 1e6; back_s *= 16.0) {
    std::string found;
    (*file)->read({io::McapOrder::log_time, {topic}, until - from_seconds(back_s), until},
                  [&](const io::McapMessage& m) {
                    found = m.data;
                    return true;
                  });
    if (!found.empty()) return found;
    if (until - from_seconds(back_s) < c.statistics.first) break;
  }
  return std::string("null");
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
  return json({{"columns", columns}}).dump();
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

Result<void> RecordingView::csv(const std::string& topic, const PieceSink& sink) const {
  const auto file = reader();
  if (!file) return file.error();
  const io::McapContents& c = (*file)->contents();
  const io::McapChannel* channel = find_topic(c, topic);
  if (channel == nullptr) return no_topic(topic);
  const CsvFormat format = csv_format(schema_of(c, *channel));
  std::string lines = format.head;
  bool taken = true;
  (*file)->read({io::McapOrder::file, {topic}}, [&](const io::McapMessage& m) {
    format.lines(lines, io::format_nanoseconds(m.log_time.nanoseconds()), m.data);
    if (lines.size() < 65536) return true;
    taken = sink(lines);
    lines.clear();
    return taken;
  });
  if (!taken || !sink(lines)) return Error{ErrorCode::cancelled, "the client has disconnected"};
  return {};
}

Result<void> RecordingView::mcap(const std::set<std::string>& topics, const PieceSink& sink) const {
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
      if (schemas.count(s.id) == 0) {
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
  (*file)->read({io::McapOrder::file, topics}, [&](const io::McapMessage& m) {
    const auto channel = channel_of(*m.channel);
    done = channel ? writer->write(*channel, m.log_time, m.publish_time, m.data)
                   : Result<void>(channel.error());
    return done.has_value();
  });
  for (const auto& [name, pairs] : c.metadata)
    if (done) done = writer->add_metadata(name, pairs);
  return done ? writer->close() : done;
}

}  // namespace wayfare::examples
