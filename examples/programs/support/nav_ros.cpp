#include "nav_ros.hpp"

#include <utility>

namespace wayfare::examples {
namespace {

Result<ros::VehicleRun> read_ros(const std::string& path, const ros::TopicNames& topics) {
  const auto file = ros::RecordingFile::open(path);
  if (!file) return file.error();
  return ros::read_vehicle(*file, topics);
}

}  // namespace

Result<io::ImuFile> read_unit(const std::string& path, const io::ColumnFormat& format,
                              const ros::TopicNames& topics) {
  if (!ros::RecordingFile::is_one(path)) return io::read_imu(path, format);
  auto run = read_ros(path, topics);
  if (!run) return run.error();
  if (run->imu.empty()) return Error{ErrorCode::not_found, "contains no inertial unit", path};
  io::ImuFile file;
  file.samples = std::move(run->imu);
  file.has_gyro = file.has_accelerometer = true;
  file.problems = std::move(run->problems);
  return file;
}

Result<io::FixFile> read_receiver(const std::string& path, const io::ColumnFormat& format,
                                  const ros::TopicNames& topics) {
  if (!ros::RecordingFile::is_one(path)) return io::read_fixes(path, format);
  auto run = read_ros(path, topics);
  if (!run) return run.error();
  if (run->fixes.empty()) return Error{ErrorCode::not_found, "contains no fixes", path};
  io::FixFile file;
  file.qualities.assign(run->fixes.size(), 0);
  file.fixes = std::move(run->fixes);
  file.problems = std::move(run->problems);
  return file;
}

}  // namespace wayfare::examples
