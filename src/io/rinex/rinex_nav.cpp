#include <algorithm>
#include <array>
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

constexpr double kBlank = std::numeric_limits<double>::quiet_NaN();

/// The numbers of a message: clock line and up to seven lines of four. A blank field is NaN.
struct Record {
  char letter = 'G';
  std::optional<SatelliteId> satellite;
  CivilTime epoch;
  std::size_t line = 0;
  std::array<double, 31> v;  ///< v[0..2] of the first line, then four a line
};

/// Spare numbers, and those that some writers leave blank, are zero.
double or_zero(double value) { return std::isnan(value) ? 0.0 : value; }

Duration seconds(double s) { return from_seconds(std::clamp(s, -1e9, 1e9)); }

int to_int(double value) {
  return std::isfinite(value) ? static_cast<int>(std::clamp(value, -1e9, 1e9)) : 0;
}

class NavigationReader {
 public:
  NavigationReader(std::string source, const RinexOptions& options)
      : source_(std::move(source)), options_(options) {
    nav_.problems = Problems(options.max_problems);
  }

  Result<RinexNavigation> read(std::string_view all) {
    text::Lines lines(all);
    std::string_view line;
    lines.next(line);
    const Result<rinex::FirstLine> first = rinex::first_line(line, source_);
    if (!first) return first.error();
    nav_.version = first->version;
    version2_ = first->version < 3.0;
    all_beidou_ = first->system == 'C';
    // RINEX 2 has files of type N (GPS), G (GLONASS) and E (Galileo, in use though not standard).
    if (first->type != 'N' && !(version2_ && (first->type == 'G' || first->type == 'E')))
      return Error{ErrorCode::parse, "is not a RINEX navigation file", source_, 1};
    letter2_ = first->type == 'G' ? 'R' : first->type == 'E' ? 'E' : 'G';
    if (!read_header(lines))
      return Error{ErrorCode::parse, "the header has no end ('END OF HEADER')", source_};
    read_messages(lines);
    nav_.lines = lines.number();
    return std::move(nav_);
  }

 private:
  bool read_header(text::Lines& lines) {
    for (std::string_view line; lines.next(line);) {
      const std::string_view name = label(line);
      if (name == "END OF HEADER") return true;
      if (name == "LEAP SECONDS") {
        int leaps = 0;
        // BeiDou's leap seconds, so marked or in a BeiDou-only file, are 14 s less.
        if (rinex::field(line, 0, 6, leaps)) {
          const bool beidou = columns(line, 24, 3) == "BDS" || (all_beidou_ && leaps < 14);
          nav_.ephemerides.leap_seconds = leaps + (beidou ? 14 : 0);
        }
      }
      if (name == "ION ALPHA") klobuchar("GPSA", line, 2);
      if (name == "ION BETA") klobuchar("GPSB", line, 2);
      if (name == "IONOSPHERIC CORR") klobuchar(columns(line, 0, 4), line, 5);
    }
    return false;
  }

  void klobuchar(std::string_view which, std::string_view line, std::size_t begin) {
    if (which != "GPSA" && which != "GPSB" && which != "BDSA" && which != "BDSB") return;
    const bool beidou = which[0] == 'B';
    auto& model = beidou ? nav_.ephemerides.beidou_ionosphere : nav_.ephemerides.gps_ionosphere;
    std::array<double, 4> values{};
    for (std::size_t i = 0; i < 4; ++i) {
      const auto value = rinex::fortran_number(columns(line, begin + 12 * i, 12));
      if (!value) return;  // both halves of the model are required
      values[i] = *value;
    }
    if (!model) model.emplace();
    if (beidou) model->carrier_hz = carrier::kB1I;
    (which[3] == 'A' ? model->alpha : model->beta) = values;
  }

  [[nodiscard]] bool starts_message(std::string_view line) const {
    const std::size_t id = version2_ ? 2 : 3;
    if (line.size() < id + 19) return false;
    if (!version2_ && (line[0] < 'A' || line[0] > 'Z')) return false;
    const char unit = line[id - 1];
    if (unit < '0' || unit > '9') return false;
    return rinex::civil_time(columns(line, id, 20)).has_value();
  }

  static std::size_t lines_of(char letter, double version) {
    if (letter == 'R') return version >= 3.05 ? 4 : 3;
    return letter == 'S' ? 3 : 7;
  }

  void read_messages(text::Lines& lines) {
    std::string_view line;
    bool have = lines.next(line), was_lost = false;
    while (have) {
      if (!starts_message(line)) {
        if (!was_lost && !rinex::is_blank(line))
          report(lines.number(), "not the beginning of a message; skipped up to the next");
        was_lost = was_lost || !rinex::is_blank(line);
        have = lines.next(line);
        continue;
      }
      was_lost = false;
      Record record;
      record.line = lines.number();
      bool whole = begin_record(line, record);
      const std::size_t indent = version2_ ? 3 : 4;
      have = lines.next(line);
      for (std::size_t k = 0; k < lines_of(record.letter, nav_.version); ++k) {
        // The first line of the next message ends an incomplete one. GLONASS may lack the fourth
        // line even in versions that have it.
        if (!have || starts_message(line)) {
          whole = whole && record.letter == 'R' && k >= 3;
          if (!whole) report(record.line, "the message is cut short");
          break;
        }
        for (std::size_t i = 0; i < 4; ++i)
          if (!number(columns(line, indent + 19 * i, 19), lines.number(), record.v[3 + 4 * k + i]))
            whole = false;
        have = lines.next(line);
      }
      if (whole) take(record);
    }
  }

  bool begin_record(std::string_view line, Record& record) {
    record.v.fill(kBlank);
    const std::size_t id = version2_ ? 2 : 3;
    record.letter = version2_ ? letter2_ : line[0];
    std::string name(columns(line, 0, id));
    if (version2_) name.insert(name.begin(), letter2_);
    record.satellite = parse_satellite(name);
    record.epoch = *rinex::civil_time(columns(line, id, 20));
    for (std::size_t i = 0; i < 3; ++i)
      if (!number(columns(line, id + 20 + 19 * i, 19), record.line, record.v[i])) return false;
    return true;
  }

  /// Leaves `value` where the field is blank; reports any other that is not a number.
  bool number(std::string_view text, std::size_t line, double& value) {
    const auto read = rinex::fortran_number(text);
    if (!read && !rinex::is_blank(text)) {
      report(line, "not a number: '" + text::printable(text) + "'");
      return false;
    }
    value = read.value_or(value);
    return true;
  }

  void take(const Record& record) {
    if (!record.satellite) {
      ++nav_.other_messages;
      return;
    }
    const GnssSystem system = record.satellite->system;
    const auto scale = system == GnssSystem::glonass  ? rinex::TimeScale::utc
                       : system == GnssSystem::beidou ? rinex::TimeScale::beidou
                                                      : rinex::TimeScale::gps;
    const auto toc = rinex::gps_from(record.epoch, scale, options_.leap_seconds);
    if (!toc) return report(record.line, "the date does not exist");
    if (system == GnssSystem::glonass) return add(record, glonass(record, *toc));
    const KeplerianEphemeris k = keplerian(record, *toc);
    if (const std::string fault = wrong_time(record, k); !fault.empty())
      return report(record.line, to_string(k.satellite) + ": " + fault);
    add(record, k);
  }

  void add(const Record& record, const Ephemeris& ephemeris) {
    const Result<void> added = nav_.ephemerides.add(ephemeris);
    if (!added) return report(record.line, added.error().message);
    ++nav_.messages;
  }

  static GlonassEphemeris glonass(const Record& r, Time<GpsClock> toe) {
    GlonassEphemeris g;
    g.satellite = *r.satellite;
    g.toe = toe;
    g.clock_bias_s = r.v[0];
    g.clock_drift = r.v[1];
    g.position_m = 1e3 * Eigen::Vector3d(r.v[3], r.v[7], r.v[11]);
    g.velocity_mps = 1e3 * Eigen::Vector3d(r.v[4], r.v[8], r.v[12]);
    g.acceleration_mps2 = 1e3 * Eigen::Vector3d(r.v[5], r.v[9], r.v[13]);
    g.health = to_int(or_zero(r.v[6]));
    g.channel = to_int(or_zero(r.v[10]));
    if (g.channel > 128) g.channel -= 256;  // some writers write the byte as unsigned
    g.age_days = to_int(or_zero(r.v[14]));
    // 999999999999 means unknown.
    const double between = or_zero(r.v[16]);
    g.l2_minus_l1_s = std::abs(between) < 1e-3 ? between : 0.0;
    return g;
  }

  static KeplerianEphemeris keplerian(const Record& r, Time<GpsClock> toc) {
    KeplerianEphemeris k;
    const bool beidou = r.satellite->system == GnssSystem::beidou;
    const bool galileo = r.satellite->system == GnssSystem::galileo;
    const Duration ahead = beidou ? kGpsMinusBeidou : Duration(0);
    k.satellite = *r.satellite;
    k.toc = toc;
    k.toe = nearest_time_of_week(seconds(or_zero(r.v[11])), toc - ahead) + ahead;
    k.clock_bias_s = r.v[0], k.clock_drift = r.v[1], k.clock_drift_rate_per_s = r.v[2];
    k.issue = to_int(r.v[3]);
    k.crs_m = r.v[4], k.mean_motion_difference_radps = r.v[5], k.mean_anomaly_rad = r.v[6];
    k.cuc_rad = r.v[7], k.eccentricity = r.v[8], k.cus_rad = r.v[9];
    k.sqrt_semi_major_axis = r.v[10];
    k.cic_rad = r.v[12], k.ascending_node_rad = r.v[13], k.cis_rad = r.v[14];
    k.inclination_rad = r.v[15], k.crc_m = r.v[16], k.argument_of_perigee_rad = r.v[17];
    k.ascending_node_rate_radps = r.v[18];
    k.inclination_rate_radps = r.v[19];
    // The low byte distinguishes I/NAV from F/NAV in messages without the clock's bits.
    const int source = to_int(r.v[20]);
    k.clock_of_e5a = galileo && ((source & 0x100) != 0 || ((source & 0x200) == 0 && source == 2));
    k.accuracy_m = std::isfinite(r.v[23]) && r.v[23] > 0.0 ? r.v[23] : 2.0;
    k.health = to_int(or_zero(r.v[24]));
    k.group_delay_s[0] = or_zero(r.v[25]);
    k.group_delay_s[1] = galileo || beidou ? or_zero(r.v[26]) : 0.0;
    return k;
  }

  /// Checks week and time of week against the date of the clock. The week may lack its roll-overs,
  /// and may differ by one where orbit and clock are on either side of midnight on Saturday.
  static std::string wrong_time(const Record& r, const KeplerianEphemeris& k) {
    const double of_week = r.v[11];
    if (!(of_week >= 0.0 && of_week <= 604800.0)) return "the time of week is missing or wrong";
    const Duration apart = k.toe - k.toc;
    if (apart > std::chrono::hours(24) || apart < -std::chrono::hours(24))
      return "the orbit's time of week is not near the clock's date";
    if (std::isnan(r.v[21])) return {};
    const bool beidou = k.satellite.system == GnssSystem::beidou;
    const int week = to_int(r.v[21]) + (beidou ? kBeidouWeekZero : 0);
    const int unrolled = beidou ? week : unrolled_week(week, k.toe);
    const int off = unrolled - week_time(beidou ? k.toe - kGpsMinusBeidou : k.toe).week;
    if (off >= -1 && off <= 1) return {};
    return "week " + std::to_string(to_int(r.v[21])) + " is inconsistent with the clock's date";
  }

  void report(std::size_t line, std::string message) {
    nav_.problems.add(Error{ErrorCode::parse, std::move(message), source_, line});
  }

  std::string source_;
  const RinexOptions& options_;
  RinexNavigation nav_;
  bool version2_ = false;
  bool all_beidou_ = false;
  char letter2_ = 'G';
};

}  // namespace

Result<RinexNavigation> parse_rinex_navigation(std::string_view text, const std::string& source,
                                               const RinexOptions& options) {
  return NavigationReader(source, options).read(text);
}

Result<RinexNavigation> read_rinex_navigation(const std::string& path,
                                              const RinexOptions& options) {
  return read_and_parse(path, options.file, parse_rinex_navigation, options);
}

}  // namespace wayfare::io
