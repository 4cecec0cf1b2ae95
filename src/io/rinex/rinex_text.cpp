#include "io/rinex/rinex_text.hpp"

#include <wayfare/io/text_file.hpp>

namespace wayfare::io::rinex {

std::optional<CivilTime> civil_time(std::string_view text) {
  text::Tokens tokens(text);
  CivilTime t;
  if (!tokens.number(t.year) || !tokens.number(t.month) || !tokens.number(t.day) ||
      !tokens.number(t.hour) || !tokens.number(t.minute))
    return std::nullopt;
  if (t.year < 0 || t.year > 2099) return std::nullopt;
  t.year = full_year(t.year);
  const std::optional<std::int64_t> of_minute = parse_nanoseconds(tokens.next());
  if (!of_minute || !tokens.at_end()) return std::nullopt;
  t.of_minute = Duration(*of_minute);
  return t;
}

std::optional<Time<GpsClock>> gps_from(const CivilTime& civil, TimeScale scale,
                                       std::span<const LeapSecond> leaps) {
  if (scale == TimeScale::utc) {
    const auto utc = utc_from_civil(civil);
    return utc ? std::optional(to_gps(*utc, leaps)) : std::nullopt;
  }
  if (scale == TimeScale::beidou) {
    const auto beidou = beidou_from_civil(civil);
    return beidou ? std::optional(to_gps(*beidou)) : std::nullopt;
  }
  return gps_from_civil(civil);
}

Result<FirstLine> first_line(std::string_view line, const std::string& source) {
  FirstLine first;
  if (label(line) != "RINEX VERSION / TYPE" || !field(line, 0, 9, first.version))
    return Error{ErrorCode::parse, "is not RINEX: the first line has no 'RINEX VERSION / TYPE'",
                 source, 1};
  if (!(first.version >= 2.0 && first.version < 4.0))
    return Error{ErrorCode::unsupported,
                 "RINEX " + text::printable(trimmed(columns(line, 0, 9))) +
                     " is not supported, only 2.xx and 3.xx",
                 source, 1};
  first.type = columns(line, 20, 1).empty() ? ' ' : line[20];
  first.system = columns(line, 40, 1).empty() ? ' ' : line[40];
  return first;
}

}  // namespace wayfare::io::rinex
