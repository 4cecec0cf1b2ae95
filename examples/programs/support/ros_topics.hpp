#pragma once

#include <wayfare/ros/recording.hpp>

#include "command_line.hpp"

namespace wayfare::examples {

/// Topics of a ROS recording (.mcap, .bag), for programs that read robot logs.
void add_robot_topics(CommandLine& app, ros::TopicNames& names);
/// Its true poses.
void add_truth_topics(CommandLine& app, ros::TopicNames& names);
/// For programs that read an inertial unit.
void add_imu_topic(CommandLine& app, ros::TopicNames& names);
/// For programs that read an inertial unit and a satellite receiver.
void add_vehicle_topics(CommandLine& app, ros::TopicNames& names);
/// For programs that read an inertial unit with a magnetometer; without --stamps, which a program
/// has once.
void add_unit_topics(CommandLine& app, ros::TopicNames& names);
void add_stamps(CommandLine& app, ros::TopicNames& names);

}  // namespace wayfare::examples
