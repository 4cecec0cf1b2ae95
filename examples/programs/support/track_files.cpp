#include "track_files.hpp"

#include <filesystem>

#include <wayfare/io/text_file.hpp>

namespace wayfare::examples {
namespace {

std::string file_of(const std::string& format) {
  return format == "ecef" ? "track_ecef.pos" : "track." + format;
}

/// `solution` has what .pos files need: fixes or states.
template <class Solution>
Result<void> write_all(const OutputArguments& to, const TrackFormats& formats,
                       std::span<const NavState> track, const Solution& solution) {
  const std::string name = std::filesystem::path(to.out).lexically_normal().filename().string();
  const io::TrackText text{name.empty() ? "track" : name, "wayfare"};
  const auto content = [&](const std::string& format) {
    if (format == "kml") return io::format_kml(track, text);
    if (format == "gpx") return io::format_gpx(track, text);
    if (format == "nmea") return io::format_nmea(track);
    const bool ecef = format == "ecef";
    return io::format_rtklib_pos(solution, text,
                                 ecef ? io::PosAxes::earth_fixed : io::PosAxes::geodetic);
  };
  for (const std::string& format : formats.words)
    if (auto done = io::write_file(to.path(file_of(format)), content(format), to.write()); !done)
      return done;
  return {};
}

}  // namespace

void TrackFormats::add_option(CommandLine& app) {
  app.add_option("--track-formats", words,
                 "the track also as track.kml, track.gpx, track.nmea, track.pos (RTKLIB), or "
                 "track_ecef.pos (the same Earth-fixed): words separated by commas")
      .delimiter(',')
      .one_of({"kml", "gpx", "nmea", "pos", "ecef"});
}

std::vector<std::string> TrackFormats::with_files(std::vector<std::string> names) const {
  for (const std::string& format : words) names.push_back(file_of(format));
  return names;
}

Result<void> write_track_files(const OutputArguments& to, const TrackFormats& formats,
                               std::span<const GnssFix> fixes) {
  NavTrajectory track;
  for (const GnssFix& fix : fixes)
    track.push_back(
        {fix.time, fix.position, fix.velocity_ned_mps.value_or(Eigen::Vector3d::Zero()), {}});
  return write_all(to, formats, track, fixes);
}

Result<void> write_track_files(const OutputArguments& to, const TrackFormats& formats,
                               std::span<const NavState> track) {
  return write_all(to, formats, track, track);
}

}  // namespace wayfare::examples
