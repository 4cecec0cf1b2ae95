#pragma once

// Tracks on the Earth in the formats of other programs: KML (Google Earth), GPX (OpenStreetMap
// editors, hiking maps), NMEA 0183 (navigation programs), RTKLIB's .pos (RTKPLOT). Times are GPS
// time and become UTC where the format has UTC.

#include <span>
#include <string>

#include <wayfare/core/detail/eigen_alignment.hpp>
#include <wayfare/sensors/measurements.hpp>
#include <wayfare/sensors/trajectory.hpp>

namespace wayfare::io {

/// Texts in the file.
struct TrackText {
  std::string name = "track";       ///< shown by the other program
  std::string program = "wayfare";  ///< that wrote the track
};

/// KML 2.2: one line. Heights are above the ellipsoid, where KML expects the sea's: the line is
/// drawn on the ground.
[[nodiscard]] std::string format_kml(std::span<const NavState> track, const TrackText& text = {});

/// GPX 1.1: one segment with times in UTC and heights above the ellipsoid.
[[nodiscard]] std::string format_gpx(std::span<const NavState> track, const TrackText& text = {});

/// A GGA and an RMC sentence for each state, in UTC to 1 ms, with quality 1. The height of GGA is
/// above the ellipsoid, with a geoid separation of zero.
[[nodiscard]] std::string format_nmea(std::span<const NavState> track);

/// Coordinates of a .pos file.
enum class PosAxes {
  geodetic,     ///< latitude, longitude, height; north, east, up
  earth_fixed,  ///< x, y, z
};

/// RTKLIB's solution in GPS time to 1 ms: position, quality 5 (single), satellites 0, standard
/// deviations and signed roots of covariances, velocity (zero where it is not known) without its
/// deviations. read_fixes and read_nav read it back.
[[nodiscard]] std::string format_rtklib_pos(std::span<const GnssFix> fixes,
                                            const TrackText& text = {},
                                            PosAxes axes = PosAxes::geodetic);
/// The same of states, whose standard deviations are not known and written as zero: read_nav reads
/// it back, read_fixes does not.
[[nodiscard]] std::string format_rtklib_pos(std::span<const NavState> track,
                                            const TrackText& text = {},
                                            PosAxes axes = PosAxes::geodetic);

}  // namespace wayfare::io
