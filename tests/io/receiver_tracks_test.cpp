// Fixes and tracks of receivers' streams, GPX and KML.

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include <wayfare/core/geodesy.hpp>
#include <wayfare/gnss/gps_time.hpp>
#include <wayfare/io/nav_text.hpp>
#include <wayfare/io/track_formats.hpp>

#include "decode/captures.hpp"
#include "decode/ubx_streams.hpp"

namespace wayfare::io {
namespace {

using decode::UbxBytes;
using ::testing::HasSubstr;

/// A drive over midnight of the end of a year, on which UTC is 18 s behind GPS time.
NavTrajectory sample_track() {
  NavTrajectory track(40);
  const LogTime start = log_time(*gps_from_civil({2021, 12, 31, 23, 59, from_seconds(48.0)})) +
                        std::chrono::seconds(18);
  const Geodetic origin{Angle::degrees(-45.4215296), Angle::degrees(-75.6971931), 72.5};
  for (std::size_t i = 0; i < track.size(); ++i) {
    const double t = 0.5 * static_cast<double>(i);
    track[i].time = start + from_seconds(t);
    track[i].position = geodetic_from_ned({12.0 * t, 100.0 * std::sin(0.1 * t), -0.5 * t}, origin);
    track[i].velocity_ned_mps = {12.0, 10.0 * std::cos(0.1 * t), -0.5};
  }
  return track;
}

std::vector<GnssFix> fixes_of(const NavTrajectory& track) {
  std::vector<GnssFix> fixes;
  for (const NavState& s : track) {
    GnssFix fix;
    fix.time = s.time;
    fix.position = s.position;
    fix.velocity_ned_mps = s.velocity_ned_mps;
    fix.position_covariance_ned_m2 << 4.0, 0.5, -0.6, 0.5, 2.25, 0.7, -0.6, 0.7, 9.0;
    fixes.push_back(fix);
  }
  return fixes;
}

void expect_same_track(const std::string& text, double position_m, double velocity_mps) {
  const NavTrajectory track = sample_track();
  const auto nav = parse_nav(text, "track");
  const auto fixes = parse_fixes(text, "track");
  ASSERT_TRUE(nav) << nav.error().to_string();
  ASSERT_TRUE(fixes) << fixes.error().to_string();
  EXPECT_TRUE(nav->problems.empty());
  ASSERT_EQ(nav->trajectory.size(), track.size());
  ASSERT_EQ(fixes->fixes.size(), track.size());
  EXPECT_EQ(nav->has_velocity, velocity_mps > 0.0);
  for (std::size_t i = 0; i < track.size(); ++i) {
    EXPECT_EQ(nav->trajectory[i].time, track[i].time) << i;
    EXPECT_EQ(fixes->fixes[i].time, track[i].time);
    EXPECT_LT(ned_from_geodetic(nav->trajectory[i].position, track[i].position).norm(), position_m);
    if (velocity_mps > 0.0) {
      const Eigen::Vector3d d = nav->trajectory[i].velocity_ned_mps - track[i].velocity_ned_mps;
      EXPECT_LT(d.norm(), velocity_mps) << i;
    }
  }
}

TEST(ReceiverTracks, EveryWriterReadsBack) {
  const NavTrajectory track = sample_track();
  const auto fixes = fixes_of(track);
  expect_same_track(format_gpx(track), 6e-4, 0.0);
  expect_same_track(format_nmea(track), 2e-3, 0.6);  // NMEA has no vertical speed
  expect_same_track(format_rtklib_pos(fixes), 2e-4, 1e-4);
  expect_same_track(format_rtklib_pos(fixes, {}, PosAxes::earth_fixed), 2e-4, 2e-4);
  const auto states = parse_nav(format_rtklib_pos(track, {}, PosAxes::earth_fixed), "x.pos");
  ASSERT_TRUE(states);
  EXPECT_EQ(states->trajectory.size(), track.size());
}

TEST(ReceiverTracks, CovariancesOfPosFilesReadBack) {
  const auto fixes = fixes_of(sample_track());
  for (const PosAxes axes : {PosAxes::geodetic, PosAxes::earth_fixed}) {
    const auto back = parse_fixes(format_rtklib_pos(fixes, {}, axes), "x.pos");
    ASSERT_TRUE(back) << back.error().to_string();
    EXPECT_EQ(back->qualities.front(), 5);
    // Four decimals of the roots: 2 · 3 m · 1e-4 m.
    EXPECT_LT(
        (back->fixes.front().position_covariance_ned_m2 - fixes.front().position_covariance_ned_m2)
            .cwiseAbs()
            .maxCoeff(),
        1e-3);
  }
}

TEST(ReceiverTracks, NmeaWithDateAfterTheFirstSentencesAndWithoutFix) {
  const auto file = parse_fixes(
      "$GPGGA,123518,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*46\r\n"  // no date yet
      "$GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W*6A\r\n"
      "$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\r\n"
      "$GPGGA,123520,4807.038,N,01131.000,E,0,08,0.9,545.4,M,46.9,M,,*4C\r\n"  // no fix
      "$GPGGA,123521,4807.038,N,01131.000,E,4,08,2.0,545.4,M,,M,,*57\r\n",     // no RMC, no geoid
      "x.nmea");
  ASSERT_TRUE(file) << file.error().to_string();
  ASSERT_EQ(file->fixes.size(), 2U);
  // 1994-03-23T12:35:19 UTC, 9 s behind GPS time then.
  EXPECT_EQ(file->fixes[0].time,
            log_time(*gps_from_civil({1994, 3, 23, 12, 35, from_seconds(28.0)})));
  EXPECT_DOUBLE_EQ(file->fixes[0].position.height_m, 545.4 + 46.9);
  EXPECT_NEAR(file->fixes[0].velocity_ned_mps->norm(), 22.4 * 1852.0 / 3600.0, 1e-9);
  EXPECT_EQ(file->qualities, (std::vector{5, 1}));
  EXPECT_DOUBLE_EQ(file->fixes[1].position.height_m, 545.4);
  EXPECT_FALSE(file->fixes[1].velocity_ned_mps);
  EXPECT_NEAR(file->fixes[1].position_covariance_ned_m2(2, 2), 0.06 * 0.06, 1e-12);
}

TEST(ReceiverTracks, StreamsWithoutAFixAreNamed) {
  const auto undated =
      parse_fixes("$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\r\n", "x");
  ASSERT_FALSE(undated);
  EXPECT_THAT(undated.error().to_string(), HasSubstr("1 GGA sentences without an RMC"));
  const UbxBytes pvt = decode::ubx(decode::UbxId::nav_pvt, UbxBytes(92));
  const auto none = parse_nav({reinterpret_cast<const char*>(pvt.data()), pvt.size()}, "x");
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().to_string(), HasSubstr("none of its 1 NAV-PVT messages"));
}

TEST(ReceiverTracks, XmlOfOtherPrograms) {
  const auto gpx = parse_fixes(
      "<?xml version='1.0'?>\n<gpx>\n<wpt lat='1' lon='2'/><trk><trkseg>\n"
      "<trkpt lon='9.25'\n lat=\"48.5\" ><ele> 250 </ele><time>2021-07-01T12:00:00+02:00</time>"
      "</trkpt>\n<trkpt lat='48.5' lon='9.26'><ele>1</ele></trkpt>\n"
      "<trkpt lat='98.5' lon='9.26'><time>2021-07-01T10:00:00Z</time></trkpt>"
      "<trkpt lat='48.5' "
      "lon='9.27'><time>2021-07-01T10:00:01.5Z</time></trkpt></trkseg></trk></gpx>",
      "x.gpx");
  ASSERT_TRUE(gpx) << gpx.error().to_string();
  ASSERT_EQ(gpx->fixes.size(), 2U);
  EXPECT_EQ(gpx->fixes[0].time, log_time(*gps_from_civil({2021, 7, 1, 10, 0, from_seconds(18.0)})));
  EXPECT_DOUBLE_EQ(gpx->fixes[0].position.height_m, 250.0);
  EXPECT_DOUBLE_EQ(gpx->fixes[0].position.longitude.degrees(), 9.25);
  ASSERT_EQ(gpx->problems.count(), 2U);
  EXPECT_THAT(gpx->problems.first()[0].to_string(), HasSubstr("x.gpx:6: the point has no time"));

  const auto kml = parse_nav(
      "<kml><gx:Track>\n<when>2021-07-01T10:00:00Z</when>\n<when>2021-07-01T10:00:01Z</when>\n"
      "<gx:coord>9.25 48.5 250</gx:coord>\n<gx:coord>9.26 48.5 251</gx:coord>\n</gx:Track></kml>",
      "x.kml");
  ASSERT_TRUE(kml) << kml.error().to_string();
  ASSERT_EQ(kml->trajectory.size(), 2U);
  EXPECT_DOUBLE_EQ(kml->trajectory[1].position.height_m, 251.0);

  EXPECT_THAT(parse_nav(format_kml(sample_track()), "x").error().to_string(),
              HasSubstr("KML line without times"));
  EXPECT_THAT(parse_nav("<?xml version='1.0'?><html/>", "x").error().to_string(),
              HasSubstr("neither GPX nor KML"));
  EXPECT_FALSE(parse_nav("<gpx><trkpt lat='1' lon='2'>", "x"));
}

/// The receiver's own fixes, and what another program made of them: positions in 1e-7 degrees, and
/// heights above the sea.
TEST(ReceiverTracks, RecordedNavPvt) {
  WAYFARE_NEEDS_RECORDING(ubx_path, "gnss/walk_0827/gnss_1730.ubx.gz");
  WAYFARE_NEEDS_RECORDING(pos_path, "gnss/walk_0827/gnss_1730_sf.pos");
  const auto ours = read_fixes(ubx_path), theirs = read_fixes(pos_path);
  ASSERT_TRUE(ours && theirs);
  ASSERT_EQ(ours->fixes.size(), 536U);
  ASSERT_EQ(theirs->fixes.size(), 536U);
  std::vector<double> geoids_m;
  const auto bytes = testing::file_bytes(ubx_path);
  const auto decoder = std::make_unique<decode::UbxDecoder>();
  decoder->feed(bytes, [&](const decode::UbxMessage& m) {
    if (const auto pvt = decode::nav_pvt(m))
      geoids_m.push_back(pvt->height_m - pvt->height_above_sea_m);
  });
  ASSERT_EQ(geoids_m.size(), 536U);
  for (std::size_t i = 0; i < ours->fixes.size(); ++i) {
    EXPECT_LE(std::abs(to_seconds(ours->fixes[i].time - theirs->fixes[i].time)), 1.1e-3);
    Geodetic other = theirs->fixes[i].position;
    other.height_m += geoids_m[i];
    const auto apart = ned_from_geodetic(ours->fixes[i].position, other);
    EXPECT_LT(apart.norm(), 0.02) << i;
    EXPECT_EQ(ours->qualities[i], theirs->qualities[i]);
  }
}

TEST(ReceiverTracks, RecordedBytesOfMixedMessages) {
  WAYFARE_NEEDS_RECORDING(mixed, "devices/ublox/pygpsdata-MIXED.log");
  const auto file = read_fixes(mixed);
  ASSERT_TRUE(file) << file.error().to_string();
  // 39 NAV-PVT messages have a valid checksum; the first has latitude 534506691, longitude
  // -22402964 (1e-7 degrees) and height 75699 mm at its bytes 28, 24 and 32.
  ASSERT_EQ(file->fixes.size(), 39U);
  const Geodetic& first = file->fixes.front().position;
  EXPECT_NEAR(first.latitude.degrees(), 53.4506691, 1e-10);
  EXPECT_NEAR(first.longitude.degrees(), -2.2402964, 1e-10);
  EXPECT_NEAR(first.height_m, 75.699, 1e-9);
}

/// Another XML parser, where there is one.
TEST(ReceiverTracks, XmlIsWellFormed) {
  if (std::system("python3 -c 'import xml.etree' 2>/dev/null") != 0)
    GTEST_SKIP() << "needs python3, as an independent parser of XML";
  const testing::TemporaryFolder folder;
  const TrackText text{"a <b> & \"c\" 'd' \x01\xff"};
  std::ofstream(folder / "a.gpx") << format_gpx(sample_track(), text);
  std::ofstream(folder / "a.kml") << format_kml(sample_track(), text);
  std::ofstream(folder / "check.py") << R"(
import sys, xml.etree.ElementTree as tree
gpx = tree.parse(sys.argv[1]).getroot()
g = '{http://www.topografix.com/GPX/1/1}'
assert gpx.tag == g + 'gpx' and gpx.get('version') == '1.1'
points = [(float(p.get('lon')), float(p.get('lat')), float(p.find(g + 'ele').text)) for p in gpx.iter(g + 'trkpt')]
times = [p.find(g + 'time').text for p in gpx.iter(g + 'trkpt')]
assert len(points) == 40 and times == sorted(times) and times[24] == '2022-01-01T00:00:00.000Z', times
kml = tree.parse(sys.argv[2]).getroot()
k = '{http://www.opengis.net/kml/2.2}'
line = [tuple(map(float, c.split(','))) for c in next(kml.iter(k + 'coordinates')).text.split()]
assert line == points
)";
  const std::string command = "python3 '" + (folder / "check.py") + "' '" + (folder / "a.gpx") +
                              "' '" + (folder / "a.kml") + "'";
  EXPECT_EQ(std::system(command.c_str()), 0);
}

}  // namespace
}  // namespace wayfare::io
