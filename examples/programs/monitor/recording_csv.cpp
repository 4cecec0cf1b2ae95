#include "recording_csv.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include <nlohmann/json.hpp>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/logger/messages.hpp>

#include "message_text.hpp"

namespace wayfare::examples {
namespace {

using nlohmann::json;

std::string time_text(LogTime time) { return io::format_nanoseconds(time.nanoseconds()); }

/// A number that is not finite is an empty field.
template <class Number>
void put(std::string& out, Number value) {
  if (!std::isfinite(value)) return;
  std::array<char, 32> text;
  out.append(text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr);
}

/// Lines of the messages that `parse` accepts: their time, then the numbers `write` passes on.
template <class Parse, class Write>
CsvFormat measured(const char* head, Parse parse, Write write) {
  return {head, [parse, write](std::string& out, const io::McapMessage& m) {
            const auto measurement = parse(m.data);
            if (!measurement) return;
            const std::string t = time_text(measurement->time);
            write(*measurement, [&](auto... numbers) {
              out += t;
              ((out += ',', put(out, numbers)), ...);
              out += '\n';
            });
          }};
}

/// Quoted where it must be.
std::string csv_text(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? "\"\"" : std::string(1, c);
  return out + '"';
}

/// The bytes of base64 up to its end or another character.
std::string from_base64(std::string_view text) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  std::uint32_t bits = 0;
  int held = 0;
  for (const char c : text) {
    const auto value = kDigits.find(c);
    if (value == kDigits.npos) break;
    bits = bits << 6U | static_cast<std::uint32_t>(value);
    held += 6;
    if (held < 8) continue;
    held -= 8;
    out += static_cast<char>(bits >> held & 0xFFU);
  }
  return out;
}

/// A number of each point of a cloud.
struct PackedField {
  std::string name;
  std::size_t offset = 0;
  int type = 0;
};

template <class Number>
void put_packed(std::string& out, std::string_view bytes, std::size_t at) {
  if (at + sizeof(Number) > bytes.size()) return;
  const auto value = decode::load_le<Number>(bytes, at);
  if constexpr (std::is_integral_v<Number>) {
    out += std::to_string(value);
  } else {
    put(out, value);
  }
}

/// By the type numbers of foxglove.PackedElementField, from 1.
void put_field(std::string& out, std::string_view bytes, std::size_t at, int type) {
  constexpr std::array kPut = {put_packed<std::uint8_t>,  put_packed<std::int8_t>,
                               put_packed<std::uint16_t>, put_packed<std::int16_t>,
                               put_packed<std::uint32_t>, put_packed<std::int32_t>,
                               put_packed<float>,         put_packed<double>};
  if (type >= 1 && type <= static_cast<int>(kPut.size()))
    kPut[static_cast<std::size_t>(type - 1)](out, bytes, at);
}

std::vector<PackedField> packed_fields(const json& message) {
  std::vector<PackedField> fields;
  const auto list = message.find("fields");
  if (list == message.end() || !list->is_array()) return fields;
  for (const json& f : *list)
    if (f.is_object() && f.contains("name") && f["name"].is_string() && f.contains("offset") &&
        f["offset"].is_number_unsigned() && f.contains("type") && f["type"].is_number_unsigned())
      fields.push_back({f["name"], f["offset"], f["type"]});
  return fields;
}

/// A point cloud's column: with its unit where the name has one of the logger's.
std::string column_of(const std::string& field) {
  static const std::map<std::string, std::string> kUnits = {
      {"x", "x_m"}, {"y", "y_m"}, {"z", "z_m"}, {"doppler", "doppler_mps"}, {"snr", "snr_db"}};
  const auto known = kUnits.find(field);
  return known == kUnits.end() ? field : known->second;
}

/// A line for each point; the first message names the columns.
CsvFormat cloud_format() {
  return {"",
          [names = std::vector<std::string>()](std::string& out, const io::McapMessage& m) mutable {
            const json message = json::parse(m.data, nullptr, false);
            const std::vector<PackedField> fields = packed_fields(message);
            if (fields.empty() || !message["data"].is_string() ||
                !message["point_stride"].is_number_unsigned())
              return;
            if (names.empty()) {
              out += "t_s";
              for (const PackedField& f : fields) {
                names.push_back(f.name);
                out += ',' + csv_text(column_of(f.name));
              }
              out += '\n';
            }
            const std::string data = from_base64(message["data"].get_ref<const std::string&>());
            const std::size_t stride = message["point_stride"];
            for (std::size_t at = 0; stride > 0 && at + stride <= data.size(); at += stride) {
              out += time_text(measured_at(m));
              for (const std::string& name : names) {
                const auto f = std::ranges::find(fields, name, &PackedField::name);
                out += ',';
                if (f != fields.end() && f->offset < stride)
                  put_field(out, data, at + f->offset, f->type);
              }
              out += '\n';
            }
          }};
}

std::string schema_text(const io::McapContents& contents, const io::McapChannel& channel) {
  for (const io::McapSchema& s : contents.schemas)
    if (s.id == channel.schema && s.encoding == "jsonschema") return s.data;
  return {};
}

/// The fields below an object of a schema that have a value each: `angular_velocity.x`.
void add_fields(const json& schema, const std::string& prefix, std::vector<std::string>& fields) {
  const auto properties = schema.find("properties");
  if (properties == schema.end() || !properties->is_object()) {
    if (!prefix.empty()) fields.push_back(prefix);
    return;
  }
  for (const auto& [name, property] : properties->items())
    if (property.is_object())
      add_fields(property, prefix.empty() ? name : prefix + '.' + name, fields);
}

/// Numbers and texts as they are, null and absent fields empty, anything else as JSON.
std::string csv_value(const json& message, const std::string& field) {
  const json* at = &message;
  for (std::size_t begin = 0, end = 0; end != field.npos; begin = end + 1) {
    end = field.find('.', begin);
    const auto found = at->find(field.substr(begin, end == field.npos ? end : end - begin));
    if (!at->is_object() || found == at->end()) return {};
    at = &*found;
  }
  if (at->is_null()) return {};
  return csv_text(at->is_string() ? at->get<std::string>() : text_of(*at));
}

/// A line for each message, with a column for each field of its schema; without one, the message.
CsvFormat flat_format(const std::string& schema) {
  std::vector<std::string> fields;
  if (const json parsed = json::parse(schema, nullptr, false); parsed.is_object())
    add_fields(parsed, "", fields);
  std::string head = "t_s";
  for (const std::string& field : fields) head += ',' + csv_text(field);
  if (fields.empty()) head += ",message";
  return {head + '\n', [fields](std::string& out, const io::McapMessage& m) {
            const json message = json::parse(m.data, nullptr, false);
            out += time_text(measured_at(m));
            for (const std::string& field : fields) out += ',' + csv_value(message, field);
            if (fields.empty()) out += ',' + csv_text(std::string(m.data));
            out += '\n';
          }};
}

}  // namespace

CsvFormat csv_format(const io::McapContents& contents, const io::McapChannel& channel) {
  const std::string schema = schema_of(contents, channel);
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
  const std::string text = schema_text(contents, channel);
  if (schema == logger::point_cloud_schema().name || text.find("\"point_stride\"") != text.npos)
    return cloud_format();
  if (channel.message_encoding == "json") return flat_format(text);
  return {"t_s,bytes,hex\n", [](std::string& out, const io::McapMessage& m) {
            out += time_text(m.log_time) + ',' + std::to_string(m.data.size()) + ',' +
                   hexadecimal(m.data) + '\n';
          }};
}

}  // namespace wayfare::examples
