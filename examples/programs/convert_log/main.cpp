// A robot's log as a recording of ROS messages, for the tools that know these alone.

#include <algorithm>
#include <cstdio>
#include <string>
#include <utility>

#include <wayfare/ros/recording_writer.hpp>
#include <wayfare/sim/differential_drive.hpp>

#include "ahrs/unit_options.hpp"
#include "support/command_line.hpp"
#include "support/exit_code.hpp"
#include "support/slam_program.hpp"
#include "support/thin_recording.hpp"

namespace {

using namespace wayfare;

struct Options : examples::SlamArguments {
  examples::UnitOptions unit;
  examples::Thinning thinning;
};

/// Logs without a clock begin at zero, which ROS takes for "no time set".
bool set_clock(Recording& r, MargRecording& unit) {
  const auto all = [&](const auto& visit) {
    visit(r.scans), visit(r.odometry), visit(r.radar), visit(r.gyro), visit(r.truth), visit(unit);
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

/// Of a log without odometry, what its wheels come to.
void reckon(Recording& r) {
  if (r.odometry.empty() && r.wheel_base_m > 0.0)
    r.odometry = sim::dead_reckon(r.wheels, r.wheel_base_m);
}

void print_counts(const Recording& r, const MargRecording& unit, const Options& o) {
  std::printf("scans     %zu\nodometry  %zu\nradar     %zu\ngyro      %zu\ntruth     %zu\n",
              r.scans.size(), r.odometry.size(), r.radar.size(), unit.empty() ? r.gyro.size() : 0,
              r.truth.size());
  if (!unit.empty()) std::printf("unit      %zu\n", unit.size());
  std::printf("written   %s\n", o.out.c_str());
}

Result<void> convert(const Options& o) {
  auto recording = examples::read_robot_log(o.log, o.topics);
  if (!recording) return recording.error();
  auto readings = o.unit.read(o.log, o.topics);
  if (!readings) return readings.error();
  Recording& r = *recording;
  examples::thin(r, o.thinning);
  MargRecording unit;
  SE2d T_base_unit;
  if (*readings) {
    unit = std::move((*readings)->file.samples);
    T_base_unit = SE2d(0.0, 0.0, Angle::radians(o.unit.q_base_unit(**readings, r).log().z()));
  }
  const bool shifted = set_clock(r, unit);
  const bool wheels_alone = r.odometry.empty();
  reckon(r);
  auto writer = ros::RecordingWriter::create(o.out, o.write());
  if (!writer) return writer.error();
  auto done = ros::write_robot(*writer, r, {}, {unit, T_base_unit});
  if (done) done = writer->close();
  if (!done || o.quiet) return done;
  print_counts(r, unit, o);
  if (shifted) std::printf("The log has no clock: its first time is now 1 s.\n");
  if (!r.wheels.empty())
    std::printf(wheels_alone ? "The odometry is that of %zu readings of wheels.\n"
                             : "Left out, for want of a message: %zu of wheels\n",
                r.wheels.size());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  examples::CommandLine app(
      "Writes a robot's log as ROS messages: /scan, /odom, /tf, /tf_static and, where there are, "
      "/radar, /imu, /magnetic_field and /truth.\nLOG is " +
      std::string(examples::kRobotLogs) +
      ". No ROS is needed. Reading what was written gives the same numbers to the bit, but for a "
      "magnetic field's last. Thinned out, it is what a lesser sensor would have recorded.");
  Options o;
  app.add_option("LOG", o.log, "the recorded log").required().existing_file();
  examples::add_out(app, o, "the file to write: ROS 2's .mcap (CDR) or ROS 1's .bag");
  o.unit.describe(app);
  examples::add_robot_topics(app, o.topics);
  examples::add_thinning(app, o.thinning);
  examples::add_manners(app, o);
  if (const auto code = app.parse(argc, argv)) return *code;
  return examples::exit_code("convert_log", convert(o));
}
