#include <wayfare/io/track_formats.hpp>

#include <cstdint>
#include <string>
#include <vector>

#include <wayfare/core/geodesy.hpp>
#include <wayfare/decode/nmea.hpp>
#include <wayfare/gnss/gps_time.hpp>
#include <wayfare/io/nav_text.hpp>

#include "support.hpp"

namespace wayfare::io {
namespace {

using ::testing::HasSubstr;

/// South and west, across the date line, minutes that round up to a whole degree, and the end of a
/// year, on which UTC is 18 s behind GPS time.
NavTrajectory sample_track() {
  NavTrajectory track(3);
  const auto gps = gps_from_civil({2021, 12, 31, 23, 59, from_seconds(59.75)});
  for (std::size_t i = 0; i < track.size(); ++i) {
    track[i].time = log_time(*gps) + std::chrono::seconds(18) +
                    static_cast<std::int64_t>(i) * std::chrono::milliseconds(500);
    track[i].velocity_ned_mps = {-1.5, -2.0, 0.25};
  }
  track[0].position = {Angle::degrees(-45.4215296), Angle::degrees(-75.6971931), 72.5};
  track[1].position = {Angle::degrees(48.9999999999), Angle::degrees(181.25), -3.0};
  track[2].position = {Angle::degrees(0.0), Angle::degrees(9.1), 0.0};
  return track;
}

TEST(TrackFormats, NmeaReadsBack) {
  const NavTrajectory track = sample_track();
  const std::string text = format_nmea(track);
  std::vector<decode::NmeaFix> fixes;
  std::vector<decode::NmeaMotion> motions;
  decode::NmeaDecoder decoder;
  const auto take = [&](const decode::NmeaSentence& s) {
    if (const auto fix = decode::nmea_gga(s)) fixes.push_back(*fix);
    if (const auto motion = decode::nmea_rmc(s)) motions.push_back(*motion);
  };
  decoder.feed({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, take);
  decoder.finish(take);
  ASSERT_EQ(fixes.size(), track.size());
  ASSERT_EQ(motions.size(), track.size());
  EXPECT_EQ(decoder.statistics().checksum_failures, 0U);
  for (std::size_t i = 0; i < track.size(); ++i) {
    const Geodetic back{Angle::degrees(fixes[i].latitude_deg),
                        Angle::degrees(fixes[i].longitude_deg),
                        fixes[i].height_above_sea_m.value() + fixes[i].geoid_m.value()};
    // A millionth of a minute is 1.9 mm.
    EXPECT_LT(ned_from_geodetic(back, track[i].position).norm(), 2e-3) << i;
    EXPECT_NEAR(motions[i].speed_mps.value(), 2.5, 3e-4);
    EXPECT_NEAR(motions[i].course_deg.value(), 233.13, 1e-9);  // atan2(−2, −1.5) + 360°
  }
  EXPECT_DOUBLE_EQ(motions[0].time_of_day_s, 86399.75);
  EXPECT_EQ(motions[0].year * 10000 + motions[0].month * 100 + motions[0].day, 20211231);
  EXPECT_DOUBLE_EQ(motions[1].time_of_day_s, 0.25);
  EXPECT_EQ(motions[1].year * 10000 + motions[1].month * 100 + motions[1].day, 20220101);
}

TEST(TrackFormats, RtklibPosReadsBack) {
  const NavTrajectory track = sample_track();
  const auto back = parse_nav(format_rtklib_pos(track), "track.pos");
  ASSERT_TRUE(back) << back.error().to_string();
  ASSERT_EQ(back->trajectory.size(), track.size());
  EXPECT_TRUE(back->problems.empty());
  for (std::size_t i = 0; i < track.size(); ++i) {
    EXPECT_EQ(back->trajectory[i].time, track[i].time);
    EXPECT_LT(ned_from_geodetic(back->trajectory[i].position, track[i].position).norm(), 2e-4);
    EXPECT_LT((back->trajectory[i].velocity_ned_mps - track[i].velocity_ned_mps).norm(), 1e-4);
  }
}

TEST(TrackFormats, KmlAndGpx) {
  const TrackText text{"drive <1> & \"2\"\x01", "test"};
  const std::string kml = format_kml(sample_track(), text), gpx = format_gpx(sample_track(), text);
  EXPECT_THAT(kml, HasSubstr("<name>drive &lt;1&gt; &amp; &quot;2&quot;\ufffd</name>"));
  EXPECT_THAT(kml, HasSubstr("-75.697193100,-45.421529600,72.500\n-178.750000000,"));
  EXPECT_THAT(gpx, HasSubstr("<trkpt lat=\"-45.421529600\" lon=\"-75.697193100\"><ele>72.500</ele>"
                             "<time>2021-12-31T23:59:59.750Z</time></trkpt>"));
  EXPECT_THAT(gpx, HasSubstr("<time>2022-01-01T00:00:00.250Z</time>"));
}

TEST(TrackFormats, AnEmptyTrackIsAnEmptyDocument) {
  EXPECT_EQ(format_nmea({}), "");
  EXPECT_THAT(format_gpx({}), HasSubstr("<trkseg>\n</trkseg>"));
  EXPECT_THAT(format_kml({}), HasSubstr("<coordinates>\n</coordinates>"));
}

}  // namespace
}  // namespace wayfare::io
