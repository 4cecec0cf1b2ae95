// Streams of GNSS receivers: UBX and NMEA 0183.

#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>

#include <wayfare/decode/nmea.hpp>
#include <wayfare/decode/ubx_messages.hpp>
#include <wayfare/gnss/gps_time.hpp>
#include <wayfare/io/text_file.hpp>

#include "tables.hpp"

namespace wayfare::examples {

namespace {

constexpr std::string_view kUbxNames =
    "message,kind,t_s,utc,fix,satellites,lat_deg,lon_deg,h_m,vn_mps,ve_mps,vd_mps,sh_m,sv_h_m,"
    "sspeed_mps,gnss,satellite,signal,range_m,carrier_cycles,doppler_hz,cn0_dbhz,range_sigma_m,"
    "doppler_sigma_hz,lock_s,valid,words";
constexpr int kPvtFields = 12, kRawFields = 11;

const char* name_of(decode::UbxGnss gnss) {
  constexpr std::array kNames = {"GPS", "SBAS", "Galileo", "BeiDou",
                                 "?",   "QZSS", "GLONASS", "NavIC"};
  const auto i = static_cast<std::size_t>(gnss);
  return i < kNames.size() ? kNames.at(i) : "?";
}

template <class... Numbers>
std::string formatted(const char* format, Numbers... numbers) {
  std::array<char, 80> text{};
  std::snprintf(text.data(), text.size(), format, numbers...);
  return text.data();
}

void add(Csv& csv, const decode::UbxPvt& p) {
  csv.empty();  // the week is not in the message
  p.date_valid&& p.time_valid ? csv.field(formatted("%04d-%02d-%02dT%02d:%02d:%02dZ", p.year,
                                                    p.month, p.day, p.hour, p.minute, p.second))
                              : csv.empty();
  csv.field(p.fix_ok ? p.fix_type : 0).field(p.satellites);
  csv.field(p.latitude_deg).field(p.longitude_deg).field(p.height_m);
  for (const double v : p.velocity_ned_mps) csv.field(v);
  csv.field(p.horizontal_sigma_m).field(p.vertical_sigma_m).field(p.speed_sigma_mps);
  csv.empty(kRawFields + 1);
}

void add(Csv& csv, const decode::UbxMeasurement& m) {
  csv.empty(kPvtFields).field(name_of(m.gnss)).field(m.satellite).field(m.signal);
  csv.field(m.pseudorange_m);
  m.carrier_phase_valid ? csv.field(m.carrier_phase_cycles) : csv.empty();
  csv.field(m.doppler_hz).field(m.cn0_db_hz).field(m.pseudorange_sigma_m);
  csv.field(m.doppler_sigma_hz).field(m.lock_time_s).field(m.pseudorange_valid ? 1 : 0).empty();
}

void add(Csv& csv, const decode::UbxSubframe& f) {
  csv.empty(kPvtFields + 1).field(name_of(f.gnss())).field(f.satellite()).field(f.signal());
  csv.empty(kRawFields - 3);
  std::string words;
  for (std::size_t i = 0; i < f.size(); ++i)
    words += (words.empty() ? "" : " ") + formatted("%08X", f.word(i));
  csv.field(words);
}

std::string counts_of(const std::map<std::string, std::size_t>& kinds, const char* what) {
  std::size_t all = 0;
  std::string list;
  for (const auto& [kind, count] : kinds) {
    all += count;
    list += (list.empty() ? ": " : ", ") + std::to_string(count) + ' ' + kind;
  }
  return std::to_string(all) + ' ' + what + list;
}

std::string kind_of(decode::UbxId id) {
  switch (id) {
    case decode::UbxId::nav_pvt:
      return "NAV-PVT";
    case decode::UbxId::rxm_rawx:
      return "RXM-RAWX";
    case decode::UbxId::rxm_sfrbx:
      return "RXM-SFRBX";
    default:
      return formatted("%02X-%02X", static_cast<unsigned>(id) >> 8U,
                       static_cast<unsigned>(id) & 0xFFU);
  }
}

void add_epoch(Csv& csv, std::size_t message, const decode::UbxRawx& raw) {
  const decode::UbxRawxEpoch epoch = raw.epoch();
  const Duration time = gps_time(epoch.week, from_seconds(epoch.time_of_week_s)).since_epoch();
  const std::string t = io::format_nanoseconds(time.count());
  for (std::size_t i = 0; i < raw.size(); ++i)
    add(csv.row().field(message).field("RXM-RAWX").field(t), raw.measurement(i));
}

void add(Csv& csv, const std::optional<double>& value) { value ? csv.field(*value) : csv.empty(); }

std::string clock_of(double time_of_day_s) {
  const auto ms = static_cast<int>(std::lround(time_of_day_s * 1e3));
  return formatted("%02d:%02d:%06.3f", ms / 3600000, ms / 60000 % 60, ms % 60000 / 1e3);
}

}  // namespace

Table ubx_table(decode::Bytes capture) {
  Csv csv(kUbxNames);
  std::map<std::string, std::size_t> kinds;
  std::size_t message = 0;
  const auto statistics = decode_all<decode::UbxDecoder>(capture, [&](const decode::UbxMessage& m) {
    ++message;
    ++kinds[kind_of(m.id())];
    if (const auto pvt = decode::nav_pvt(m)) add(csv.row().field(message).field("NAV-PVT"), *pvt);
    if (const auto raw = decode::rxm_rawx(m)) add_epoch(csv, message, *raw);
    if (const auto f = decode::rxm_sfrbx(m)) add(csv.row().field(message).field("RXM-SFRBX"), *f);
  });
  return {std::move(csv).take(), statistics, counts_of(kinds, "messages")};
}

Table nmea_table(decode::Bytes capture) {
  Csv csv(
      "sentence,kind,utc_date,utc_clock,quality,satellites,hdop,lat_deg,lon_deg,h_sea_m,geoid_m,"
      "speed_mps,course_deg");
  std::map<std::string, std::size_t> kinds;
  std::size_t index = 0;
  const auto take = [&](const decode::NmeaSentence& s) {
    ++index;
    const std::string kind = std::string(s.talker()) + std::string(s.type());
    ++kinds[kind];
    if (const auto fix = decode::nmea_gga(s)) {
      csv.row().field(index).field(kind).empty().field(clock_of(fix->time_of_day_s));
      csv.field(fix->quality).field(fix->satellites);
      add(csv, fix->hdop);
      csv.field(fix->latitude_deg).field(fix->longitude_deg);
      add(csv, fix->height_above_sea_m);
      add(csv, fix->geoid_m);
      csv.empty(2);
    }
    if (const auto motion = decode::nmea_rmc(s)) {
      csv.row().field(index).field(kind);
      csv.field(formatted("%04d-%02d-%02d", motion->year, motion->month, motion->day));
      csv.field(clock_of(motion->time_of_day_s)).field(motion->valid ? 1 : 0).empty(2);
      csv.field(motion->latitude_deg).field(motion->longitude_deg).empty(2);
      add(csv, motion->speed_mps);
      add(csv, motion->course_deg);
    }
  };
  const auto statistics = decode_all<decode::NmeaDecoder>(capture, take);
  return {std::move(csv).take(), statistics, counts_of(kinds, "sentences")};
}

}  // namespace wayfare::examples
