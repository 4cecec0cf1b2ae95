#pragma once

// ROS messages and recordings without ROS, and the engines of the nodes.

#include <wayfare/ros/convert.hpp>
#include <wayfare/ros/frame_tree.hpp>
#include <wayfare/ros/geometry_messages.hpp>
#include <wayfare/ros/messages.hpp>
#include <wayfare/ros/pedestrian_node.hpp>
#include <wayfare/ros/recording.hpp>
#include <wayfare/ros/recording_writer.hpp>
#include <wayfare/ros/serialise.hpp>
#include <wayfare/ros/slam_node.hpp>
