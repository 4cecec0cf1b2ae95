#include "io/picture/report_json.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <system_error>

#include "io/text/utf8.hpp"

namespace wayfare::io::json {
namespace {

/// All of `text` as a number; NaN for the sign of a value that is not known.
std::optional<double> number_in(std::string_view text) {
  if (text == "\u2013") return std::numeric_limits<double>::quiet_NaN();
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::string cell(std::string_view content) {
  if (const auto value = number_in(content)) return number(*value);
  constexpr std::string_view kBetween = " \u00b1 ";
  const std::size_t at = content.find(kBetween);
  if (at != content.npos) {
    const auto mean = number_in(content.substr(0, at));
    const auto std = number_in(content.substr(at + kBetween.size()));
    if (mean && std) return "{\"mean\": " + number(*mean) + ", \"std\": " + number(*std) + "}";
  }
  return text(content);
}

template <class Range, class Element>
std::string array(const Range& range, const Element& element, const char* between = ", ") {
  std::string out;
  for (const auto& each : range) out += (out.empty() ? "" : between) + element(each);
  return "[" + out + "]";
}

std::string block(const char* kind, const std::string& content) {
  return std::string("{\"") + kind + "\": " + content + "}";
}

std::string fact(const std::string& name, const std::string& content) {
  std::string out = "{\"name\": " + text(name) + ", \"text\": " + text(content);
  const std::string_view all = content;
  const std::size_t end = std::min(all.find(' '), all.size());
  const std::string_view unit = all.substr(std::min(end + 1, all.size()));
  const auto value = number_in(all.substr(0, end));
  if (value && unit.find(' ') == unit.npos)
    out += ", \"value\": " + number(*value) + ", \"unit\": " + text(unit);
  return out + "}";
}

std::string row(const std::vector<std::string>& cells) {
  std::string out;
  for (std::size_t i = 0; i < cells.size(); ++i)
    out += i == 0 ? text(cells[0]) : ", " + cell(cells[i]);
  return "[" + out + "]";
}

std::string series(const Series& s) {
  const std::size_t points = std::min(s.x.size(), s.y.size());
  return "{\"name\": " + text(s.name) + ", \"x\": " + array(std::span(s.x).first(points), number) +
         ", \"y\": " + array(std::span(s.y).first(points), number) + "}";
}

}  // namespace

std::string text(std::string_view text) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string out = "\"";
  while (!text.empty()) {
    const std::size_t length = io::text::utf8_length(text);
    const char c = text.front();
    const auto code = static_cast<unsigned char>(c);
    if (length == 0) {
      out += "\ufffd";
    } else if (c == '"' || c == '\\') {
      out += {'\\', c};
    } else if (code < 0x20 || code == 0x7f) {
      out += {'\\', 'u', '0', '0', kDigits[code >> 4U], kDigits[code & 15U]};
    } else {
      out += text.substr(0, length);
    }
    text.remove_prefix(length == 0 ? 1 : length);
  }
  return out + '"';
}

std::string number(double value) {
  if (!std::isfinite(value)) return "null";
  char digits[40];
  const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
  return {digits, end};
}

std::string heading(const std::string& text) { return block("heading", json::text(text)); }
std::string paragraph(const std::string& text) { return block("paragraph", json::text(text)); }
std::string image(const std::string& caption) { return block("image", text(caption)); }

std::string facts(const std::vector<std::pair<std::string, std::string>>& facts) {
  return block("facts", array(
                            facts, [](const auto& f) { return fact(f.first, f.second); }, ",\n "));
}

std::string table(const eval::Table& table, const std::string& caption) {
  const auto column = [](const eval::Table::Column& c) {
    return "{\"name\": " + text(c.name) + ", \"unit\": " + text(c.unit) + "}";
  };
  return block("table", "{\"caption\": " + text(caption) +
                            ",\n \"columns\": " + array(table.columns(), column) +
                            ",\n \"rows\": " + array(table.rows(), row, ",\n  ") + "}");
}

std::string plot(const Plot& plot) {
  return block("plot", "{\"title\": " + text(plot.title) + ", \"x_label\": " + text(plot.x_label) +
                           ", \"y_label\": " + text(plot.y_label) +
                           ",\n \"series\": " + array(plot.series, series, ",\n  ") + "}");
}

}  // namespace wayfare::io::json
