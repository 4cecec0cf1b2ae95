#pragma once

#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/sim/plan_text.hpp>
#include <wayfare/sim/simulate_recording.hpp>

namespace wayfare {

/// A robot with slipping wheels of unlike size, its laser ahead of its centre.
inline sim::RobotParams slipping_robot() {
  sim::RobotParams robot;
  robot.wheels.right_scale = 1.002;
  robot.wheels.slip_m_per_sqrt_m = 0.005;
  robot.T_base_laser = Transform2<frame::Base, frame::Laser>(SE2d(0.15, 0.0, Angle{}));
  return robot;
}

inline sim::SimulatedRun simulate(std::string_view plan_text, const sim::RobotParams& robot,
                                  std::uint64_t seed) {
  const auto planned = sim::read_plan(plan_text, "plan");
  if (!planned) throw std::runtime_error(planned.error().to_string());
  auto run = sim::simulate_recording(planned->plan, planned->route_m, robot, Rng(seed));
  if (!run) throw std::runtime_error(run.error().to_string());
  return *std::move(run);
}

/// A ring of corridors, 18 m × 11 m, driven round twice.
inline constexpr std::string_view kRing = R"(metres_per_character 0.5
route a b c d a b
picture
####################################
#                        ##        #
#                                  #
#   a                          b   #
#                                  #
#     ########################     #
#     #                      #     #
#     #                      #     #
#     #                      #     #
##    #                      #     #
##    #                      #    ##
#     #                      #     #
#     #                      #     #
#     #                      #     #
#     #                      #     #
#     ########################     #
#                                  #
#                                  #
#   d                          c   #
#            ##                    #
#            ##                    #
####################################
)";

/// A corridor of 50 m without a feature on its way.
inline constexpr std::string_view kCorridor = R"(metres_per_character 0.5
route a b
picture
########################################################################################################
#                                                                                                      #
#    a                                                                                             b   #
#                                                                                                      #
#                                                                                                      #
########################################################################################################
)";

/// An empty room of 6 m × 4 m seen from (x, y) by a laser of 360 beams all round.
inline LaserScan room_scan(double time_s, double x, double y) {
  LaserScan scan{
      LogTime::from_seconds(time_s), Angle::degrees(-180), Angle::degrees(1), 0.05F, 20.0F, {}};
  for (std::size_t i = 0; i < 360; ++i) {
    const double b = scan.first_bearing.radians() + static_cast<double>(i) * std::numbers::pi / 180;
    const double tx = ((std::cos(b) > 0 ? 6.0 : 0.0) - x) / std::cos(b);
    const double ty = ((std::sin(b) > 0 ? 4.0 : 0.0) - y) / std::sin(b);
    scan.ranges_m.push_back(static_cast<float>(std::min(std::abs(tx), std::abs(ty))));
  }
  return scan;
}

}  // namespace wayfare
