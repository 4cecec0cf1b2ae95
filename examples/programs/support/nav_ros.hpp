#pragma once

// Inertial samples and fixes from columns of text or a ROS recording (.mcap, .bag).

#include <string>

#include <wayfare/io/nav_text.hpp>
#include <wayfare/ros/recording.hpp>

namespace wayfare::examples {

[[nodiscard]] Result<io::ImuFile> read_unit(const std::string& path, const io::ColumnFormat& format,
                                            const ros::TopicNames& topics);
[[nodiscard]] Result<io::FixFile> read_receiver(const std::string& path,
                                                const io::ColumnFormat& format,
                                                const ros::TopicNames& topics);

}  // namespace wayfare::examples
