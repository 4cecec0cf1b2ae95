#include <algorithm>
#include <utility>

#include <wayfare/ros/recording.hpp>

#include "ros/recording/lanes.hpp"
#include "ros/recording/layout.hpp"

namespace wayfare::ros {

Result<MargRun> read_marg(const RecordingFile& file, const TopicNames& names) {
  const auto imu = choose_topic(file, Imu::kType.name, names.imu, "inertial unit");
  if (!imu) return imu.error();
  if (imu->empty())
    return Error{ErrorCode::not_found, "has no inertial unit (sensor_msgs/Imu)", file.path()};
  const auto magnetometer =
      choose_topic(file, MagneticField::kType.name, names.magnetometer, "magnetometer");
  if (!magnetometer) return magnetometer.error();
  MargRun run;
  run.problems = file.problems();
  run.topic = *imu;
  MargRecording fields;
  Layout layout;
  std::optional<std::string> frame;
  Lanes lanes(file, names);
  lanes.add<Imu>(*imu, run.samples, [&frame](const Imu& m, LogTime time) -> Result<MargSample> {
    if (!frame) frame = frame_of(m.header);
    const auto sample = imu_of(m, time);
    if (!sample) return sample.error();
    return MargSample{time, sample->angular_rate_radps, sample->specific_force_mps2};
  });
  lanes.add<MagneticField>(*magnetometer, fields,
                           [](const MagneticField& m, LogTime time) -> Result<MargSample> {
                             MargSample sample{time};
                             sample.magnetic_field_uT = field_uT_of(m);
                             return sample;
                           });
  layout.listen(lanes, file, run.problems);
  if (auto done = lanes.run(run.problems); !done) return done.error();
  run.q_base_unit = rotation_of(layout.tree, layout.base_frame(names), frame.value_or(""));
  // A magnetometer sample with the same stamp as one of the unit is merged with it.
  const auto units = run.samples.size();
  std::size_t i = 0;
  for (const MargSample& field : fields) {
    while (i < units && run.samples[i].time < field.time) ++i;
    if (i < units && run.samples[i].time == field.time) {
      run.samples[i].magnetic_field_uT = field.magnetic_field_uT;
    } else {
      run.samples.push_back(field);
    }
  }
  std::stable_sort(run.samples.begin(), run.samples.end(),
                   [](const MargSample& a, const MargSample& b) { return a.time < b.time; });
  return run;
}

Result<VehicleRun> read_vehicle(const RecordingFile& file, const TopicNames& names) {
  const auto imu = choose_topic(file, Imu::kType.name, names.imu, "inertial unit");
  if (!imu) return imu.error();
  const auto fix = choose_topic(file, NavSatFix::kType.name, names.fix, "receiver's fixes");
  if (!fix) return fix.error();
  if (imu->empty() && fix->empty())
    return Error{ErrorCode::not_found, "has no inertial unit and no fixes", file.path()};
  VehicleRun run;
  run.problems = file.problems();
  Lanes lanes(file, names);
  lanes.add<Imu>(*imu, run.imu, imu_of);
  lanes.add<NavSatFix>(*fix, run.fixes, fix_of);
  if (auto done = lanes.run(run.problems); !done) return done.error();
  return run;
}

Result<io::ImuFile> read_imu(const std::string& path, const io::ColumnFormat& format,
                             const TopicNames& names) {
  if (!RecordingFile::is_one(path)) return io::read_imu(path, format);
  const auto file = RecordingFile::open(path);
  if (!file) return file.error();
  auto run = read_vehicle(*file, names);
  if (!run) return run.error();
  if (run->imu.empty()) return Error{ErrorCode::not_found, "contains no inertial unit", path};
  return io::ImuFile{std::move(run->imu), {}, true, true, std::move(run->problems)};
}

Result<io::FixFile> read_fixes(const std::string& path, const io::ColumnFormat& format,
                               const TopicNames& names) {
  if (!RecordingFile::is_one(path)) return io::read_fixes(path, format);
  const auto file = RecordingFile::open(path);
  if (!file) return file.error();
  auto run = read_vehicle(*file, names);
  if (!run) return run.error();
  if (run->fixes.empty()) return Error{ErrorCode::not_found, "contains no fixes", path};
  std::vector<int> qualities(run->fixes.size(), 0);
  return io::FixFile{std::move(run->fixes), std::move(qualities), std::move(run->problems)};
}

}  // namespace wayfare::ros
