#pragma once

// The records of a ROS 1 bag: a header of named fields, then data, each preceded by its length.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <wayfare/io/bag.hpp>

#include "io/recording/bytes.hpp"

namespace wayfare::io::bag {

inline constexpr std::string_view kMagic = "#ROSBAG V2.0\n";
inline constexpr std::size_t kHeadBytes = 4096;  ///< of the bag's first record
inline constexpr std::uint32_t kIndexVersion = 1;

enum class Op : std::uint8_t {
  message = 2,
  head = 3,
  index = 4,
  chunk = 5,
  chunk_info = 6,
  connection = 7,
};

/// `name=value` fields of a header.
class Fields {
 public:
  /// nullopt where a field exceeds the header or has no `=`.
  [[nodiscard]] static std::optional<Fields> parse(std::string_view bytes) {
    Fields fields;
    ByteCursor cursor(bytes);
    while (!cursor.at_end()) {
      const std::string_view field = cursor.text();
      const std::size_t equals = field.find('=');
      if (!cursor.ok() || equals == std::string_view::npos) return std::nullopt;
      fields.all_.emplace_back(field.substr(0, equals), field.substr(equals + 1));
    }
    return fields;
  }

  /// Empty where there is no such field.
  [[nodiscard]] std::string_view text(std::string_view name) const {
    for (const auto& [key, value] : all_)
      if (key == name) return value;
    return {};
  }
  [[nodiscard]] bool has(std::string_view name) const {
    for (const auto& [key, value] : all_)
      if (key == name) return true;
    return false;
  }
  /// nullopt where there is no such field of that size.
  template <std::unsigned_integral T>
  [[nodiscard]] std::optional<T> number(std::string_view name) const {
    const std::string_view value = text(name);
    if (value.size() != sizeof(T)) return std::nullopt;
    return ByteCursor(value).number<T>();
  }
  [[nodiscard]] std::optional<LogTime> time(std::string_view name) const {
    const auto both = number<std::uint64_t>(name);
    if (!both) return std::nullopt;
    const std::uint64_t ns = *both >> 32U;
    if (ns >= 1'000'000'000) return std::nullopt;
    const auto sec = static_cast<std::int64_t>(*both & 0xFFFFFFFFU);
    return LogTime::from_nanoseconds(sec * 1'000'000'000 + static_cast<std::int64_t>(ns));
  }

 private:
  std::vector<std::pair<std::string_view, std::string_view>> all_;
};

struct Record {
  Op op = Op::head;
  Fields fields;
  std::string_view data;
};

/// Removes the first record from `rest`; nullopt where there is none.
[[nodiscard]] inline std::optional<Record> take_record(std::string_view& rest) {
  ByteCursor cursor(rest);
  auto fields = Fields::parse(cursor.text());
  const std::string_view data = cursor.text();
  const auto op = fields ? fields->number<std::uint8_t>("op") : std::nullopt;
  if (!cursor.ok() || !op) return std::nullopt;
  rest = cursor.rest();
  return Record{static_cast<Op>(*op), *std::move(fields), data};
}

/// The connection of a record; nullopt where its number, topic or type is missing.
[[nodiscard]] inline std::optional<BagConnection> connection_of(const Record& record) {
  const auto id = record.fields.number<std::uint32_t>("conn");
  const auto about = Fields::parse(record.data);
  if (!id || !about || !record.fields.has("topic") || !about->has("type")) return std::nullopt;
  return BagConnection{*id,
                       std::string(record.fields.text("topic")),
                       std::string(about->text("type")),
                       std::string(about->text("md5sum")),
                       std::string(about->text("message_definition")),
                       about->text("latching") == "1"};
}

}  // namespace wayfare::io::bag
