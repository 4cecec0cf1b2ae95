// Tracks of GPX and KML files. Elements are searched by their names, without a general parser: both
// formats write a point's values in elements of its own.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include <wayfare/gnss/gps_time.hpp>

#include "io/columns/receiver_fixes.hpp"
#include "io/text/lines.hpp"

namespace wayfare::io {
namespace {

/// An element's start tag and content.
struct Element {
  std::string_view tag, content;
  std::size_t line = 0;  ///< of its start
};

/// The elements of one name, one after the other.
class Elements {
 public:
  Elements(std::string_view text, std::string_view name)
      : text_(text), begin_(std::string("<").append(name)), end_(std::string("</").append(name)) {}

  bool next(Element& element) {
    for (std::size_t at = at_; (at = text_.find(begin_, at)) != text_.npos; ++at) {
      const std::size_t after = at + begin_.size();
      if (after < text_.size() && !is_end_of_name(text_[after])) continue;
      const std::size_t close = text_.find('>', after);
      if (close == text_.npos) break;
      element.tag = text_.substr(after, close - after);
      element.line = line_at(at);
      const bool empty = element.tag.ends_with('/');
      const std::size_t end = empty ? close + 1 : text_.find(end_, close + 1);
      element.content = text_.substr(close + 1, end == text_.npos ? 0 : end - close - 1);
      at_ = empty ? close + 1 : end == text_.npos ? text_.size() : end + end_.size();
      return true;
    }
    at_ = text_.size();
    return false;
  }

 private:
  static bool is_end_of_name(char c) {
    return text::is_space(c) || c == '\n' || c == '>' || c == '/';
  }
  std::size_t line_at(std::size_t at) {
    for (; counted_ < at; ++counted_) line_ += text_[counted_] == '\n' ? 1 : 0;
    return line_;
  }

  std::string_view text_;
  std::string begin_, end_;
  std::size_t at_ = 0, counted_ = 0, line_ = 1;
};

std::optional<std::string_view> attribute(std::string_view tag, std::string_view name) {
  for (std::size_t at = 0; (at = tag.find(name, at)) != tag.npos; at += name.size()) {
    std::string_view rest = text::trimmed(tag.substr(at + name.size()));
    const bool begins = at > 0 && (text::is_space(tag[at - 1]) || tag[at - 1] == '\n');
    if (!begins || !rest.starts_with('=')) continue;
    rest = text::trimmed(rest.substr(1));
    if (rest.empty() || (rest.front() != '"' && rest.front() != '\'')) return std::nullopt;
    return rest.substr(1, rest.find(rest.front(), 1) - 1);
  }
  return std::nullopt;
}

std::string_view without_breaks(std::string_view text) {
  while (!text.empty() && (text::is_space(text.front()) || text.front() == '\n'))
    text.remove_prefix(1);
  while (!text.empty() && (text::is_space(text.back()) || text.back() == '\n'))
    text.remove_suffix(1);
  return text;
}

std::optional<std::string_view> child(std::string_view content, std::string_view name) {
  Elements all(content, name);
  Element element;
  if (!all.next(element)) return std::nullopt;
  return without_breaks(element.content);
}

/// Digits `[at, at + count)`; negative where they are none.
int digits_at(std::string_view text, std::size_t at, std::size_t count) {
  int value = -1;
  if (text.size() < at + count || text[at] == '-' || text[at] == '+') return -1;
  return text::to_number(text.substr(at, count), value) ? value : -1;
}

/// Minutes of "Z", "+02:00" or nothing.
std::optional<int> zone_minutes(std::string_view zone) {
  if (zone.empty() || zone == "Z") return 0;
  if (zone.size() != 6 || (zone[0] != '+' && zone[0] != '-') || zone[3] != ':') return std::nullopt;
  const int hours = digits_at(zone, 1, 2), minutes = digits_at(zone, 4, 2);
  if (hours < 0 || hours > 14 || minutes < 0 || minutes > 59) return std::nullopt;
  return (zone[0] == '-' ? -1 : 1) * (60 * hours + minutes);
}

/// GPS time of "2021-12-31T23:59:59.750Z".
std::optional<LogTime> iso_time(std::string_view t) {
  if (t.size() < 19 || t[4] != '-' || t[7] != '-' || t[10] != 'T' || t[13] != ':' || t[16] != ':')
    return std::nullopt;
  const std::size_t end = std::min(t.find_first_not_of("0123456789.", 17), t.size());
  const auto seconds = parse_nanoseconds(t.substr(17, end - 17));
  const auto zone = zone_minutes(t.substr(end));
  if (!seconds || *seconds < 0 || !zone) return std::nullopt;
  const auto utc = utc_from_civil({digits_at(t, 0, 4), digits_at(t, 5, 2), digits_at(t, 8, 2),
                                   digits_at(t, 11, 2), digits_at(t, 14, 2), Duration(*seconds)});
  if (!utc) return std::nullopt;
  return log_time(to_gps(*utc - std::chrono::minutes(*zone)));
}

/// An error message, or an empty string with the fix taken.
std::string take_point(double lat_deg, double lon_deg, double h_m,
                       std::optional<std::string_view> time, FixFile& file) {
  if (!(std::abs(lat_deg) <= 90.0) || !(std::abs(lon_deg) <= 360.0)) return "not a position";
  if (!std::isfinite(h_m)) return "not a height";
  if (!time) return "the point has no time";
  const auto stamp = iso_time(*time);
  if (!stamp) return "not a time: '" + text::printable(*time) + "'";
  GnssFix fix;
  fix.time = *stamp;
  fix.position = {Angle::degrees(lat_deg), Angle::degrees(lon_deg), h_m};
  file.fixes.push_back(fix);
  file.qualities.push_back(0);
  return {};
}

std::optional<double> number_of(std::optional<std::string_view> text) {
  double value = 0.0;
  if (!text || !text::to_number(*text, value)) return std::nullopt;
  return value;
}

void read_gpx(std::string_view all, const std::string& source, FixFile& file) {
  Elements points(all, "trkpt");
  for (Element point; points.next(point);) {
    const auto lat = number_of(attribute(point.tag, "lat"));
    const auto lon = number_of(attribute(point.tag, "lon"));
    const auto height = child(point.content, "ele");
    const auto h = height ? number_of(height) : 0.0;
    std::string fault = "not a position";
    if (lat && lon && h) fault = take_point(*lat, *lon, *h, child(point.content, "time"), file);
    if (!fault.empty()) file.problems.add({ErrorCode::parse, std::move(fault), source, point.line});
  }
}

/// Times and positions of gx:Track, in two lists.
void read_kml(std::string_view all, const std::string& source, FixFile& file) {
  Elements tracks(all, "gx:Track");
  for (Element track; tracks.next(track);) {
    Elements whens(track.content, "when"), coords(track.content, "gx:coord");
    for (Element when, coord; whens.next(when) && coords.next(coord);) {
      text::Tokens tokens(without_breaks(coord.content));
      double lon = 0.0, lat = 0.0, h = 0.0;
      std::string fault = "not a position";
      if (tokens.number(lon) && tokens.number(lat) && tokens.number(h))
        fault = take_point(lat, lon, h, without_breaks(when.content), file);
      if (!fault.empty())
        file.problems.add(
            {ErrorCode::parse, std::move(fault), source, track.line + coord.line - 1});
    }
  }
}

}  // namespace

bool is_xml(std::string_view bytes) {
  if (bytes.starts_with("\xef\xbb\xbf")) bytes.remove_prefix(3);
  const std::string_view begin = without_breaks(bytes.substr(0, 64));
  return begin.starts_with("<?xml") || begin.starts_with("<gpx") || begin.starts_with("<kml");
}

Result<FixFile> parse_xml_fixes(std::string_view all, const std::string& source) {
  FixFile file;
  const bool gpx = all.find("<gpx") != all.npos, kml = all.find("<kml") != all.npos;
  if (!gpx && !kml) return Error{ErrorCode::parse, "is XML, but neither GPX nor KML", source};
  gpx ? read_gpx(all, source, file) : read_kml(all, source, file);
  if (!file.fixes.empty()) return file;
  if (kml && file.problems.empty() && all.find("<LineString") != all.npos)
    return Error{ErrorCode::parse, "is a KML line without times; gx:Track has them, and GPX",
                 source};
  return no_content("track point", source, file.problems);
}

}  // namespace wayfare::io
