# Two processes of the peer: a reader that is there before, and one that joins late.
cmake_minimum_required(VERSION 3.22)
string(RANDOM LENGTH 2 ALPHABET 123456789 domain)  # ports below 32768
set(of_all --domain ${domain})

execute_process(
  COMMAND "${PEER}" publish rt/scan sensor_msgs/msg/LaserScan --wait-for 1 --size 1080 ${of_all}
  COMMAND "${PEER}" subscribe rt/scan sensor_msgs/msg/LaserScan 10 --size 1080 ${of_all}
  RESULTS_VARIABLE results OUTPUT_VARIABLE text ERROR_VARIABLE errors)
if(NOT results STREQUAL "0;0" OR NOT text MATCHES "received 10 of 10, lost 0, last 9")
  message(FATAL_ERROR "the samples were not received: ${results} ${text} ${errors}")
endif()

# The map is sent before its reader exists.
execute_process(
  COMMAND "${PEER}" publish rt/map nav_msgs/msg/OccupancyGrid --count 1 --size 100000
          --transient-local --depth 1 --late-readers 1 ${of_all}
  COMMAND sh -c "sleep 1 && exec \"$@\"" sh "${PEER}" subscribe rt/map nav_msgs/msg/OccupancyGrid 1
          --size 100000 --transient-local --depth 1 ${of_all}
  RESULTS_VARIABLE results OUTPUT_VARIABLE text ERROR_VARIABLE errors)
if(NOT results STREQUAL "0;0" OR NOT text MATCHES "received 1 of 1, lost 0, last 0")
  message(FATAL_ERROR "a late reader did not get the map: ${results} ${text} ${errors}")
endif()
