#include <wayfare/ros/frame_tree.hpp>
#include <wayfare/ros/recording.hpp>

#include "lanes.hpp"

namespace wayfare::ros {
namespace {

constexpr std::string_view kOdomFrame = "odom";

bool has_topic(const RecordingFile& file, const std::string& name, std::string_view type) {
  for (const Topic& topic : file.topics())
    if (topic.type == type && (name.empty() || topic.name == name)) return true;
  return false;
}

bool has_speed(const PointCloud2& cloud) {
  for (const PointField& field : cloud.fields_of_point)
    if (field.name == "velocity" || field.name == "doppler" || field.name == "v_doppler_mps")
      return true;
  return false;
}

/// Point clouds of a radar among those of other sensors: the first message says.
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
  if (has_topic(file, named, RadarScan::kType.name)) {
    const auto topic = choose_topic(file, RadarScan::kType.name, named, "radar");
    if (!topic) return topic.error();
    return RadarTopic{*topic, false};
  }
  if (!named.empty()) {
    const auto topic = choose_topic(file, PointCloud2::kType.name, named, "radar");
    if (!topic) return topic.error();
    return RadarTopic{*topic, true};
  }
  const auto clouds = radar_clouds(file);
  if (clouds.size() > 1)
    return Error{ErrorCode::invalid,
                 "holds several radars: name one among " + clouds[0] + ", " + clouds[1],
                 file.path()};
  return RadarTopic{clouds.empty() ? std::string() : clouds.front(), true};
}

/// Transforms of a recording, and the robot's way by them.
struct Transforms {
  FrameTree tree;
  std::vector<OdometrySample> odometry;
  std::string odometry_child;

  void take(const TfMessage& message, io::Problems& problems) {
    for (const TransformStamped& t : message.transforms) {
      tree.add(t);
      if (frame_of(t.header) != kOdomFrame) continue;
      const auto time = time_of(t.header.stamp);
      const auto pose = plane_pose_of(
          {{t.transform.translation.x, t.transform.translation.y, 0.0}, t.transform.rotation});
      if (time && pose) {
        odometry.push_back({*time, Transform2<frame::Odom, frame::Base>(*pose)});
        odometry_child = t.child_frame_id;
      } else {
        problems.add({ErrorCode::parse, time ? pose.error().message : time.error().message,
                      "transform " + t.child_frame_id});
      }
    }
  }
};

/// What a reader of a robot's run learns besides its measurements.
struct Frames {
  std::optional<std::string> scan, radar;
  std::string odometry_child;
};

/// A topic's messages are all of one frame, that of the first.
Result<void> take_frame(const Header& header, std::optional<std::string>& frame) {
  if (!frame) frame = frame_of(header);
  return check_frame(header, *frame);
}

std::string base_frame(const TopicNames& names, const Frames& frames) {
  if (!names.base_frame.empty()) return names.base_frame;
  return frames.odometry_child.empty() ? "base_link" : frames.odometry_child;
}

/// How the sensor of `frame` sits on the robot; where nothing says, in its middle, and that is
/// said. Errors: not level.
Result<LevelMounting> mounting_of(const FrameTree& tree, const std::string& base,
                                  const std::string& frame, io::Problems& problems) {
  const auto found = tree.find(base, frame);
  if (found) return level_mounting_of(*found);
  problems.add({ErrorCode::not_found,
                found.error().message + ": the sensor is taken to be where the robot's frame is",
                "frame " + frame});
  return LevelMounting{};
}

Result<void> mount_sensors(RobotRun& run, const FrameTree& tree, const TopicNames& names,
                           const Frames& frames) {
  const std::string base = base_frame(names, frames);
  if (!run.recording.scans.empty()) {
    const auto mounting = mounting_of(tree, base, frames.scan.value_or(""), run.problems);
    if (!mounting) return mounting.error();
    run.recording.T_base_laser =
        Transform2<frame::Base, frame::Laser>(mounting->T_base_sensor.raw());
    if (mounting->upside_down)
      for (wayfare::LaserScan& scan : run.recording.scans) scan = turned_over(std::move(scan));
  }
  if (!run.recording.radar.empty()) {
    const auto mounting = mounting_of(tree, base, frames.radar.value_or(""), run.problems);
    if (!mounting) return mounting.error();
    run.recording.T_base_radar =
        Transform2<frame::Base, frame::Radar>(mounting->T_base_sensor.raw());
    if (mounting->upside_down)
      for (wayfare::RadarScan& scan : run.recording.radar)
        for (RadarPoint& p : scan.points) p.y_m = -p.y_m, p.z_m = -p.z_m;
  }
  return {};
}

}  // namespace

Result<RobotRun> read_robot(const RecordingFile& file, const TopicNames& names) {
  const auto scan = choose_topic(file, LaserScan::kType.name, names.scan, "scan");
  if (!scan) return scan.error();
  const auto odometry = choose_topic(file, Odometry::kType.name, names.odometry, "odometry");
  if (!odometry) return odometry.error();
  const auto radar = choose_radar(file, names.radar);
  if (!radar) return radar.error();
  if (scan->empty() && radar->name.empty())
    return Error{ErrorCode::not_found, "holds no laser scan and no radar points", file.path()};
  RobotRun run;
  run.problems = file.problems();
  run.scan_topic = *scan, run.odometry_topic = *odometry, run.radar_topic = radar->name;
  Frames frames;
  Transforms transforms;
  Lanes lanes(file, names);
  lanes.add<LaserScan>(*scan, run.recording.scans,
                       [&](const LaserScan& m, LogTime time) -> Result<wayfare::LaserScan> {
                         if (auto ok = take_frame(m.header, frames.scan); !ok) return ok.error();
                         return laser_scan_of(m, time);
                       });
  lanes.add<Odometry>(*odometry, run.recording.odometry, [&](const Odometry& m, LogTime time) {
    frames.odometry_child = m.child_frame_id;
    return odometry_of(m, time);
  });
  const auto take_radar = [&](const auto& m, LogTime time) -> Result<wayfare::RadarScan> {
    if (auto ok = take_frame(m.header, frames.radar); !ok) return ok.error();
    return radar_scan_of(m, time);
  };
  if (radar->is_cloud) {
    lanes.add<PointCloud2>(radar->name, run.recording.radar, take_radar);
  } else {
    lanes.add<RadarScan>(radar->name, run.recording.radar, take_radar);
  }
  for (const Topic& topic : file.topics())
    if (topic.type == TfMessage::kType.name || topic.type == "tf/tfMessage")
      lanes.visit<TfMessage>(topic.name,
                             [&](const TfMessage& m) { transforms.take(m, run.problems); });
  if (auto done = lanes.run(run.problems); !done) return done.error();
  if (odometry->empty()) {
    frames.odometry_child = transforms.odometry_child;
    run.recording.odometry = std::move(transforms.odometry);
    std::stable_sort(run.recording.odometry.begin(), run.recording.odometry.end(),
                     [](const auto& a, const auto& b) { return a.time < b.time; });
  }
  if (auto done = mount_sensors(run, transforms.tree, names, frames); !done) return done.error();
  return run;
}

Result<MargRun> read_marg(const RecordingFile& file, const TopicNames& names) {
  const auto imu = choose_topic(file, Imu::kType.name, names.imu, "inertial unit");
  if (!imu) return imu.error();
  if (imu->empty())
    return Error{ErrorCode::not_found, "holds no inertial unit (sensor_msgs/Imu)", file.path()};
  const auto magnetometer =
      choose_topic(file, MagneticField::kType.name, names.magnetometer, "magnetometer");
  if (!magnetometer) return magnetometer.error();
  MargRun run;
  run.problems = file.problems();
  run.topic = *imu;
  MargRecording fields;
  Lanes lanes(file, names);
  lanes.add<Imu>(*imu, run.samples, [](const Imu& m, LogTime time) -> Result<MargSample> {
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
  if (auto done = lanes.run(run.problems); !done) return done.error();
  // A reading with the stamp of the unit's own joins it.
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
    return Error{ErrorCode::not_found, "holds no inertial unit and no fixes", file.path()};
  VehicleRun run;
  run.problems = file.problems();
  Lanes lanes(file, names);
  lanes.add<Imu>(*imu, run.imu, imu_of);
  lanes.add<NavSatFix>(*fix, run.fixes, fix_of);
  if (auto done = lanes.run(run.problems); !done) return done.error();
  return run;
}

}  // namespace wayfare::ros
