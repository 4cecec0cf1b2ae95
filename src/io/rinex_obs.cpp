#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <wayfare/gnss/signal.hpp>
#include <wayfare/io/rinex.hpp>

#include "pose_lines.hpp"
#include "rinex_text.hpp"
#include "text.hpp"

namespace wayfare::io {
namespace {

using rinex::columns;
using rinex::label;

/// Where in a satellite's list of values the parts of one signal stand; −1: not in the list.
struct SignalPlaces {
  int code = -1, doppler = -1, phase = -1, strength = -1;
  char band = '1';
};

/// The RINEX 3 name of a RINEX 2 observation type: C1 is C1C, P2 is C2W, L5 is L5X. RINEX 2 has one
/// phase a band, which goes with either code.
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

class ObservationReader {
 public:
  ObservationReader(std::string source, const RinexOptions& options)
      : source_(std::move(source)), options_(options) {
    file_.problems = Problems(options.max_problems);
  }

  Result<RinexObservations> read(std::string_view all) {
    text::Lines lines(all);
    std::string_view line;
    lines.next(line);
    const Result<rinex::FirstLine> first = rinex::first_line(line, source_);
    if (!first) return first.error();
    if (first->type != 'O')
      return Error{ErrorCode::parse, "is not a RINEX observation file", source_, 1};
    file_.version = first->version;
    version2_ = first->version < 3.0;
    default_letter_ = first->system == ' ' || first->system == 'M' ? 'G' : first->system;
    if (first->system == 'R') scale_ = rinex::TimeScale::utc;
    if (first->system == 'C') scale_ = rinex::TimeScale::beidou;
    if (!read_header(lines))
      return Error{ErrorCode::parse, "the header has no end ('END OF HEADER')", source_};
    read_epochs(lines);
    file_.lines = lines.number();
    if (file_.epochs.empty()) return nothing_in_it("epoch", source_, file_.problems);
    return std::move(file_);
  }

 private:
  // --- header --------------------------------------------------------------------------------

  bool read_header(text::Lines& lines) {
    for (std::string_view line; lines.next(line);) {
      if (label(line) == "END OF HEADER") return finish_header(), true;
      header_line(line, lines.number());
    }
    return false;
  }

  /// One header line, of the header or after an event.
  void header_line(std::string_view line, std::size_t number) {
    const std::string_view name = label(line);
    if (name == "SYS / # / OBS TYPES") return types_of_system(line, number);
    if (name == "# / TYPES OF OBSERV") return types_of_all(line, number);
    if (name == "MARKER NAME")
      file_.marker = text::printable(rinex::trimmed(line.substr(0, 60)), 60);
    if (name == "APPROX POSITION XYZ") {
      Eigen::Vector3d p;
      if (three_numbers(line, p) && p.norm() > 1e6) file_.approximate_position_ecef_m = p;
    }
    if (name == "ANTENNA: DELTA H/E/N") three_numbers(line, file_.antenna_up_east_north_m);
    if (name == "TIME OF FIRST OBS") time_system(columns(line, 48, 3), number);
    if (name == "GLONASS SLOT / FRQ #") glonass_channels(line);
    int leaps = 0;
    if (name == "LEAP SECONDS" && rinex::field(line, 0, 6, leaps)) file_.leap_seconds = leaps;
    double factor = 1.0;
    if (name == "SYS / SCALE FACTOR" && rinex::field(line, 2, 4, factor) && factor != 1.0)
      report(number, "scale factors are not read; the values are taken as they stand");
  }

  static bool three_numbers(std::string_view line, Eigen::Vector3d& out) {
    Eigen::Vector3d values;
    for (std::size_t i = 0; i < 3; ++i)
      if (!rinex::field(line, 14 * i, 14, values[static_cast<Eigen::Index>(i)])) return false;
    if (!values.allFinite()) return false;
    out = values;
    return true;
  }

  void time_system(std::string_view name, std::size_t number) {
    if (name == "GPS" || name == "GAL" || name == "QZS") scale_ = rinex::TimeScale::gps;
    if (name == "GLO" || name == "UTC") scale_ = rinex::TimeScale::utc;
    if (name == "BDT") scale_ = rinex::TimeScale::beidou;
    if (name == "IRN") report(number, "time system IRN is taken as GPS");
  }

  void types_of_system(std::string_view line, std::size_t number) {
    // A continuation leaves the system blank.
    if (columns(line, 0, 1) != " " && !line.empty()) {
      types_letter_ = line[0];
      types_[static_cast<unsigned char>(types_letter_)].clear();
    }
    auto& types = types_[static_cast<unsigned char>(types_letter_)];
    for (std::size_t at = 7; at + 3 <= std::min<std::size_t>(line.size(), 58); at += 4) {
      const std::string_view type = line.substr(at, 3);
      if (rinex::is_blank(type)) break;
      if (types.size() < kMaxTypes) types.push_back({std::string(type)});
    }
    if (types_letter_ == ' ') report(number, "observation types without a system");
  }

  void types_of_all(std::string_view line, std::size_t number) {
    int count = 0;
    if (rinex::field(line, 0, 6, count)) types2_.clear();
    for (std::size_t at = 10; at + 2 <= std::min<std::size_t>(line.size(), 60); at += 6) {
      const std::string_view type = line.substr(at, 2);
      if (rinex::is_blank(type)) break;
      if (types2_.size() < kMaxTypes) types2_.push_back(names_of_version_2(type));
    }
    if (types2_.empty()) report(number, "no observation types in this line");
  }

  void glonass_channels(std::string_view line) {
    for (std::size_t at = 4; at + 6 <= std::min<std::size_t>(line.size(), 60); at += 7) {
      const auto satellite = parse_satellite(line.substr(at, 3));
      int channel = 0;
      if (satellite && rinex::field(line, at + 3, 3, channel) && channel >= -7 && channel <= 13)
        file_.glonass_channels[*satellite] = channel;
    }
  }

  /// Turns the lists of types into the places of the signals asked for.
  void finish_header() {
    for (const GnssSystem system : kAllGnssSystems) {
      const auto& types =
          version2_ ? types2_ : types_[static_cast<unsigned char>(letter_of(system))];
      auto& places = places_[static_cast<std::size_t>(index_of(system))];
      places.clear();
      for (const std::string& signal :
           options_.signals[static_cast<std::size_t>(index_of(system))]) {
        if (signal.size() != 2) continue;
        const auto find = [&](char kind) {
          for (std::size_t i = 0; i < types.size(); ++i)
            for (const std::string& name : types[i])
              if (name == kind + signal) return static_cast<int>(i);
          return -1;
        };
        SignalPlaces place{find('C'), find('D'), find('L'), find('S'), signal[0]};
        // BeiDou's B1I is band 1 in RINEX 3.02 alone.
        if (system == GnssSystem::beidou && signal == "1I") place.band = '2';
        if (place.code >= 0) places.push_back(place);
      }
    }
  }

  // --- epochs --------------------------------------------------------------------------------

  struct EpochLine {
    std::optional<Time<GpsClock>> time;
    int flag = 0;
    int count = 0;
  };

  /// The first line of an epoch, or nothing where it is none.
  std::optional<EpochLine> epoch_line(std::string_view line) const {
    if (version2_ ? line.size() < 32 : line.size() < 35 || line[0] != '>') return std::nullopt;
    const std::size_t flag_at = version2_ ? 28 : 31, date_at = version2_ ? 0 : 1;
    EpochLine epoch;
    if (!rinex::field(line, flag_at, 1, epoch.flag) || epoch.flag > 6) return std::nullopt;
    if (!rinex::field(line, flag_at + 1, 3, epoch.count) || epoch.count < 0) return std::nullopt;
    const std::string_view date = line.substr(date_at, flag_at - date_at);
    if (const auto civil = rinex::civil_time(date))
      epoch.time = rinex::gps_from(*civil, scale_, options_.leap_seconds);
    // Only an event may go without a time.
    const bool event = epoch.flag >= 2 && epoch.flag <= 5;
    if (!epoch.time && !(event && rinex::is_blank(date))) return std::nullopt;
    return epoch;
  }

  void read_epochs(text::Lines& lines) {
    std::string_view line;
    bool have = lines.next(line), lost = false;
    while (have) {
      const std::optional<EpochLine> epoch = epoch_line(line);
      if (!epoch) {
        // One damaged epoch is one problem, whatever the number of its lines.
        const bool begins = !version2_ && !line.empty() && line[0] == '>';
        if (!rinex::is_blank(line) && (!lost || begins)) {
          report(lines.number(), "not the beginning of an epoch; skipped up to the next");
          ++file_.skipped_epochs;
          lost = true;
        }
        have = lines.next(line);
        continue;
      }
      lost = false;
      if (epoch->flag >= 1) file_.events.push_back({epoch->flag, epoch->time, lines.number()});
      if (epoch->flag <= 1) {
        have = version2_ ? epoch_2(*epoch, lines, line) : epoch_3(*epoch, lines, line);
      } else {
        have = event(*epoch, lines, line);
      }
    }
  }

  /// Lines that come with an event; header lines among them are obeyed.
  bool event(const EpochLine& epoch, text::Lines& lines, std::string_view& line) {
    bool have = lines.next(line), header = false;
    for (int i = 0; i < epoch.count && have; ++i) {
      if (!version2_ && !line.empty() && line[0] == '>') break;
      if (epoch.flag != 6 && !label(line).empty()) {
        header_line(line, lines.number());
        header = true;
      }
      have = lines.next(line);
    }
    if (header) finish_header();
    return have;
  }

  bool epoch_3(const EpochLine& epoch, text::Lines& lines, std::string_view& line) {
    ObservationEpoch result{*epoch.time, {}};
    const std::size_t began = lines.number();
    bool have = lines.next(line);
    int found = 0;
    for (; found < epoch.count && have; ++found) {
      if (!line.empty() && line[0] == '>') break;
      const auto satellite = parse_satellite(columns(line, 0, 3));
      const auto system = line.empty() ? std::nullopt : system_of(line[0]);
      if (satellite && system) {
        SatelliteObservation o;
        const auto value = [&](int place) {
          return value_at(columns(line, 3 + 16 * static_cast<std::size_t>(place), 14),
                          lines.number());
        };
        if (observe(*satellite, value, o)) result.satellites.push_back(o);
      } else if (!system && !line.empty() && std::string_view("JSI").find(line[0]) != line.npos) {
        ++file_.other_satellites;
      } else {
        report(lines.number(), "not a satellite: '" + text::printable(columns(line, 0, 3)) + "'");
      }
      have = lines.next(line);
    }
    if (found < epoch.count)
      report(began, "the epoch has " + std::to_string(found) + " of " +
                        std::to_string(epoch.count) + " satellites");
    file_.epochs.push_back(std::move(result));
    return have;
  }

  bool epoch_2(const EpochLine& epoch, text::Lines& lines, std::string_view& line) {
    ObservationEpoch result{*epoch.time, {}};
    const std::size_t began = lines.number();
    std::vector<std::string> names;
    bool have = true;
    while (static_cast<int>(names.size()) < epoch.count) {
      for (std::size_t at = 32; at + 3 <= 68 && static_cast<int>(names.size()) < epoch.count;
           at += 3)
        names.emplace_back(columns(line, at, 3));
      have = lines.next(line);
      if (!have) break;
    }
    if (epoch.count == 0) have = lines.next(line);
    const std::size_t rows = (types2_.size() + 4) / 5;
    int found = 0;
    for (std::string& name : names) {
      if (!have || rows == 0) break;
      std::vector<std::pair<std::string_view, std::size_t>> mine;
      bool interrupted = false;
      for (std::size_t r = 0; r < rows && have; ++r) {
        if (epoch_line(line)) {
          interrupted = true;
          break;
        }
        mine.emplace_back(line, lines.number());
        have = lines.next(line);
      }
      if (interrupted || mine.size() < rows) break;
      ++found;
      if (name.size() == 3 && name[0] == ' ') name[0] = default_letter_;
      const auto satellite = parse_satellite(name);
      if (!satellite) {
        if (!name.empty() && std::string_view("JSI").find(name[0]) != std::string_view::npos) {
          ++file_.other_satellites;
        } else {
          report(began, "not a satellite: '" + text::printable(name) + "'");
        }
        continue;
      }
      SatelliteObservation o;
      const auto value = [&](int place) {
        const auto& [text, number] = mine[static_cast<std::size_t>(place) / 5];
        return value_at(columns(text, 16 * (static_cast<std::size_t>(place) % 5), 14), number);
      };
      if (observe(*satellite, value, o)) result.satellites.push_back(o);
    }
    if (found < epoch.count)
      report(began, "the epoch has " + std::to_string(found) + " of " +
                        std::to_string(epoch.count) + " satellites");
    file_.epochs.push_back(std::move(result));
    return have;
  }

  /// A field of fourteen columns with three decimals; NaN where it is blank, zero or damaged. A
  /// field that is cut off would read as another number, so all fourteen must be there.
  double value_at(std::string_view text, std::size_t line) {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    if (rinex::is_blank(text)) return kNone;
    double value = 0.0;
    const bool whole = text.size() == 14 && text[10] == '.';
    if (!whole || !text::to_number(rinex::trimmed(text), value) || !std::isfinite(value)) {
      report(line, "not a value with three decimals: '" + text::printable(text) + "'");
      return kNone;
    }
    return value == 0.0 ? kNone : value;
  }

  /// The first signal asked for that has a code.
  template <class Value>
  bool observe(SatelliteId satellite, const Value& value, SatelliteObservation& o) {
    for (const SignalPlaces& p : places_[static_cast<std::size_t>(index_of(satellite.system))]) {
      const double code = value(p.code);
      if (std::isnan(code)) continue;
      o.satellite = satellite;
      o.pseudorange_m = code;
      if (p.doppler >= 0) o.doppler_hz = value(p.doppler);
      if (p.phase >= 0) o.carrier_cycles = value(p.phase);
      if (p.strength >= 0) o.cn0_dbhz = value(p.strength);
      const auto channel = file_.glonass_channels.find(satellite);
      o.carrier_hz = carrier_hz(satellite.system, p.band,
                                channel == file_.glonass_channels.end() ? 0 : channel->second)
                         .value_or(std::numeric_limits<double>::quiet_NaN());
      return true;
    }
    ++file_.no_signal;
    return false;
  }

  void report(std::size_t line, std::string message) {
    file_.problems.add(Error{ErrorCode::parse, std::move(message), source_, line});
  }

  static constexpr std::size_t kMaxTypes = 999;

  std::string source_;
  const RinexOptions& options_;
  RinexObservations file_;
  bool version2_ = false;
  char default_letter_ = 'G';
  char types_letter_ = ' ';
  rinex::TimeScale scale_ = rinex::TimeScale::gps;
  std::array<std::vector<std::vector<std::string>>, 256> types_;  ///< by system letter
  std::vector<std::vector<std::string>> types2_;                  ///< of version 2, for all
  std::array<std::vector<SignalPlaces>, kGnssSystems> places_;
};

}  // namespace

SignalPreference default_signals() {
  return {{{"1C", "1W", "1P", "1X", "1L", "1S", "1Y"},
           {"1C", "1P"},
           {"1C", "1X", "1B", "1Z", "1A"},
           {"2I", "1I", "2X", "2Q"}}};
}

Result<RinexObservations> parse_rinex_observations(std::string_view text, const std::string& source,
                                                   const RinexOptions& options) {
  return ObservationReader(source, options).read(text);
}

Result<RinexObservations> read_rinex_observations(const std::string& path,
                                                  const RinexOptions& options) {
  return read_and_parse<RinexObservations>(path, options.file,
                                           [&](std::string_view text, const std::string& source) {
                                             return parse_rinex_observations(text, source, options);
                                           });
}

}  // namespace wayfare::io
