#include <string>
#include <utility>

#include <wayfare/nav/check_drive.hpp>

#include "nav_config.hpp"
#include "program_files.hpp"

namespace wayfare::examples {
namespace {

/// Other observations may bring their navigation messages.
bool is_rinex(const std::string& path) {
  if (path.empty()) return false;
  const auto file = io::read_file(path);
  return file && file->bytes.substr(0, 81).find("RINEX") != std::string::npos;
}

void apply(const NavConfig& config, GnssInsRecording& recording) {
  DriveEstimate factors;
  factors.gyro_factor = config.gyro_factor;
  factors.accel_factor = config.accel_factor;
  recording = corrected(std::move(recording), factors);
  recording.start = config.start;
  if (!config.start) return;
  recording.start->nav.time =
      config.start_time_s
          ? LogTime::from_seconds(*config.start_time_s)
          : recording.imu.front().time + from_seconds(config.filter.imu_time_offset_s);
}

}  // namespace

Result<io::NavRecording> load_nav_recording(const NavFiles& files, const NavConfig& config,
                                            const std::function<void(double)>& progress,
                                            bool apart) {
  if (files.observations.empty() && files.ranges.empty() && files.fixes.empty())
    return bad_use("satellite measurements are needed: --obs and --nav, --ranges, or --fixes");
  if (files.ranges.empty() && files.navigation.empty() && is_rinex(files.observations))
    return bad_use("raw observations need a navigation file (--nav)");
  const auto imu = [&](const std::string& path, const io::ColumnFormat& format) {
    return ros::read_imu(path, format, files.topics);
  };
  const auto fixes = [&](const std::string& path, const io::ColumnFormat& format) {
    return ros::read_fixes(path, format, files.topics);
  };
  auto loaded = io::read_nav_recording(
      files, config,
      {progress, print_problems, imu, fixes, apart, config.filter.imu_time_offset_s});
  if (loaded) apply(config, loaded->recording);
  return loaded;
}

}  // namespace wayfare::examples
