#pragma once

// ROS messages and recordings without ROS, and the engines of the nodes.

#include <wayfare/ros/convert.hpp>
#include <wayfare/ros/localise_node.hpp>
#include <wayfare/ros/message_parts.hpp>
#include <wayfare/ros/messages.hpp>
#include <wayfare/ros/node.hpp>
#include <wayfare/ros/nodes.hpp>
#include <wayfare/ros/qos.hpp>
#include <wayfare/ros/recording.hpp>
#include <wayfare/ros/scan_node.hpp>
#include <wayfare/ros/serialise.hpp>
