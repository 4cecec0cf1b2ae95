#include <wayfare/sim/simulate_recording.hpp>

#include <algorithm>
#include <limits>
#include <vector>

namespace wayfare::sim {
namespace {

template <class Sample>
std::vector<Sample> between(const std::vector<Sample>& samples, LogTime from, LogTime to) {
  std::vector<Sample> part;
  std::copy_if(samples.begin(), samples.end(), std::back_inserter(part),
               [&](const Sample& s) { return s.time >= from && s.time < to; });
  return part;
}

template <class Sample>
void append(std::vector<Sample>& to, std::vector<Sample> more, Duration earlier_by) {
  for (Sample& s : more) {
    s.time = s.time - earlier_by;
    to.push_back(std::move(s));
  }
}

}  // namespace

Recording part_of(const Recording& recording, LogTime from, LogTime to) {
  Recording part;
  part.T_base_laser = recording.T_base_laser;
  part.T_base_radar = recording.T_base_radar;
  part.wheel_base_m = recording.wheel_base_m;
  part.scans = between(recording.scans, from, to);
  part.odometry = between(recording.odometry, from, to);
  part.radar = between(recording.radar, from, to);
  part.wheels = between(recording.wheels, from, to);
  part.gyro = between(recording.gyro, from, to);
  part.truth = between(recording.truth, from, to);
  return part;
}

Recording kidnapped(const Recording& recording, LogTime from, LogTime to) {
  const LogTime begin = LogTime::from_nanoseconds(std::numeric_limits<std::int64_t>::min());
  const LogTime end = LogTime::from_nanoseconds(std::numeric_limits<std::int64_t>::max());
  Recording result = part_of(recording, begin, from);
  Recording rest = part_of(recording, to, end);
  if (!result.odometry.empty() && !rest.odometry.empty()) {
    const SE2d T = result.odometry.back().T_odom_base.raw() *
                   rest.odometry.front().T_odom_base.raw().inverse();
    for (OdometrySample& s : rest.odometry)
      s.T_odom_base = Transform2<frame::Odom, frame::Base>(T * s.T_odom_base.raw());
  }
  append(result.scans, std::move(rest.scans), to - from);
  append(result.odometry, std::move(rest.odometry), to - from);
  append(result.radar, std::move(rest.radar), to - from);
  append(result.wheels, std::move(rest.wheels), to - from);
  append(result.gyro, std::move(rest.gyro), to - from);
  append(result.truth, std::move(rest.truth), to - from);
  return result;
}

}  // namespace wayfare::sim
