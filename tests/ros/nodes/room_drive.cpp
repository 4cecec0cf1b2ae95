#include "room_drive.hpp"

#include <utility>

#include <wayfare/sim/worlds.hpp>
#include "sim/support.hpp"

namespace wayfare::testing {
namespace {

template <class Stream>
void shift(Stream& stream, Duration by) {
  for (auto& item : stream) item.time += by;
}

}  // namespace

const Recording& room_drive() {
  static const Recording recording = [] {
    sim::RobotParams robot;
    robot.T_base_laser = Transform2<frame::Base, frame::Laser>(SE2d(0.2, 0.0, Angle{}));
    sim::SimulatedRun run = simulate(office_plan("a b c b a d a b"), robot, 1);
    Recording r = std::move(run.recording);
    r.truth = std::move(run.truth);
    const Duration by = from_seconds(1000.0);
    shift(r.scans, by), shift(r.odometry, by), shift(r.truth, by);
    return r;
  }();
  return recording;
}

const Recording& radar_drive() {
  static const Recording recording = [] {
    const Rng rng(1);
    auto world = *sim::make_world("room", rng);
    world.route_m.resize(3);
    Recording r = *sim::simulate_world(world, sim::turtlebot(rng), rng);
    r.wheels.clear(), r.gyro.clear();
    r.radar_max_speed_m_s = 0.0;  // not in the messages
    // Staggered ends, so that nothing is waited for in vain.
    const auto cut_and_shift = [begin = r.truth.front().time](auto& stream, double end_s) {
      const LogTime end = begin + from_seconds(end_s);
      std::erase_if(stream, [&](const auto& sample) { return sample.time > end; });
      shift(stream, from_seconds(1000.0));
    };
    cut_and_shift(r.scans, 9.8), cut_and_shift(r.radar, 9.9), cut_and_shift(r.odometry, 10.0);
    cut_and_shift(r.truth, 10.0);
    return r;
  }();
  return recording;
}

ros::TfMessage mounting(const Recording& recording) {
  const LogTime time = recording.scans.front().time;
  return {{ros::transform_of(recording.T_base_laser.raw(), time, "base_link", "laser"),
           ros::transform_of(recording.T_base_radar.raw(), time, "base_link", "radar")}};
}

}  // namespace wayfare::testing
