#include <wayfare/io/track_formats.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>

#include <wayfare/core/geodesy.hpp>
#include <wayfare/gnss/gps_time.hpp>
#include <wayfare/io/report.hpp>

#include "io/text/text.hpp"

namespace wayfare::io {
namespace {

/// Year … second of UTC, rounded to milliseconds.
struct UtcReading {
  CivilTime civil;
  int milliseconds = 0;  ///< of the minute
};

UtcReading utc_of(LogTime time) {
  constexpr Duration kHalf = std::chrono::microseconds(500);
  const Time<UtcClock> utc = to_utc(gps_time(time)) + kHalf;
  // The calendar of UTC is that of GPS where leap seconds do not count.
  const CivilTime civil = civil_from_gps(Time<GpsClock>() + utc.since_epoch());
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(civil.of_minute);
  return {civil, static_cast<int>(ms.count())};
}

/// With leading zeros.
std::string digits(int value, std::size_t width) {
  std::string text = std::to_string(value);
  return text.size() < width ? std::string(width - text.size(), '0') + text : text;
}

std::string seconds_of(const UtcReading& t) {
  return digits(t.milliseconds / 1000, 2) + '.' + digits(t.milliseconds % 1000, 3);
}

std::string iso_time(LogTime time) {
  const UtcReading t = utc_of(time);
  return digits(t.civil.year, 4) + '-' + digits(t.civil.month, 2) + '-' + digits(t.civil.day, 2) +
         'T' + digits(t.civil.hour, 2) + ':' + digits(t.civil.minute, 2) + ':' + seconds_of(t) +
         'Z';
}

/// ±180 degrees.
double longitude_deg(const NavState& s) {
  return std::remainder(s.position.longitude.degrees(), 360.0);
}

constexpr std::string_view kXml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";

std::string sentence(const std::string& content) {
  unsigned sum = 0;
  for (const char c : content) sum ^= static_cast<unsigned char>(c);
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  return "$" + content + "*" + kDigits[sum >> 4U] + kDigits[sum & 15U] + "\r\n";
}

/// ddmm.mmmmmm and the hemisphere: the minutes are rounded before they are separated, so that they
/// are never 60.
std::string nmea_angle(double degrees, std::size_t width, char positive, char negative) {
  constexpr std::int64_t kPerMinute = 1'000'000;
  const std::int64_t all = std::llround(std::abs(degrees) * 60.0 * double{kPerMinute});
  const std::int64_t whole = all / (60 * kPerMinute), rest = all % (60 * kPerMinute);
  return digits(static_cast<int>(whole), width) + digits(static_cast<int>(rest / kPerMinute), 2) +
         '.' + digits(static_cast<int>(rest % kPerMinute), 6) + ',' +
         (degrees < 0.0 ? negative : positive);
}

std::string nmea_position(const NavState& s) {
  return nmea_angle(s.position.latitude.degrees(), 2, 'N', 'S') + ',' +
         nmea_angle(longitude_deg(s), 3, 'E', 'W');
}

std::string nmea_clock(const UtcReading& t) {
  return digits(t.civil.hour, 2) + digits(t.civil.minute, 2) + seconds_of(t);
}

std::string rmc(const NavState& s) {
  constexpr double kKnot_mps = 1852.0 / 3600.0;
  const UtcReading t = utc_of(s.time);
  const double north = s.velocity_ned_mps.x(), east = s.velocity_ned_mps.y();
  const double course = std::fmod(Angle::radians(std::atan2(east, north)).degrees() + 360.0, 360.0);
  return sentence("GNRMC," + nmea_clock(t) + ",A," + nmea_position(s) + ',' +
                  text::fixed(std::hypot(north, east) / kKnot_mps, 3) + ',' +
                  text::fixed(course, 2) + ',' + digits(t.civil.day, 2) + digits(t.civil.month, 2) +
                  digits(t.civil.year % 100, 2) + ",,,A");
}

std::string gga(const NavState& s) {
  return sentence("GNGGA," + nmea_clock(utc_of(s.time)) + ',' + nmea_position(s) + ",1,,," +
                  text::fixed(s.position.height_m, 3) + ",M,0.0,M,,");
}

}  // namespace

std::string format_kml(std::span<const NavState> track, const TrackText& text) {
  std::string out(kXml);
  out += "<kml xmlns=\"http://www.opengis.net/kml/2.2\"><Document><name>" + escape_html(text.name) +
         "</name>\n<Style id=\"line\"><LineStyle><color>ff3333cc</color><width>3</width>"
         "</LineStyle></Style>\n<Placemark><name>" +
         escape_html(text.name) +
         "</name><styleUrl>#line</styleUrl><LineString><tessellate>1</tessellate><altitudeMode>"
         "clampToGround</altitudeMode><coordinates>\n";
  for (const NavState& s : track) {
    out += text::fixed(longitude_deg(s), 9) + ',' + text::fixed(s.position.latitude.degrees(), 9) +
           ',' + text::fixed(s.position.height_m, 3) + '\n';
  }
  return out += "</coordinates></LineString></Placemark></Document></kml>\n";
}

std::string format_gpx(std::span<const NavState> track, const TrackText& text) {
  std::string out(kXml);
  out += "<gpx version=\"1.1\" creator=\"" + escape_html(text.program) +
         "\" xmlns=\"http://www.topografix.com/GPX/1/1\">\n<trk><name>" + escape_html(text.name) +
         "</name><trkseg>\n";
  for (const NavState& s : track) {
    out += "<trkpt lat=\"" + text::fixed(s.position.latitude.degrees(), 9) + "\" lon=\"" +
           text::fixed(longitude_deg(s), 9) + "\"><ele>" + text::fixed(s.position.height_m, 3) +
           "</ele><time>" + iso_time(s.time) + "</time></trkpt>\n";
  }
  return out += "</trkseg></trk></gpx>\n";
}

std::string format_nmea(std::span<const NavState> track) {
  std::string out;
  for (const NavState& s : track) out += gga(s) + rmc(s);
  return out;
}

namespace {

std::string pos_heading(const TrackText& text, PosAxes axes) {
  std::string out = "% program   : " + text.program;
  if (axes == PosAxes::geodetic) {
    out +=
        "\n% (lat/lon/height=WGS84/ellipsoidal,Q=1:fix,2:float,3:sbas,4:dgps,5:single,"
        "6:ppp,ns=# of satellites)\n"
        "%  GPST latitude(deg) longitude(deg) height(m) Q ns sdn(m) sde(m) sdu(m) "
        "sdne(m) sdeu(m) sdun(m) age(s) ratio vn(m/s) ve(m/s) vu(m/s)\n";
  } else {
    out +=
        "\n% (x/y/z-ecef=WGS84,Q=1:fix,2:float,3:sbas,4:dgps,5:single,6:ppp,ns=# of satellites)\n"
        "%  GPST x-ecef(m) y-ecef(m) z-ecef(m) Q ns sdx(m) sdy(m) sdz(m) "
        "sdxy(m) sdyz(m) sdzx(m) age(s) ratio vx(m/s) vy(m/s) vz(m/s)\n";
  }
  return out;
}

std::string pos_time(LogTime time) {
  const CivilTime t = civil_from_gps(gps_time(time) + std::chrono::microseconds(500));
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(t.of_minute).count();
  return digits(t.year, 4) + '/' + digits(t.month, 2) + '/' + digits(t.day, 2) + ' ' +
         digits(t.hour, 2) + ':' + digits(t.minute, 2) + ':' +
         digits(static_cast<int>(ms / 1000), 2) + '.' + digits(static_cast<int>(ms % 1000), 3);
}

void append_fixed(std::string& out, double value, int decimals) {
  out += ' ';
  out += text::fixed(value, decimals);
}

std::string pos_position(const Geodetic& p, PosAxes axes) {
  std::string out;
  if (axes == PosAxes::geodetic) {
    append_fixed(out, p.latitude.degrees(), 9);
    append_fixed(out, std::remainder(p.longitude.degrees(), 360.0), 9);
    append_fixed(out, p.height_m, 4);
  } else {
    for (const double v : ecef_from_geodetic(p)) append_fixed(out, v, 4);
  }
  return out + " 5 0";
}

/// Standard deviations, none of which is zero, and signed roots of the covariances of axes 0 and 1,
/// 1 and 2, 2 and 0.
void append_deviations(std::string& out, const Eigen::Matrix3d& covariance) {
  for (Eigen::Index k = 0; k < 3; ++k)
    append_fixed(out, std::max(std::sqrt(covariance(k, k)), 1e-4), 4);
  for (Eigen::Index k = 0; k < 3; ++k) {
    const double v = covariance(k, (k + 1) % 3);
    append_fixed(out, std::copysign(std::sqrt(std::abs(v)), v), 4);
  }
}

/// From north, east, down to the axes of a .pos file.
Eigen::Matrix3d pos_rotation(const Geodetic& position, PosAxes axes) {
  if (axes == PosAxes::earth_fixed) return rotation_ecef_ned(position);
  return Eigen::Vector3d(1.0, 1.0, -1.0).asDiagonal();
}

}  // namespace

std::string format_rtklib_pos(std::span<const GnssFix> fixes, const TrackText& text, PosAxes axes) {
  std::string out = pos_heading(text, axes);
  for (const GnssFix& fix : fixes) {
    const Eigen::Matrix3d to_axes = pos_rotation(fix.position, axes);
    out += pos_time(fix.time) + pos_position(fix.position, axes);
    append_deviations(out, to_axes * fix.position_covariance_ned_m2 * to_axes.transpose());
    out += " 0 0";
    const Eigen::Vector3d v =
        to_axes * fix.velocity_ned_mps.value_or(Eigen::Vector3d::Zero().eval());
    for (const double component : v) append_fixed(out, component, 4);
    out += '\n';
  }
  return out;
}

std::string format_rtklib_pos(std::span<const NavState> track, const TrackText& text,
                              PosAxes axes) {
  std::string out = pos_heading(text, axes);
  for (const NavState& s : track) {
    out += pos_time(s.time) + pos_position(s.position, axes) + " 0 0 0 0 0 0 0 0";
    const Eigen::Vector3d v = pos_rotation(s.position, axes) * s.velocity_ned_mps;
    for (const double component : v) append_fixed(out, component, 4);
    out += '\n';
  }
  return out;
}

}  // namespace wayfare::io
