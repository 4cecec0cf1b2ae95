#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include <wayfare/io/mcap.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/logger/messages.hpp>

#include "recording_view.hpp"

namespace wayfare::examples {
namespace {

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
