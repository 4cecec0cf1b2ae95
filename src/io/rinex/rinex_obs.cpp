#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <wayfare/gnss/ephemerides.hpp>
#include <wayfare/io/rinex.hpp>

#include "io/rinex/rinex_header.hpp"
#include "io/text/lines.hpp"

namespace wayfare::io {
namespace {

using rinex::columns;
using rinex::label;

/// The current line; a reader that cannot use it leaves it for the next one.
struct Cursor {
  text::Lines lines;
  std::string_view line = {};
  bool have = true;

  void next() { have = lines.next(line); }
  [[nodiscard]] std::size_t number() const { return lines.number(); }
};

/// The first line of an epoch.
struct EpochLine {
  std::optional<Time<GpsClock>> time;
  int flag = 0;   ///< 0 observations, 1 after a power failure, 2 to 5 events, 6 cycle slips
  int count = 0;  ///< of satellites, or of an event's lines
};

class EpochReader {
 public:
  EpochReader(rinex::ObservationHeader& header, const std::string& source,
              const RinexOptions& options, RinexObservations& file)
      : header_(header), source_(source), options_(options), file_(file) {}

  void read(Cursor& at) {
    bool lost = false;
    while (at.have) {
      const std::optional<EpochLine> epoch = epoch_line(at.line);
      if (!epoch) {
        skip(at, lost);
        continue;
      }
      lost = false;
      if (epoch->flag >= 1) file_.events.push_back({epoch->flag, epoch->time, at.number()});
      if (epoch->flag > 1)
        event(*epoch, at);
      else if (header_.version_2())
        epoch_2(*epoch, at);
      else
        epoch_3(*epoch, at);
    }
  }

 private:
  /// nullopt where it is not one.
  [[nodiscard]] std::optional<EpochLine> epoch_line(std::string_view line) const {
    const bool version_2 = header_.version_2();
    if (version_2 ? line.size() < 32 : line.size() < 35 || line[0] != '>') return std::nullopt;
    const std::size_t flag_at = version_2 ? 28 : 31, date_at = version_2 ? 0 : 1;
    EpochLine epoch;
    if (!rinex::field(line, flag_at, 1, epoch.flag) || epoch.flag > 6) return std::nullopt;
    if (!rinex::field(line, flag_at + 1, 3, epoch.count) || epoch.count < 0) return std::nullopt;
    const std::string_view date = line.substr(date_at, flag_at - date_at);
    if (const auto civil = rinex::civil_time(date))
      epoch.time = rinex::gps_from(*civil, header_.time_scale(), options_.leap_seconds);
    // Only an event may lack a time.
    const bool event = epoch.flag >= 2 && epoch.flag <= 5;
    if (!epoch.time && !(event && rinex::is_blank(date))) return std::nullopt;
    return epoch;
  }

  [[nodiscard]] bool begins_epoch_3(std::string_view line) const {
    return !header_.version_2() && !line.empty() && line[0] == '>';
  }

  /// A damaged epoch is one problem, independent of the number of its lines.
  void skip(Cursor& at, bool& lost) {
    if (!rinex::is_blank(at.line) && (!lost || begins_epoch_3(at.line))) {
      report(at.number(), "not the beginning of an epoch; skipped up to the next");
      ++file_.skipped_epochs;
      lost = true;
    }
    at.next();
  }

  /// The lines of an event; header lines among them are applied.
  void event(const EpochLine& epoch, Cursor& at) {
    bool header = false;
    at.next();
    for (int i = 0; i < epoch.count && at.have && !begins_epoch_3(at.line); ++i, at.next()) {
      if (epoch.flag == 6 || label(at.line).empty()) continue;
      header_.take(at.line, at.number());
      header = true;
    }
    if (header) header_.finish();
  }

  /// Version 3: one line per satellite, which begins with its name.
  void epoch_3(const EpochLine& epoch, Cursor& at) {
    ObservationEpoch result{*epoch.time, {}};
    const std::size_t began = at.number();
    int found = 0;
    for (at.next(); found < epoch.count && at.have && !begins_epoch_3(at.line); ++found, at.next())
      satellite(columns(at.line, 0, 3), at.number(), result, [&](std::size_t place) {
        return Field{columns(at.line, 3 + 16 * place, 15), at.number()};
      });
    finish(epoch, std::move(result), found, began);
  }

  /// Version 2: first the names of all satellites, then their values, five per line.
  void epoch_2(const EpochLine& epoch, Cursor& at) {
    ObservationEpoch result{*epoch.time, {}};
    const std::size_t began = at.number();
    const std::vector<std::string> names = names_2(epoch.count, at);
    int found = 0;
    for (const std::string& name : names) {
      const std::vector<Row> rows = rows_2(at);
      if (rows.empty()) break;
      ++found;
      satellite(name, began, result, [&](std::size_t place) {
        const Row& row = rows[place / 5];
        return Field{columns(row.line, 16 * (place % 5), 15), row.number};
      });
    }
    finish(epoch, std::move(result), found, began);
  }

  /// Twelve per line, from the epoch's first line on.
  std::vector<std::string> names_2(int count, Cursor& at) const {
    std::vector<std::string> names;
    do {
      for (std::size_t i = 32; i + 3 <= 68 && std::ssize(names) < count; i += 3) {
        std::string& name = names.emplace_back(columns(at.line, i, 3));
        if (name.size() == 3 && name[0] == ' ') name[0] = header_.default_letter();
      }
      at.next();
    } while (at.have && std::ssize(names) < count);
    return names;
  }

  struct Row {
    std::string_view line;
    std::size_t number = 0;
  };
  /// The lines of one satellite; nullopt where the file or the epoch ends before them.
  std::vector<Row> rows_2(Cursor& at) const {
    const std::size_t count = (header_.values_of_version_2() + 4) / 5;
    std::vector<Row> rows;
    for (; rows.size() < count && at.have && !epoch_line(at.line); at.next())
      rows.push_back({at.line, at.number()});
    if (rows.size() < count) rows.clear();
    return rows;
  }

  void finish(const EpochLine& epoch, ObservationEpoch&& result, int found, std::size_t began) {
    if (epoch.flag == 1)  // after a power failure
      for (SatelliteObservation& o : result.satellites) o.phase_interrupted = true;
    if (found < epoch.count)
      report(began, "the epoch has " + std::to_string(found) + " of " +
                        std::to_string(epoch.count) + " satellites");
    file_.epochs.push_back(std::move(result));
  }

  /// A value's fourteen columns and its loss-of-lock indicator, with the number of their line.
  struct Field {
    std::string_view text;
    std::size_t line = 0;
  };

  /// Adds the satellite's observation with the values of `field(place)` to the epoch.
  template <class FieldAt>
  void satellite(std::string_view name, std::size_t line, ObservationEpoch& epoch,
                 const FieldAt& field) {
    SatelliteObservation o;
    if (const auto satellite = parse_satellite(name)) {
      if (observe(*satellite, field, o)) epoch.satellites.push_back(o);
    } else if (!name.empty() && std::string_view("JSI").find(name[0]) != name.npos) {
      ++file_.other_satellites;
    } else {
      report(line, "not a satellite: '" + text::printable(name) + "'");
    }
  }

  /// The first requested signal with a code measurement.
  template <class FieldAt>
  bool observe(SatelliteId satellite, const FieldAt& field, SatelliteObservation& o) {
    const auto at = [&](int place) {
      if (place < 0) return kNone;
      const Field f = field(static_cast<std::size_t>(place));
      return value_at(columns(f.text, 0, 14), f.line);
    };
    for (const rinex::SignalPlaces& p : header_.places(satellite.system)) {
      const double code = at(p.code);
      if (std::isnan(code)) continue;
      o.satellite = satellite;
      o.pseudorange_m = code;
      o.doppler_hz = at(p.doppler);
      o.carrier_cycles = at(p.phase);
      o.phase_interrupted =
          p.phase >= 0 && lock_lost(field(static_cast<std::size_t>(p.phase)).text);
      o.cn0_dbhz = at(p.strength);
      const auto channel = file_.glonass_channels.find(satellite);
      o.carrier_hz = carrier_hz(satellite.system, p.band,
                                channel == file_.glonass_channels.end() ? 0 : channel->second)
                         .value_or(kNone);
      return true;
    }
    ++file_.no_signal;
    return false;
  }

  /// A field of fourteen columns with three decimals; NaN where it is blank, zero or damaged. A
  /// truncated field would read as another number, so all fourteen are required.
  double value_at(std::string_view text, std::size_t line) {
    if (rinex::is_blank(text)) return kNone;
    double value = 0.0;
    const bool whole = text.size() == 14 && text[10] == '.';
    if (!whole || !text::to_number(rinex::trimmed(text), value) || !std::isfinite(value)) {
      report(line, "not a value with three decimals: '" + text::printable(text) + "'");
      return kNone;
    }
    return value == 0.0 ? kNone : value;
  }

  /// Loss-of-lock indicator: bit 0 lock lost since the epoch before, bit 1 half cycles unknown.
  static bool lock_lost(std::string_view text) {
    const std::string_view indicator = columns(text, 14, 1);
    return !indicator.empty() && indicator[0] >= '1' && indicator[0] <= '7' &&
           ((indicator[0] - '0') & 3) != 0;
  }

  void report(std::size_t line, std::string message) {
    file_.problems.add(Error{ErrorCode::parse, std::move(message), source_, line});
  }

  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  rinex::ObservationHeader& header_;
  const std::string& source_;
  const RinexOptions& options_;
  RinexObservations& file_;
};

bool read_header(rinex::ObservationHeader& header, Cursor& at) {
  for (at.next(); at.have; at.next()) {
    if (label(at.line) == "END OF HEADER") return at.next(), header.finish(), true;
    header.take(at.line, at.number());
  }
  return false;
}

}  // namespace

SignalPreference default_signals() {
  return {{{"1C", "1W", "1P", "1X", "1L", "1S", "1Y"},
           {"1C", "1P"},
           {"1C", "1X", "1B", "1Z", "1A"},
           {"2I", "1I", "2X", "2Q"}}};
}

Result<RinexObservations> parse_rinex_observations(std::string_view text, const std::string& source,
                                                   const RinexOptions& options) {
  Cursor at{text::Lines(text)};
  at.next();
  const Result<rinex::FirstLine> first = rinex::first_line(at.line, source);
  if (!first) return first.error();
  if (first->type != 'O')
    return Error{ErrorCode::parse, "is not a RINEX observation file", source, 1};
  RinexObservations file;
  file.problems = Problems(options.max_problems);
  file.version = first->version;
  rinex::ObservationHeader header(*first, source, options, file);
  if (!read_header(header, at))
    return Error{ErrorCode::parse, "the header has no end ('END OF HEADER')", source};
  EpochReader(header, source, options, file).read(at);
  file.lines = at.number();
  if (file.epochs.empty()) return no_content("epoch", source, file.problems);
  return file;
}

Result<RinexObservations> read_rinex_observations(const std::string& path,
                                                  const RinexOptions& options) {
  return read_and_parse(path, options.file, parse_rinex_observations, options);
}

}  // namespace wayfare::io
