#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <memory>
#include <type_traits>
#include <utility>

#include <wayfare/io/mcap.hpp>
#include <wayfare/io/time_text.hpp>
#include <wayfare/logger/messages.hpp>

#include "recording_view.hpp"

namespace wayfare::examples {
namespace {

template <class Number>
void put(std::string& out, Number value) {
  if constexpr (std::is_floating_point_v<Number>) {
    if (!std::isfinite(value)) return;  // an empty field
  }
  std::array<char, 32> text;
  out.append(text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr);
}

/// Format of the lines of a message, by its schema; without one: time, length, bytes.
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
