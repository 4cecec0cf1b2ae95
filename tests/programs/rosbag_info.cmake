# cmake -DBAG=FILE -P rosbag_info.cmake: ROS 1's tool reads a bag written by wayfare.
find_program(rosbag rosbag)
if(NOT rosbag)
  message("skipped: needs rosbag (Debian: python3-rosbag)")
  return()
endif()
execute_process(COMMAND "${rosbag}" info "${BAG}" RESULT_VARIABLE code OUTPUT_VARIABLE text
                ERROR_VARIABLE errors)
string(APPEND text "${errors}")
foreach(wanted IN ITEMS "version: +2.0" "compression: +none" "/scan +[0-9]+ msgs +: sensor_msgs/LaserScan"
                        "/odom +[0-9]+ msgs +: nav_msgs/Odometry" "90c7ef2dc6895d81024acba2ac42f369")
  if(NOT code EQUAL 0 OR NOT text MATCHES "${wanted}")
    message(FATAL_ERROR "rosbag info does not print '${wanted}':\n${text}")
  endif()
endforeach()
