#include "ros_nodes/room_drive.hpp"

namespace wayfare::testing {
namespace {

constexpr std::string_view kRoom = R"(metres_per_character 0.5
route a b c b a d a b
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

template <class Stream>
void shift(Stream& stream, Duration by) {
  for (auto& item : stream) item.time += by;
}

}  // namespace

const Recording& room_drive() {
  static const Recording recording = [] {
    const auto plan = sim::read_plan(kRoom);
    sim::RobotParams robot;
    robot.T_base_laser = Transform2<frame::Base, frame::Laser>(SE2d(0.2, 0.0, Angle{}));
    Recording r = sim::simulate_recording(plan->plan, plan->route_m, robot, Rng(1))->recording;
    const Duration by = from_seconds(1000.0);
    shift(r.scans, by), shift(r.odometry, by);
    return r;
  }();
  return recording;
}

ros::TfMessage mounting(const Recording& recording) {
  return {{ros::transform_of(recording.T_base_laser.raw(), recording.scans.front().time,
                             "base_link", "laser")}};
}

}  // namespace wayfare::testing
