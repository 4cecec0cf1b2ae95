#include "recording_view.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <system_error>
#include <vector>

#include <nlohmann/json.hpp>

#include <wayfare/estimate/pedestrian.hpp>
#include <wayfare/io/mcap_writer.hpp>
#include <wayfare/io/time_text.hpp>
#include <wayfare/logger/messages.hpp>
#include <wayfare/logger/read_recording.hpp>
#include <wayfare/system/graph_slam.hpp>

#include "slam_outputs.hpp"

namespace wayfare::examples {
namespace {

using nlohmann::json;

std::string schema_of(const io::McapContents& contents, const io::McapChannel& channel) {
  for (const io::McapSchema& s : contents.schemas)
    if (s.id == channel.schema) return s.name;
  return {};
}

const io::McapChannel* find_topic(const io::McapContents& contents, const std::string& topic) {
  for (const io::McapChannel& c : contents.channels)
    if (c.topic == topic) return &c;
  return nullptr;
}

Error no_topic(const std::string& topic) {
  return Error{ErrorCode::not_found, "there is no topic '" + topic + "'"};
}

template <class Number>
void put(std::string& out, Number value) {
  if constexpr (std::is_floating_point_v<Number>) {
    if (!std::isfinite(value)) return;  // an empty field
  }
  std::array<char, 32> text;
  out.append(text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr);
}

/// How a message becomes lines, by its schema; without one: time and length.
struct CsvFormat {
  const char* head;
  std::function<void(std::string&, const std::string& t, std::string_view data)> lines;
};

void put_vector(std::string& line, const Eigen::Vector3d& v) {
  for (const double x : {v.x(), v.y(), v.z()}) line += ',', put(line, x);
}

CsvFormat csv_format(const std::string& schema) {
  if (schema == logger::imu_schema().name)
    return {"t_s,gx_radps,gy_radps,gz_radps,ax_mps2,ay_mps2,az_mps2,mx_uT,my_uT,mz_uT\n",
            [](std::string& out, const std::string&, std::string_view data) {
              const auto s = logger::parse_imu(data);
              if (!s) return;
              out += io::format_nanoseconds(s->time.nanoseconds());
              put_vector(out, s->angular_rate_radps);
              put_vector(out, s->specific_force_mps2);
              put_vector(out, s->magnetic_field_uT);
              out += '\n';
            }};
  if (schema == logger::laser_scan_schema().name)
    return {"t_s,bearing_rad,range_m\n",
            [](std::string& out, const std::string&, std::string_view data) {
              const auto s = logger::parse_laser_scan(data);
              if (!s) return;
              const std::string t = io::format_nanoseconds(s->time.nanoseconds());
              for (std::size_t i = 0; i < s->ranges_m.size(); ++i) {
                out += t + ',';
                put(out, s->bearing(i).radians());
                out += ',';
                put(out, s->ranges_m[i]);
                out += '\n';
              }
            }};
  if (schema == logger::point_cloud_schema().name)
    return {"t_s,x_m,y_m,z_m,doppler_mps,snr_db\n",
            [](std::string& out, const std::string&, std::string_view data) {
              const auto s = logger::parse_point_cloud(data);
              if (!s) return;
              const std::string t = io::format_nanoseconds(s->time.nanoseconds());
              for (const RadarPoint& p : s->points) {
                out += t;
                for (const float v : {p.x_m, p.y_m, p.z_m, p.doppler_m_s, p.snr_db})
                  out += ',', put(out, v);
                out += '\n';
              }
            }};
  return {"t_s,bytes,hex\n", [](std::string& out, const std::string& t, std::string_view data) {
            constexpr std::string_view kDigits = "0123456789abcdef";
            out += t + ',';
            put(out, data.size());
            out += ',';
            for (const char c : data) {
              const auto byte = static_cast<unsigned char>(c);
              out += {kDigits[byte >> 4], kDigits[byte & 15U]};
            }
            out += '\n';
          }};
}

/// Hands a writer's bytes on.
class ForwardSink final : public io::ByteSink {
 public:
  explicit ForwardSink(const PieceSink& sink) : sink_(sink) {}
  Result<void> write(std::string_view bytes) override {
    if (!sink_(bytes)) return Error{ErrorCode::cancelled, "nobody takes it any more"};
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
  const std::int64_t now = steady_clock::now().time_since_epoch().count();
  constexpr std::int64_t kLeastAge = 2'000'000'000;  // a growing file is read through each time
  if (reader_ && (size == size_ || now - opened_ns_ < kLeastAge)) return reader_;
  auto opened = io::McapReader::open(path_);
  if (!opened) return opened.error();
  reader_ = std::make_shared<const io::McapReader>(std::move(*opened));
  size_ = size;
  opened_ns_ = now;
  return reader_;
}

Result<std::string> RecordingView::contents() const {
  const auto file = reader();
  if (!file) return file.error();
  const io::McapContents& c = (*file)->contents();
  json out = {{"path", logger::json_escaped(path_)},
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
  const std::uint64_t stride = std::max<std::uint64_t>(1, n / std::max<std::size_t>(most, 1));
  std::vector<double> t;
  std::array<std::vector<double>, 6> columns;
  std::uint64_t i = 0;
  (*file)->read({io::McapOrder::file, {topic}}, [&](const io::McapMessage& m) {
    if (i++ % stride != 0) return true;
    const auto sample = logger::parse_imu(m.data);
    if (!sample) return true;
    t.push_back(to_seconds(sample->time - c.statistics.first));
    for (int k = 0; k < 3; ++k) {
      columns[static_cast<std::size_t>(k)].push_back(sample->specific_force_mps2[k]);
      columns[static_cast<std::size_t>(k + 3)].push_back(sample->angular_rate_radps[k]);
    }
    return true;
  });
  return json({{"t", t}, {"columns", columns}, {"stride", stride}}).dump();
}

Result<std::string> RecordingView::message(const std::string& topic, double t_s) const {
  const auto file = reader();
  if (!file) return file.error();
  const io::McapContents& c = (*file)->contents();
  const io::McapChannel* channel = find_topic(c, topic);
  if (channel == nullptr || channel->message_encoding != "json") return no_topic(topic);
  const LogTime until = c.statistics.first + from_seconds(t_s);
  // The last one before: looked for further and further back.
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
  auto robot = logger::read_robot_recording(path_);
  if (!robot) return robot.error();
  std::vector<LaserScan>& scans = robot->recording.scans;
  if (scans.empty()) return Error{ErrorCode::not_found, "there are no laser scans"};
  const LogTime end = scans.front().time + from_seconds(most_s);
  while (scans.back().time > end) scans.pop_back();
  const auto slam = run_graph_slam(robot->recording);
  if (!slam) return slam.error();
  return io::encode_png(map_picture(slam->map, slam->trajectory));
}

Result<void> RecordingView::csv(const std::string& topic, const PieceSink& sink) const {
  const auto file = reader();
  if (!file) return file.error();
  const io::McapChannel* channel = find_topic((*file)->contents(), topic);
  if (channel == nullptr) return no_topic(topic);
  const CsvFormat format = csv_format(schema_of((*file)->contents(), *channel));
  std::string lines = format.head;
  bool taken = true;
  (*file)->read({io::McapOrder::file, {topic}}, [&](const io::McapMessage& m) {
    format.lines(lines, io::format_nanoseconds(m.log_time.nanoseconds()), m.data);
    if (lines.size() < 65536) return true;
    taken = sink(lines);
    lines.clear();
    return taken;
  });
  if (!taken || !sink(lines)) return Error{ErrorCode::cancelled, "nobody takes it any more"};
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
