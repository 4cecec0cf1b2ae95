#include <algorithm>
#include <utility>

#include <wayfare/ros/recording.hpp>

#include "ros/recording/lanes.hpp"
#include "ros/recording/truth.hpp"
#include "ros/recording/wheels.hpp"

namespace wayfare::ros {
namespace {

bool has_speed(const PointCloud2& cloud) {
  for (const PointField& field : cloud.fields_of_point)
    if (field.name == "velocity" || field.name == "doppler" || field.name == "v_doppler_mps")
      return true;
  return false;
}

/// A radar's point clouds among those of other sensors: determined by the first message.
std::vector<std::string> radar_clouds(const RecordingFile& file) {
  std::vector<std::string> radars;
  for (const Topic& topic : file.topics()) {
    if (topic.type != PointCloud2::kType.name) continue;
    file.read({topic.name}, [&](const RecordedMessage& m) {
      const auto cloud = from_bytes<PointCloud2>(m.data, m.topic.dialect);
      if (cloud && has_speed(*cloud)) radars.push_back(topic.name);
      return false;
    });
  }
  return radars;
}

struct RadarTopic {
  std::string name;
  bool is_cloud = false;
};

Result<RadarTopic> choose_radar(const RecordingFile& file, const std::string& named) {
  const bool is_cloud = !has_topic(file, named, RadarScan::kType.name);
  if (!is_cloud || !named.empty()) {
    const auto& type = is_cloud ? PointCloud2::kType : RadarScan::kType;
    const auto topic = choose_topic(file, type.name, named, "radar");
    if (!topic) return topic.error();
    return RadarTopic{*topic, is_cloud};
  }
  const auto clouds = radar_clouds(file);
  if (clouds.size() > 1)
    return Error{ErrorCode::invalid,
                 "has several radars: name one among " + clouds[0] + ", " + clouds[1], file.path()};
  return RadarTopic{clouds.empty() ? std::string() : clouds.front(), true};
}

/// The named inertial unit, else the only one. With several, none: it is optional for a robot.
Result<std::string> choose_unit(const RecordingFile& file, const std::string& named,
                                io::Problems& problems) {
  auto unit = choose_topic(file, Imu::kType.name, named, "inertial unit");
  if (unit || !named.empty()) return unit;
  Error several = unit.error();
  several.message += "; none is used";
  problems.add(std::move(several));
  return std::string();
}

struct Frames {
  std::optional<std::string> scan, radar, unit;
};

/// Measurements of a unit, about its own axes.
struct TurnRate {
  LogTime time;
  Eigen::Vector3d rate_radps;
};

void mount_laser(Recording& r, const LevelMounting& mounting) {
  r.T_base_laser = Transform2<frame::Base, frame::Laser>(mounting.T_base_sensor.raw());
  if (mounting.upside_down)
    for (wayfare::LaserScan& scan : r.scans) scan = turned_over(std::move(scan));
}

void mount_radar(Recording& r, const LevelMounting& mounting) {
  r.T_base_radar = Transform2<frame::Base, frame::Radar>(mounting.T_base_sensor.raw());
  if (mounting.upside_down)
    for (wayfare::RadarScan& scan : r.radar) scan = turned_over(std::move(scan));
}

/// The robot's turn rate, for any mounting of the unit; without a transform its z axis points up.
void mount_unit(RobotRun& run, const std::vector<TurnRate>& rates, const Layout& layout,
                const std::string& base, const std::string& frame) {
  if (rates.empty()) return;
  const auto q_base_unit = rotation_of(layout.tree, base, frame);
  if (!q_base_unit)
    run.problems.add({ErrorCode::not_found,
                      "no transform leads from '" + base + "' to '" + frame +
                          "': the unit's z axis is taken to point up",
                      "frame " + frame});
  for (const TurnRate& r : rates)
    run.recording.gyro.push_back({r.time, (q_base_unit.value_or(SO3d()) * r.rate_radps).z()});
}

Result<void> mount_sensors(RobotRun& run, const Layout& layout, const std::string& base,
                           const Frames& frames) {
  const auto mount = [&](bool there, const std::optional<std::string>& frame,
                         void (*as)(Recording&, const LevelMounting&)) -> Result<void> {
    if (!there) return {};
    const auto mounting = mounting_of(layout.tree, base, frame.value_or(""), run.problems);
    if (!mounting) return mounting.error();
    as(run.recording, *mounting);
    return {};
  };
  auto done = mount(!run.recording.scans.empty(), frames.scan, mount_laser);
  return done ? mount(!run.recording.radar.empty(), frames.radar, mount_radar) : done;
}

/// Topics of a robot.
struct Chosen {
  std::string scan, odometry, unit, truth;
  RadarTopic radar;
};

Result<Chosen> choose_topics(const RecordingFile& file, const TopicNames& names,
                             io::Problems& problems) {
  const auto scan = choose_topic(file, LaserScan::kType.name, names.scan, "scan");
  if (!scan) return scan.error();
  const auto truth = choose_truth(file, names);
  if (!truth) return truth.error();
  const auto odometry =
      choose_topic(file, Odometry::kType.name, names.odometry, "odometry", *truth);
  if (!odometry) return odometry.error();
  const auto radar = choose_radar(file, names.radar);
  if (!radar) return radar.error();
  if (scan->empty() && radar->name.empty())
    return Error{ErrorCode::not_found, "has no laser scan and no radar points", file.path()};
  const auto unit = choose_unit(file, names.imu, problems);
  if (!unit) return unit.error();
  return Chosen{*scan, *odometry, *unit, *truth == *odometry ? std::string() : *truth, *radar};
}

/// For an optional topic: required if it was named.
Need need_of(const std::string& named) { return named.empty() ? Need::optional : Need::required; }

}  // namespace

Result<RobotRun> read_robot(const RecordingFile& file, const TopicNames& names) {
  RobotRun run;
  run.problems = file.problems();
  const auto topics = choose_topics(file, names, run.problems);
  if (!topics) return topics.error();
  run.scan_topic = topics->scan, run.odometry_topic = topics->odometry;
  run.radar_topic = topics->radar.name, run.imu_topic = topics->unit;
  run.truth_topic = topics->truth;
  Frames frames;
  Layout layout;
  std::vector<TurnRate> rates;
  std::string odometry_child;
  Lanes lanes(file, names);
  lanes.add<LaserScan>(topics->scan, run.recording.scans,
                       [&](const LaserScan& m, LogTime time) -> Result<wayfare::LaserScan> {
                         if (auto ok = take_frame(m.header, frames.scan); !ok) return ok.error();
                         return laser_scan_of(m, time);
                       });
  lanes.add<Odometry>(topics->odometry, run.recording.odometry,
                      [&](const Odometry& m, LogTime time) {
                        odometry_child = m.child_frame_id;
                        return odometry_of(m, time);
                      });
  const auto take_radar = [&](const auto& m, LogTime time) -> Result<wayfare::RadarScan> {
    if (auto ok = take_frame(m.header, frames.radar); !ok) return ok.error();
    return radar_scan_of(m, time);
  };
  if (topics->radar.is_cloud) {
    lanes.add<PointCloud2>(topics->radar.name, run.recording.radar, take_radar);
  } else {
    lanes.add<RadarScan>(topics->radar.name, run.recording.radar, take_radar);
  }
  lanes.add<Imu>(
      topics->unit, rates,
      [&](const Imu& m, LogTime time) -> Result<TurnRate> {
        if (auto ok = take_frame(m.header, frames.unit); !ok) return ok.error();
        const auto rate = turn_rate_of(m);
        if (!rate) return rate.error();
        return TurnRate{time, *rate};
      },
      need_of(names.imu));
  add_truth(lanes, layout, file, topics->truth, names, run.recording.truth);
  WheelReader wheels(file, names);
  if (auto ok = wheels.listen(lanes, run.problems); !ok) return ok.error();
  layout.listen(lanes, file, run.problems);
  if (auto done = lanes.run(run.problems); !done) return done.error();
  if (auto done = finish_truth(layout, file, names, run.recording.truth, run.problems); !done)
    return done.error();
  if (auto done = wheels.finish(run); !done) return done.error();
  if (topics->odometry.empty()) {
    run.recording.odometry = std::move(layout.by_transforms);
    std::stable_sort(run.recording.odometry.begin(), run.recording.odometry.end(),
                     [](const auto& a, const auto& b) { return a.time < b.time; });
  } else {
    layout.odometry_child = odometry_child;
  }
  const std::string base = layout.base_frame(names);
  if (auto done = mount_sensors(run, layout, base, frames); !done) return done.error();
  mount_unit(run, rates, layout, base, frames.unit.value_or(""));
  compare_with_gyro(run.recording, run.wheel_topic, run.problems);
  return run;
}

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
