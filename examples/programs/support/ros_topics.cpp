#include "ros_topics.hpp"

namespace wayfare::examples {

void add_stamps(CommandLine& app, ros::TopicNames& names) {
  app.add_choice<ros::StampSource>(
      "--stamps", names.stamps,
      {{"header", ros::StampSource::header}, {"received", ros::StampSource::received}},
      "times of a ROS recording: the senders' stamps (header, the default), or when the recorder "
      "received each message (received)");
}

namespace {

void add_wheels(CommandLine& app, ros::TopicNames& names) {
  app.add_option("--joint-topic", names.wheels.topic,
                 "of a ROS recording: sensor_msgs/JointState with the wheels' positions, or else "
                 "velocities");
  app.add_option("--wheels", names.wheels.names,
                 "LEFT,RIGHT: joints of the wheels in a ROS recording; by default "
                 "left_wheel_joint,right_wheel_joint, if they exist")
      .delimiter(',')
      .expected(2);
  app.add_option("--wheel-radius", names.wheels.radius_m,
                 "of those wheels, m; by default of the recording's /robot_description (URDF)");
  app.add_option("--wheel-base", names.wheels.base_m,
                 "distance between those wheels, m; by default of the /robot_description");
  app.add_option("--radar-max-speed", names.radar_max_speed_mps,
                 "radial speed at which the radar of a ROS recording wraps, m/s");
}

}  // namespace

void add_robot_topics(CommandLine& app, ros::TopicNames& names) {
  app.add_option("--scan-topic", names.scan, "of a ROS recording: sensor_msgs/LaserScan");
  app.add_option("--odometry-topic", names.odometry, "of a ROS recording: nav_msgs/Odometry");
  app.add_option("--radar-topic", names.radar,
                 "of a ROS recording: wayfare_msgs/RadarScan or sensor_msgs/PointCloud2");
  app.add_option("--imu-topic", names.imu, "of a ROS recording: sensor_msgs/Imu, the robot's gyro");
  add_wheels(app, names);
  add_truth_topics(app, names);
  app.add_option("--base-frame", names.base_frame,
                 "the robot's frame in a ROS recording; by default that of its odometry");
  add_stamps(app, names);
}

void add_truth_topics(CommandLine& app, ros::TopicNames& names) {
  app.add_option("--truth-topic", names.truth,
                 "of a ROS recording, the true poses: geometry_msgs/PoseStamped, "
                 "geometry_msgs/PoseWithCovarianceStamped or nav_msgs/Odometry; by default /truth, "
                 "if it exists");
  app.add_option("--truth-frames", names.truth_frames,
                 "PARENT,CHILD: true poses by the transforms of a ROS recording instead, directly "
                 "or by way of frames between")
      .delimiter(',')
      .expected(2)
      .excludes("--truth-topic");
}

void add_imu_topic(CommandLine& app, ros::TopicNames& names) {
  app.add_option("--imu-topic", names.imu, "of a ROS recording: sensor_msgs/Imu");
  add_stamps(app, names);
}

void add_vehicle_topics(CommandLine& app, ros::TopicNames& names) {
  add_imu_topic(app, names);
  app.add_option("--fix-topic", names.fix, "of a ROS recording: sensor_msgs/NavSatFix");
}

void add_unit_topics(CommandLine& app, ros::TopicNames& names) {
  app.add_option("--magnetometer-topic", names.magnetometer,
                 "of a ROS recording: sensor_msgs/MagneticField");
}

}  // namespace wayfare::examples
