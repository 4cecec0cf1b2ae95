#include <wayfare/sim/robot_geometry.hpp>

namespace wayfare::sim {

RobotGeometry draw_geometry(const WorldRobot& robot, const Rng& rng) {
  Rng draw = rng.stream(17);
  const auto moved = [&](const SE2d& given, double yaw_deg) {
    const double x = draw.normal(0.0, 0.06), y = draw.normal(0.0, 0.06);
    const Angle yaw = Angle::degrees(draw.normal(0.0, yaw_deg));
    return SE2d(given.x() + x, given.y() + y, given.heading() + yaw);
  };
  RobotGeometry g;
  g.left_scale = draw.normal(1.0, 0.03);
  g.right_scale = draw.normal(1.0, 0.03);
  g.wheel_base_m = robot.robot.wheels.wheel_base_m * draw.normal(1.0, 0.05);
  g.T_base_laser = moved(robot.robot.T_base_laser.raw(), 10.0);
  g.T_base_radar = moved(robot.radar.T_base_radar.raw(), 20.0);
  g.laser_delay_s = draw.uniform(-0.08, 0.08);
  g.radar_delay_s = draw.uniform(-0.08, 0.08);
  g.gyro_delay_s = draw.uniform(-0.08, 0.08);
  return g;
}

Result<Recording> simulate_misdescribed(const World& world, const WorldRobot& robot,
                                        const RobotGeometry& geometry, const Rng& rng,
                                        const SimulationControl& control) {
  WorldRobot real = robot;
  WheelParams& wheels = real.robot.wheels;
  wheels.left_scale = 1.0 / geometry.left_scale;
  wheels.right_scale = 1.0 / geometry.right_scale;
  wheels.wheel_base_m = geometry.wheel_base_m;
  real.robot.T_base_laser = Transform2<frame::Base, frame::Laser>(geometry.T_base_laser);
  real.radar.T_base_radar = Transform2<frame::Base, frame::Radar>(geometry.T_base_radar);
  auto recording = simulate_world(world, real, rng, control);
  if (!recording) return recording;
  recording->T_base_laser = robot.robot.T_base_laser;
  recording->T_base_radar = robot.radar.T_base_radar;
  recording->wheel_base_m = robot.robot.wheels.wheel_base_m;
  recording->odometry = dead_reckon(recording->wheels, recording->wheel_base_m);
  const auto delay = [](auto& stream, double by_s) {
    for (auto& measurement : stream) measurement.time += from_seconds(by_s);
  };
  delay(recording->scans, geometry.laser_delay_s);
  delay(recording->radar, geometry.radar_delay_s);
  delay(recording->gyro, geometry.gyro_delay_s);
  return recording;
}

}  // namespace wayfare::sim
