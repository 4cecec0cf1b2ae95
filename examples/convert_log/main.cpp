// A robot's log as a recording of ROS messages, for the tools that know these alone.

#include <algorithm>
#include <cstdio>
#include <string>

#include <wayfare/ros/recording_writer.hpp>

#include "command_line.hpp"
#include "exit_code.hpp"
#include "slam_program.hpp"
#include "thin_recording.hpp"

namespace {

using namespace wayfare;

struct Options : examples::SlamArguments {
  std::string log;
  examples::Thinning thinning;
};

template <class Stream>
void shift(Stream& stream, Duration by) {
  for (auto& item : stream) item.time += by;
}

/// Logs without a clock begin at zero, which ROS takes for "no time set".
bool set_clock(Recording& r) {
  LogTime first = LogTime::from_nanoseconds(INT64_MAX);
  const auto look = [&](const auto& stream) {
    if (!stream.empty()) first = std::min(first, stream.front().time);
  };
  look(r.scans), look(r.odometry), look(r.radar);
  if (first > LogTime()) return false;
  const Duration by = LogTime::from_seconds(1.0) - first;
  shift(r.scans, by), shift(r.odometry, by), shift(r.radar, by);
  return true;
}

Result<void> convert(const Options& o) {
  auto recording = examples::read_robot_log(o.log, o.topics);
  if (!recording) return recording.error();
  const Recording& r = *recording;
  examples::thin(*recording, o.thinning);
  const bool shifted = set_clock(*recording);
  auto writer = ros::RecordingWriter::create(o.out, o.write());
  if (!writer) return writer.error();
  auto done = ros::write_robot(*writer, r);
  if (done) done = writer->close();
  if (!done || o.quiet) return done;
  std::printf("scans     %zu\nodometry  %zu\nradar     %zu\nwritten   %s\n", r.scans.size(),
              r.odometry.size(), r.radar.size(), o.out.c_str());
  if (shifted) std::printf("The log has no clock: its first time is now 1 s.\n");
  if (const std::size_t left = r.wheels.size() + r.gyro.size() + r.truth.size(); left > 0)
    std::printf("Left out, for want of a message: %zu of wheels, %zu of gyro, %zu of truth\n",
                r.wheels.size(), r.gyro.size(), r.truth.size());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  examples::CommandLine app(
      "Writes a robot's log as ROS messages: /scan, /odom, /tf, /tf_static and, of a radar, "
      "/radar.\nLOG is " +
      std::string(examples::kRobotLogs) +
      ". No ROS is needed. Reading what was written gives the same numbers to the bit. Thinned "
      "out, it is what a lesser sensor would have recorded.");
  Options o;
  app.add_option("LOG", o.log, "the recorded log").required().existing_file();
  examples::add_out(app, o, "the file to write: ROS 2's .mcap (CDR) or ROS 1's .bag");
  examples::add_robot_topics(app, o.topics);
  examples::add_thinning(app, o.thinning);
  examples::add_manners(app, o);
  if (const auto code = app.parse(argc, argv)) return *code;
  return examples::exit_code("convert_log", convert(o));
}
