#include "io/rinex/rinex_header.hpp"

#include <algorithm>
#include <optional>
#include <utility>

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

namespace {

/// The RINEX 3 name of a RINEX 2 observation type: C1 is C1C, P2 is C2W, L5 is L5X. RINEX 2 has one
/// phase per band, used with either code.
std::vector<std::string> names_of_version_2(std::string_view type) {
  if (type.size() != 2 || type[1] < '1' || type[1] > '8') return {};
  const char kind = type[0], band = type[1];
  const std::string civil = band <= '2' ? "C" : "X";
  if (kind == 'C') return {std::string{'C', band} + civil};
  if (kind == 'P') return {std::string{'C', band} + "W"};
  if (kind == 'L' || kind == 'D' || kind == 'S')
    return {std::string{kind, band} + civil, std::string{kind, band} + "W"};
  return {};
}

std::optional<Eigen::Vector3d> three_numbers(std::string_view line) {
  Eigen::Vector3d values;
  for (std::size_t i = 0; i < 3; ++i)
    if (!field(line, 14 * i, 14, values[static_cast<Eigen::Index>(i)])) return std::nullopt;
  return values.allFinite() ? std::optional(values) : std::nullopt;
}

}  // namespace

ObservationHeader::ObservationHeader(const FirstLine& first, const std::string& source,
                                     const RinexOptions& options, RinexObservations& file)
    : source_(source),
      options_(options),
      file_(file),
      version_2_(first.version < 3.0),
      default_letter_(first.system == ' ' || first.system == 'M' ? 'G' : first.system) {
  if (first.system == 'R') scale_ = TimeScale::utc;
  if (first.system == 'C') scale_ = TimeScale::beidou;
}

void ObservationHeader::take(std::string_view line, std::size_t number) {
  const std::string_view name = label(line);
  if (name == "SYS / # / OBS TYPES") return types_of_system(line, number);
  if (name == "# / TYPES OF OBSERV") return types_of_all(line, number);
  if (name == "MARKER NAME") file_.marker = text::printable(trimmed(line.substr(0, 60)), 60);
  if (name == "APPROX POSITION XYZ") {
    const auto p = three_numbers(line);
    if (p && p->norm() > 1e6) file_.approximate_position_ecef_m = *p;
  }
  if (name == "ANTENNA: DELTA H/E/N")
    file_.antenna_up_east_north_m = three_numbers(line).value_or(file_.antenna_up_east_north_m);
  if (name == "TIME OF FIRST OBS") time_system(columns(line, 48, 3), number);
  if (name == "GLONASS SLOT / FRQ #") glonass_channels(line);
  int leaps = 0;
  if (name == "LEAP SECONDS" && field(line, 0, 6, leaps)) file_.leap_seconds = leaps;
  double factor = 1.0;
  if (name == "SYS / SCALE FACTOR" && field(line, 2, 4, factor) && factor != 1.0)
    report(number, "scale factors are not supported; the values are used unscaled");
}

void ObservationHeader::time_system(std::string_view name, std::size_t number) {
  if (name == "GPS" || name == "GAL" || name == "QZS") scale_ = TimeScale::gps;
  if (name == "GLO" || name == "UTC") scale_ = TimeScale::utc;
  if (name == "BDT") scale_ = TimeScale::beidou;
  if (name == "IRN") report(number, "time system IRN is treated as GPS");
}

void ObservationHeader::types_of_system(std::string_view line, std::size_t number) {
  // The system is blank in a continuation line.
  if (columns(line, 0, 1) != " " && !line.empty()) {
    types_letter_ = line[0];
    types_[static_cast<unsigned char>(types_letter_)].clear();
  }
  Types& types = types_[static_cast<unsigned char>(types_letter_)];
  for (std::size_t at = 7; at + 3 <= std::min<std::size_t>(line.size(), 58); at += 4) {
    const std::string_view type = line.substr(at, 3);
    if (is_blank(type)) break;
    if (types.size() < kMaxTypes) types.push_back({std::string(type)});
  }
  if (types_letter_ == ' ') report(number, "observation types without a system");
}

void ObservationHeader::types_of_all(std::string_view line, std::size_t number) {
  int count = 0;
  if (field(line, 0, 6, count)) types_of_all_.clear();
  for (std::size_t at = 10; at + 2 <= std::min<std::size_t>(line.size(), 60); at += 6) {
    const std::string_view type = line.substr(at, 2);
    if (is_blank(type)) break;
    if (types_of_all_.size() < kMaxTypes) types_of_all_.push_back(names_of_version_2(type));
  }
  if (types_of_all_.empty()) report(number, "no observation types in this line");
}

void ObservationHeader::glonass_channels(std::string_view line) {
  for (std::size_t at = 4; at + 6 <= std::min<std::size_t>(line.size(), 60); at += 7) {
    const auto satellite = parse_satellite(line.substr(at, 3));
    int channel = 0;
    if (satellite && field(line, at + 3, 3, channel) && channel >= -7 && channel <= 13)
      file_.glonass_channels[*satellite] = channel;
  }
}

void ObservationHeader::finish() {
  for (const GnssSystem system : kAllGnssSystems) {
    const Types& types =
        version_2_ ? types_of_all_ : types_[static_cast<unsigned char>(letter_of(system))];
    places_[index_of(system)] = places_among(system, types);
  }
}

std::vector<SignalPlaces> ObservationHeader::places_among(GnssSystem system,
                                                          const Types& types) const {
  std::vector<SignalPlaces> places;
  for (const std::string& signal : options_.signals[index_of(system)]) {
    if (signal.size() != 2) continue;
    const auto find = [&](char kind) {
      const auto here = std::find_if(types.begin(), types.end(), [&](const auto& names) {
        return std::find(names.begin(), names.end(), kind + signal) != names.end();
      });
      return here == types.end() ? -1 : static_cast<int>(here - types.begin());
    };
    SignalPlaces place{find('C'), find('D'), find('L'), find('S'), signal[0]};
    // BeiDou's B1I is band 1 only in RINEX 3.02.
    if (system == GnssSystem::beidou && signal == "1I") place.band = '2';
    if (place.code >= 0) places.push_back(place);
  }
  return places;
}

void ObservationHeader::report(std::size_t line, std::string message) {
  file_.problems.add(Error{ErrorCode::parse, std::move(message), source_, line});
}

}  // namespace wayfare::io::rinex
