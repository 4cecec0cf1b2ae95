#pragma once

// What the nodes of SLAM have in common.

#include <functional>
#include <string>
#include <vector>

#include <wayfare/ros/nodes.hpp>

#include "node_program.hpp"
#include "support/option_fields.hpp"

namespace wayfare::examples {

struct SlamNodeArguments {
  ros::SlamNodeOptions node;
  std::vector<double> laser;  ///< x, y in m, heading in degrees
  std::string forward;        ///< axis of the inertial unit
  std::string config;         ///< of the options of the system
};

/// Frames, waiting, and `laser`, its mounting: x, y in m, heading in degrees.
void add_scan_options(CommandLine& app, ros::ScanNodeOptions& options, std::vector<double>& laser);
/// These, the map, and a JSON file of the system's options.
void add_slam_options(CommandLine& app, SlamNodeArguments& arguments, const std::string& program);
/// Mounting of the inertial unit, as of the programs on logs.
void add_unit_options(CommandLine& app, SlamNodeArguments& arguments);
/// To transforms, on /tf and /tf_static.
void subscribe_to_transforms(ros::Node& node,
                             const std::function<void(const ros::TfMessage&)>& take);
/// Warns at the end of messages that were lost, refused, or left out by the node.
void say_counts(const ros::Node& node, const ros::ScanNode& scans);
/// Processes scans until the node is ended; `publish` takes what comes of each.
template <class ScanNode, class Publish>
void process_scans(ros::Node& node, ScanNode& scans, const Publish& publish) {
  while (node.ok()) {
    node.spin(scans.busy() ? 0.0 : 0.05);
    publish(scans.work(steady_s()));
  }
  say_counts(node, scans);
}
void add_threads(CommandLine& app, SlamNodeArguments& arguments);
void add_resolution(CommandLine& app, SlamNodeArguments& arguments);

[[nodiscard]] SE2d pose_of(const std::vector<double>& x_y_degrees);
/// Sets what these options give; `fields` are those of the JSON file, checked by
/// `check_grid(grid)`.
[[nodiscard]] Result<void> complete(SlamNodeArguments& arguments,
                                    const std::vector<OptionField>& fields,
                                    const MultiResolutionOptions& grid);

/// Runs the node until it is ended; `complete` sets its options once they are read. Returns the
/// program's exit code.
[[nodiscard]] int run_slam_node(int argc, char** argv, const std::string& name, CommandLine& app,
                                const ros::SlamNodeOptions& options,
                                const std::function<Result<void>()>& complete);

}  // namespace wayfare::examples
