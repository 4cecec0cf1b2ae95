// Converts a robot's log to a recording of ROS messages.

#include <algorithm>
#include <cstdio>
#include <string>
#include <utility>

#include <wayfare/ros/recording.hpp>

#include "ahrs/recording.hpp"
#include "support/slam_program.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Options : SlamArguments {
  UnitOptions unit;
  Thinning thinning;
};

/// Logs without a clock begin at zero, which means "no time set" to ROS.
bool set_clock(Recording& r, MargRecording& unit) {
  const auto all = [&](const auto& visit) {
    visit(r.scans), visit(r.odometry), visit(r.radar), visit(r.wheels), visit(r.gyro);
    visit(r.truth), visit(unit);
  };
  LogTime first = LogTime::from_nanoseconds(INT64_MAX);
  all([&](const auto& stream) {
    if (!stream.empty()) first = std::min(first, stream.front().time);
  });
  if (first > LogTime()) return false;
  const Duration by = LogTime::from_seconds(1.0) - first;
  all([by](auto& stream) {
    for (auto& sample : stream) sample.time += by;
  });
  return true;
}

void add_thinning(CommandLine& app, Thinning& t) {
  app.add_option("--every", t.every, "keep one scan of this number").range(1, 1000000);
  app.add_option("--beams", t.beams, "keep one beam of this number").range(1, 100000);
  app.add_option("--max-range", t.max_range_m, "farther ranges become missing returns, m")
      .range(0.0, 10000.0);
  app.add_option("--field-of-view", t.field_of_view_deg,
                 "of the beams to keep, symmetric about ahead, deg")
      .range(0.0, 360.0);
}

void print_counts(const Recording& r, const MargRecording& unit, const Options& o) {
  std::printf("scans     %zu\nodometry  %zu\nradar     %zu\ngyro      %zu\ntruth     %zu\n",
              r.scans.size(), r.odometry.size(), r.radar.size(), unit.empty() ? r.gyro.size() : 0,
              r.truth.size());
  if (!r.wheels.empty()) std::printf("wheels    %zu\n", r.wheels.size());
  if (!unit.empty()) std::printf("unit      %zu\n", unit.size());
  std::printf("written   %s\n", o.out.c_str());
}

Result<void> convert(const Options& o) {
  if (!o.out.ends_with(".mcap") && !o.out.ends_with(".bag"))
    return bad_use("--out ends neither in .mcap nor in .bag: " + o.out);
  if (auto ready = check_writable({o.out}, o.write()); !ready) return ready;
  auto recording = read_robot_log(o.log, o.topics);
  if (!recording) return recording.error();
  auto readings = o.unit.read(o.log, o.topics);
  if (!readings) return readings.error();
  Recording& r = *recording;
  thin(r, o.thinning);
  MargRecording unit;
  SE2d T_base_unit;
  if (*readings) {
    unit = std::move((*readings)->file.samples);
    T_base_unit = SE2d(0.0, 0.0, Angle::radians(o.unit.q_base_unit(**readings, r).log().z()));
  }
  const bool shifted = set_clock(r, unit);
  auto writer = ros::RecordingWriter::create(o.out, o.write());
  if (!writer) return writer.error();
  auto done = ros::write_robot(*writer, r, {}, {unit, T_base_unit});
  if (done) done = writer->close();
  if (!done || o.quiet) return done;
  print_counts(r, unit, o);
  if (shifted) std::printf("The log has no clock: its times now begin at 1 s.\n");
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Convert a robot's log to ROS messages: /scan, /odom, /tf, /tf_static and, if the log has "
      "them, /radar, /imu, /magnetic_field, /truth and, for its wheels, /joint_states with "
      "/robot_description.\nLOG is " +
      std::string(kRobotLogs) +
      ". ROS is not needed. Reading the recording gives bit-identical numbers, except for the last "
      "bits of a magnetic field and of wheels whose distances are no encoder counts. Thinned out, "
      "it is what a lesser sensor would have recorded.");
  Options o;
  app.add_file("LOG", o.log, "the recorded log").required();
  app.add_option("--out", o.out, "the file to write: ROS 2's .mcap (CDR) or ROS 1's .bag")
      .shown_as("FILE")
      .required();
  o.unit.add_options(app);
  add_robot_topics(app, o.topics);
  add_thinning(app, o.thinning);
  add_force_and_quiet(app, o);
  app.example("robot.log --out robot.mcap", "a ROS 2 recording");
  app.example("robot.log --every 2 --beams 2 --out thin.bag",
              "a ROS 1 recording of half the scans with half the beams");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("convert_log", convert(o));
}
