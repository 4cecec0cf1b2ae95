#pragma once

// Simulated recordings used by the tests of several families.

#include <cstdint>
#include <string>
#include <string_view>

#include <wayfare/sim/floor_plan.hpp>
#include <wayfare/sim/simulate_recording.hpp>

namespace wayfare {

/// A robot with slipping wheels of different size and its laser ahead of its centre.
inline sim::RobotParams slipping_robot() {
  sim::RobotParams robot;
  robot.wheels.right_scale = 1.002;
  robot.wheels.slip_m_per_sqrt_m = 0.005;
  robot.T_base_laser = Transform2<frame::Base, frame::Laser>(SE2d(0.15, 0.0, Angle{}));
  return robot;
}

/// The floor and route of a plan; the text must be valid.
inline sim::PlannedRoute planned(std::string_view plan_text) {
  return sim::read_plan(plan_text, "plan").value();
}

inline sim::SimulatedRun simulate(std::string_view plan_text, const sim::RobotParams& robot,
                                  std::uint64_t seed) {
  const sim::PlannedRoute planned_route = planned(plan_text);
  return sim::simulate_recording(planned_route.plan, planned_route.route_m, robot, Rng(seed))
      .value();
}

/// Two rooms with two gaps in the wall between them, 10 m × 4 m, driven through along the marks a
/// to d.
inline std::string office_plan(const std::string& route) {
  return "metres_per_character 0.5\nroute " + route + R"(
picture
####################
#        #         #
# a                #
#           b      #
#        #         #
#   d    #  c      #
#                  #
####################
)";
}
inline const std::string kOffice = office_plan("a b c");

/// A loop of corridors, 18 m × 11 m, driven twice.
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

/// A corridor of 50 m without features.
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

}  // namespace wayfare
