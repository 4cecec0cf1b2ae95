#pragma once

// Nodes in a DDS domain of the test's own, on the loopback interface.

#include <chrono>
#include <functional>
#include <initializer_list>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/ros/node.hpp>
#include <wayfare/ros/qos.hpp>
#include <wayfare/ros/ros2_node.hpp>
#include "ros/nodes/processes.hpp"

namespace wayfare::testing {

/// A connected node with arguments.
inline std::unique_ptr<ros::Node> own_node(const std::string& name,
                                           std::vector<std::string> arguments = {}) {
  arguments.insert(arguments.begin(), "program");
  auto raw = ros::ros2_node(arguments, name, {own_domain(), false});
  EXPECT_TRUE(raw) << raw.error().to_string();
  if (!raw) return nullptr;
  auto node = std::make_unique<ros::Node>(*std::move(raw));
  EXPECT_TRUE(node->raw().connect());
  return node;
}

/// Spins the nodes until `done`; false after half a minute.
inline bool spin_until(std::initializer_list<ros::Node*> nodes, const std::function<bool()>& done) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (!done()) {
    if (std::chrono::steady_clock::now() > end) return false;
    for (ros::Node* node : nodes) node->spin(0.01);
  }
  return true;
}

}  // namespace wayfare::testing
